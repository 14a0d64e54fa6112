//! Errors of stored logs and assets.

use std::io;
use std::path::PathBuf;

use document::{AssetHash, EditError};
use edit::ReplayError;
use light::MAX_NAME_BYTES;
use protocol::{ErrorCode, FileError, Refused};
use thiserror::Error;

use protocol::MAX_RECORD_BYTES;

use crate::difference::Difference;
use crate::limits::{MAX_ASSET_BYTES, MAX_NAME_CHARS, MAX_SESSIONS};

/// Reason for which the store refused or failed. Each message says what to do.
#[derive(Debug, Error)]
pub enum StoreError {
    #[error("{}: holds no sessions; name the folder that `bendylights serve --data` was given", .0.display())]
    NoData(PathBuf),
    #[error("{}: has no folder `assets` with scenes; name the folder that `bendylights serve --data` was given", .0.display())]
    NoAssets(PathBuf),
    /// The path of the data folder is a file.
    #[error("{}: is a file, and the data lies in a folder; name that with --data", .0.display())]
    NotAFolder(PathBuf),
    /// The target of a backup exists.
    #[error("{}: is there already, and a backup is never written over: name another folder", .0.display())]
    BackupExists(PathBuf),
    /// The system refused to read or write a file or folder.
    #[error("{}: cannot be used ({reason}); check that you may write there and that the disk is not full", path.display())]
    Io { path: PathBuf, reason: io::Error },
    /// SQLite failed.
    #[error("the database of sessions cannot be used ({0}); check the disk, and that its folder may be written")]
    Database(String),
    /// A stored rejection has a code that this version does not know.
    #[error(
        "the database has a refusal with the code `{0}`, which this program does not know: use the newer one that wrote it"
    )]
    UnknownCode(String),
    /// The disk failed at the end of a commit and again when the store removed the commit's remains. Or the outcome of
    /// an operation that may have arrived before cannot be read.
    #[error(
        "the disk failed ({0}), and whether this is in the log cannot be told: check the disk, then send it again under the same name"
    )]
    UnknownOutcome(String),
    /// A newer version of the program wrote the database.
    #[error("{}: was written by a newer version of this program (schema {found}); use that one", path.display())]
    NewerDatabase {
        path: PathBuf,
        /// Schema version of the database.
        found: u32,
    },
    /// The file system does not support a write-ahead log.
    #[error("{}: cannot hold a write-ahead log; choose a folder on a local disk", .0.display())]
    NoWriteAheadLog(PathBuf),
    /// The name cannot name a session.
    #[error(
        "`{0}` cannot name a session: take 1 to {MAX_NAME_CHARS} of a-z A-Z 0-9 - _ . and start with a letter or digit"
    )]
    BadName(String),
    /// The text is no valid display name of a scene.
    #[error(
        "a scene's name has 1 to {MAX_NAME_BYTES} bytes, begins and ends without a space and has no control characters: \
         choose another, in UTF-8"
    )]
    BadSceneName,
    /// The text is no valid title of a session.
    #[error(
        "a session's title has 1 to {MAX_NAME_BYTES} bytes, begins and ends without a space and has no control characters: \
         choose another"
    )]
    BadTitle,
    /// Only archived sessions can be deleted.
    #[error("session `{0}` is not archived, and only what is archived can be deleted: archive it first")]
    NotArchived(String),
    /// A session of that name exists.
    #[error("there is a session `{0}` already: choose another name")]
    Exists(String),
    #[error("there is no session `{0}`: look at the list of sessions")]
    NoSession(String),
    #[error("there are {MAX_SESSIONS} sessions, the most a folder holds: use another folder")]
    TooManySessions,
    /// The log has no record of that number.
    #[error("the log ends with record {last} and has no record {requested}: ask for an earlier one")]
    NoRecord { requested: u64, last: u64 },
    /// A record does not follow the stored log.
    #[error("record {0} does not follow the stored log: another program has written to it; open the session again")]
    ConcurrentWrite(u64),
    #[error("a record has more than {MAX_RECORD_BYTES} bytes: divide the edit into smaller ones")]
    RecordTooLarge,
    #[error("the log has more than {} records, the most a session holds: import a shorter one", edit::MAX_RECORDS)]
    TooManyRecords,
    #[error("an asset has more than {MAX_ASSET_BYTES} bytes: make the scene smaller")]
    AssetTooLarge,
    /// The bytes of an asset do not match its hash.
    #[error("the stored file of {0} is damaged: put the scene's file into the assets again")]
    DamagedAsset(AssetHash),
    #[error("the log cannot be read ({0}); check the file")]
    Unreadable(io::Error),
    #[error("the log cannot be written ({0}); check that the disk is not full")]
    Unwritable(io::Error),
    /// A line of a log file is not UTF-8. Lines count from 1.
    #[error("line {line}: is not UTF-8 text; give a file that `bendylights export` wrote")]
    NotUtf8 { line: u64 },
    /// A line of a log file has the wrong shape. Lines count from 1.
    #[error("line {line}: {reason}")]
    Line { line: u64, reason: FileError },
    /// A stored record has the wrong shape.
    #[error("record {seq} is damaged: {reason}")]
    DamagedRecord { seq: u64, reason: FileError },
    /// A record has the right shape, but its content is invalid.
    #[error("record {seq}: {reason}")]
    InvalidRecord { seq: u64, reason: Refused },
    /// The log file lacks its end.
    #[error("the log ends without a checkpoint: it was cut short; export it again")]
    Truncated,
    /// A checkpoint of a log file is at the wrong position.
    #[error(
        "line {line}: a checkpoint of record {found} does not stand directly after that record: the log was changed by hand; export it again"
    )]
    MisplacedCheckpoint {
        /// Number of the line, from 1.
        line: u64,
        /// The record that the checkpoint names.
        found: u64,
    },
    /// A record does not follow from the ones before it.
    #[error("{0}")]
    Replay(#[from] ReplayError),
    /// A log file has one operation of an actor twice.
    #[error("record {seq} repeats operation {op_id} of the same actor: the log was changed by hand")]
    RepeatedOperation {
        /// The second record of the operation.
        seq: u64,
        op_id: String,
    },
    /// The stored lines of the log are not the ones that were written.
    #[error(
        "what the log says of record {seq} or one before it is not what was logged: the database was changed; take the \
         folder's backup"
    )]
    ProofMismatch {
        /// The first record whose proof differs.
        seq: u64,
    },
    /// The document of a stored log differs from the one at the time of writing.
    #[error(
        "the document after record {seq} is not the one that was logged: the database or the program was changed; take \
         the folder's backup"
    )]
    HashMismatch {
        /// The first record whose hash differs.
        seq: u64,
    },
    /// A log file differs from the log that was written.
    #[error("{0}")]
    CheckpointMismatch(Difference),
}

impl StoreError {
    /// Returns the error code for clients.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::NoSession(_) | Self::NoRecord { .. } => ErrorCode::NotFound,
            Self::Exists(_) => ErrorCode::Exists,
            Self::BadName(_) | Self::BadSceneName | Self::BadTitle => ErrorCode::BadName,
            Self::NotArchived(_) => ErrorCode::NotArchived,
            Self::TooManySessions | Self::TooManyRecords => ErrorCode::TooMany,
            Self::RecordTooLarge | Self::AssetTooLarge => ErrorCode::TooLarge,
            Self::Replay(ReplayError::Record { reason: EditError::UnknownAsset(_), .. }) => ErrorCode::UnknownAsset,
            Self::Line { .. }
            | Self::NotUtf8 { .. }
            | Self::InvalidRecord { .. }
            | Self::Truncated
            | Self::MisplacedCheckpoint { .. }
            | Self::Replay(_)
            | Self::RepeatedOperation { .. }
            | Self::ProofMismatch { .. }
            | Self::HashMismatch { .. }
            | Self::CheckpointMismatch(_) => ErrorCode::BadLog,
            Self::UnknownOutcome(_) => ErrorCode::UnknownOutcome,
            Self::DamagedAsset(_) => ErrorCode::DamagedAsset,
            Self::NoData(_)
            | Self::NoAssets(_)
            | Self::NotAFolder(_)
            | Self::BackupExists(_)
            | Self::Io { .. }
            | Self::Database(_)
            | Self::UnknownCode(_)
            | Self::NewerDatabase { .. }
            | Self::NoWriteAheadLog(_)
            | Self::ConcurrentWrite(_)
            | Self::DamagedRecord { .. }
            | Self::Unreadable(_)
            | Self::Unwritable(_) => ErrorCode::Storage,
        }
    }
}
