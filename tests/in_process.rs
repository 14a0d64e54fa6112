//! A server in the process of the test, which starts at once and can be given what no program has.

use std::path::Path;

use bench::ServerAddress;
use server::{Server, ServerConfig};
use tokio::net::TcpListener;
use tokio::runtime::Runtime;

/// Server on a free port of the loopback interface. It ends with its runtime.
pub struct InProcessServer {
    pub runtime: Runtime,
    pub address: ServerAddress,
}

impl InProcessServer {
    /// Opens the data in `data`, with `scene` in session `main`, and serves it.
    pub fn start(data: &Path, scene: Option<&str>) -> Self {
        let (data, scene) = (data.to_owned(), scene.map(str::to_owned));
        let config = ServerConfig { data, scene, session: "main".into(), ..ServerConfig::default() };
        let server = Server::open(&config).expect("a server");
        let runtime = Runtime::new().expect("a runtime");
        let listener = runtime.block_on(TcpListener::bind("127.0.0.1:0")).expect("a port");
        let host = listener.local_addr().expect("bound").to_string();
        let address = ServerAddress { host, token: server.token().digits().into() };
        runtime.spawn(server.run(listener, runtime.handle().clone(), std::future::pending()));
        Self { runtime, address }
    }
}
