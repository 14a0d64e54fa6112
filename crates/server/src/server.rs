//! Starting, serving, stopping.

use std::fs::{File, TryLockError};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Instant;

use edit::{Actor, Committed, Request};
use scene::{AssetHash, Command};
use store::{Batch, Store};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::backend::Backend;
use crate::hosts::{Hosts, PublicUrl};
use crate::limits::{DRAIN_WITHIN, MAX_REQUESTS, MAX_SOCKETS, MAX_STILLS, MAX_UPLOADS};
use crate::metrics::Metrics;
use crate::renderer::{RenderThread, Renders};
use crate::room::{Rooms, time_ms};
use crate::scenes::Scenes;
use crate::storage::Storage;
use crate::{ServerError, Token, connections, http, private};

/// The file that holds the folder against a second server.
pub const LOCK: &str = "lock";

/// How a server is started.
#[derive(Clone, Debug)]
pub struct Config {
    /// Where its data lies; made where it is missing.
    pub data: PathBuf,
    /// The session that is there in any case.
    pub session: String,
    /// What that session loads when it is made: a scene's file, or `demo:NAME`.
    pub scene: String,
    /// Where browsers find it besides the address that it listens on.
    pub public_urls: Vec<PublicUrl>,
}

/// A server that is ready to listen.
pub struct Server {
    store: Store,
    renders: Renders,
    render_thread: RenderThread,
    token: Token,
    data: PathBuf,
    public_urls: Vec<PublicUrl>,
    /// Holds the folder against a second server.
    _lock: File,
}

/// What every request can use.
pub struct Shared {
    pub backend: Backend,
    pub rooms: Rooms,
    pub token: Token,
    /// The names that it answers to.
    pub hosts: Hosts,
    /// A permit for each socket that has said hello.
    pub sockets: Arc<Semaphore>,
    /// A permit for each request under way.
    pub requests: Semaphore,
    /// A permit for each picture for HTTP under way.
    pub stills: Semaphore,
    /// A permit for each scene on its way here.
    pub uploads: Semaphore,
    /// Counts pictures for HTTP: each has a slot of its own in the renderer, from the other end than clients'.
    pub stills_begun: AtomicU64,
}

impl Server {
    /// Takes the data folder, makes the first session where it is missing, and opens the graphics device. Blocks.
    pub fn open(config: &Config) -> Result<Self, ServerError> {
        let data = config.data.clone();
        private::make_folder(&data)?;
        let lock = lock(&data)?;
        let mut store = Store::create(&data)?;
        ensure_session(&mut store, config)?;
        let token = Token::of(&data)?;
        let (renders, render_thread) = Renders::start()?;
        let public_urls = config.public_urls.clone();
        Ok(Self { store, renders, render_thread, token, data, public_urls, _lock: lock })
    }

    /// The secret that clients need.
    pub fn token(&self) -> &Token {
        &self.token
    }

    /// Serves until `shutdown`, then finishes what was accepted, within 10 seconds.
    pub async fn run(
        self,
        listener: TcpListener,
        shutdown: impl Future<Output = ()> + Send + 'static,
    ) -> Result<(), ServerError> {
        // Whether all ends well or is cut off, the render thread has ended when this returns.
        let Self { store, renders, render_thread: _render_thread, token, data, public_urls, _lock } = self;
        let address = listener.local_addr().map_err(ServerError::Listen)?;
        let metrics = Arc::new(Metrics::new());
        let storage = Storage::start(&data, store, Arc::clone(&metrics));
        let backend = Backend {
            scenes: Arc::new(Scenes::new(storage.clone())),
            storage,
            renders,
            metrics,
            draining: CancellationToken::new(),
            started: Instant::now(),
            sockets: TaskTracker::new(),
        };
        let shared = Arc::new(Shared {
            rooms: Rooms::start(backend.clone()),
            backend: backend.clone(),
            token,
            hosts: Hosts::new(address, &public_urls),
            sockets: Arc::new(Semaphore::new(MAX_SOCKETS)),
            requests: Semaphore::new(MAX_REQUESTS),
            stills: Semaphore::new(MAX_STILLS),
            uploads: Semaphore::new(MAX_UPLOADS),
            stills_begun: AtomicU64::new(0),
        });
        let router = http::router(Arc::clone(&shared));
        let serving = tokio::spawn(connections::serve(listener, router, backend.draining.clone()));
        shutdown.await;
        tracing::info!("stopping: what was accepted is finished");
        backend.draining.cancel();
        let drain = async {
            shared.rooms.drain().await;
            backend.sockets.close();
            backend.sockets.wait().await;
            serving.await
        };
        let Ok(served) = timeout(DRAIN_WITHIN, drain).await else {
            tracing::warn!("some connections did not end within {} s and are cut", DRAIN_WITHIN.as_secs());
            return Ok(());
        };
        served.map_err(|_| ServerError::Fault)
    }
}

fn lock(data: &Path) -> Result<File, ServerError> {
    let path = data.join(LOCK);
    let unusable = |reason| ServerError::Data { path: path.clone(), reason };
    let file =
        File::options().create(true).truncate(false).write(true).mode(0o600).open(&path).map_err(unusable)?;
    match file.try_lock() {
        Ok(()) => Ok(file),
        Err(TryLockError::WouldBlock) => Err(ServerError::Locked(data.into())),
        Err(TryLockError::Error(reason)) => Err(unusable(reason)),
    }
}

/// Makes the first session, with its scene as its first record.
fn ensure_session(store: &mut Store, config: &Config) -> Result<(), ServerError> {
    let name = &config.session;
    if store.sessions()?.iter().any(|row| row.name == *name) {
        return Ok(());
    }
    let (asset, scene) = first_scene(store, &config.scene)?;
    let actor = Actor { id: "server".into(), name: "Server".into() };
    let command = Command::LoadScene { asset, name: scene_label(&config.scene) };
    let request = Request::Edit { base_seq: None, command };
    let mut session = edit::Session::default();
    let committed =
        session.request(request, &actor, "first-scene", time_ms(), &|_| Some(Arc::clone(&scene)))?;
    store.create_session(name)?;
    if let Committed::New { record, .. } = committed {
        store.append(&[Batch { session: name, records: &[*record], hash: session.document().hash() }])?;
    }
    Ok(())
}

fn first_scene(store: &Store, name: &str) -> Result<(AssetHash, Arc<scene::Scene>), ServerError> {
    let bytes = match name.strip_prefix(crate::scenes::DEMO) {
        Some(demo) => assets::demo_bytes(demo).ok_or_else(|| ServerError::NoDemo(demo.into()))?,
        None => assets::pack(Path::new(name))?,
    };
    let loaded =
        assets::load_bytes(&bytes).map_err(|error| assets::AssetError { file: name.into(), ..error })?;
    Ok((store.put_asset(&bytes)?, Arc::new(loaded.scene)))
}

/// What people call a scene: a demo by its name, a file by its last part.
fn scene_label(name: &str) -> String {
    let label = Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name);
    let fits = label.char_indices().take_while(|(at, c)| at + c.len_utf8() <= scene::MAX_NAME_BYTES);
    fits.map(|(_, c)| c).collect()
}
