//! The program as a process: servers, and commands that must succeed.

use std::path::{Path, PathBuf};
use std::process::Command;

use bench::ServerProcess;

use crate::program::program;
use crate::sources::repository;

/// Starts a server on the data in `data`, and waits until it is ready.
pub fn serve(data: &Path, arguments: &[&str]) -> ServerProcess {
    let server = ServerProcess::start(program(), data, arguments).expect("started");
    server.wait_until_ready().expect("ready");
    server
}

/// Path of a tool of `tests/openapi/requirements.txt`.
pub fn openapi_tool(name: &str) -> PathBuf {
    repository().join("target/openapi-tools/bin").join(name)
}

/// Runs a command that must succeed. Returns its output.
pub fn output_of(command: &mut Command) -> String {
    let output = command.output().expect("it runs");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}
