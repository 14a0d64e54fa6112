//! What every request can use. How it comes to be is in `server`.

use std::sync::Arc;

use tokio::runtime::Handle;
use tokio::sync::Semaphore;

use crate::access::{Hosts, Token};
use crate::anonymous::AnonymousPermits;
use crate::backend::Services;
use crate::permits::SessionPermits;
use crate::room::Rooms;

/// One a server; requests share it.
pub struct AppState {
    pub backend: Services,
    pub rooms: Rooms,
    pub token: Token,
    /// Where sockets are served: they carry what hands do, and requests what programs ask, as many as they can.
    pub socket_runtime: Handle,
    /// The names that it answers to.
    pub hosts: Hosts,
    /// A permit for each socket that has said hello.
    pub sockets: Arc<Semaphore>,
    /// A permit for each request under way.
    pub requests: SessionPermits,
    /// A permit for each picture for HTTP under way.
    pub stills: SessionPermits,
    /// A permit for each scene on its way here.
    pub uploads: Semaphore,
    /// Turns of strangers who look whether the server lives, or open a socket.
    pub anonymous_short_permits: AnonymousPermits,
    /// Turns of strangers who ask for anything else.
    pub anonymous_permits: AnonymousPermits,
}
