//! Why a measurement could not be made.

use std::path::PathBuf;
use std::time::Duration;

use light::LightError;
use protocol::FileError;
use render::RenderError;
use stream::StreamError;
use thiserror::Error;

/// Why a measurement could not be made.
#[derive(Debug, Error)]
pub enum BenchError {
    /// The server could not be started.
    #[error("the server {program} does not start: {reason}")]
    Start { program: String, reason: String },
    /// The server's first line is not an address.
    #[error("`{0}` is no address of a server: it should look like http://127.0.0.1:8080/#token=...")]
    Address(String),
    /// The socket failed.
    #[error("the connection to the server broke: {0}")]
    Socket(#[from] Box<tungstenite::Error>),
    /// A request failed.
    #[error("a request to the server failed: {0}")]
    Http(#[from] ureq::Error),
    /// A control message could not be read.
    #[error("the server sent a message that cannot be read: {0}")]
    Message(#[from] FileError),
    /// A frame could not be read.
    #[error("the server sent a frame that cannot be read: {0}")]
    Frame(#[from] StreamError),
    /// A frame's picture could not be decoded.
    #[error("the server sent a picture that cannot be decoded: {0}")]
    Picture(#[from] image::ImageError),
    /// The server refused.
    #[error("the server refused: {0}")]
    Refused(String),
    /// The server did not answer.
    #[error("the server did not send {what} within {} s", within.as_secs())]
    Silent {
        /// What was waited for.
        what: &'static str,
        /// How long.
        within: Duration,
    },
    /// The adapter could not do its part.
    #[error(transparent)]
    Render(#[from] RenderError),
    /// A light that cannot be evaluated.
    #[error(transparent)]
    Light(#[from] LightError),
    /// A file could not be written or read.
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// What a process uses could not be read.
    #[error("{}: cannot be read ({reason}): `bench neighbours` needs Linux's /proc", file.display())]
    Usage { file: PathBuf, reason: String },
    /// A folder without other renderers.
    #[error("{}: holds no peers: each is a folder in it with a bench.py; name another with --peers", .0.display())]
    NoPeers(PathBuf),
    /// A folder of other renderers without the Python that runs them.
    #[error(
        "{}: has no virtual environment: make one with its setup.sh, or name the Python that has the peers with --python",
        .0.display()
    )]
    NoPython(PathBuf),
    /// Another renderer could not be measured.
    #[error("{} cannot be measured by {} ({reason}); try it by hand", script.display(), python.display())]
    Peer { script: PathBuf, python: PathBuf, reason: String },
    /// The picture of the result could not be drawn.
    #[error("the chart cannot be drawn: {0}")]
    Chart(String),
}

impl From<tungstenite::Error> for BenchError {
    fn from(error: tungstenite::Error) -> Self {
        Self::Socket(Box::new(error))
    }
}
