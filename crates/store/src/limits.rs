//! How much the store takes.

/// Characters that a session's name has at most.
pub const MAX_NAME_CHARS: usize = 64;
/// Sessions that a data folder holds at most.
pub const MAX_SESSIONS: u64 = 10_000;
/// Bytes that an asset has at most. The largest scene that can be read, 512 MiB, with its pictures in base64 takes 683.
pub const MAX_ASSET_BYTES: u64 = 768 << 20;
/// Rejections that are kept of one actor in a session.
pub const MAX_REJECTIONS: u64 = 1_000;
/// Rejections that are kept of all actors in all sessions.
pub const MAX_ALL_REJECTIONS: u64 = 1_000_000;
/// Bytes of records that are given at once, but for a single record that has more.
pub const MAX_PAGE_BYTES: usize = 64 << 20;
/// Bytes of earlier records that are kept in memory while a log is read, for later ones to refer to.
pub const MAX_HELD_BYTES: usize = 64 << 20;
