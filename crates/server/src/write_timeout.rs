//! A connection that ends if its other side takes nothing for too long.

use std::future::Future;
use std::io::{self, ErrorKind, IoSlice};
use std::pin::Pin;
use std::task::{Context, Poll, ready};
use std::time::Duration;

use rustix::io::Errno;
use rustix::net::{SendFlags, send};
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::net::TcpStream;
use tokio::time::{Instant, Sleep, sleep};

/// Number of times that a blocked write is tried again within the write timeout.
const TRIES_PER_TIMEOUT: u32 = 6;

/// A stream of which a write fails with `TimedOut` once the other side has taken nothing for `write_timeout`.
///
/// Linux calls a socket writable once a third of its send buffer is free. A side that takes some kilobytes per second
/// does not reach that in time. So a waiting write tries again several times, and succeeds once anything was taken.
#[derive(Debug)]
pub struct WriteTimeoutStream {
    stream: TcpStream,
    write_timeout: Duration,
    next_try: Pin<Box<Sleep>>,
    /// Time since which a write is blocked. `None` if none is.
    waits_since: Option<Instant>,
}

impl WriteTimeoutStream {
    pub fn new(stream: TcpStream, write_timeout: Duration) -> Self {
        Self { stream, write_timeout, next_try: Box::pin(sleep(write_timeout)), waits_since: None }
    }

    /// Moves the connection to the current runtime, which polls it from now on.
    pub fn into_current_runtime(self) -> io::Result<Self> {
        Ok(Self::new(TcpStream::from_std(self.stream.into_std()?)?, self.write_timeout))
    }

    /// Returns the result of a write of `bytes`, after the stream's own write returned `written`.
    fn poll_waiting(
        &mut self,
        context: &mut Context<'_>,
        bytes: &[u8],
        written: Poll<io::Result<usize>>,
    ) -> Poll<io::Result<usize>> {
        if written.is_ready() {
            self.waits_since = None;
            return written;
        }
        let between = self.write_timeout / TRIES_PER_TIMEOUT;
        let since = *self.waits_since.get_or_insert_with(|| {
            self.next_try.as_mut().reset(Instant::now() + between);
            Instant::now()
        });
        loop {
            ready!(self.next_try.as_mut().poll(context));
            match send(&self.stream, bytes, SendFlags::empty()) {
                Err(Errno::AGAIN | Errno::INTR) if since.elapsed() < self.write_timeout => {
                    self.next_try.as_mut().reset(Instant::now() + between);
                }
                Err(Errno::AGAIN | Errno::INTR) => return Poll::Ready(Err(ErrorKind::TimedOut.into())),
                sent => {
                    self.waits_since = None;
                    return Poll::Ready(sent.map_err(Into::into));
                }
            }
        }
    }
}

impl AsyncWrite for WriteTimeoutStream {
    fn poll_write(mut self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write(context, bytes);
        self.poll_waiting(context, bytes, written)
    }

    fn poll_write_vectored(
        mut self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let written = Pin::new(&mut self.stream).poll_write_vectored(context, parts);
        let first = parts.iter().find(|part| !part.is_empty());
        self.poll_waiting(context, first.map_or(&[], |part| part), written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_flush(context)
    }

    fn poll_shutdown(mut self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_shutdown(context)
    }
}

impl AsyncRead for WriteTimeoutStream {
    fn poll_read(mut self: Pin<&mut Self>, context: &mut Context<'_>, into: &mut ReadBuf<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.stream).poll_read(context, into)
    }
}

#[cfg(test)]
mod tests {
    use rustix::net::sockopt::set_socket_send_buffer_size;
    use tokio::io::{AsyncReadExt, AsyncWriteExt};
    use tokio::net::{TcpListener, TcpSocket};
    use tokio::time::timeout;

    use super::*;

    const WITHIN: Duration = Duration::from_secs(1);

    /// Measures the time for which 64 MiB can be written to a reader that takes `bytes` bytes 20 times per second, up
    /// to 6 s.
    async fn lasts(bytes: usize) -> Duration {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        set_socket_send_buffer_size(&listener, 512 << 10).unwrap();
        let reader = TcpSocket::new_v4().unwrap();
        reader.set_recv_buffer_size(16 << 10).unwrap();
        let mut reader = reader.connect(listener.local_addr().unwrap()).await.unwrap();
        let mut writer = WriteTimeoutStream::new(listener.accept().await.unwrap().0, WITHIN);
        let takes = tokio::spawn(async move {
            let mut part = vec![0; bytes];
            while reader.read_exact(&mut part).await.is_ok() {
                sleep(Duration::from_millis(50)).await;
            }
        });
        let began = Instant::now();
        let large = vec![0; 64 << 20];
        if let Ok(written) = timeout(6 * WITHIN, writer.write_all(&large)).await {
            assert_eq!(written.unwrap_err().kind(), ErrorKind::TimedOut);
        }
        takes.abort();
        began.elapsed()
    }

    /// A socket is writable again once about 350 KB are free, which takes the first reader 2 s.
    #[tokio::test]
    async fn only_a_reader_that_takes_nothing_times_out() {
        let (little, nothing) = tokio::join!(lasts(8 << 10), lasts(1));
        assert!(little >= 6 * WITHIN, "{little:?}");
        assert!((WITHIN..3 * WITHIN).contains(&nothing), "{nothing:?}");
    }
}
