//! A server, clients that mirror its document, and edits for them to make.

use std::path::Path;

use bench::{BenchError, Client, Incoming, ServerProcess, Tiles};
use image::RgbImage;
use light::parameters::{NAME, POSITION};
use light::{Light, LightId};
use protocol::{ClientMessage, GestureState, Interaction, Outcome, Problem, ServerMessage, State, Vec3};
use stream::FrameHeader;

use crate::program::program;

/// A ready server with the demo scene in session `main` and data of its own.
pub struct Server {
    pub process: ServerProcess,
    pub data: tempfile::TempDir,
}

impl Server {
    pub fn start() -> Self {
        let data = tempfile::tempdir().expect("a folder");
        let process = start_over(data.path());
        Self { process, data }
    }

    pub fn connect(&self, actor: &str) -> Mirror {
        Mirror::connect(&self.process, actor)
    }

    /// Kills the server, and starts it again with the same data.
    pub fn restart(self) -> Self {
        let Self { process, data } = self;
        process.kill().expect("killed");
        let process = start_over(data.path());
        Self { process, data }
    }

    /// Sequence number and hash of `main`, over HTTP.
    pub fn state(&self) -> (u64, String) {
        let state = self.process.get("/sessions/main").expect("answered");
        assert_eq!(state.status, 200, "{}", state.text());
        let state: protocol::SessionState = protocol::parse_body(&state.text()).expect("a session");
        (state.seq, state.hash)
    }
}

fn start_over(data: &Path) -> ServerProcess {
    let process = ServerProcess::start(program(), data, &["--scene", "demo:vases"]).expect("started");
    process.wait_until_ready().expect("ready");
    process
}

/// A client that keeps the document by applying the server's messages.
pub struct Mirror {
    pub client: Client,
    pub document: document::Document,
    pub seq: u64,
    operations: u64,
    actor: String,
}

impl Mirror {
    pub fn connect(process: &ServerProcess, actor: &str) -> Self {
        let client = Client::connect(&process.address, "main", actor, None).expect("welcome");
        let State::Snapshot(document) = client.welcome.state.clone() else { panic!("a snapshot") };
        let document = document.into_domain(0).expect("a valid document");
        assert_eq!(document.hash().to_string(), client.welcome.hash, "the snapshot has the stated hash");
        Self { seq: client.welcome.seq, client, document, operations: 0, actor: actor.into() }
    }

    /// The first BendyLight and its id.
    fn bendy(&self) -> (LightId, &Light) {
        let mut lights = self.document.lights().iter().map(|(id, placed)| (*id, placed.light.light()));
        lights.find(|(_, light)| !light.points().is_empty()).expect("a BendyLight")
    }

    /// Id of the first BendyLight.
    pub fn light(&self) -> u64 {
        self.bendy().0.0
    }

    /// Name of the first BendyLight.
    pub fn name(&self) -> &str {
        self.bendy().1.name()
    }

    /// Position of control point `point` of the first BendyLight.
    pub fn point(&self, point: usize) -> Vec3 {
        self.bendy().1.points()[point].position.to_array()
    }

    /// Radius of the first BendyLight at control point `point`.
    pub fn radius(&self, point: usize) -> f64 {
        self.bendy().1.points()[point].radius
    }

    pub fn send(&mut self, message: &ClientMessage) {
        self.client.send(message).expect("sent");
    }

    /// An operation id that no other client of these tests uses.
    pub fn op_id(&mut self) -> String {
        self.operations += 1;
        format!("{}-{}", self.actor, self.operations)
    }

    /// Sends a command. Returns its operation id.
    pub fn edit(&mut self, command: protocol::Command) -> String {
        let (op_id, base_seq) = (self.op_id(), self.seq);
        self.send(&ClientMessage::Edit { op_id: op_id.clone(), base_seq, command });
        op_id
    }

    /// Sends a command, and waits for its outcome and its record.
    pub fn edited(&mut self, command: protocol::Command) -> Outcome {
        let op_id = self.edit(command);
        self.result(&op_id)
    }

    /// Waits for the outcome of an operation, and for its record.
    pub fn result(&mut self, op_id: &str) -> Outcome {
        let outcome = self.wait_for("a result", |message| match message {
            ServerMessage::EditResult(result) if result.op_id == op_id => Some(result.outcome.clone()),
            _ => None,
        });
        if let Some(seq) = outcome.seq() {
            self.catch_up(seq);
        }
        outcome
    }

    /// Waits until the mirror holds record `seq`.
    pub fn catch_up(&mut self, seq: u64) {
        while self.seq < seq {
            self.wait_for("a record", |message| {
                matches!(message, ServerMessage::Log { .. } | ServerMessage::Resync(_)).then_some(())
            });
        }
    }

    /// Waits for a message. Applies and checks records meanwhile, and acknowledges frames.
    pub fn wait_for<T>(
        &mut self,
        what: &'static str,
        mut wanted: impl FnMut(&ServerMessage) -> Option<T>,
    ) -> T {
        self.receive_until(what, |incoming| match incoming {
            Incoming::Message(message) => wanted(message),
            Incoming::Frame(..) => None,
        })
    }

    /// Waits for a message or a frame.
    pub fn receive_until<T>(
        &mut self,
        what: &'static str,
        mut wanted: impl FnMut(&Incoming) -> Option<T>,
    ) -> T {
        let Self { client, document, seq, .. } = self;
        let found = client.wait_for(what, |incoming| {
            if let Incoming::Message(message) = &incoming {
                apply_message(message, document, seq);
            }
            wanted(&incoming)
        });
        found.unwrap_or_else(|error: BenchError| panic!("{error}"))
    }

    /// Opens a view of 160 x 90 pixels with the camera that the session suggests.
    pub fn open_view(&mut self) {
        self.open_view_of([160, 90], None);
    }

    /// Opens a view of this size in pixels, with the reductions that `interaction` allows while something moves.
    pub fn open_view_of(&mut self, [width, height]: [u32; 2], interaction: Option<Interaction>) {
        let source = protocol::ViewSource::Own(self.client.welcome.camera.clone());
        self.send(&ClientMessage::OpenView {
            source,
            width,
            height,
            camera_revision: 1,
            settings: None,
            interaction,
            stats: false,
        });
    }

    /// Follows the view of `leader`. The picture has its size; the size in this request is ignored.
    pub fn follow(&mut self, leader: &Self) {
        self.send(&ClientMessage::OpenView {
            source: protocol::ViewSource::Follow(leader.client.welcome.client),
            width: 999,
            height: 77,
            camera_revision: 1,
            settings: None,
            interaction: None,
            stats: false,
        });
    }

    /// Pixels of the next lossless frame that shows record `log_seq`.
    pub fn settled(&mut self, log_seq: u64) -> Vec<u8> {
        let (header, payload) = self.receive_until("a lossless frame", |incoming| match incoming {
            Incoming::Frame(header, payload) if header.flags.is_settled && header.log_seq >= log_seq => {
                Some((*header, payload.clone()))
            }
            _ => None,
        });
        frame_pixels(&header, &payload)
    }
}

/// The next state of a gesture that is `wanted`.
pub fn state_of(mirror: &mut Mirror, mut wanted: impl FnMut(&GestureState) -> bool) -> GestureState {
    mirror.wait_for("a gesture's state", |message| match message {
        ServerMessage::GestureState(state) if wanted(state) => Some(state.clone()),
        _ => None,
    })
}

/// Applies a message to the document and checks its hash.
fn apply_message(message: &ServerMessage, document: &mut document::Document, seq: &mut u64) {
    let hash = match message {
        ServerMessage::Log { record, hash, .. } => {
            assert_eq!(record.seq, *seq + 1, "records come in order, without gaps");
            let record = edit::Record::try_from(record.as_ref().clone()).expect("a valid record");
            document.apply(&record.changes).expect("it fits");
            *seq = record.seq;
            hash
        }
        ServerMessage::Resync(resync) => {
            assert!(resync.seq >= *seq, "a resync holds what was missed");
            *document = resync.document.clone().into_domain(0).expect("a valid document");
            *seq = resync.seq;
            &resync.hash
        }
        _ => return,
    };
    assert_eq!(document.hash().to_string(), *hash, "after record {seq}");
}

/// RGB pixels of a picture file.
pub fn pixels(file: &[u8]) -> Vec<u8> {
    image::load_from_memory(file).expect("a picture").to_rgb8().into_raw()
}

/// RGB pixels of a frame that contains a whole picture.
pub fn frame_pixels(header: &FrameHeader, tiles: &Tiles) -> Vec<u8> {
    let mut picture = RgbImage::new(header.width.into(), header.height.into());
    tiles.draw_on(&mut picture).expect("pictures");
    picture.into_raw()
}

pub fn move_point(light: u64, point: usize, position: Vec3) -> protocol::Command {
    protocol::Command::SetPoint { light, point, parameter: POSITION.to(position.into()).into() }
}

pub fn rename(light: u64, name: &str) -> protocol::Command {
    protocol::Command::SetLight { light, parameter: NAME.to(name.into()).into() }
}

/// `position` plus `by`.
pub fn moved(position: Vec3, by: Vec3) -> Vec3 {
    std::array::from_fn(|k| position[k] + by[k])
}

/// Sequence number of a committed edit that was not rebased.
pub fn committed(outcome: &Outcome) -> u64 {
    match outcome {
        Outcome::Committed(committed) if !committed.rebased => committed.seq,
        _ => panic!("it was not just committed: {outcome:?}"),
    }
}

/// Problem of a rejected edit.
pub fn rejected(outcome: &Outcome) -> &Problem {
    match outcome {
        Outcome::Rejected(problem) => problem,
        _ => panic!("it was not rejected: {outcome:?}"),
    }
}
