//! Proxy that limits the bandwidth between a client and the server.

use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::thread;
use std::time::{Duration, Instant};

use crate::{BenchError, ServerAddress};

/// Bytes per second towards the client: 2 Mbit/s.
const BYTES_PER_SECOND: f64 = 250_000.0;
/// Number of bytes that are forwarded at once: two Ethernet frames.
const PIECE: usize = 3_000;

/// Opens a proxy for one connection to `address`, and returns the proxy's address. The proxy forwards data from
/// `address` slowly. It ends with the connection.
pub(super) fn open(address: &ServerAddress) -> Result<ServerAddress, BenchError> {
    let listener = TcpListener::bind("127.0.0.1:0")?;
    let host = listener.local_addr()?.to_string();
    let server = address.host.clone();
    // One connection is enough: that of the victim, which has the view.
    thread::spawn(move || {
        let linked = || -> std::io::Result<()> {
            let (client, _) = listener.accept()?;
            let server = TcpStream::connect(server)?;
            server.set_nodelay(true)?;
            client.set_nodelay(true)?;
            let (up_from, up_to) = (client.try_clone()?, server.try_clone()?);
            thread::spawn(move || forward_slowly(up_from, up_to, f64::INFINITY));
            forward_slowly(server, client, BYTES_PER_SECOND);
            Ok(())
        };
        // The client reports a failed connection itself.
        let _ = linked();
    });
    Ok(ServerAddress { host, token: address.token.clone() })
}

/// Forwards bytes, at most `bytes_per_second`, until one side closes.
fn forward_slowly(mut from: TcpStream, mut to: TcpStream, bytes_per_second: f64) {
    let mut bytes = [0; PIECE];
    let mut free_at = Instant::now();
    loop {
        let count = match from.read(&mut bytes) {
            Ok(0) => break,
            Ok(count) => count,
            Err(error) if error.kind() == ErrorKind::Interrupted => continue,
            Err(_) => break,
        };
        if to.write_all(&bytes[..count]).is_err() {
            break;
        }
        let now = Instant::now();
        free_at = free_at.max(now) + Duration::from_secs_f64(count as f64 / bytes_per_second);
        thread::sleep(free_at.saturating_duration_since(now));
    }
    let _ = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
}
