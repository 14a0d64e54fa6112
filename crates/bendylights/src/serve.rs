//! `bendylights serve`: starts the render server.

use std::io::{self, IsTerminal};
use std::net::{Ipv4Addr, Ipv6Addr, SocketAddr, TcpListener};
use std::path::PathBuf;

use cli::{print_answer, print_note};
use server::{PublicUrl, Server, ServerConfig, StartSession};
use tokio::runtime::Runtime;
use tokio::signal::unix::{SignalKind, signal};
use tracing_subscriber::EnvFilter;

use crate::error::Error;
use crate::gpu::BackendArgs;
use crate::usage::{DATA, ListenAddress};

/// Name of the session in a new data folder.
const SESSION: &str = "main";

#[derive(clap::Args)]
#[command(after_help = "\
Prints the address to open, with the token that lets its bearer in: of the list of sessions or, with --scene, of that
scene's session. Whoever has the address can edit and see everything.
With --token-file it is printed without the token, as for a service whose standard output many can read; the page then
asks for that.

Stop it with Ctrl+C or SIGTERM: it finishes what it has accepted. Edits are on disk before they are acknowledged, and so
survive any other end too. RUST_LOG=debug says more of what it does.

Examples:
  bendylights serve
  bendylights serve --scene room.glb --data room-data
  bendylights serve --listen 9000
  bendylights serve --trace trace.jsonl")]
pub struct Args {
    /// Address to listen on: HOST:PORT, or a port of 127.0.0.1 alone; port 0 takes a free one
    #[arg(long, default_value = "127.0.0.1:8080", value_name = "ADDR", aliases = ["addr", "address", "bind", "port"])]
    listen: ListenAddress,
    /// Folder of edit logs, scenes and the token; made where it is missing
    #[arg(long, default_value = DATA, value_name = "DIR")]
    data: PathBuf,
    /// glTF file (.gltf or .glb) or `demo:NAME`: the session `main` begins with it, or, where that
    /// holds another, a session of the scene's name [default: demo:vases, in a new folder]
    #[arg(long, value_name = "SCENE")]
    scene: Option<String>,
    /// File of the token, 32 hexadecimal digits, made where it is missing [default: `token` in the data folder]
    #[arg(long, value_name = "FILE")]
    token_file: Option<PathBuf>,
    /// Address at which browsers find it, such as a proxy's: `https://lights.example.org`; may be given more than once
    #[arg(long, value_name = "URL")]
    public_url: Vec<PublicUrl>,
    /// File to whose end a line of JSON is written for each picture: when, of what, how long
    /// it took, which passes ran and why
    #[arg(long, value_name = "FILE")]
    trace: Option<PathBuf>,
    #[command(flatten)]
    backend: BackendArgs,
}

pub fn run(args: &Args) -> Result<(), Error> {
    cli::restart_without_window_system();
    let filter = EnvFilter::try_from_default_env()
        .unwrap_or_else(|_| EnvFilter::new(if cli::is_quiet() { "error" } else { "info,wgpu=warn" }));
    let colors = io::stderr().is_terminal();
    let log = tracing_subscriber::fmt().with_env_filter(filter).with_writer(io::stderr).with_ansi(colors);
    // Without this, an error of writing to standard error (a full disk, a closed pipe) is a panic.
    log.log_internal_errors(false).init();

    let (listener, address) = listen(&args.listen.0).map_err(|reason| {
        let address = args.listen.0.clone();
        Error::CannotListen { address, reason }
    })?;
    if !address.ip().is_loopback() {
        print_note(&format!(
            "note: {address} can be reached from other machines, and what is sent is not encrypted: put a proxy with TLS in \
             front, or listen on 127.0.0.1"
        ));
    }
    let config = ServerConfig {
        data: args.data.clone(),
        session: SESSION.into(),
        scene: args.scene.clone(),
        token_file: args.token_file.clone(),
        public_urls: args.public_url.clone(),
        trace: args.trace.clone(),
        backend: args.backend.wanted(),
    };
    let server = Server::open(&config)?;
    let url = args.public_url.first().map_or_else(|| format!("http://{}", reachable(address)), PublicUrl::to_string);
    let StartSession { name, scene_already_there: kept } = server.session();
    let mut page = vec![];
    if args.token_file.is_none() {
        page.push(format!("token={}", server.token().digits()));
    }
    if let Some(scene) = &args.scene {
        if let Some(kept) = kept {
            print_note(&format!("note: session `{SESSION}` keeps {kept}; {scene} is served as session `{name}`"));
        }
        page.push(format!("session={name}"));
    }
    let page = if page.is_empty() { format!("{url}/") } else { format!("{url}/#{}", page.join("&")) };
    let runtime = Runtime::new().map_err(Error::NoRuntime)?;
    let requests = server::request_runtime().map_err(Error::NoRuntime)?;
    let served = runtime.block_on(async {
        let stop = stop_signal().map_err(Error::NoRuntime)?;
        let listener = tokio::net::TcpListener::from_std(listener).map_err(Error::NoRuntime)?;
        print_answer(&page)?;
        let is_warm = server.wait_until_warm();
        runtime.spawn(async move {
            // The last line of a service's journal, without the token.
            if is_warm.await {
                tracing::info!("ready at {url}");
            }
        });
        Ok(server.run(listener, requests.handle().clone(), stop).await?)
    });
    // Shutdown does not wait for a scene that is being decoded.
    requests.shutdown_background();
    runtime.shutdown_background();
    served
}

fn listen(address: &str) -> io::Result<(TcpListener, SocketAddr)> {
    let listener = TcpListener::bind(address)?;
    listener.set_nonblocking(true)?;
    let address = listener.local_addr()?;
    Ok((listener, address))
}

/// Returns the address at which a browser on this machine reaches a server that listens on all addresses.
fn reachable(address: SocketAddr) -> SocketAddr {
    match address {
        SocketAddr::V4(v4) if v4.ip().is_unspecified() => (Ipv4Addr::LOCALHOST, v4.port()).into(),
        SocketAddr::V6(v6) if v6.ip().is_unspecified() => (Ipv6Addr::LOCALHOST, v6.port()).into(),
        other => other,
    }
}

/// Returns a future that ends on SIGTERM or SIGINT.
fn stop_signal() -> io::Result<impl Future<Output = ()> + Send + 'static> {
    let (mut terminate, mut interrupt) = (signal(SignalKind::terminate())?, signal(SignalKind::interrupt())?);
    Ok(async move {
        tokio::select! {
            _ = terminate.recv() => {}
            _ = interrupt.recv() => {}
        }
    })
}
