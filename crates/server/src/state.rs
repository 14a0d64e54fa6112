//! State that all requests use. `server` makes it.

use std::sync::Arc;

use axum::extract::State;
use tokio::runtime::Handle;
use tokio::sync::Semaphore;

use crate::access::{Hosts, Token};
use crate::anonymous::AnonymousPermits;
use crate::permits::SessionPermits;
use crate::room::Rooms;
use crate::services::Services;

/// State of the server as the argument of a handler.
pub type App = State<Arc<AppState>>;

/// State of a server, shared by its requests.
pub struct AppState {
    pub services: Services,
    pub rooms: Rooms,
    pub token: Token,
    /// Runtime of sockets. They carry users' interactions, while HTTP requests come from programs, which send as many
    /// as they can.
    pub socket_runtime: Handle,
    /// Host names of the server.
    pub hosts: Hosts,
    /// A permit for each socket that has said hello.
    pub sockets: Arc<Semaphore>,
    /// A permit for each request in progress.
    pub requests: SessionPermits,
    /// A permit for each picture for HTTP in progress.
    pub stills: SessionPermits,
    /// A permit for each scene being uploaded.
    pub uploads: Semaphore,
    /// Permits for anonymous requests that check if the server is alive, and for opening sockets.
    pub anonymous_short_permits: AnonymousPermits,
    /// Permits of all other anonymous requests.
    pub anonymous_permits: AnonymousPermits,
}
