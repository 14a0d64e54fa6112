//! Tests of `serve` as a service: its output, and the place of the token.

use std::fs;
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};

use crate::program::{Folder, binary};

/// Returns the status of `/sessions` with that token.
fn status(host: &str, token: &str) -> String {
    let mut stream = TcpStream::connect(host).expect("it listens");
    let ask = format!(
        "GET /sessions HTTP/1.1\r\nHost: localhost\r\nAuthorization: Bearer {token}\r\nConnection: close\r\n\r\n"
    );
    stream.write_all(ask.as_bytes()).expect("sent");
    let mut answer = String::new();
    stream.read_to_string(&mut answer).expect("an answer");
    answer.split(' ').nth(1).unwrap_or_default().to_owned()
}

/// Server that is killed when dropped.
pub struct Service {
    child: Child,
    /// Address that it prints.
    address: String,
    /// Standard error until it is ready.
    said: String,
}

impl Drop for Service {
    fn drop(&mut self) {
        // A failure here must not hide that of the test.
        let _ = (self.child.kill(), self.child.wait());
    }
}

/// Starts a server, and waits until it is ready.
pub fn serve(args: &[&str]) -> Service {
    let mut command = Command::new(binary());
    command.args(["serve", "--listen", "127.0.0.1:0"]).args(args).env_remove("RUST_LOG");
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the binary runs");
    let mut address = String::new();
    BufReader::new(child.stdout.take().expect("a pipe")).read_line(&mut address).expect("an address");
    let mut said = String::new();
    let mut stderr = BufReader::new(child.stderr.take().expect("a pipe"));
    while !said.contains(" ready at ") {
        assert_ne!(stderr.read_line(&mut said).expect("text"), 0, "it has ended: {said}");
    }
    Service { child, address: address.trim_end().to_owned(), said }
}

/// Rules: HTTP-1
#[test]
fn a_service_keeps_its_token_in_a_file_and_out_of_its_journal() {
    let folder = Folder::new();
    let (data, file) = (folder.path("data"), folder.path("token"));
    for round in 0..2 {
        let server = serve(&["--data", &data, "--token-file", &file]);
        let (address, said) = (&server.address, &server.said);
        let token = fs::read_to_string(&file).expect("a token");
        let host = address.strip_prefix("http://").and_then(|rest| rest.strip_suffix('/')).expect("no token in it");
        assert_eq!(
            said.lines().last().and_then(|line| line.split(" ready at ").nth(1)),
            Some(&*format!("http://{host}"))
        );
        assert!(!said.contains(&token) && !address.contains(&token), "{address}\n{said}");
        assert_eq!([status(host, &token), status(host, &"0".repeat(32))], ["200", "401"], "round {round}");
    }
    assert!(!fs::exists(format!("{data}/token")).expect("a folder"), "there is one token");
    // Without the option the token is in the address, but not in the standard error.
    let server = serve(&["--data", &data]);
    let (address, said) = (&server.address, &server.said);
    let token = fs::read_to_string(format!("{data}/token")).expect("a token");
    assert!(address.ends_with(&format!("/#token={token}")) && !said.contains(&token), "{address}\n{said}");
}
