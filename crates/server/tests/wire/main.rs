//! The server in use by clients and programs: real sockets, real HTTP, a real store.

mod anonymous;
mod bodies;
mod client;
mod documented;
mod drain;
mod errors;
mod groups;
mod hello;
mod kept_pins;
mod limits;
mod methods;
mod metrics;
mod nodes;
mod operations;
mod patience;
mod pictures;
mod probes;
mod scenes;
mod scripts;
mod server;
mod session_list;
mod sessions;
mod slow;
mod unread;
mod uploads;
