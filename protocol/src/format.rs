//! The format of records and logs.

/// Format of records and logs that this version writes. Records of earlier formats are upgraded when they are
/// read:
///
/// - Format 1 had neither `rebased` nor references.
/// - Up to format 2, a document's hash covered the fields that lights had then.
/// - Up to format 3, a log's proof did not cover its header.
/// - Up to format 4, a record had at most one command.
/// - Up to format 5, a pin was of a point, and of the kinds `direction`, `lit`, `shadowed` and `shadow`.
pub const FORMAT: u32 = 6;
