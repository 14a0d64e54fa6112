//! Servers for tests.

use std::io::{Read, Write};
use std::net::{SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use std::time::Duration;
use std::{fs, thread};

use server::{Server, ServerConfig, ServerError};
use tempfile::TempDir;
use tokio::net::TcpListener;
use tokio::runtime::{Handle, Runtime};
use tokio::sync::oneshot;
use tokio::task::{JoinHandle, spawn_blocking};

/// Address of a server, and the token for it.
#[derive(Clone)]
pub struct ServerDoor {
    pub address: SocketAddr,
    pub token: String,
}

/// A server for one test.
pub struct OwnServer {
    pub door: ServerDoor,
    pub folder: TempDir,
    stop: oneshot::Sender<()>,
    served: JoinHandle<Result<(), ServerError>>,
}

/// The server that tests share. Each test uses its own sessions. It ends with the process, so it is warm before its
/// use: a process that ends while its driver compiles may crash.
pub static SHARED: LazyLock<ServerDoor> = LazyLock::new(|| {
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("shared-server");
    let _ = fs::remove_dir_all(&folder);
    let (opened, door) = std::sync::mpsc::sync_channel(1);
    thread::spawn(move || {
        Runtime::new().unwrap().block_on(async move {
            let (door, server, listener) = open(&folder).await;
            opened.send(door).unwrap();
            server.run(listener, Handle::current(), std::future::pending()).await.unwrap();
        });
    });
    let door = door.recv().unwrap();
    for _ in 0..2400 {
        if is_ready(door.address) {
            return door;
        }
        thread::sleep(Duration::from_millis(50));
    }
    panic!("the server is not warm after two minutes");
});

/// True if a server has drawn with every common pipeline.
pub fn is_ready(address: SocketAddr) -> bool {
    let mut stream = TcpStream::connect(address).unwrap();
    stream.write_all(b"GET /readyz HTTP/1.1\r\nHost: localhost\r\nConnection: close\r\n\r\n").unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    answer.starts_with("HTTP/1.1 200 ")
}

impl OwnServer {
    pub async fn start() -> Self {
        Self::start_in(TempDir::new().unwrap()).await
    }

    pub async fn start_in(folder: TempDir) -> Self {
        let (door, server, listener) = open(folder.path()).await;
        let (stop, stopped) = oneshot::channel();
        let served = tokio::spawn(server.run(listener, Handle::current(), async { stopped.await.unwrap() }));
        Self { door, folder, stop, served }
    }

    /// Stops the server and returns its folder.
    pub async fn stopped(self) -> TempDir {
        let (folder, served) = self.stop();
        served.await.unwrap().unwrap();
        folder
    }

    /// Asks the server to stop.
    pub fn stop(self) -> (TempDir, JoinHandle<Result<(), ServerError>>) {
        self.stop.send(()).unwrap();
        (self.folder, self.served)
    }
}

async fn open(folder: &Path) -> (ServerDoor, Server, TcpListener) {
    let config = ServerConfig {
        data: folder.into(),
        session: "main".into(),
        public_urls: vec!["https://lights.example.org".parse().unwrap()],
        ..ServerConfig::default()
    };
    let server = spawn_blocking(move || Server::open(&config).unwrap()).await.unwrap();
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    (ServerDoor { address, token: server.token().digits().to_owned() }, server, listener)
}
