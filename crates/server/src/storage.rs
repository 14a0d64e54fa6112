//! Async access to the store: one thread commits, and the blocking pool reads.

use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::thread;

use document::{AssetHash, DocumentHash};
use edit::Record;
use protocol::SessionCheckpoint;
use store::{CommitBatch, RecordTail, Rejection, SessionChange, SessionSummary, Store, StoreError};
use tokio::sync::{mpsc, oneshot};
use tokio::task::spawn_blocking;

use crate::limits::{COMMIT_QUEUE, MAX_READERS};
use crate::{ServerError, metrics::Metrics};

/// Handle to the store. Clones share the committing thread, which ends with the last of them.
#[derive(Clone, Debug)]
pub struct Storage {
    folder: Arc<Path>,
    writes: mpsc::Sender<WriteJob>,
    /// Open connections for reading that nobody uses at the moment.
    readers: Arc<Mutex<Vec<Store>>>,
}

/// A write to the database.
enum WriteJob {
    /// Commits records and rejections of a session. The answer is the number and size of the records that its log grew
    /// by.
    Commit(Commit, oneshot::Sender<Result<RecordTail, StoreError>>),
    /// A transaction of its own, which sends its own answer.
    Exclusive(Box<dyn FnOnce(&mut Store) + Send>),
}

/// Records and rejections of one session, in order.
struct Commit {
    session: Arc<str>,
    records: Vec<Record>,
    rejections: Vec<Rejection>,
    hash: DocumentHash,
}

impl Storage {
    /// Starts a thread for `store`, which is in `folder`.
    pub fn start(folder: &Path, store: Store, metrics: Arc<Metrics>) -> Self {
        let (writes, inbox) = mpsc::channel(COMMIT_QUEUE);
        thread::spawn(move || write_until_closed(store, inbox, &metrics));
        Self { folder: folder.into(), writes, readers: Arc::default() }
    }

    /// Writes records and rejections, which are on disk when this returns. `hash` is the hash of the document after the
    /// last record. Returns the growth of the log.
    pub async fn append(
        &self,
        session: Arc<str>,
        records: Vec<Record>,
        rejections: Vec<Rejection>,
        hash: DocumentHash,
    ) -> Result<RecordTail, ServerError> {
        let (done, answer) = oneshot::channel();
        self.write(WriteJob::Commit(Commit { session, records, rejections, hash }, done)).await?;
        receive_result(answer).await
    }

    /// Makes a session with that title and those records, completely or not at all. Returns its epoch.
    pub async fn begin_session(
        &self,
        session: &str,
        title: Option<String>,
        records: Vec<Record>,
        hash: DocumentHash,
    ) -> Result<String, ServerError> {
        let first = Commit { session: session.into(), records, rejections: Vec::new(), hash };
        self.run_exclusive(move |store| store.begin_session(&first.batch(), title.as_deref())).await
    }

    /// Changes the title or the archived state of a session.
    pub async fn change_session(
        &self,
        name: String,
        change: SessionChange,
    ) -> Result<SessionSummary, ServerError> {
        self.run_exclusive(move |store| store.change_session(&name, &change)).await
    }

    /// Makes session `copy` of `name`, completely or not at all.
    pub async fn duplicate_session(
        &self,
        name: String,
        copy: String,
        title: Option<String>,
    ) -> Result<SessionSummary, ServerError> {
        self.run_exclusive(move |store| store.duplicate_session(&name, &copy, title.as_deref())).await
    }

    /// Deletes an archived session, which must not be open.
    pub async fn delete_session(&self, name: Arc<str>) -> Result<(), ServerError> {
        self.run_exclusive(move |store| store.delete_session(&name)).await
    }

    /// Stores a session's checkpoint, replaces an earlier one, and returns its size in bytes.
    pub async fn keep_checkpoint(
        &self,
        session: &Arc<str>,
        checkpoint: SessionCheckpoint,
    ) -> Result<u64, ServerError> {
        let session = Arc::clone(session);
        self.run_exclusive(move |store| store.keep_checkpoint(&session, &checkpoint)).await
    }

    /// Runs `work` on the committing thread. Its writes are on disk when this returns.
    async fn run_exclusive<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Store) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, ServerError> {
        let (done, answer) = oneshot::channel();
        // The asker may be gone. The work stays done.
        self.write(WriteJob::Exclusive(Box::new(move |store| drop(done.send(work(store)))))).await?;
        receive_result(answer).await
    }

    async fn write(&self, write: WriteJob) -> Result<(), ServerError> {
        self.writes.send(write).await.map_err(|_| ServerError::Internal)
    }

    /// Stores an asset's bytes, which are on disk when this returns.
    pub async fn put_asset(
        &self,
        bytes: impl AsRef<[u8]> + Send + 'static,
    ) -> Result<AssetHash, ServerError> {
        self.with_reader(move |store| store.assets.put(bytes.as_ref()).map_err(ServerError::Store)).await
    }

    /// Stores the display name of an asset, which is on disk when this returns.
    pub async fn name_asset(&self, asset: AssetHash, name: String) -> Result<(), ServerError> {
        self.with_reader(move |store| store.assets.set_name(&asset, &name).map_err(ServerError::Store)).await
    }

    /// Reads from the store on the blocking pool.
    pub async fn read<T: Send + 'static>(
        &self,
        question: impl FnOnce(&Store) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, ServerError> {
        self.with_reader(move |store| question(store).map_err(ServerError::StoreRead)).await
    }

    async fn with_reader<T: Send + 'static>(
        &self,
        question: impl FnOnce(&Store) -> Result<T, ServerError> + Send + 'static,
    ) -> Result<T, ServerError> {
        let storage = self.clone();
        let answer = spawn_blocking(move || {
            let known = storage.readers().pop();
            let reader = known.map_or_else(|| storage.open(), Ok).map_err(ServerError::StoreRead)?;
            let answer = question(&reader);
            let mut readers = storage.readers();
            // A connection that had an error is not reused.
            if answer.is_ok() && readers.len() < MAX_READERS {
                readers.push(reader);
            }
            answer
        });
        answer.await.map_err(|_| ServerError::Internal)?
    }

    fn readers(&self) -> std::sync::MutexGuard<'_, Vec<Store>> {
        self.readers.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the data folder.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// Opens a connection for reading by the caller. Blocks.
    pub fn open(&self) -> Result<Store, StoreError> {
        Store::open(&self.folder)
    }
}

async fn receive_result<T>(answer: oneshot::Receiver<Result<T, StoreError>>) -> Result<T, ServerError> {
    answer.await.map_err(|_| ServerError::Internal)?.map_err(ServerError::Store)
}

/// Carries out writes. Waiting commits become one transaction, so the disk is waited for once.
fn write_until_closed(mut store: Store, mut inbox: mpsc::Receiver<WriteJob>, metrics: &Metrics) {
    let mut waiting = Vec::with_capacity(COMMIT_QUEUE);
    while inbox.blocking_recv_many(&mut waiting, COMMIT_QUEUE) > 0 {
        let mut commits = Vec::new();
        for write in waiting.drain(..) {
            match write {
                WriteJob::Commit(commit, done) => commits.push((commit, done)),
                WriteJob::Exclusive(work) => work(&mut store),
            }
        }
        if !commits.is_empty() {
            let started = std::time::Instant::now();
            let results = commit_all(&mut store, &commits);
            // Counted before the answer, so a client that has the answer finds it in the metrics.
            metrics.commit_seconds.observe(started.elapsed().as_secs_f64());
            for ((_, done), result) in commits.into_iter().zip(results) {
                let _ = done.send(result);
            }
        }
    }
}

/// Commits all batches in one transaction. If that fails, commits each in a transaction of its own, so that no session
/// fails because of another.
fn commit_all<T>(store: &mut Store, commits: &[(Commit, T)]) -> Vec<Result<RecordTail, StoreError>> {
    let batches: Vec<CommitBatch> = commits.iter().map(|(commit, _)| commit.batch()).collect();
    let together = if batches.len() > 1 { store.append(&batches).ok() } else { None };
    match together {
        Some(tails) => tails.into_iter().map(Ok).collect(),
        None => batches.into_iter().map(|batch| store.append(&[batch]).map(|tails| tails[0])).collect(),
    }
}

impl Commit {
    fn batch(&self) -> CommitBatch<'_> {
        let Self { session, records, rejections, hash } = self;
        CommitBatch { session, records, rejections, hash: *hash }
    }
}
