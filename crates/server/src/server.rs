//! Starting, serving, stopping.

use std::fs::{File, TryLockError};
use std::os::unix::fs::OpenOptionsExt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use document::{AssetHash, Command};
use edit::{Actor, Request, Sources};
use render::Ledger;
use store::{Batch, Store};
use tokio::net::TcpListener;
use tokio::sync::Semaphore;
use tokio::time::timeout;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::backend::Backend;
use crate::hosts::{Hosts, PublicUrl};
use crate::limits::{DRAIN_WITHIN, MAX_RENDER_BYTES, MAX_REQUESTS, MAX_SOCKETS, MAX_STILLS, MAX_UPLOADS};
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
    metrics: Arc<Metrics>,
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
}

impl Server {
    /// Takes the data folder, makes the first session where it is missing, and opens the graphics device. Blocks.
    pub fn open(config: &Config) -> Result<Self, ServerError> {
        let Data { store, token, lock } = Data::open(config)?;
        let metrics = Arc::new(Metrics::new(Ledger::new(MAX_RENDER_BYTES)));
        let (renders, render_thread) = Renders::start(Arc::clone(&metrics))?;
        let (data, public_urls) = (config.data.clone(), config.public_urls.clone());
        Ok(Self { store, renders, render_thread, metrics, token, data, public_urls, _lock: lock })
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
        let Self { store, renders, render_thread: _render_thread, metrics, token, data, public_urls, _lock } =
            self;
        let address = listener.local_addr().map_err(ServerError::Listen)?;
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

/// What lies in the data folder.
struct Data {
    store: Store,
    token: Token,
    lock: File,
}

impl Data {
    /// Takes the folder and makes what is missing. A start that is cut off leaves nothing half made.
    fn open(config: &Config) -> Result<Self, ServerError> {
        let folder = &config.data;
        private::make_folder(folder)?;
        let lock = lock(folder)?;
        let mut store = Store::create(folder)?;
        store.remove_leftovers()?;
        ensure_session(&mut store, config)?;
        let token = Token::of(folder)?;
        Ok(Self { store, token, lock })
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

/// Makes the first session, with its scene as its first record, or nothing. A session that has no record yet, as a start
/// that was cut off could leave it once, is given the scene too.
fn ensure_session(store: &mut Store, config: &Config) -> Result<(), ServerError> {
    let name = &config.session;
    let known = store.sessions()?.into_iter().find(|row| row.name == *name);
    if known.as_ref().is_some_and(|row| row.seq > 0) {
        return Ok(());
    }
    let (asset, scene) = first_scene(store, &config.scene)?;
    let actor = Actor { id: "server".into(), name: "Server".into() };
    let command = Command::LoadScene { asset, name: scene_label(&config.scene) };
    let request = Request::Edit { base_seq: None, command };
    let mut session = edit::Session::default();
    let sources = Sources { scene: &|_| Some(Arc::clone(&scene)), taken_back: None };
    let record = session.request(request, &actor, "first-scene", time_ms(), sources)?;
    let (records, hash) = (&[record], session.document().hash());
    let first = Batch { session: name, records, rejections: &[], hash };
    match known {
        None => drop(store.begin_session(&first)?),
        Some(_) => drop(store.append(&[first])?),
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
    let asset = store.put_asset(&bytes)?;
    if loaded.name.as_deref() != Some(name) {
        store.name_asset(&asset, &scene_label(name))?;
    }
    Ok((asset, Arc::new(loaded.scene)))
}

/// What people call a scene: a demo by its name, a file by its last part, as far as that is fit to be a name.
fn scene_label(name: &str) -> String {
    let label = Path::new(name).file_name().and_then(|name| name.to_str()).unwrap_or(name);
    let fits = label.char_indices().take_while(|(at, c)| at + c.len_utf8() <= document::MAX_NAME_BYTES);
    let label: String = fits.map(|(_, c)| c).filter(|c| !c.is_control()).collect();
    let label = label.trim();
    if label.is_empty() { "scene".into() } else { label.into() }
}

/// Tests that kill a first start at every write and every sync. They stand here to start no renderer.
#[cfg(test)]
mod tests {
    use std::env;
    use std::process::{Command as Process, Stdio};

    use super::*;

    const CHILD: &str = "server::tests::child_that_starts";
    const FOLDER: &str = "BENDYLIGHTS_CHILD_FOLDER";

    fn config(data: &Path) -> Config {
        let (session, scene, public_urls) = ("main".into(), "demo:vases".into(), Vec::new());
        Config { data: data.into(), session, scene, public_urls }
    }

    #[test]
    #[ignore = "the child of the test below, which starts it"]
    fn child_that_starts() {
        let folder = env::var(FOLDER).expect("started by a test");
        drop(Data::open(&config(Path::new(&folder))).expect("a start"));
    }

    /// Whether a start that is killed at call `number` of `call` was over before.
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
        let Ok(opened) = Data::open(&config(data)) else { return false };
        let row = opened.store.session("main").expect("a session");
        let find_scene = |_: &AssetHash| assets::demo("vases").map(Arc::new);
        let document = opened.store.replay("main", None, &find_scene).expect("a log").document().clone();
        row.seq == 1 && !document.lights().is_empty() && opened.token.digits().len() == 32
    }

    /// Rules: HTTP-4
    #[test]
    fn a_first_start_that_is_killed_anywhere_is_made_up_for_by_the_next() {
        let can_trace = Process::new("strace").args(["-o", "/dev/null", "true"]).output();
        if !can_trace.is_ok_and(|done| done.status.success()) {
            assert_ne!(
                env::var("CI").as_deref(),
                Ok("true"),
                "strace cannot run here: install it, allow ptrace"
            );
            println!("skipped: strace cannot run here");
            return;
        }
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

    /// A session without a record is what a start that made the session first, and its scene later, could leave.
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
            let bytes = format!(r#"{{"asset": {{"version": "2.0", "generator": "{}"}}}}"#, file.len());
            std::fs::write(&scene, &bytes).expect("a scene's file");
            let data = tempfile::tempdir().expect("a folder");
            let config = Config { scene: scene.display().to_string(), ..config(data.path()) };
            let store = Data::open(&config).expect("a start").store;
            let asset = AssetHash::of(bytes.as_bytes());
            assert_eq!(store.asset_name(&asset).expect("no error").as_deref(), Some(name), "{file:?}");
        }
    }
}
