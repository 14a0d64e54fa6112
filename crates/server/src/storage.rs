//! Async access to the store: one thread commits, and the blocking pool reads.

use std::path::Path;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread;

use document::{AssetHash, DocumentHash};
use edit::Record;
use store::{CommitBatch, RecordTail, Rejection, Store, StoreError};
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
        let commit = Commit { session, records, rejections, hash };
        self.write(|done| WriteJob::Commit(commit, done)).await
    }

    /// Runs `work` on the committing thread. Its writes are on disk when this returns.
    pub async fn run_exclusive<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Store) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, ServerError> {
        // The asker may be gone. The work stays done.
        self.write(|done| WriteJob::Exclusive(Box::new(move |store| drop(done.send(work(store)))))).await
    }

    /// Hands a write to the committing thread and waits for its result.
    async fn write<T>(
        &self,
        job: impl FnOnce(oneshot::Sender<Result<T, StoreError>>) -> WriteJob,
    ) -> Result<T, ServerError> {
        let (done, result) = oneshot::channel();
        self.writes.send(job(done)).await.map_err(|_| ServerError::Internal)?;
        result.await.map_err(|_| ServerError::Internal)?.map_err(ServerError::Store)
    }

    /// Stores an asset's bytes, which are on disk when this returns.
    pub async fn put_asset(&self, bytes: impl AsRef<[u8]> + Send + 'static) -> Result<AssetHash, ServerError> {
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

    fn readers(&self) -> MutexGuard<'_, Vec<Store>> {
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
    let batches = commits.iter().map(|(commit, _)| {
        let Commit { session, records, rejections, hash } = commit;
        CommitBatch { session, records, rejections, hash: *hash }
    });
    let batches: Vec<CommitBatch> = batches.collect();
    let together = if batches.len() > 1 { store.append(&batches).ok() } else { None };
    match together {
        Some(tails) => tails.into_iter().map(Ok).collect(),
        None => batches.into_iter().map(|batch| store.append(&[batch]).map(|tails| tails[0])).collect(),
    }
}
