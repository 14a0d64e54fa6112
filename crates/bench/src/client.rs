//! WebSocket client of one session, which behaves as the page does.

use std::io::ErrorKind;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use image::RgbImage;
use protocol::{Actor, ClientMessage, Command, EditResult, PROTOCOL, ServerMessage, ViewSettings, ViewSource, Welcome};
use stream::{FrameHeader, FrameTile, HEADER_BYTES};
use tungstenite::{Message, WebSocket};

use crate::{BenchError, ServerAddress};

/// Longest time that a server may take to answer.
const ANSWER_WITHIN: Duration = Duration::from_mins(1);

/// Part of the history that a reconnecting client has.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct KnownHistory {
    /// Id of the history.
    pub epoch: String,
    /// Latest record of that history that the client has.
    pub last_seq: u64,
}

/// Message or frame from the server.
#[derive(Clone, Debug, PartialEq)]
pub enum Incoming {
    Message(Box<ServerMessage>),
    /// A complete frame: the header of its last tile, and all of its tiles.
    Frame(FrameHeader, Tiles),
}

impl Incoming {
    /// Returns the message; `None` for a frame.
    pub fn into_message(self) -> Option<ServerMessage> {
        match self {
            Self::Message(message) => Some(*message),
            Self::Frame(..) => None,
        }
    }
}

/// Tiles of a frame, each an encoded picture file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tiles(Vec<(FrameTile, Vec<u8>)>);

impl Tiles {
    /// Returns the bytes of all picture files.
    pub fn byte_count(&self) -> usize {
        self.0.iter().map(|(_, file)| file.len()).sum()
    }

    /// Rectangles of the tiles in the picture.
    pub fn tiles(&self) -> impl Iterator<Item = FrameTile> {
        self.0.iter().map(|(tile, _)| *tile)
    }

    /// Decodes the tiles onto `picture`, which must have the size of the frame.
    pub fn draw_on(&self, picture: &mut RgbImage) -> Result<(), BenchError> {
        for (tile, file) in &self.0 {
            let part = image::load_from_memory(file)?.to_rgb8();
            image::imageops::replace(picture, &part, tile.x.into(), tile.y.into());
        }
        Ok(())
    }
}

/// Connection to one session.
#[derive(Debug)]
pub struct Client {
    socket: WebSocket<TcpStream>,
    /// Number of the frame whose last tile has not arrived yet, and its tiles so far.
    partial_frame: (u64, Tiles),
    /// Answer of the server to the hello.
    pub welcome: Welcome,
}

impl Client {
    /// Connects and sends a hello.
    pub fn connect(
        address: &ServerAddress,
        session: &str,
        actor: &str,
        known: Option<KnownHistory>,
    ) -> Result<Self, BenchError> {
        Self::connect_over(TcpStream::connect(&address.host)?, address, session, actor, known)
    }

    /// Sends a hello over the connection `tcp`, which leads to `address`.
    pub(crate) fn connect_over(
        tcp: TcpStream,
        address: &ServerAddress,
        session: &str,
        actor: &str,
        known: Option<KnownHistory>,
    ) -> Result<Self, BenchError> {
        let mut socket = say_hello(tcp, address, session, actor, known)?;
        let until = Instant::now() + ANSWER_WITHIN;
        while Instant::now() < until {
            match receive(&mut socket, ANSWER_WITHIN)? {
                Some(Received::Text(message)) => match *message {
                    ServerMessage::Welcome(welcome) => {
                        return Ok(Self { socket, partial_frame: (0, Tiles::default()), welcome: *welcome });
                    }
                    ServerMessage::Error { message, .. } => return Err(BenchError::Refused(message)),
                    _ => {}
                },
                Some(Received::Tile(..)) | None => {}
            }
        }
        Err(BenchError::Silent { what: "a welcome", within: ANSWER_WITHIN })
    }

    pub fn send(&mut self, message: &ClientMessage) -> Result<(), BenchError> {
        send(&mut self.socket, message)
    }

    /// Returns the next message or frame; `None` if none arrives within `timeout`.
    pub fn receive(&mut self, timeout: Duration) -> Result<Option<Incoming>, BenchError> {
        let until = Instant::now() + timeout;
        loop {
            let left = until.saturating_duration_since(Instant::now());
            match receive(&mut self.socket, left)? {
                Some(Received::Text(message)) => return Ok(Some(Incoming::Message(message))),
                Some(Received::Tile(header, file)) => {
                    if let Some(tiles) = self.assemble_frame(&header, file) {
                        return Ok(Some(Incoming::Frame(header, tiles)));
                    }
                }
                None if Instant::now() >= until => return Ok(None),
                None => {}
            }
        }
    }

    /// Stores a tile, and returns all tiles of the frame if it is the last. Missing tiles of an earlier frame are
    /// dropped, because they never arrive later.
    fn assemble_frame(&mut self, header: &FrameHeader, file: Vec<u8>) -> Option<Tiles> {
        if self.partial_frame.0 != header.frame {
            self.partial_frame = (header.frame, Tiles::default());
        }
        self.partial_frame.1.0.push((header.tile, file));
        header.flags.is_last_tile.then(|| std::mem::take(&mut self.partial_frame.1))
    }

    /// Acknowledges a frame.
    pub fn ack(&mut self, header: &FrameHeader) -> Result<(), BenchError> {
        self.send(&ClientMessage::Ack { frame: header.frame })
    }

    /// Opens a view of the session's camera.
    pub fn open_view(&mut self, [width, height]: [u32; 2], settings: Option<ViewSettings>) -> Result<(), BenchError> {
        self.send(&ClientMessage::OpenView {
            source: ViewSource::Own(self.welcome.camera.clone()),
            width,
            height,
            camera_revision: 1,
            settings,
            interaction: None,
            stats: false,
        })
    }

    /// Receives until a lossless picture arrives, called `what` in the error if none does. Acknowledges frames.
    pub fn wait_until_settled(&mut self, what: &'static str) -> Result<(), BenchError> {
        self.wait_for(what, |incoming| {
            matches!(incoming, Incoming::Frame(header, _) if header.flags.is_settled).then_some(())
        })
    }

    /// Begins a gesture on a light.
    pub(crate) fn begin_gesture(&mut self, gesture: &str, light: u64) -> Result<(), BenchError> {
        let base_seq = self.welcome.seq;
        self.send(&ClientMessage::GestureBegin { gesture: gesture.into(), light, base_seq })
    }

    pub(crate) fn update_gesture(&mut self, gesture: &str, update: u64, command: Command) -> Result<(), BenchError> {
        self.send(&ClientMessage::GestureUpdate { gesture: gesture.into(), update, command })
    }

    pub(crate) fn cancel_gesture(&mut self, gesture: &str) -> Result<(), BenchError> {
        self.send(&ClientMessage::GestureCancel { gesture: gesture.into() })
    }

    /// Receives until an edit has its result. Acknowledges frames.
    pub(crate) fn wait_for_edit(
        &mut self,
        mut is_wanted: impl FnMut(&EditResult) -> bool,
    ) -> Result<EditResult, BenchError> {
        self.wait_for("what became of an edit", |incoming| match incoming.into_message()? {
            ServerMessage::EditResult(result) if is_wanted(&result) => Some(result),
            _ => None,
        })
    }

    /// Receives until `wanted` returns a value for what has arrived. Acknowledges frames.
    pub fn wait_for<T>(
        &mut self,
        what: &'static str,
        mut wanted: impl FnMut(Incoming) -> Option<T>,
    ) -> Result<T, BenchError> {
        let until = Instant::now() + ANSWER_WITHIN;
        while Instant::now() < until {
            let Some(incoming) = self.receive(Duration::from_millis(500))? else { continue };
            if let Incoming::Frame(header, _) = &incoming {
                let header = *header;
                self.ack(&header)?;
            }
            if let Some(found) = wanted(incoming) {
                return Ok(found);
            }
        }
        Err(BenchError::Silent { what, within: ANSWER_WITHIN })
    }
}

/// Sends a hello and does not wait for the answer.
pub(crate) fn say_hello(
    tcp: TcpStream,
    address: &ServerAddress,
    session: &str,
    actor: &str,
    known: Option<KnownHistory>,
) -> Result<WebSocket<TcpStream>, BenchError> {
    tcp.set_nodelay(true)?;
    let url = format!("ws://{}/socket", address.host);
    let (mut socket, _) = tungstenite::client(url, tcp).map_err(|error| match error {
        tungstenite::HandshakeError::Failure(error) => BenchError::from(error),
        tungstenite::HandshakeError::Interrupted(_) => {
            BenchError::Silent { what: "the handshake", within: ANSWER_WITHIN }
        }
    })?;
    let (epoch, last_seq) = known.map(|known| (known.epoch, known.last_seq)).unzip();
    let hello = ClientMessage::Hello {
        protocol: PROTOCOL,
        token: address.token.clone(),
        session: session.into(),
        actor: Actor { id: actor.into(), name: actor.into() },
        epoch,
        last_seq,
    };
    send(&mut socket, &hello)?;
    Ok(socket)
}

fn send(socket: &mut WebSocket<TcpStream>, message: &ClientMessage) -> Result<(), BenchError> {
    let text = serde_json::to_string(message).expect("plain data with string keys");
    Ok(socket.send(Message::text(text))?)
}

/// Message or tile from the server.
enum Received {
    Text(Box<ServerMessage>),
    Tile(FrameHeader, Vec<u8>),
}

fn receive(socket: &mut WebSocket<TcpStream>, timeout: Duration) -> Result<Option<Received>, BenchError> {
    // A timeout of zero means no timeout.
    socket.get_ref().set_read_timeout(Some(timeout.max(Duration::from_micros(1))))?;
    match socket.read() {
        Ok(Message::Text(text)) => Ok(Some(Received::Text(Box::new(protocol::parse_body(text.as_str())?)))),
        Ok(Message::Binary(bytes)) => {
            let header = FrameHeader::from_bytes(&bytes)?;
            Ok(Some(Received::Tile(header, bytes[HEADER_BYTES..].to_vec())))
        }
        Ok(_) => Ok(None),
        Err(tungstenite::Error::Io(error)) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {
            Ok(None)
        }
        Err(error) => Err(error.into()),
    }
}
