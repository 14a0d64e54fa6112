//! The other client: its connections, its threads, and counts of its requests.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::ops::{Deref, DerefMut};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

use serde::Serialize;

use crate::{BenchError, Client, ServerAddress};

/// Action of the other client in a row. It starts threads that go on until the other client leaves, and returns.
pub(super) type ClientAction = Box<dyn FnOnce(&OtherClient) -> Result<(), BenchError>>;

/// Interval at which a thread checks if the other client has to leave.
pub(super) const POLL_INTERVAL: Duration = Duration::from_millis(100);
/// Pause of a client after a refusal.
const AFTER_REFUSAL: Duration = Duration::from_millis(50);
/// Niceness of the other client's threads. They have a lower priority than the threads with which the server draws.
const NICE: i32 = 15;
/// Number of bytes of an answer that are kept. The rest is dropped.
const KEPT_BYTES: usize = 4096;
/// Number of connections above which the closed ones are removed from the list.
const PRUNE_CONNECTIONS_ABOVE: usize = 512;
/// Clients in one session: the most that a server accepts.
pub(super) const CLIENTS: usize = 64;

/// Counts of the other client's requests.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct OtherClientCounts {
    /// Number of actions and requests: drags, moves of views, views opened, requests, edits, bodies.
    pub done: u64,
    /// Number of answers to these: frames, pictures, responses, edits.
    pub answered: u64,
    /// Refusals by the server, closed connections included.
    pub refused: u64,
    /// Text of the first refusal.
    pub refusal: Option<String>,
}

/// The other client, shared by its threads.
#[derive(Clone, Debug)]
pub(super) struct OtherClient {
    pub address: ServerAddress,
    /// Name of the row, and of its first session.
    row_name: &'static str,
    /// Process id of the server.
    pub pid: u32,
    /// Duration of the measured period.
    pub span: Duration,
    many_actors: bool,
    shared: Arc<Shared>,
}

#[derive(Debug, Default)]
struct Shared {
    is_over: AtomicBool,
    counts: Mutex<OtherClientCounts>,
    /// Connections that are closed when the client leaves, so that no thread goes on waiting for an answer.
    connections: Mutex<Vec<TcpStream>>,
    threads: Mutex<Vec<JoinHandle<()>>>,
    writes: Mutex<Option<Writes>>,
}

/// Locks a value, even after a panic of another thread.
pub(super) fn locked<T>(value: &Mutex<T>) -> MutexGuard<'_, T> {
    value.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Bytes that the server wrote to disk per edit.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "camelCase")]
pub struct Writes {
    pub one_actor_bytes: f64,
    /// Bytes per edit if each edit has a new actor.
    pub many_actors_bytes: f64,
    /// `many_actors_bytes` over `one_actor_bytes`.
    pub ratio: f64,
}

/// Client whose connection is closed on drop, although the other client also has a handle of the connection.
pub(super) struct TrackedClient {
    client: Client,
    tcp: TcpStream,
}

impl Deref for TrackedClient {
    type Target = Client;

    fn deref(&self) -> &Client {
        &self.client
    }
}

impl DerefMut for TrackedClient {
    fn deref_mut(&mut self) -> &mut Client {
        &mut self.client
    }
}

impl Drop for TrackedClient {
    fn drop(&mut self) {
        let _ = self.tcp.shutdown(Shutdown::Both);
    }
}

impl OtherClient {
    pub fn new(address: ServerAddress, row_name: &'static str, pid: u32, span: Duration, many_actors: bool) -> Self {
        Self { address, row_name, pid, span, many_actors, shared: Arc::default() }
    }

    /// Returns the actor of a socket, by the socket's number.
    pub fn actor(&self, socket: usize) -> String {
        if self.many_actors { format!("other-{socket}") } else { "other".into() }
    }

    /// Returns the session of a socket, by the socket's number. A session has `CLIENTS` sockets.
    pub fn session(&self, socket: usize) -> String {
        match socket / CLIENTS {
            0 => self.row_name.into(),
            more => format!("{}-{more}", self.row_name),
        }
    }

    /// Connects a socket by its number.
    pub fn connect(&self, socket: usize) -> Result<TrackedClient, BenchError> {
        self.connect_to(&self.session(socket), socket)
    }

    pub fn connect_to(&self, session: &str, socket: usize) -> Result<TrackedClient, BenchError> {
        let tcp = self.tcp()?;
        let also = tcp.try_clone()?;
        let client = Client::connect_over(tcp, &self.address, session, &self.actor(socket), None)?;
        Ok(TrackedClient { client, tcp: also })
    }

    /// Opens a connection that is closed when the client leaves.
    pub fn tcp(&self) -> Result<TcpStream, BenchError> {
        let tcp = TcpStream::connect(&self.address.host)?;
        let mut connections = locked(&self.shared.connections);
        // Connections that have ended need not be closed.
        if connections.len() > PRUNE_CONNECTIONS_ABOVE {
            connections.retain(|connection| connection.peer_addr().is_ok());
        }
        connections.push(tcp.try_clone()?);
        Ok(tcp)
    }

    pub fn is_over(&self) -> bool {
        self.shared.is_over.load(Ordering::Relaxed)
    }

    /// Waits until the client leaves, for at most `time`.
    pub fn wait(&self, time: Duration) {
        let began = Instant::now();
        while began.elapsed() < time && !self.is_over() {
            thread::sleep(POLL_INTERVAL);
        }
    }

    pub fn wait_until_over(&self) {
        self.wait(Duration::MAX);
    }

    /// Starts a thread that repeats `act` until the client leaves. Errors are counted as refusals.
    pub fn spawn(&self, mut act: impl FnMut(&Self) -> Result<(), BenchError> + Send + 'static) {
        let other = self.clone();
        let thread = thread::spawn(move || {
            // A real client would run on another machine. If the system refuses the niceness, the rows are harder to
            // pass.
            let _refused = rustix::process::nice(NICE);
            while !other.is_over() {
                let acted = act(&other);
                if !other.is_over() {
                    other.count_refusal(acted);
                }
            }
        });
        locked(&self.shared.threads).push(thread);
    }

    /// Counts a refusal, and pauses before the next try.
    pub fn count_refusal(&self, acted: Result<(), BenchError>) {
        let Err(why) = acted else { return };
        let mut counts = locked(&self.shared.counts);
        counts.refused += 1;
        counts.refusal.get_or_insert(why.to_string());
        drop(counts);
        thread::sleep(AFTER_REFUSAL);
    }

    /// Counts actions or requests.
    pub fn count_done(&self, count: u64) {
        locked(&self.shared.counts).done += count;
    }

    /// Counts answers.
    pub fn count_answered(&self, count: u64) {
        locked(&self.shared.counts).answered += count;
    }

    pub fn counts(&self) -> OtherClientCounts {
        locked(&self.shared.counts).clone()
    }

    pub fn keep_writes(&self, writes: Writes) {
        *locked(&self.shared.writes) = Some(writes);
    }

    pub fn writes(&self) -> Option<Writes> {
        *locked(&self.shared.writes)
    }

    /// Closes all connections and waits for the threads.
    pub fn leave(&self) {
        self.shared.is_over.store(true, Ordering::Relaxed);
        let mut threads = std::mem::take(&mut *locked(&self.shared.threads));
        // The next round closes a connection that was just being opened.
        while !threads.is_empty() {
            self.close_connections();
            threads.retain(|thread| !thread.is_finished());
            thread::sleep(Duration::from_millis(20));
        }
        self.close_connections();
    }

    fn close_connections(&self) {
        for connection in locked(&self.shared.connections).drain(..) {
            let _ = connection.shutdown(Shutdown::Both);
        }
    }

    /// Sends a request over a new connection. Keeps only the beginning of the answer, and stops reading when the client
    /// leaves.
    pub fn ask(&self, method: &str, path: &str, body: &[u8]) -> Result<(), BenchError> {
        self.count_done(1);
        let mut tcp = self.send_request(method, path, body)?;
        self.read_answer(&mut tcp)?;
        self.count_answered(1);
        Ok(())
    }

    /// Sends a request and does not read the answer.
    pub fn send_request(&self, method: &str, path: &str, body: &[u8]) -> Result<TcpStream, BenchError> {
        let mut tcp = TcpStream::connect(&self.address.host)?;
        tcp.set_nodelay(true)?;
        tcp.set_write_timeout(Some(Duration::from_secs(30)))?;
        tcp.write_all(self.head(method, path, body.len()).as_bytes())?;
        tcp.write_all(body)?;
        Ok(tcp)
    }

    /// Makes the head of a request with a body of `body_bytes` bytes.
    pub fn head(&self, method: &str, path: &str, body_bytes: usize) -> String {
        let ServerAddress { host, token } = &self.address;
        format!(
            "{method} {path} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\nConnection: close\r\n\
             Content-Type: application/json\r\nContent-Length: {body_bytes}\r\n\r\n"
        )
    }

    /// Reads a response; an error if the server refuses.
    fn read_answer(&self, tcp: &mut TcpStream) -> Result<(), BenchError> {
        tcp.set_read_timeout(Some(POLL_INTERVAL))?;
        let (mut start, mut bytes) = (Vec::new(), vec![0; 1 << 16]);
        while !self.is_over() {
            match tcp.read(&mut bytes) {
                Ok(0) => break,
                Ok(count) => {
                    let room = KEPT_BYTES.saturating_sub(start.len());
                    start.extend_from_slice(&bytes[..count.min(room)]);
                }
                Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
                Err(error) => return Err(error.into()),
            }
        }
        let start = String::from_utf8_lossy(&start).into_owned();
        let status = start.split(' ').nth(1).and_then(|status| status.parse().ok());
        let status: u16 = status.ok_or_else(|| BenchError::Refused("it closed the connection".into()))?;
        if (200..300).contains(&status) {
            return Ok(());
        }
        let body = start.split_once("\r\n\r\n").map_or("", |(_, body)| body);
        Err(BenchError::Refused(format!("{status} {body}")))
    }
}
