//! Start, run and stop of the server.

use std::fs::File;
use std::num::NonZero;
use std::path::PathBuf;
use std::sync::Arc;
use std::thread::available_parallelism;
use std::time::Instant;

use render::MemoryBudget;
use store::Store;
use tokio::net::TcpListener;
use tokio::runtime::Handle;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_util::task::TaskTracker;

use crate::access::{Hosts, PublicUrl, TOKEN_FILE, Token, random_digits};
use crate::anonymous::AnonymousPermits;
use crate::connections::{self, ShutdownSignals};
use crate::first_session::StartSession;
use crate::in_flight::ByteBudget;
use crate::limits::{
    DRAIN_TIMEOUT, MAX_PROBES, MAX_RENDER_BYTES, MAX_REQUESTS, MAX_SOCKETS, MAX_STILLS, MAX_UPLOADS,
    THROTTLED_EDIT_RATE, THROTTLED_REQUEST_RATE,
};
use crate::metrics::Metrics;
use crate::pacing::RequestPacing;
use crate::permits::SessionPermits;
use crate::renderer::{RenderQueue, RenderThread};
use crate::room::Rooms;
use crate::scenes::SceneCache;
use crate::services::Services;
use crate::solver::Solver;
use crate::state::AppState;
use crate::storage::Storage;
use crate::trace::{Trace, TraceThread};
use crate::views::MovingPixels;
use crate::{ServerError, data_folder, first_session, http};

/// Configuration of a server.
#[derive(Clone, Debug, Default)]
pub struct ServerConfig {
    /// Data folder, made if it is missing.
    pub data: PathBuf,
    /// Name of the first session, which the server makes.
    pub session: String,
    /// A scene to serve: a file, or `demo:NAME`. The first session loads it when it is made. If that session has
    /// another scene already, the server makes a session for the given scene.
    pub scene: Option<String>,
    /// File of the token, made if it is missing. `None` means a file in the data folder.
    pub token_file: Option<PathBuf>,
    /// Addresses for browsers besides the one that the server listens on.
    pub public_urls: Vec<PublicUrl>,
    /// File to which a line is appended for each picture (SPEC, TRACE-1).
    pub trace: Option<PathBuf>,
    /// Backend of shadows and lights. `None` chooses it by the graphics device.
    pub backend: Option<render::Backend>,
}

/// A server that is ready to listen.
pub struct Server {
    config: ServerConfig,
    renders: RenderQueue,
    render_thread: RenderThread,
    in_flight: ByteBudget,
    metrics: Arc<Metrics>,
    trace: Trace,
    trace_thread: Option<TraceThread>,
    /// Dropped last, since it has the lock of the folder.
    opened: OpenedDataFolder,
}

impl Server {
    /// Locks the data folder, makes the first session if it is missing, and opens the graphics device. Blocks.
    pub fn open(config: &ServerConfig) -> Result<Self, ServerError> {
        let (trace, trace_thread) = config.trace.as_deref().map(Trace::start).transpose()?.unzip();
        let (config, trace) = (config.clone(), trace.unwrap_or_default());
        let opened = OpenedDataFolder::open(&config)?;
        let in_flight = ByteBudget::default();
        let metrics = Arc::new(Metrics::new(MemoryBudget::new(MAX_RENDER_BYTES), in_flight.clone()));
        let (renders, render_thread) = RenderQueue::start(Arc::clone(&metrics), config.backend)?;
        Ok(Self { config, renders, render_thread, in_flight, metrics, trace, trace_thread, opened })
    }

    /// Returns the secret that clients need.
    pub fn token(&self) -> &Token {
        &self.opened.token
    }

    /// Waits until every pipeline has drawn or one has failed. Resolves to true if all have drawn.
    pub fn wait_until_warm(&self) -> impl Future<Output = bool> + Send + 'static {
        self.renders.wait_until_warm()
    }

    /// Returns the session that the start opens.
    pub fn session(&self) -> &StartSession {
        &self.opened.session
    }

    /// Serves until `shutdown`, then finishes accepted work within 10 seconds. Sockets run on the current runtime, and
    /// HTTP requests on `requests`, which may be the same.
    pub async fn run(
        self,
        listener: TcpListener,
        requests: Handle,
        shutdown: impl Future<Output = ()> + Send + 'static,
    ) -> Result<(), ServerError> {
        // In every case the render thread has ended when this returns, and the trace has all its pictures.
        let Self { config, opened, renders, in_flight, metrics, trace, .. } = self;
        let OpenedDataFolder { store, token, _lock, .. } = opened;
        let (_trace_thread, _render_thread) = (self.trace_thread, self.render_thread);
        let address = listener.local_addr().map_err(ServerError::Listen)?;
        let storage = Storage::start(&config.data, store, Arc::clone(&metrics));
        let cores = available_parallelism().map_or(1, NonZero::get);
        let moving_pixels = Arc::<MovingPixels>::default();
        let ending = ShutdownSignals::default();
        let services = Services {
            scenes: Arc::new(SceneCache::new(storage.clone(), Arc::clone(&metrics), Arc::clone(&moving_pixels))),
            storage,
            renders,
            moving_pixels: Arc::clone(&moving_pixels),
            probes: Arc::new(Semaphore::new(MAX_PROBES)),
            solver: Solver::new(cores, metrics.solves_under_way.clone(), Arc::clone(&moving_pixels)),
            edit_pacing: Arc::new(RequestPacing::new(THROTTLED_EDIT_RATE, Arc::clone(&moving_pixels))),
            request_pacing: Arc::new(RequestPacing::new(THROTTLED_REQUEST_RATE, moving_pixels)),
            in_flight,
            metrics,
            trace,
            draining: ending.draining.clone(),
            run: random_digits().map_err(|_| ServerError::Internal)?.into(),
            started: Instant::now(),
            sockets: TaskTracker::new(),
        };
        let state = Arc::new(AppState {
            rooms: Rooms::start(services.clone()),
            services: services.clone(),
            token,
            socket_runtime: Handle::current(),
            hosts: Hosts::new(address, &config.public_urls),
            sockets: Arc::new(Semaphore::new(MAX_SOCKETS)),
            requests: SessionPermits::new("requests", MAX_REQUESTS),
            stills: SessionPermits::new("pictures", MAX_STILLS),
            uploads: Semaphore::new(MAX_UPLOADS),
            anonymous_short_permits: AnonymousPermits::new(),
            anonymous_permits: AnonymousPermits::new(),
        });
        let router = http::router(Arc::clone(&state));
        let serving = tokio::spawn(connections::serve(listener, requests, router, ending.clone()));
        shutdown.await;
        tracing::info!("stopping: what was accepted is finished");
        ending.draining.cancel();
        let drain = async {
            state.rooms.drain().await;
            services.sockets.close();
            services.sockets.wait().await;
            ending.sockets_ended.cancel();
            serving.await
        };
        let Ok(served) = timeout(DRAIN_TIMEOUT, drain).await else {
            tracing::warn!("some connections did not end within {} s and are cut", DRAIN_TIMEOUT.as_secs());
            return Ok(());
        };
        served.map_err(|_| ServerError::Internal)
    }
}

/// Opened parts of the data folder.
struct OpenedDataFolder {
    store: Store,
    token: Token,
    session: StartSession,
    /// Locks the folder against a second server.
    _lock: File,
}

impl OpenedDataFolder {
    /// Locks the folder and makes its missing files. An interrupted start leaves nothing incomplete.
    fn open(config: &ServerConfig) -> Result<Self, ServerError> {
        let folder = &config.data;
        data_folder::make(folder)?;
        let lock = data_folder::lock(folder)?;
        let mut store = Store::create(folder)?;
        store.assets.remove_leftovers()?;
        let session = first_session::ensure(&mut store, &config.session, config.scene.as_deref())?;
        let token = Token::from_file(&config.token_file.clone().unwrap_or_else(|| folder.join(TOKEN_FILE)))?;
        Ok(Self { store, token, session, _lock: lock })
    }
}

/// Tests that kill the first start of a server at every write and every sync. They are in this file because they open
/// the data folder alone, without a renderer.
#[cfg(test)]
mod tests {
    use std::env;
    use std::path::Path;
    use std::process::{Command as Process, Stdio};

    use document::AssetHash;

    use super::*;

    const CHILD: &str = "server::tests::child_that_starts";
    const FOLDER: &str = "BENDYLIGHTS_CHILD_FOLDER";

    fn start(data: &Path, scene: Option<&str>) -> Result<OpenedDataFolder, ServerError> {
        let (data, session, scene) = (data.into(), "main".into(), scene.map(str::to_owned));
        OpenedDataFolder::open(&ServerConfig { data, session, scene, ..ServerConfig::default() })
    }

    /// Writes a scene's file whose bytes differ from those of other marks, and returns them.
    fn write_scene(file: &Path, mark: usize) -> String {
        let text = format!(r#"{{"asset": {{"version": "2.0", "generator": "{mark}"}}}}"#);
        std::fs::write(file, &text).expect("a scene's file");
        text
    }

    #[test]
    #[ignore = "the child of the test below, which starts it"]
    fn child_that_starts() {
        let folder = env::var(FOLDER).expect("started by a test");
        drop(start(Path::new(&folder), None).expect("a start"));
    }

    /// True if a start ended before call `number` of `call`, at which it would have been killed.
    fn is_done_before(call: &str, number: usize, data: &Path) -> bool {
        let test = env::current_exe().expect("this program");
        let (trace, inject) = (format!("trace={call}"), format!("inject={call}:signal=KILL:when={number}"));
        let mut strace = Process::new("strace");
        strace.args(["-f", "-o", "/dev/null", "-e", &trace, "-e", &inject]).arg(test);
        strace.args(["--exact", CHILD, "--ignored", "--test-threads=1"]).env(FOLDER, data);
        let status = strace.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null()).status();
        status.expect("strace runs").success()
    }

    fn is_whole(data: &Path) -> bool {
        let Ok(opened) = start(data, None) else { return false };
        let row = opened.store.session("main").expect("a session");
        let document = opened.store.replay("main", None).expect("a log").document().clone();
        row.seq == 1 && !document.lights().is_empty() && opened.token.digits().len() == 32
    }

    /// Rules: HTTP-4
    #[test]
    #[ignore = "needs strace"]
    fn a_first_start_that_is_killed_anywhere_is_made_up_for_by_the_next() {
        let can_trace = Process::new("strace").args(["-o", "/dev/null", "true"]).status();
        assert!(can_trace.is_ok_and(|status| status.success()), "install strace, allow ptrace");
        let mut kills = 0;
        for call in ["write", "pwrite64", "fsync", "fdatasync", "rename", "mkdir", "unlink"] {
            for number in 1.. {
                let folder = tempfile::tempdir().expect("a folder");
                let data = folder.path().join("data");
                let is_done = is_done_before(call, number, &data);
                assert!(is_whole(&data), "killed at {call} {number}");
                if is_done {
                    break;
                }
                kills += 1;
            }
        }
        assert!(kills > 20, "{kills} places to kill it at");
    }

    /// A start that made the session first and added its scene later could leave a session without a record.
    ///
    /// Rules: HTTP-4
    #[test]
    fn a_session_that_was_left_empty_gets_its_scene() {
        let folder = tempfile::tempdir().expect("a folder");
        Store::create(folder.path()).expect("a store").create_session("main").expect("a session");
        assert!(is_whole(folder.path()));
    }

    /// Rules: HTTP-10
    #[test]
    fn the_first_scene_is_called_as_its_file() {
        let folder = tempfile::tempdir().expect("a folder");
        for (file, name) in [("room.gltf", "room.gltf"), (" ro\nom.gltf ", "room.gltf"), ("\u{1}", "scene")] {
            let scene = folder.path().join(file);
            let bytes = write_scene(&scene, file.len());
            let data = tempfile::tempdir().expect("a folder");
            let store = start(data.path(), scene.to_str()).expect("a start").store;
            let asset = AssetHash::of(bytes.as_bytes());
            assert_eq!(store.assets.name_of(&asset).expect("no error").as_deref(), Some(name), "{file:?}");
        }
    }

    /// Rules: HTTP-10
    #[test]
    fn a_scene_that_the_first_session_does_not_hold_gets_its_own() {
        let (folder, data) = (tempfile::tempdir().expect("a folder"), tempfile::tempdir().expect("a folder"));
        let file = folder.path().join("my room.gltf");
        let start = |scene: Option<&str>| start(data.path(), scene).expect("a start").session;
        let scene = file.display().to_string();
        let of = |name: &str, own_scene: Option<&str>| {
            let scene_already_there = own_scene.map(str::to_owned);
            StartSession { name: name.into(), scene_already_there }
        };
        write_scene(&file, 1);
        assert_eq!(start(None), of("main", None));
        assert_eq!(start(Some("demo:vases")), of("main", None), "it holds that");
        assert_eq!(start(Some(&scene)), of("my-room", Some("demo:vases")));
        assert_eq!(start(Some(&scene)), of("my-room", Some("demo:vases")), "found again");
        write_scene(&file, 2);
        assert_eq!(start(Some(&scene)), of("my-room-2", Some("demo:vases")), "another file under that name");
        assert_eq!(start(None), of("main", None));
        let store = Store::open(data.path()).expect("a store");
        let names: Vec<_> = store.sessions().expect("a list").into_iter().map(|row| (row.name, row.seq)).collect();
        assert_eq!(names, ["main", "my-room", "my-room-2"].map(|name| (name.to_owned(), 1)));
        drop(store);
        // A session that cannot be read does not count as the scene's, and does not prevent a start.
        let database = rusqlite::Connection::open(data.path().join("bendylights.sqlite")).expect("a database");
        let fault = "DROP TRIGGER record_stays; UPDATE record SET json = 'damaged'";
        database.execute_batch(fault).expect("a planted fault");
        assert_eq!(start(Some(&scene)), of("my-room-3", Some("what it has")));
    }

    /// Rules: HTTP-35
    #[test]
    fn a_first_session_that_was_deleted_stays_so_but_for_a_scene() {
        let data = tempfile::tempdir().expect("a folder");
        let start = |scene: Option<&str>| start(data.path(), scene).expect("a start").store;
        let names = |store: &Store| -> Vec<String> {
            store.sessions().expect("a list").into_iter().map(|row| row.name).collect()
        };
        let mut store = start(None);
        store.create_session("other").expect("a session");
        let archived = store::SessionChange { archived: Some(true), ..Default::default() };
        store.change_session("main", &archived).expect("archived");
        store.delete_session("main").expect("deleted");
        drop(store);
        assert_eq!(names(&start(None)), ["other"]);
        assert_eq!(names(&start(Some("demo:arbor"))), ["main", "other"]);
    }
}
