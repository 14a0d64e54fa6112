//! Connections from their first byte: how many there may be, and for how long they may keep the server waiting.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;

use axum::Router;
use axum::body::Bytes;
use axum::extract::Request;
use hyper::body::Incoming;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use rustix::net::sockopt::{set_socket_recv_buffer_size, set_socket_send_buffer_size};
use tokio::net::{TcpListener, TcpStream};
use tokio::runtime::Handle;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{sleep, timeout};
use tokio_util::sync::{CancellationToken, DropGuard};
use tokio_util::task::TaskTracker;

use crate::in_flight::taken_within;
use crate::limits::{
    HEADERS_WITHIN, MAX_CONNECTIONS, MAX_HEAD_BYTES, MAX_STRANGERS, RECEIVE_BUFFER_BYTES, SEND_BUFFER_BYTES,
    SEND_WITHIN,
};
use crate::send_within::SendWithin;

/// How long to wait after the system has refused a connection, as it does where too many files are open.
const AFTER_REFUSAL: Duration = Duration::from_millis(100);

/// One connection, for its requests to say that they know it. Clones are of the same connection.
#[derive(Clone, Debug)]
pub struct Connection(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    number: u64,
    strangers: Arc<Strangers>,
    given_up: CancellationToken,
    /// Whether a request has come by it.
    asked: AtomicBool,
    /// Whether it has shown the token.
    is_known: AtomicBool,
    _permit: OwnedSemaphorePermit,
}

/// Connections that have not shown the token, by their number, which grows with each.
#[derive(Debug, Default)]
struct Strangers {
    last: AtomicU64,
    waiting: Mutex<BTreeMap<u64, CancellationToken>>,
}

impl Connection {
    fn of(strangers: &Arc<Strangers>, permit: OwnedSemaphorePermit) -> Self {
        let (number, given_up) = strangers.enter();
        let (asked, is_known) = (AtomicBool::new(false), AtomicBool::new(false));
        let strangers = Arc::clone(strangers);
        Self(Arc::new(Inner { number, strangers, given_up, asked, is_known, _permit: permit }))
    }

    /// Whoever is behind it has shown the token.
    pub fn is_known(&self) {
        self.0.is_known.store(true, Ordering::Relaxed);
        self.0.strangers.leave(self.0.number);
    }

    /// Whether it has: what is asked by it counts as asked by somebody who has the token.
    pub fn has_shown_token(&self) -> bool {
        self.0.is_known.load(Ordering::Relaxed)
    }

    /// The same bytes for an answer to it: where they are not taken as fast as they have to be, it is cut off.
    pub fn takes_in_time(&self, bytes: Bytes) -> Bytes {
        let taken = CancellationToken::new();
        let untaken = taken.clone().drop_guard();
        let within = taken_within(bytes.len());
        let given_up = self.0.given_up.clone();
        tokio::spawn(async move {
            if timeout(within, taken.cancelled()).await.is_err() {
                given_up.cancel();
            }
        });
        Bytes::from_owner(Untaken { bytes, _untaken: untaken })
    }

    /// Returns when the connection has to end: to make room for others, which one that is known never has to, or because it takes an
    /// answer too slowly.
    pub async fn given_up(&self) {
        self.0.given_up.cancelled().await;
    }
}

/// Bytes of which not all are taken.
struct Untaken {
    bytes: Bytes,
    _untaken: DropGuard,
}

impl AsRef<[u8]> for Untaken {
    fn as_ref(&self) -> &[u8] {
        &self.bytes
    }
}

impl Drop for Inner {
    fn drop(&mut self) {
        self.strangers.leave(self.number);
    }
}

impl Strangers {
    /// Takes in one more. Where there are too many the oldest is given up: whoever has the token shows it at once.
    fn enter(&self) -> (u64, CancellationToken) {
        let number = self.last.fetch_add(1, Ordering::Relaxed);
        let token = CancellationToken::new();
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.insert(number, token.clone());
        if waiting.len() > MAX_STRANGERS
            && let Some((_, oldest)) = waiting.pop_first()
        {
            oldest.cancel();
        }
        (number, token)
    }

    fn leave(&self, number: u64) {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner).remove(&number);
    }
}

/// How the server ends.
#[derive(Clone, Debug, Default)]
pub struct Ending {
    /// What was accepted is being finished. Connections end with the answer that they wait for; new ones get one answer each,
    /// so that `/readyz` can say what goes on.
    pub draining: CancellationToken,
    /// All sockets have ended.
    pub sockets_ended: CancellationToken,
}

/// Answers connections on `requests`, by `router`, until all that came before [`Ending::draining`], and the sockets, have ended.
pub async fn serve(listener: TcpListener, requests: Handle, router: Router, ending: Ending) {
    // Its connections have the same.
    let bounded = set_socket_recv_buffer_size(&listener, RECEIVE_BUFFER_BYTES)
        .and_then(|()| set_socket_send_buffer_size(&listener, SEND_BUFFER_BYTES));
    if let Err(error) = bounded {
        tracing::debug!("connections have buffers as large as the system likes: {error}");
    }
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    let strangers = Arc::new(Strangers::default());
    let (open, late) = (TaskTracker::new(), TaskTracker::new());
    let (over, ended) = (CancellationToken::new(), ending.clone());
    let are_over = async {
        ended.draining.cancelled().await;
        open.close();
        tokio::join!(open.wait(), ended.sockets_ended.cancelled());
    };
    let mut are_over = std::pin::pin!(are_over);
    loop {
        let accepted = tokio::select! {
            biased;
            () = are_over.as_mut() => break,
            accepted = accept(&listener, Arc::clone(&permits)) => accepted,
        };
        let Some((stream, permit)) = accepted else { break };
        let connection = Connection::of(&strangers, permit);
        let router = router.clone();
        let is_late = ending.draining.is_cancelled();
        let ends = if is_late { Ends::AfterOne(over.clone()) } else { Ends::With(ending.draining.clone()) };
        let served = async move {
            match SendWithin::new(stream, SEND_WITHIN).moved_here() {
                Ok(stream) => answer(stream, connection, router, ends).await,
                Err(error) => tracing::debug!("a connection broke: {error}"),
            }
        };
        if is_late {
            late.spawn_on(served, &requests)
        } else {
            open.spawn_on(served, &requests)
        };
    }
    drop(listener);
    over.cancel();
    late.close();
    late.wait().await;
}

/// When a connection ends that nobody closes.
enum Ends {
    /// With the answer that is under way when this is cancelled.
    With(CancellationToken),
    /// After one answer; without, when this is cancelled before it is asked for.
    AfterOne(CancellationToken),
}

/// The next connection and its permit. While there are too many, others wait in the system's queue.
async fn accept(
    listener: &TcpListener,
    permits: Arc<Semaphore>,
) -> Option<(TcpStream, OwnedSemaphorePermit)> {
    let permit = permits.acquire_owned().await.ok()?;
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                // A frame or an edit is one small write; waiting to fill a packet would only delay it.
                if let Err(error) = stream.set_nodelay(true) {
                    tracing::debug!("a connection delays its packets: {error}");
                }
                return Some((stream, permit));
            }
            Err(error) => {
                tracing::warn!("a connection was not accepted: {error}");
                sleep(AFTER_REFUSAL).await;
            }
        }
    }
}

async fn answer(stream: SendWithin, connection: Connection, router: Router, ends: Ends) {
    let service = TowerToHyperService::new(router);
    let named = connection.clone();
    let service = service_fn(move |mut request: Request<Incoming>| {
        named.0.asked.store(true, Ordering::Relaxed);
        request.extensions_mut().insert(named.clone());
        service.call(request)
    });
    let mut served = http1::Builder::new();
    served.timer(TokioTimer::new()).header_read_timeout(HEADERS_WITHIN).max_buf_size(MAX_HEAD_BYTES);
    let (is_last, end) = match ends {
        Ends::With(end) => (false, end),
        Ends::AfterOne(end) => (true, end),
    };
    served.keep_alive(!is_last);
    let served = served.serve_connection(TokioIo::new(stream), service).with_upgrades();
    let mut served = std::pin::pin!(served);
    let ended = tokio::select! {
        ended = served.as_mut() => ended,
        () = connection.given_up() => return,
        () = end.cancelled() => {
            // One that has asked for nothing would be waited for in vain.
            if !connection.0.asked.load(Ordering::Relaxed) {
                return;
            }
            served.as_mut().graceful_shutdown();
            served.await
        }
    };
    if let Err(error) = ended {
        tracing::debug!("a connection broke: {error}");
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_oldest_stranger_gives_way_and_who_is_known_never() {
        let permits = Arc::new(Semaphore::new(MAX_STRANGERS + 3));
        let strangers = Arc::new(Strangers::default());
        let enter = || Connection::of(&strangers, Arc::clone(&permits).try_acquire_owned().unwrap());
        let (known, oldest) = (enter(), enter());
        known.is_known();
        let rest: Vec<Connection> = (1..MAX_STRANGERS).map(|_| enter()).collect();
        assert!(!oldest.0.given_up.is_cancelled());
        let _one_more = enter();
        assert!(oldest.0.given_up.is_cancelled());
        assert!(!known.0.given_up.is_cancelled() && rest.iter().all(|one| !one.0.given_up.is_cancelled()));
        drop(rest);
        assert_eq!(strangers.waiting.lock().unwrap().len(), 1);
    }
}
