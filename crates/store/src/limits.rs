//! Limits of the store.

/// Greatest number of characters in a session's name.
pub const MAX_NAME_CHARS: usize = 64;
/// Greatest number of sessions in a data folder.
pub const MAX_SESSIONS: u64 = 10_000;
/// Greatest size of an asset in bytes. The largest scene that can be read has 512 MiB and takes 683 MiB with its
/// pictures in base64.
pub const MAX_ASSET_BYTES: u64 = 768 << 20;
/// Number of rejections kept per actor and session.
pub const MAX_REJECTIONS: u64 = 1_000;
/// Number of rejections kept of all actors in all sessions.
pub const MAX_ALL_REJECTIONS: u64 = 1_000_000;
/// Greatest size of the records returned at once, in bytes. A single larger record is returned alone.
pub const MAX_PAGE_BYTES: usize = 64 << 20;
/// Bytes of earlier records that a reader of a log keeps in memory, since later records may refer to them.
pub const MAX_HELD_BYTES: usize = 64 << 20;
