//! A server, clients that mirror its document, and edits for them to make.

use std::io::Write as _;
use std::net::TcpStream;
use std::time::{Duration, Instant};

use bench::{BenchError, Client, Incoming, Response, ServerAddress, ServerProcess, Tiles};
use image::RgbImage;
use light::parameters::{NAME, POSITION};
use light::{Light, LightId};
use protocol::{
    ClientMessage, Command, GestureState, GestureStatus, Interaction, Outcome, Problem, Record, Scope, ServerMessage,
    State, Vec3, ViewSource,
};
use serde_json::{Value, json};
use stream::FrameHeader;
use tokio::runtime::Runtime;

use crate::in_process::InProcessServer;
use crate::processes::serve;

/// Arguments of a server with the demo scene.
pub const DEMO: &[&str] = &["--scene", "demo:vases"];

/// A ready server with the demo scene in session `main` and data of its own.
pub struct Server {
    pub address: ServerAddress,
    pub data: tempfile::TempDir,
    host: Host,
}

enum Host {
    /// The test itself: a server starts at once.
    #[expect(dead_code, reason = "a server ends with it")]
    Test(Runtime),
    Process(ServerProcess),
}

impl Server {
    /// Starts a server in the process of the test.
    pub fn start() -> Self {
        let data = tempfile::tempdir().expect("a folder");
        let InProcessServer { runtime, address } = InProcessServer::start(data.path(), Some("demo:vases"));
        address.wait_until_ready().expect("ready");
        Self { address, data, host: Host::Test(runtime) }
    }

    /// Starts a server as a process, to be killed, stopped or measured.
    pub fn start_process() -> Self {
        Self::over(tempfile::tempdir().expect("a folder"))
    }

    fn over(data: tempfile::TempDir) -> Self {
        let process = serve(data.path(), DEMO);
        Self { address: process.address.clone(), data, host: Host::Process(process) }
    }

    /// Connects actors to it.
    pub fn with<const N: usize>(self, actors: [&str; N]) -> (Self, [Mirror; N]) {
        let mirrors = actors.map(|actor| self.connect(actor));
        (self, mirrors)
    }

    /// Starts a server in the process of the test, and connects actors to it.
    pub fn start_with<const N: usize>(actors: [&str; N]) -> (Self, [Mirror; N]) {
        Self::start().with(actors)
    }

    pub fn connect(&self, actor: &str) -> Mirror {
        Mirror::connect(&self.address, actor)
    }

    /// The server's process and data, for tests that started one.
    pub fn into_process(self) -> (ServerProcess, tempfile::TempDir) {
        let Host::Process(process) = self.host else { panic!("the server is in this process") };
        (process, self.data)
    }

    /// Id of the server's process.
    pub fn pid(&self) -> u32 {
        let Host::Process(process) = &self.host else { panic!("the server is in this process") };
        process.pid()
    }

    /// Kills the server's process, and starts it again with the same data.
    pub fn restart(self) -> Self {
        let (process, data) = self.into_process();
        process.kill().expect("killed");
        Self::over(data)
    }

    pub fn get(&self, path: &str) -> Response {
        self.address.get(path).expect("answered")
    }

    pub fn post(&self, path: &str, body: &Value) -> Response {
        self.address.post(path, body.to_string().as_bytes()).expect("answered")
    }

    /// Value of a metric, without the prefix of all metrics, over all label sets that contain `labels`.
    pub fn metric(&self, name: &str, labels: &str) -> f64 {
        self.address.metric(&format!("bendylights_{name}"), labels).expect("metrics")
    }

    /// Sequence number and hash of `main`, over HTTP.
    pub fn state(&self) -> (u64, String) {
        let state = ok(self.get("/sessions/main")).text();
        let state: protocol::SessionState = protocol::parse_body(&state).expect("a session");
        (state.seq, state.hash)
    }

    /// Records of `main` from number `from` on, over HTTP.
    pub fn records(&self, from: u64) -> Vec<Record> {
        let log = self.get(&format!("/sessions/main/log?from={from}")).text();
        log.lines().filter_map(|line| serde_json::from_str(line).ok()).collect()
    }
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
    pub fn connect(address: &ServerAddress, actor: &str) -> Self {
        let client = Client::connect(address, "main", actor, None).expect("welcome");
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
    pub fn edit(&mut self, command: Command) -> String {
        let (op_id, base_seq) = (self.op_id(), self.seq);
        self.send(&ClientMessage::Edit { op_id: op_id.clone(), base_seq, command });
        op_id
    }

    /// Sends a command, and waits for its outcome and its record.
    pub fn edited(&mut self, command: Command) -> Outcome {
        let op_id = self.edit(command);
        self.result(&op_id)
    }

    /// Moves a control point of the first BendyLight by `by`. Returns the number of the record.
    pub fn shift_point(&mut self, point: usize, by: Vec3) -> u64 {
        let command = move_point(self.light(), point, moved(self.point(point), by));
        self.edited(command).seq().expect("committed")
    }

    /// Undoes a step, and waits for the outcome and the record. The operation id differs from those before a reconnect.
    pub fn undo(&mut self, scope: Scope) -> Outcome {
        let op_id = format!("{}, undo after {}", self.actor, self.seq);
        self.send(&ClientMessage::Undo { op_id: op_id.clone(), scope });
        self.result(&op_id)
    }

    /// Adds a spotlight in addition to the demo's own light. Returns its id.
    pub fn add_lamp(&mut self, intensity: f64, cone_angle: f64) -> u64 {
        let light = json!({"type": "spot", "name": "lamp", "intensity": intensity, "coneAngle": cone_angle,
            "transform": {"translation": [0, 3, 4], "rotation": [-0.35, 0, 0, 0.936_749_7], "scale": 1}});
        self.edited(Command::AddLight { light: serde_json::from_value(light).expect("a light") });
        self.document.lights().keys().map(|id| id.0).max().expect("a light")
    }

    /// Begins a gesture on the first BendyLight.
    pub fn begin(&mut self, gesture: &str) {
        let (light, base_seq) = (self.light(), self.seq);
        self.send(&ClientMessage::GestureBegin { gesture: gesture.into(), light, base_seq });
    }

    pub fn update(&mut self, gesture: &str, update: u64, command: Command) {
        self.send(&ClientMessage::GestureUpdate { gesture: gesture.into(), update, command });
    }

    /// Commits a gesture as operation `commit`.
    pub fn commit(&mut self, gesture: &str) {
        self.send(&ClientMessage::GestureCommit { gesture: gesture.into(), op_id: "commit".into() });
    }

    pub fn cancel(&mut self, gesture: &str) {
        self.send(&ClientMessage::GestureCancel { gesture: gesture.into() });
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
    pub fn wait_for<T>(&mut self, what: &'static str, mut select: impl FnMut(&ServerMessage) -> Option<T>) -> T {
        self.receive_until(what, |incoming| match incoming {
            Incoming::Message(message) => select(message),
            Incoming::Frame(..) => None,
        })
    }

    /// Waits for a message or a frame.
    pub fn receive_until<T>(&mut self, what: &'static str, mut select: impl FnMut(&Incoming) -> Option<T>) -> T {
        let Self { client, document, seq, .. } = self;
        let found = client.wait_for(what, |incoming| {
            if let Incoming::Message(message) = &incoming {
                apply_message(message, document, seq);
            }
            select(&incoming)
        });
        found.unwrap_or_else(|error: BenchError| panic!("{error}"))
    }

    /// Opens a view of 160 x 90 pixels with the camera that the session suggests.
    pub fn open_view(&mut self) {
        self.open_view_of([160, 90], None);
    }

    /// Opens a view of this size in pixels, with the reductions that `interaction` allows while something moves.
    pub fn open_view_of(&mut self, size: [u32; 2], interaction: Option<Interaction>) {
        self.send(&view_message(own_view(&self.client), size, interaction, false));
    }

    /// Moves the camera of the view by `by` from where the session suggests.
    pub fn move_camera(&mut self, by: Vec3, camera_revision: u32) {
        let mut camera = self.client.welcome.camera.clone();
        camera.translation = moved(camera.translation, by);
        self.send(&ClientMessage::SetCamera { camera, camera_revision });
    }

    /// Follows the view of `leader`. The picture has its size; the size in this request is ignored.
    pub fn follow(&mut self, leader: &Self) {
        self.send(&view_message(ViewSource::Follow(leader.client.welcome.client), [999, 77], None, false));
    }

    /// The next frame that `accepts` takes.
    pub fn frame(&mut self, mut accepts: impl FnMut(&FrameHeader) -> bool) -> (FrameHeader, Tiles) {
        self.receive_until("a frame", |incoming| match incoming {
            Incoming::Frame(header, tiles) if accepts(header) => Some((*header, tiles.clone())),
            _ => None,
        })
    }

    /// The next lossless frame that shows record `log_seq`.
    pub fn settled_frame(&mut self, log_seq: u64) -> (FrameHeader, Tiles) {
        self.frame(|header| header.flags.is_settled && header.log_seq >= log_seq)
    }

    /// Pixels of the next lossless frame that shows record `log_seq`.
    pub fn settled(&mut self, log_seq: u64) -> Vec<u8> {
        let (header, tiles) = self.settled_frame(log_seq);
        frame_pixels(&header, &tiles)
    }
}

/// The response, whose status must be 200.
pub fn ok(response: Response) -> Response {
    assert_eq!(response.status, 200, "{}", response.text());
    response
}

/// Waits for up to a minute until `is_so`.
pub fn wait_until(what: &str, mut is_so: impl FnMut() -> bool) {
    let until = Instant::now() + Duration::from_mins(1);
    while !is_so() {
        assert!(Instant::now() < until, "{what} never came");
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// View of one's own, with the camera that the session suggests.
pub fn own_view(client: &Client) -> ViewSource {
    ViewSource::Own(client.welcome.camera.clone())
}

/// Message that opens a view of this size in pixels.
pub fn view_message(
    source: ViewSource,
    [width, height]: [u32; 2],
    interaction: Option<Interaction>,
    stats: bool,
) -> ClientMessage {
    ClientMessage::OpenView { source, width, height, camera_revision: 1, settings: None, interaction, stats }
}

/// Sends a request with a body, which may be empty, and does not read the answer. The server drops the request when the
/// stream is dropped.
pub fn begin_request(address: &ServerAddress, method: &str, path: &str, body: &str) -> TcpStream {
    let ServerAddress { host, token } = address;
    let mut stream = TcpStream::connect(host).expect("connected");
    let content = match body {
        "" => String::new(),
        _ => format!("Content-Type: application/json\r\nContent-Length: {}\r\n", body.len()),
    };
    let request =
        format!("{method} {path} HTTP/1.1\r\nHost: {host}\r\nAuthorization: Bearer {token}\r\n{content}\r\n{body}");
    stream.write_all(request.as_bytes()).expect("sent");
    stream
}

/// The next state of a gesture that `accepts` takes.
pub fn state_of(mirror: &mut Mirror, mut accepts: impl FnMut(&GestureState) -> bool) -> GestureState {
    mirror.wait_for("a gesture's state", |message| match message {
        ServerMessage::GestureState(state) if accepts(state) => Some(state.clone()),
        _ => None,
    })
}

/// True if a gesture is committed, cancelled or rejected.
pub fn has_ended(state: &GestureState) -> bool {
    !matches!(state.status, GestureStatus::Held { .. })
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

pub fn move_point(light: u64, point: usize, position: Vec3) -> Command {
    Command::SetPoint { light, point, parameter: POSITION.to(position.into()).into(), ignore_pins: false }
}

pub fn rename(light: u64, name: &str) -> Command {
    Command::SetLight { light, parameter: NAME.to(name.into()).into(), ignore_pins: false }
}

/// `position` plus `by`.
pub fn moved(position: Vec3, by: Vec3) -> Vec3 {
    std::array::from_fn(|k| position[k] + by[k])
}

/// Pixels from which the drag of a feature starts and to which it leads.
pub fn drag_ends(drag: &mut Command) -> [&mut [f64; 2]; 2] {
    let Command::DragFeature(drag) = drag else { panic!("it is a drag of a feature: {drag:?}") };
    [&mut drag.from, &mut drag.to]
}

/// `position`, moved to one side at even steps and to the other at odd ones.
pub fn oscillate(position: Vec3, step: u64) -> Vec3 {
    moved(position, [0.0, if step.is_multiple_of(2) { 0.1 } else { -0.1 }, 0.0])
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
