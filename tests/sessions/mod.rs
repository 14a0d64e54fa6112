//! Tests of whole sessions: the program as a server, clients on real sockets, their state and the files on disk.

mod alternatives;
mod backup;
mod bending;
mod crash;
mod disk;
mod features;
mod frames;
mod gestures;
mod history;
mod http;
mod interactive;
mod load;
mod neighbours;
mod opening;
mod picture;
mod proxies;
mod reach;
mod reconnect;
mod solving;
mod stats;
pub mod support;
mod tiles;
mod together;
