//! Runs a server as a process of its own.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::str::FromStr;
use std::time::{Duration, Instant};

use render::Backend;
use tempfile::TempDir;

use crate::BenchError;

/// Longest time until the server has drawn with every pipeline: a software driver compiles for seconds, and other tests
/// may use the machine at the same time.
const READY_WITHIN: Duration = Duration::from_mins(3);

/// Address and token of a server.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct ServerAddress {
    /// Host and port.
    pub host: String,
    pub token: String,
}

impl FromStr for ServerAddress {
    type Err = BenchError;

    /// Parses the line that `bendylights serve` prints: `http://HOST:PORT/#token=TOKEN`, with or without a session
    /// after it.
    fn from_str(line: &str) -> Result<Self, BenchError> {
        let parts = line.trim().strip_prefix("http://").and_then(|rest| rest.split_once("/#token="));
        let (host, token) = parts.ok_or_else(|| BenchError::Address(line.into()))?;
        let token = token.split('&').next().unwrap_or_default();
        Ok(Self { host: host.into(), token: token.into() })
    }
}

impl ServerAddress {
    /// Requests `path` by GET, with the token.
    pub fn get(&self, path: &str) -> Result<Response, BenchError> {
        let request = agent().get(self.url(path)).header("Authorization", self.bearer());
        answer(request.call()?)
    }

    /// Sends `body` to `path` by POST, with the token.
    pub fn post(&self, path: &str, body: &[u8]) -> Result<Response, BenchError> {
        let request = agent().post(self.url(path)).header("Authorization", self.bearer());
        answer(request.content_type("application/json").send(body)?)
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

    /// Returns the value of a counter or gauge of `/metrics`: the sum over all label sets that contain `labels`.
    pub fn metric(&self, name: &str, labels: &str) -> Result<f64, BenchError> {
        let text = self.get("/metrics")?.text();
        let of_it = text.lines().filter(|line| {
            line.strip_prefix(name).is_some_and(|rest| rest.starts_with(['{', ' ']) && rest.contains(labels))
        });
        Ok(of_it.filter_map(|line| line.rsplit(' ').next()?.parse::<f64>().ok()).sum())
    }

    fn url(&self, path: &str) -> String {
        format!("http://{}{path}", self.host)
    }

    fn bearer(&self) -> String {
        format!("Bearer {}", self.token)
    }
}

/// Running `bendylights serve`, killed on drop.
#[derive(Debug)]
pub struct ServerProcess {
    child: Child,
    pub address: ServerAddress,
    /// Folder of the data, if it is removed with the server.
    folder: Option<TempDir>,
}

/// HTTP response.
#[derive(Clone, Debug)]
pub struct Response {
    pub status: u16,
    pub body: Vec<u8>,
    /// Values of the headers `x-bendylights-note`, each of which names a thing that the picture lacks.
    pub notes: Vec<String>,
}

impl Response {
    /// Returns the body as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }
}

impl ServerProcess {
    /// Starts `program serve` with the data folder `data` on a free port of the loopback interface, and waits until it
    /// listens.
    pub fn start(program: &Path, data: &Path, more: &[&str]) -> Result<Self, BenchError> {
        let mut command = Command::new(program);
        Self::spawn(command.args(["serve", "--listen", "127.0.0.1:0", "--data"]).arg(data).args(more))
    }

    /// Starts a server with new data, and waits until it is ready. The server selects the backend if `None`.
    pub fn start_with_new_data(program: &Path, scene: &str, backend: Option<Backend>) -> Result<Self, BenchError> {
        let folder = tempfile::tempdir()?;
        // The server creates the folder, so that no other user can read it.
        let data = folder.path().join("data");
        let backend = backend.map_or("auto", Backend::name);
        let mut server = Self::start(program, &data, &["--scene", scene, "--backend", backend])?;
        server.folder = Some(folder);
        server.wait_until_ready()?;
        Ok(server)
    }

    /// Starts a server by a command, and waits until it listens.
    pub fn spawn(command: &mut Command) -> Result<Self, BenchError> {
        let program = command.get_program().display().to_string();
        let failed = |reason: String| BenchError::Start { program: program.clone(), reason };
        let child = command.stdin(Stdio::null()).stdout(Stdio::piped()).spawn();
        let mut child = child.map_err(|error| failed(error.to_string()))?;
        let mut line = String::new();
        let stdout = child.stdout.take().ok_or_else(|| failed("it has no output".into()))?;
        BufReader::new(stdout).read_line(&mut line)?;
        match line.parse() {
            Ok(address) => Ok(Self { child, address, folder: None }),
            Err(error) => {
                // The process may have ended already. In both cases none is left running.
                let _ = child.kill();
                child.wait()?;
                Err(error)
            }
        }
    }

    /// Waits until every pipeline has drawn once.
    pub fn wait_until_ready(&self) -> Result<(), BenchError> {
        self.address.wait_until_ready()
    }

    /// Requests `path` by GET, with the token.
    pub fn get(&self, path: &str) -> Result<Response, BenchError> {
        self.address.get(path)
    }

    /// Sends `body` to `path` by POST, with the token.
    pub fn post(&self, path: &str, body: &[u8]) -> Result<Response, BenchError> {
        self.address.post(path, body)
    }

    /// Returns the value of a metric, as [`ServerAddress::metric`].
    pub fn metric(&self, name: &str, labels: &str) -> Result<f64, BenchError> {
        self.address.metric(name, labels)
    }

    /// Process id, for signals.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// Kills the server without a shutdown, as a power cut would.
    pub fn kill(mut self) -> Result<(), BenchError> {
        self.child.kill()?;
        self.child.wait()?;
        Ok(())
    }

    /// Waits until the server exits, and returns its exit code.
    pub fn wait(mut self) -> Result<Option<i32>, BenchError> {
        Ok(self.child.wait()?.code())
    }
}

impl Drop for ServerProcess {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
        drop(self.folder.take());
    }
}

/// Makes an HTTP agent for which error statuses are responses, not errors.
fn agent() -> ureq::Agent {
    ureq::Agent::config_builder().http_status_as_error(false).build().into()
}

fn answer(mut response: ureq::http::Response<ureq::Body>) -> Result<Response, BenchError> {
    let body = response.body_mut().with_config().limit(1 << 30).read_to_vec()?;
    let notes = response.headers().get_all("x-bendylights-note").iter();
    let notes = notes.map(|note| String::from_utf8_lossy(note.as_bytes()).into_owned()).collect();
    Ok(Response { status: response.status().as_u16(), body, notes })
}
