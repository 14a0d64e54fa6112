//! A server in a process of its own.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::str::FromStr;
use std::time::{Duration, Instant};

use crate::BenchError;

/// How long a server may take until every pipeline has drawn: a software driver compiles for seconds, and may share the
/// machine with other tests.
const READY_WITHIN: Duration = Duration::from_mins(3);

/// Where a server is and what lets one in.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerAddress {
    /// Host and port.
    pub host: String,
    /// The token.
    pub token: String,
}

impl FromStr for ServerAddress {
    type Err = BenchError;

    /// Reads what `bendylights serve` prints: `http://HOST:PORT/#token=TOKEN`, and a session behind it or none.
    fn from_str(line: &str) -> Result<Self, BenchError> {
        let parts = line.trim().strip_prefix("http://").and_then(|rest| rest.split_once("/#token="));
        let (host, token) = parts.ok_or_else(|| BenchError::Address(line.into()))?;
        let token = token.split('&').next().unwrap_or_default();
        Ok(Self { host: host.into(), token: token.into() })
    }
}

impl ServerAddress {
    /// Asks for `path`, with the token.
    pub fn get(&self, path: &str) -> Result<Response, BenchError> {
        let request = agent().get(self.url(path)).header("Authorization", self.bearer());
        answer(request.call()?)
    }

    /// Sends `body` to `path`, with the token.
    pub fn post(&self, path: &str, body: &[u8]) -> Result<Response, BenchError> {
        let request = agent().post(self.url(path)).header("Authorization", self.bearer());
        answer(request.content_type("application/json").send(body)?)
    }

    fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.host)
    }

    fn bearer(&self) -> String {
        format!("Bearer {}", self.token)
    }
}

/// A running `bendylights serve`; killed when it is dropped.
#[derive(Debug)]
pub struct ServerProcess {
    child: Child,
    /// Where it listens.
    pub address: ServerAddress,
}

/// What a server answers to a request.
#[derive(Clone, Debug)]
pub struct Response {
    /// The status code.
    pub status: u16,
    /// The body's bytes.
    pub body: Vec<u8>,
    /// What a picture lacks: the headers `x-bendylights-note`.
    pub notes: Vec<String>,
}

impl Response {
    /// The body as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

impl ServerProcess {
    /// Starts `program serve` on a free port of the loopback interface, over the data in `data`, and waits until it listens.
    pub fn start(program: &Path, data: &Path, more: &[&str]) -> Result<Self, BenchError> {
        let failed = |reason: String| BenchError::Start { program: program.display().to_string(), reason };
        let mut child = Command::new(program)
            .args(["serve", "--listen", "127.0.0.1:0", "--data"])
            .arg(data)
            .args(more)
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| failed(error.to_string()))?;
        let mut line = String::new();
        let stdout = child.stdout.take().ok_or_else(|| failed("it has no output".into()))?;
        BufReader::new(stdout).read_line(&mut line)?;
        match line.parse() {
            Ok(address) => Ok(Self { child, address }),
            Err(error) => {
                // It may have stopped by itself; either way nothing is left running.
                let _ = child.kill();
                child.wait()?;
                Err(error)
            }
        }
    }

    /// Waits until every pipeline has drawn once.
    pub fn wait_until_ready(&self) -> Result<(), BenchError> {
        let until = Instant::now() + READY_WITHIN;
        while Instant::now() < until {
            if self.get("/readyz")?.status == 200 {
                return Ok(());
            }
            std::thread::sleep(Duration::from_millis(50));
        }
        Err(BenchError::Silent { what: "that it is ready", within: READY_WITHIN })
    }

    /// Asks for `path`, with the token.
    pub fn get(&self, path: &str) -> Result<Response, BenchError> {
        self.address.get(path)
    }

    /// Sends `body` to `path`, with the token.
    pub fn post(&self, path: &str, body: &[u8]) -> Result<Response, BenchError> {
        self.address.post(path, body)
    }

    /// Value of a counter or gauge of `/metrics`: the sum over all labels that contain `labels`.
    pub fn metric(&self, name: &str, labels: &str) -> Result<f64, BenchError> {
        let text = self.get("/metrics")?.text();
        let of_it = text.lines().filter(|line| {
            line.strip_prefix(name).is_some_and(|rest| rest.starts_with(['{', ' ']) && rest.contains(labels))
        });
        Ok(of_it.filter_map(|line| line.rsplit(' ').next()?.parse::<f64>().ok()).sum())
    }

    /// Process id, for signals.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Stops it as a power cut would.
    pub fn kill(mut self) -> Result<(), BenchError> {
        self.child.kill()?;
        self.child.wait()?;
        Ok(())
    }

    /// Waits until it stops by itself; its exit code.
    pub fn wait(mut self) -> Result<Option<i32>, BenchError> {
        Ok(self.child.wait()?.code())
    }
}

impl Drop for ServerProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Refusals are answers too, not errors.
fn agent() -> ureq::Agent {
    ureq::Agent::config_builder().http_status_as_error(false).build().into()
}

fn answer(mut response: ureq::http::Response<ureq::Body>) -> Result<Response, BenchError> {
    let body = response.body_mut().with_config().limit(1 << 30).read_to_vec()?;
    let notes = response.headers().get_all("x-bendylights-note").iter();
    let notes = notes.map(|note| String::from_utf8_lossy(note.as_bytes()).into_owned()).collect();
    Ok(Response { status: response.status().as_u16(), body, notes })
}
