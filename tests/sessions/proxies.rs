//! Tests the snippets of deploy/ with real nginx and Caddy, in front of a real server.

use std::fs;
use std::io::{Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use bench::{Client, ServerAddress, ServerProcess};

use crate::processes::serve;
use crate::sessions::support::{DEMO, wait_until};

const NGINX: &str = include_str!("../../deploy/nginx.conf");
const CADDY: &str = include_str!("../../deploy/Caddyfile");
/// Host name in both snippets.
const NAME: &str = "lights.example.org";
/// Address of the server in both snippets.
const SERVER: &str = "127.0.0.1:8080";
/// A bit more than the usual timeout of a reverse proxy for an idle connection.
const IDLE: Duration = Duration::from_secs(65);

/// A proxy in a folder of its own, killed on drop.
struct Proxy {
    process: Child,
    address: ServerAddress,
    _folder: tempfile::TempDir,
}

impl Drop for Proxy {
    fn drop(&mut self) {
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

impl Proxy {
    fn start(
        server: &ServerProcess,
        configure: impl FnOnce(&str, u16, &Path) -> String,
        command: impl FnOnce(&Path) -> Command,
    ) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let port = TcpListener::bind("127.0.0.1:0").and_then(|free| free.local_addr()).expect("a port").port();
        let file = folder.path().join("proxy.conf");
        fs::write(&file, configure(&server.address.host, port, folder.path())).expect("a file");
        let process = command(&file).stdin(Stdio::null()).spawn().expect("`make test-packages` installs it");
        let address = ServerAddress { host: format!("127.0.0.1:{port}"), token: server.address.token.clone() };
        let proxy = Self { process, address, _folder: folder };
        wait_until("the proxy", || TcpStream::connect(&proxy.address.host).is_ok());
        proxy
    }

    /// Starts nginx with this snippet, without TLS.
    fn nginx(server: &ServerProcess, snippet: &str) -> Self {
        let configure = |server: &str, port: u16, folder: &Path| {
            let lines = snippet.lines().filter(|line| !line.trim().starts_with("ssl_certificate"));
            let site = lines.collect::<Vec<_>>().join("\n");
            let site = site.replace("listen 443 ssl;", &format!("listen 127.0.0.1:{port};"));
            let site = site.replace(NAME, "127.0.0.1").replace(SERVER, server);
            let folder = folder.display();
            let paths = ["client_body", "proxy", "fastcgi", "uwsgi", "scgi"];
            let paths = paths.map(|kind| format!("{kind}_temp_path {folder}/{kind};")).join(" ");
            format!(
                "daemon off; master_process off; pid {folder}/pid; error_log stderr; events {{}}\n\
                 http {{ access_log off; {paths}\n{site}\n}}\n"
            )
        };
        Self::start(server, configure, |file| {
            let mut command = Command::new("nginx");
            command.arg("-c").arg(file).env("PATH", "/usr/sbin:/usr/bin:/sbin:/bin");
            command
        })
    }

    /// Starts Caddy with this snippet, without TLS.
    fn caddy(server: &ServerProcess, snippet: &str) -> Self {
        let configure = |server: &str, port: u16, _: &Path| {
            let site = snippet.replace(NAME, &format!("http://127.0.0.1:{port}")).replace(SERVER, server);
            format!("{{\n\tadmin off\n\tauto_https off\n}}\n{site}")
        };
        Self::start(server, configure, |file| {
            let mut command = Command::new("caddy");
            command.args(["run", "--adapter", "caddyfile", "--config"]).arg(file).stderr(Stdio::null());
            command.env("HOME", file.parent().expect("a folder"));
            command
        })
    }

    /// True if the socket of a session opens through the proxy.
    fn opens_sockets(&self) -> bool {
        Client::connect(&self.address, "main", "Ada", None).is_ok()
    }

    /// Status of an upload of 8 MiB through the proxy.
    fn sends_scene(&self) -> u16 {
        self.address.post("/assets?name=large", &large_scene()).map_or(0, |answer| answer.status)
    }

    /// True if a socket without messages survives for `time`.
    fn keeps_idle(&self, time: Duration) -> bool {
        let mut client = Client::connect(&self.address, "main", "Ben", None).expect("a socket");
        let until = Instant::now() + time;
        while Instant::now() < until {
            if client.receive(until.saturating_duration_since(Instant::now())).is_err() {
                return false;
            }
        }
        true
    }

    /// Status of a request from a page of the proxy's own address, with `Origin` as in a browser.
    fn answers_own_page(&self) -> String {
        let mut stream = TcpStream::connect(&self.address.host).expect("a connection");
        let host = &self.address.host;
        let ask =
            format!("GET /healthz HTTP/1.1\r\nHost: {host}\r\nOrigin: http://{host}\r\nConnection: close\r\n\r\n");
        stream.write_all(ask.as_bytes()).expect("sent");
        let mut answer = String::new();
        stream.read_to_string(&mut answer).expect("an answer");
        answer.split(' ').nth(1).unwrap_or_default().to_owned()
    }
}

/// A valid glTF file of 8 MiB, with nothing to see.
fn large_scene() -> Vec<u8> {
    let mut scene = br#"{"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{}]}"#.to_vec();
    scene.resize(8 << 20, b' ');
    scene
}

/// Checks everything that must pass the proxy.
fn check(proxy: &Proxy) {
    assert_eq!(proxy.answers_own_page(), "200", "it keeps Host");
    assert!(proxy.opens_sockets(), "it passes the upgrade on");
    assert_eq!(proxy.sends_scene(), 201, "it takes large bodies");
    let picture = proxy.address.get("/sessions/main/render?size=64x36&samples=1").expect("an answer");
    assert_eq!((picture.status, &picture.body[1..4]), (200, &b"PNG"[..]));
    assert!(proxy.keeps_idle(IDLE), "it keeps a socket on which nothing is said");
}

/// Rules: HTTP-2, SOCK-1
#[test]
#[ignore = "needs nginx and Caddy"]
fn nginx_with_our_snippet_lets_everything_through() {
    let data = tempfile::tempdir().expect("a folder");
    let server = serve(data.path(), DEMO);
    check(&Proxy::nginx(&server, NGINX));
    // Planted faults: each line of the snippet is necessary.
    let without = |start: &str| {
        let lines: Vec<_> = NGINX.lines().filter(|line| !line.trim().starts_with(start)).collect();
        assert_eq!(lines.len() + 1, NGINX.lines().count(), "{start}");
        Proxy::nginx(&server, &lines.join("\n"))
    };
    assert!(!without("proxy_set_header Upgrade").opens_sockets());
    assert!(!without("proxy_http_version").opens_sockets());
    assert_eq!(without("client_max_body_size").sends_scene(), 413);
    assert_eq!(without("proxy_set_header Host").answers_own_page(), "403");
    let hasty = NGINX.replace("proxy_read_timeout 1h", "proxy_read_timeout 2s");
    assert!(!Proxy::nginx(&server, &hasty).keeps_idle(Duration::from_secs(6)));
}

/// Rules: HTTP-2, SOCK-1
#[test]
#[ignore = "needs nginx and Caddy"]
fn caddy_with_our_snippet_lets_everything_through() {
    let data = tempfile::tempdir().expect("a folder");
    let server = serve(data.path(), DEMO);
    check(&Proxy::caddy(&server, CADDY));
    let small = CADDY.replace("768MiB", "1MiB");
    assert_ne!(small, CADDY);
    assert_ne!(Proxy::caddy(&server, &small).sends_scene(), 201, "a planted fault");
}
