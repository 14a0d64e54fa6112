//! The store as tasks use it: one thread commits, the blocking pool reads.

use std::path::Path;
use std::sync::Arc;
use std::thread;

use edit::Record;
use scene::{AssetHash, DocumentHash};
use store::{Batch, Store, StoreError};
use tokio::sync::{mpsc, oneshot};
use tokio::task::spawn_blocking;

use crate::limits::COMMIT_QUEUE;
use crate::{ServerError, metrics::Metrics};

/// The way to the store. Clones share the thread that commits; it ends with the last of them.
#[derive(Clone, Debug)]
pub struct Storage {
    folder: Arc<Path>,
    writes: mpsc::Sender<Write>,
}

/// What changes the database.
enum Write {
    Commit(Commit),
    CreateSession { name: String, done: oneshot::Sender<Result<String, StoreError>> },
}

/// Records of one session, in order.
struct Commit {
    session: Arc<str>,
    records: Vec<Record>,
    hash: DocumentHash,
    done: oneshot::Sender<Result<(), StoreError>>,
}

impl Storage {
    /// Gives `store`, which lies in `folder`, a thread of its own.
    pub fn start(folder: &Path, store: Store, metrics: Arc<Metrics>) -> Self {
        let (writes, inbox) = mpsc::channel(COMMIT_QUEUE);
        thread::spawn(move || write_until_closed(store, inbox, &metrics));
        Self { folder: folder.into(), writes }
    }

    /// Writes records down; they are on disk when it returns. `hash` is of the document after the last of them.
    pub async fn append(
        &self,
        session: Arc<str>,
        records: Vec<Record>,
        hash: DocumentHash,
    ) -> Result<(), ServerError> {
        let (done, answer) = oneshot::channel();
        self.write(Write::Commit(Commit { session, records, hash, done })).await?;
        Ok(answer.await.map_err(|_| ServerError::Fault)??)
    }

    /// Makes a session and gives its epoch.
    pub async fn create_session(&self, name: String) -> Result<String, ServerError> {
        let (done, answer) = oneshot::channel();
        self.write(Write::CreateSession { name, done }).await?;
        Ok(answer.await.map_err(|_| ServerError::Fault)??)
    }

    async fn write(&self, write: Write) -> Result<(), ServerError> {
        self.writes.send(write).await.map_err(|_| ServerError::Fault)
    }

    /// Keeps an asset's bytes; they are on disk when it returns.
    pub async fn put_asset(
        &self,
        bytes: impl AsRef<[u8]> + Send + 'static,
    ) -> Result<AssetHash, ServerError> {
        self.read(move |store| store.put_asset(bytes.as_ref())).await
    }

    /// Asks the store on the blocking pool.
    pub async fn read<T: Send + 'static>(
        &self,
        question: impl FnOnce(&Store) -> Result<T, StoreError> + Send + 'static,
    ) -> Result<T, ServerError> {
        let storage = self.clone();
        let answer = spawn_blocking(move || question(&storage.open()?));
        Ok(answer.await.map_err(|_| ServerError::Fault)??)
    }

    /// Where the data lies.
    pub fn folder(&self) -> &Path {
        &self.folder
    }

    /// A connection of the caller's own, for reading. Blocks.
    pub fn open(&self) -> Result<Store, StoreError> {
        Store::open(&self.folder)
    }
}

/// Carries out writes. Commits that wait together become one transaction: the disk is waited for once.
fn write_until_closed(mut store: Store, mut inbox: mpsc::Receiver<Write>, metrics: &Metrics) {
    let mut waiting = Vec::with_capacity(COMMIT_QUEUE);
    while inbox.blocking_recv_many(&mut waiting, COMMIT_QUEUE) > 0 {
        let mut commits = Vec::new();
        for write in waiting.drain(..) {
            match write {
                Write::Commit(commit) => commits.push(commit),
                Write::CreateSession { name, done } => {
                    // Nobody may be waiting any more; the session is there all the same.
                    let _ = done.send(store.create_session(&name));
                }
            }
        }
        if !commits.is_empty() {
            let started = std::time::Instant::now();
            commit_all(&mut store, commits);
            metrics.commit_seconds.observe(started.elapsed().as_secs_f64());
        }
    }
}

/// Commits all together, or where that fails each for itself, so that no session fails for another's sake.
fn commit_all(store: &mut Store, commits: Vec<Commit>) {
    let batches: Vec<Batch> = commits.iter().map(Commit::batch).collect();
    let together = commits.len() > 1 && store.append(&batches).is_ok();
    for commit in commits {
        let result = if together { Ok(()) } else { store.append(&[commit.batch()]) };
        let _ = commit.done.send(result);
    }
}

impl Commit {
    fn batch(&self) -> Batch<'_> {
        Batch { session: &self.session, records: &self.records, hash: self.hash }
    }
}
