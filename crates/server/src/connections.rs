//! Connections from their first byte: limits of their number and of the time for which they can delay the server.

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
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

use crate::in_flight::{delivery_timeout, guarded_bytes};
use crate::limits::{
    HEADERS_TIMEOUT, MAX_ANONYMOUS_CONNECTIONS, MAX_CONNECTIONS, MAX_HEAD_BYTES, RECEIVE_BUFFER_BYTES,
    SEND_BUFFER_BYTES, SEND_TIMEOUT,
};
use crate::write_timeout::WriteTimeoutStream;

/// Delay after the system refused a connection, for example because too many files are open.
const ACCEPT_RETRY_DELAY: Duration = Duration::from_millis(100);

/// Connection of a client. Each of its requests has a clone of it.
#[derive(Clone, Debug)]
pub struct Connection(Arc<ConnectionState>);

#[derive(Debug)]
struct ConnectionState {
    number: u64,
    anonymous: Arc<AnonymousConnections>,
    close_token: CancellationToken,
    /// True once a request has arrived.
    has_requested: AtomicBool,
    /// True once a request on the connection has shown the token.
    is_authenticated: AtomicBool,
    _permit: OwnedSemaphorePermit,
}

/// Connections that have not shown the token, by number. A later connection has a higher number.
#[derive(Debug, Default)]
struct AnonymousConnections {
    last: AtomicU64,
    waiting: Mutex<BTreeMap<u64, CancellationToken>>,
}

impl Connection {
    fn of(anonymous: &Arc<AnonymousConnections>, permit: OwnedSemaphorePermit) -> Self {
        let (number, close_token) = anonymous.enter();
        Self(Arc::new(ConnectionState {
            number,
            anonymous: Arc::clone(anonymous),
            close_token,
            has_requested: AtomicBool::new(false),
            is_authenticated: AtomicBool::new(false),
            _permit: permit,
        }))
    }

    /// Notes that the connection has shown the token.
    pub fn mark_authenticated(&self) {
        self.0.is_authenticated.store(true, Ordering::Relaxed);
        self.0.anonymous.leave(self.0.number);
    }

    /// True if the connection has shown the token. Then all its requests count as authenticated.
    pub fn is_authenticated(&self) -> bool {
        self.0.is_authenticated.load(Ordering::Relaxed)
    }

    /// Wraps the bytes of an answer. If the client does not take them in time, the connection is closed.
    pub fn with_delivery_timeout(&self, bytes: Bytes) -> Bytes {
        let taken = CancellationToken::new();
        let untaken = taken.clone().drop_guard();
        let within = delivery_timeout(bytes.len());
        let close_token = self.0.close_token.clone();
        tokio::spawn(async move {
            if timeout(within, taken.cancelled()).await.is_err() {
                close_token.cancel();
            }
        });
        guarded_bytes(bytes, untaken)
    }

    /// Waits until the server has to close the connection: because the limit of anonymous connections is reached, or
    /// because the client takes an answer too slowly.
    pub async fn until_closed_by_server(&self) {
        self.0.close_token.cancelled().await;
    }
}

impl Drop for ConnectionState {
    fn drop(&mut self) {
        self.anonymous.leave(self.number);
    }
}

impl AnonymousConnections {
    /// Adds a connection. Above the limit closes the oldest one, since a client with the token shows it at once.
    fn enter(&self) -> (u64, CancellationToken) {
        let number = self.last.fetch_add(1, Ordering::Relaxed);
        let token = CancellationToken::new();
        let mut waiting = self.waiting.lock().unwrap_or_else(PoisonError::into_inner);
        waiting.insert(number, token.clone());
        if waiting.len() > MAX_ANONYMOUS_CONNECTIONS
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

/// Stages of a shutdown.
#[derive(Clone, Debug, Default)]
pub struct ShutdownSignals {
    /// Accepted work is being finished. Connections close after their current answer. New connections get one answer
    /// each, so `/readyz` can report the state.
    pub draining: CancellationToken,
    /// All sockets have ended.
    pub sockets_ended: CancellationToken,
}

/// Answers connections with `router` on `requests`, until all connections from before the `draining` stage and the
/// sockets have ended.
pub async fn serve(listener: TcpListener, requests: Handle, router: Router, ending: ShutdownSignals) {
    // Accepted connections inherit these.
    let bounded = set_socket_recv_buffer_size(&listener, RECEIVE_BUFFER_BYTES)
        .and_then(|()| set_socket_send_buffer_size(&listener, SEND_BUFFER_BYTES));
    if let Err(error) = bounded {
        tracing::debug!("connections have buffers as large as the system likes: {error}");
    }
    let permits = Arc::new(Semaphore::new(MAX_CONNECTIONS));
    let anonymous = Arc::new(AnonymousConnections::default());
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
        let connection = Connection::of(&anonymous, permit);
        let router = router.clone();
        let is_late = ending.draining.is_cancelled();
        let end = if is_late { over.clone() } else { ending.draining.clone() };
        let served = async move {
            match WriteTimeoutStream::new(stream, SEND_TIMEOUT).into_current_runtime() {
                Ok(stream) => serve_connection(stream, connection, router, is_late, end).await,
                Err(error) => tracing::debug!("a connection broke: {error}"),
            }
        };
        let tasks = if is_late { &late } else { &open };
        tasks.spawn_on(served, &requests);
    }
    drop(listener);
    over.cancel();
    late.close();
    late.wait().await;
}

/// Accepts the next connection and takes its permit. While there are too many, others wait in the system's queue.
async fn accept(listener: &TcpListener, permits: Arc<Semaphore>) -> Option<(TcpStream, OwnedSemaphorePermit)> {
    let permit = permits.acquire_owned().await.ok()?;
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                // A frame or an edit is one small write. Waiting to fill a packet would only delay it.
                if let Err(error) = stream.set_nodelay(true) {
                    tracing::debug!("a connection delays its packets: {error}");
                }
                return Some((stream, permit));
            }
            Err(error) => {
                tracing::warn!("a connection was not accepted: {error}");
                sleep(ACCEPT_RETRY_DELAY).await;
            }
        }
    }
}

/// Answers the requests of a connection until either side closes it, or until the answer that is in progress when `end`
/// is cancelled. A late connection gets one answer, or none if `end` is cancelled before a request arrives.
async fn serve_connection(
    stream: WriteTimeoutStream,
    connection: Connection,
    router: Router,
    is_late: bool,
    end: CancellationToken,
) {
    let service = TowerToHyperService::new(router);
    let named = connection.clone();
    let service = service_fn(move |mut request: Request<Incoming>| {
        named.0.has_requested.store(true, Ordering::Relaxed);
        request.extensions_mut().insert(named.clone());
        service.call(request)
    });
    let mut served = http1::Builder::new();
    served.timer(TokioTimer::new()).header_read_timeout(HEADERS_TIMEOUT).max_buf_size(MAX_HEAD_BYTES);
    served.keep_alive(!is_late);
    let served = served.serve_connection(TokioIo::new(stream), service).with_upgrades();
    let mut served = std::pin::pin!(served);
    let ended = tokio::select! {
        ended = served.as_mut() => ended,
        () = connection.until_closed_by_server() => return,
        () = end.cancelled() => {
            // A connection without a request would never end by itself.
            if !connection.0.has_requested.load(Ordering::Relaxed) {
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
    fn the_oldest_anonymous_connection_is_evicted() {
        let permits = Arc::new(Semaphore::new(MAX_ANONYMOUS_CONNECTIONS + 3));
        let anonymous = Arc::new(AnonymousConnections::default());
        let enter = || Connection::of(&anonymous, Arc::clone(&permits).try_acquire_owned().unwrap());
        let (known, oldest) = (enter(), enter());
        known.mark_authenticated();
        let rest: Vec<Connection> = (1..MAX_ANONYMOUS_CONNECTIONS).map(|_| enter()).collect();
        assert!(!oldest.0.close_token.is_cancelled());
        let _one_more = enter();
        assert!(oldest.0.close_token.is_cancelled());
        assert!(!known.0.close_token.is_cancelled() && rest.iter().all(|one| !one.0.close_token.is_cancelled()));
        drop(rest);
        assert_eq!(anonymous.waiting.lock().unwrap().len(), 1);
    }
}
