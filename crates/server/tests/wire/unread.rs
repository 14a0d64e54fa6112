//! Clients that read nothing, and the memory that a server process holds for them.

use std::io::{BufRead, BufReader, Read};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::Duration;
use std::{env, fs, io};

use futures_util::future::join;
use protocol::ErrorCode;
use serde_json::{Value, json};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::task::spawn_blocking;
use tokio::time::{Instant, pause, sleep};

use crate::client::{
    Client, SMALL_BUFFER_BYTES, connect_with_buffer, get, head_of, make_session, on_thread, results_of, send_raw,
    wait_until,
};
use crate::server::{OwnServer, ServerDoor, is_ready};

const MIB: u64 = 1 << 20;

/// Rules: SOCK-10
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "the child of the test below, which starts it"]
async fn child_that_serves_until_its_input_ends() {
    let own = OwnServer::start().await;
    println!("door {} {}", own.door.address, own.door.token);
    spawn_blocking(|| io::stdin().read_to_end(&mut Vec::new())).await.unwrap().unwrap();
    own.stopped().await;
}

/// A server in another process.
struct ChildServer {
    door: ServerDoor,
    child: Child,
    /// The server ends when this is dropped.
    _input: ChildStdin,
}

impl ChildServer {
    fn start() -> Self {
        let child = ["--exact", "unread::child_that_serves_until_its_input_ends", "--ignored", "--nocapture"];
        let mut command = Command::new(env::current_exe().unwrap());
        command.args(child).stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut child = command.spawn().unwrap();
        let input = child.stdin.take().unwrap();
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let door = lines.map_while(Result::ok).find_map(|line| {
            let (address, token) = line.split_once("door ")?.1.split_once(' ')?;
            Some(ServerDoor { address: address.parse().unwrap(), token: token.to_owned() })
        });
        Self { door: door.expect("it serves"), child, _input: input }
    }

    /// Returns the resident memory in bytes.
    fn resident(&self) -> u64 {
        let status = fs::read_to_string(format!("/proc/{}/status", self.child.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() << 10
    }
}

impl Drop for ChildServer {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

fn edit(door: &ServerDoor, command: &Value) {
    let results = results_of(door, "large", &json!([{ "command": command }]));
    assert_eq!(results[0]["status"], "committed", "{results:?}");
}

/// Opens a session whose document has more than 16 MiB.
fn large_session(door: &ServerDoor) {
    make_session(door, &json!({"name": "large"}));
    let paths: Vec<String> = (0..256).map(|n| format!("{n:0>250}")).collect();
    let links = json!({ "include": paths });
    let light = json!({"type": "spot", "lightLink": links, "shadowLink": links});
    for _ in 0..132 {
        edit(door, &json!({"type": "addLight", "light": light}));
    }
    assert!(get(door, "/sessions/large").body.len() as u64 > 16 * MIB);
}

fn document_request(door: &ServerDoor) -> String {
    head_of(door, "GET /sessions/large", "Content-Length: 0")
}

/// Connects a socket that says hello, and sends a request for the document. The client reads nothing from either
/// connection.
async fn reads_nothing(door: &ServerDoor, number: usize) -> (Client, TcpStream) {
    let mut socket = Client::connect(door).await;
    socket.say_hello(door, "large", &format!("client {number}")).await;
    (socket, send_raw(door, document_request(door)).await)
}

/// Deliberate fault that the check must detect: each client asks for another revision, so their texts cannot be shared.
///
/// Rules: SOCK-10, SOCK-13, HTTP-26
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_document_is_held_once_however_many_read_nothing_of_it() {
    let server = spawn_blocking(ChildServer::start).await.unwrap();
    let door = server.door.clone();
    while !is_ready(door.address) {
        sleep(Duration::from_millis(50)).await;
    }
    on_thread(&door, large_session).await;
    let before = server.resident();
    let mut readers = Vec::new();
    for number in 0..60 {
        readers.push(reads_nothing(&door, number).await);
    }
    sleep(Duration::from_secs(3)).await;
    let shared = server.resident().saturating_sub(before);
    assert!(shared < 100 * MIB, "{} MiB for 120 that read nothing of 16", shared / MIB);
    drop(readers);
    let mut readers = Vec::new();
    for number in 0..30 {
        let rename = json!({"type": "setLight", "light": 1, "parameter": {"name": format!("lamp {number}")}});
        on_thread(&door, move |door| edit(door, &rename)).await;
        readers.push(reads_nothing(&door, number).await);
    }
    sleep(Duration::from_secs(3)).await;
    let apart = server.resident().saturating_sub(before);
    assert!(apart > 200 * MIB, "{} MiB: texts that are not shared are seen", apart / MIB);
    assert!(apart < 600 * MIB, "{} MiB: and no more of them are made than the account has room for", apart / MIB);
    let refused = on_thread(&door, |door| get(door, "/sessions/large")).await;
    assert_eq!(refused.refusal(), (503, "busy".into()));
    let mut late = Client::connect(&door).await;
    late.say_hello(&door, "large", "Late").await;
    assert_eq!(late.fatal_error().await.0, ErrorCode::Busy);
    drop(readers);
    let is_admitted = async || Client::connect(&door).await.greet(&door, "large", "Ada").await.is_some();
    wait_until("freed reservations have room for a client", is_admitted).await;
}

/// Reads a little every 10 seconds, so never nothing for 30, until the connection ends. Returns the time until then.
async fn take_slowly(mut stream: impl AsyncRead + Unpin) -> Duration {
    let (began, mut part) = (Instant::now(), vec![0; 32 << 10]);
    while let Ok(1..) = stream.read(&mut part).await {
        sleep(Duration::from_secs(10)).await;
    }
    began.elapsed()
}

/// Rules: SOCK-10, HTTP-26
#[tokio::test]
async fn slow_readers_are_disconnected() {
    let own = OwnServer::start().await;
    on_thread(&own.door, large_session).await;
    let mut http = connect_with_buffer(&own.door, SMALL_BUFFER_BYTES).await;
    http.write_all(document_request(&own.door).as_bytes()).await.unwrap();
    let mut client = Client::connect_with_small_buffers(&own.door).await;
    client.say_hello(&own.door, "large", "Ada").await;
    let mut client = client.into_stream();
    for stream in [&mut http as &mut (dyn AsyncRead + Unpin), &mut client] {
        stream.read_exact(&mut [0; 4]).await.unwrap();
    }
    // From here on time advances once everybody waits.
    pause();
    let (of_http, of_socket) = join(take_slowly(http), take_slowly(client)).await;
    // 17 MiB at 16 KiB per second. At 32 KiB in 10 seconds all of it would take 90 minutes.
    for taken in [of_http, of_socket] {
        assert!((Duration::from_mins(17)..Duration::from_hours(1)).contains(&taken), "{taken:?}");
    }
}
