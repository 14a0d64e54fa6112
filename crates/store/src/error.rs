//! What can go wrong with stored logs and assets.

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

/// Why the store did not do what was asked. Each sentence says what to do.
#[derive(Debug, Error)]
pub enum StoreError {
    /// The folder holds no data.
    #[error("{}: holds no sessions; name the folder that `bendylights serve --data` was given", .0.display())]
    NoData(PathBuf),
    /// The folder holds no scenes.
    #[error("{}: has no folder `assets` with scenes; name the folder that `bendylights serve --data` was given", .0.display())]
    NoAssets(PathBuf),
    /// A file where the data folder should be.
    #[error("{}: is a file, and the data lies in a folder; name that with --data", .0.display())]
    NotAFolder(PathBuf),
    /// Something is where a backup should go.
    #[error("{}: is there already, and a backup is never written over: name another folder", .0.display())]
    BackupExists(PathBuf),
    /// A file or folder that the system would not read or write.
    #[error("{}: cannot be used ({reason}); check that you may write there and that the disk is not full", path.display())]
    Io { path: PathBuf, reason: io::Error },
    /// The database could not.
    #[error(
        "the database of sessions cannot be used ({0}); check the disk, and that its folder may be written"
    )]
    Database(String),
    /// A code of a refusal that this version does not know.
    #[error(
        "the database has a refusal with the code `{0}`, which this program does not know: use the newer one that wrote it"
    )]
    UnknownCode(String),
    /// The disk failed at the end of a commit, and again when the store saw to it that nothing is left of that; or what
    /// became of an operation that may have come before cannot be read.
    #[error(
        "the disk failed ({0}), and whether this is in the log cannot be told: check the disk, then send it again under the same name"
    )]
    UnknownOutcome(String),
    /// The database is of a later version.
    #[error("{}: was written by a newer version of this program (schema {found}); use that one", path.display())]
    NewerDatabase {
        /// The database.
        path: PathBuf,
        /// Its version.
        found: u32,
    },
    /// The file system cannot keep the log safe.
    #[error("{}: cannot hold a write-ahead log; choose a folder on a local disk", .0.display())]
    NoWriteAheadLog(PathBuf),
    /// Not a session's name.
    #[error(
        "`{0}` cannot name a session: take 1 to {MAX_NAME_CHARS} of a-z A-Z 0-9 - _ . and start with a letter or digit"
    )]
    BadName(String),
    /// Not what people call a scene.
    #[error(
        "a scene's name has 1 to {MAX_NAME_BYTES} bytes, begins and ends without a space and has no control characters: \
         choose another, in UTF-8"
    )]
    BadSceneName,
    /// Not what people call a session.
    #[error(
        "a session's title has 1 to {MAX_NAME_BYTES} bytes, begins and ends without a space and has no control characters: \
         choose another"
    )]
    BadTitle,
    /// Only what is archived can be deleted.
    #[error("session `{0}` is not archived, and only what is archived can be deleted: archive it first")]
    NotArchived(String),
    /// The name is taken.
    #[error("there is a session `{0}` already: choose another name")]
    Exists(String),
    /// No such session.
    #[error("there is no session `{0}`: look at the list of sessions")]
    NoSession(String),
    /// Too many sessions.
    #[error("there are {MAX_SESSIONS} sessions, the most a folder holds: use another folder")]
    TooManySessions,
    /// A log is shorter than was asked for.
    #[error("the log ends with record {last} and has no record {asked}: ask for an earlier one")]
    NoRecord {
        /// Which was asked for.
        asked: u64,
        /// The last there is.
        last: u64,
    },
    /// A record does not follow what is stored.
    #[error(
        "record {0} does not follow the stored log: another program has written to it; open the session again"
    )]
    ConcurrentWrite(u64),
    /// A record over the limit.
    #[error("a record has more than {MAX_RECORD_BYTES} bytes: divide the edit into smaller ones")]
    RecordTooLarge,
    /// A log over the limit.
    #[error(
        "the log has more than {} records, the most a session holds: import a shorter one",
        edit::MAX_RECORDS
    )]
    TooManyRecords,
    /// An asset over the limit.
    #[error("an asset has more than {MAX_ASSET_BYTES} bytes: make the scene smaller")]
    AssetTooLarge,
    /// An asset's file does not hold what its name says.
    #[error("the stored file of {0} is damaged: put the scene's file into the assets again")]
    DamagedAsset(AssetHash),
    /// A log file that cannot be read.
    #[error("the log cannot be read ({0}); check the file")]
    Unreadable(io::Error),
    /// A log file that cannot be written.
    #[error("the log cannot be written ({0}); check that the disk is not full")]
    Unwritable(io::Error),
    /// A line of a log file that is not UTF-8. Lines count from 1.
    #[error("line {line}: is not UTF-8 text; give a file that `bendylights export` wrote")]
    NotUtf8 { line: u64 },
    /// A line of a log file that does not have the right shape. Lines count from 1.
    #[error("line {line}: {reason}")]
    Line { line: u64, reason: FileError },
    /// A stored record that does not have the right shape.
    #[error("record {seq} is damaged: {reason}")]
    DamagedRecord { seq: u64, reason: FileError },
    /// A record without a meaning.
    #[error("record {seq}: {reason}")]
    InvalidRecord { seq: u64, reason: Refused },
    /// A log file without its end.
    #[error("the log ends without a checkpoint: it was cut short; export it again")]
    Truncated,
    /// A checkpoint in the wrong place.
    #[error(
        "line {line}: a checkpoint of record {found} does not stand directly after that record: the log was changed by hand; export it again"
    )]
    MisplacedCheckpoint {
        /// The line.
        line: u64,
        /// What it says.
        found: u64,
    },
    /// A record does not go on from those before it.
    #[error("{0}")]
    Replay(#[from] ReplayError),
    /// One operation of an actor twice.
    #[error("record {seq} repeats operation {op_id} of the same actor: the log was changed by hand")]
    RepeatedOperation {
        /// The second record.
        seq: u64,
        /// The operation.
        op_id: String,
    },
    /// The log's lines are not those that were written.
    #[error(
        "what the log says of record {seq} or one before it is not what was logged: the database was changed; take the \
         folder's backup"
    )]
    ProofMismatch {
        /// The first record whose checkpoint differs.
        seq: u64,
    },
    /// The document of a stored log is not what it was when the log was written.
    #[error(
        "the document after record {seq} is not the one that was logged: the database or the program was changed; take \
         the folder's backup"
    )]
    HashMismatch {
        /// The first record whose hash differs.
        seq: u64,
    },
    /// A log file is not what was logged.
    #[error("{0}")]
    CheckpointMismatch(Difference),
}

impl StoreError {
    /// The code that programs act on.
    pub fn code(&self) -> ErrorCode {
        match self {
            Self::NoSession(_) | Self::NoRecord { .. } => ErrorCode::NotFound,
            Self::Exists(_) => ErrorCode::Exists,
            Self::BadName(_) | Self::BadSceneName | Self::BadTitle => ErrorCode::BadName,
            Self::NotArchived(_) => ErrorCode::NotArchived,
            Self::TooManySessions | Self::TooManyRecords => ErrorCode::TooMany,
            Self::RecordTooLarge | Self::AssetTooLarge => ErrorCode::TooLarge,
            Self::Replay(ReplayError::Record { reason: EditError::UnknownAsset(_), .. }) => {
                ErrorCode::UnknownAsset
            }
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
