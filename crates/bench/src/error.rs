//! Errors of benchmarks.

use std::path::PathBuf;
use std::time::Duration;

use light::LightError;
use protocol::{FileError, Problem};
use render::RenderError;
use stream::StreamError;
use thiserror::Error;

/// Reason that a measurement failed.
#[derive(Debug, Error)]
pub enum BenchError {
    #[error("the server {program} does not start: {reason}")]
    Start { program: String, reason: String },
    #[error("`{0}` is no address of a server: it should look like http://127.0.0.1:8080/#token=...")]
    Address(String),
    #[error("the connection to the server broke: {0}")]
    Socket(#[from] Box<tungstenite::Error>),
    #[error("a request to the server failed: {0}")]
    Http(#[from] ureq::Error),
    #[error("the server sent a message that cannot be read: {0}")]
    Message(#[from] FileError),
    #[error("the server sent a frame that cannot be read: {0}")]
    Frame(#[from] StreamError),
    #[error("the server sent a picture that cannot be decoded: {0}")]
    Picture(#[from] image::ImageError),
    #[error("the server refused: {0}")]
    Refused(String),
    #[error("the server did not send {what} within {} s", within.as_secs())]
    Silent {
        /// Thing that the client waited for.
        what: &'static str,
        within: Duration,
    },
    /// The GPU or the renderer failed.
    #[error(transparent)]
    Render(#[from] RenderError),
    #[error(transparent)]
    Light(#[from] LightError),
    #[error("{0}")]
    Io(#[from] std::io::Error),
    /// CPU or memory use of a process could not be read.
    #[error("{}: cannot be read ({reason}): `bench neighbours` needs Linux's /proc", file.display())]
    Usage { file: PathBuf, reason: String },
    #[error("{}: holds no peers: each is a folder in it with a bench.py; name another with --peers", .0.display())]
    NoPeers(PathBuf),
    #[error(
        "{}: has no virtual environment: make one with its setup.sh, or name the Python that has the peers with --python",
        .0.display()
    )]
    NoPython(PathBuf),
    #[error("{} cannot be measured by {} ({reason}); try it by hand", script.display(), python.display())]
    Peer { script: PathBuf, python: PathBuf, reason: String },
    #[error("the chart cannot be drawn: {0}")]
    Chart(String),
}

impl BenchError {
    /// Returns an error if the server refused for a `problem`.
    pub(crate) fn check(problem: Option<&Problem>) -> Result<(), Self> {
        problem.map_or(Ok(()), |problem| Err(Self::Refused(problem.message.clone())))
    }
}

impl From<serde_json::Error> for BenchError {
    fn from(error: serde_json::Error) -> Self {
        Self::Refused(error.to_string())
    }
}

impl From<tungstenite::Error> for BenchError {
    fn from(error: tungstenite::Error) -> Self {
        Self::Socket(Box::new(error))
    }
}
