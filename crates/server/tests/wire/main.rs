//! The server as clients and programs meet it: real sockets, real HTTP, a real store.

mod client;
mod drain;
mod errors;
mod hello;
mod limits;
mod operations;
mod patience;
mod pictures;
mod server;
mod sessions;
mod slow;
