//! What clients and programs request of a session, read from what they send.

use document::{Command, Document};
use edit::{Actor, UndoScope};
use light::LightId;
use protocol::{ClientMessage, Interaction, ProbeCamera, ViewSource};
use scene::Camera;
use store::check_scene_name;

use crate::ServerError;
use crate::limits::{MAX_LABEL_BYTES, MAX_VIEW_PIXELS, MAX_VIEW_SIDE};
use crate::outboxes::ClientId;
use crate::scenes::SceneCache;
use crate::views::ViewSettings;

/// What a client requests of its session.
#[derive(Debug)]
pub enum ClientRequest {
    /// A view of one's own.
    OpenView {
        /// From where.
        camera: Camera,
        /// The client's number for it.
        camera_revision: u32,
        /// How it is.
        settings: ViewSettings,
        /// What may be reduced while something moves.
        interaction: Interaction,
        /// Whether stats come after each frame.
        stats: bool,
        /// Width and height in pixels.
        size: [u32; 2],
    },
    /// To see what another client sees.
    Follow {
        /// The other's number.
        leader: ClientId,
        /// Whether stats come after each frame.
        stats: bool,
    },
    /// Another camera of one's own view.
    SetCamera {
        /// Which.
        camera: Camera,
        /// The client's number for it.
        camera_revision: u32,
    },
    /// How one's own view is.
    SetView {
        /// How.
        settings: ViewSettings,
        /// Whether stats come after each frame from now on, where that changes.
        stats: Option<bool>,
        /// The client's number for its camera from now on.
        camera_revision: u32,
    },
    /// Another size of one's own view, in pixels.
    Resize([u32; 2]),
    /// A frame is shown.
    Ack(u64),
    /// A frame could not be decoded.
    RequestKeyFrame(u64),
    /// Something that ends in a record.
    Step(RecordRequest),
    /// To drag a light.
    BeginGesture {
        /// The client's name for it.
        gesture: String,
        /// Which light.
        light: LightId,
        /// The latest record that the client knew.
        base_seq: u64,
    },
    /// The latest state of a drag.
    UpdateGesture {
        /// Which.
        gesture: String,
        /// The client's number for it.
        update: u64,
        /// The state, or why it has no meaning.
        command: Result<Command, ServerError>,
    },
    /// To end a drag without a trace.
    CancelGesture(String),
    /// The light that the client looks at.
    Select(Option<u64>),
    /// What undo and redo would take back.
    History,
    /// To know why a pixel is lit or not.
    Probe(ProbeQuestion),
    /// A sign of life; the number comes back.
    Ping(f64),
    /// What could not be read or is not allowed: why.
    Invalid(ServerError),
}

impl ClientRequest {
    /// Whether it changes what its sender sees already: then that one waits for each picture of it. Whoever opens a view waits for
    /// the first like those who watch: else views opened by the dozen take turns with the hand of another, one each.
    pub fn is_interactive(&self) -> bool {
        self.may_edit() || matches!(self, Self::SetCamera { .. } | Self::SetView { .. } | Self::Resize(_))
    }

    /// Whether it may change the document, or what is being dragged in it.
    pub fn may_edit(&self) -> bool {
        matches!(
            self,
            Self::Step(_) | Self::BeginGesture { .. } | Self::UpdateGesture { .. } | Self::CancelGesture(_)
        )
    }
}

/// What a client asks of a pixel.
#[derive(Debug)]
pub struct ProbeQuestion {
    /// The client's name for it.
    pub probe: String,
    /// Who looks; `None` for the client's view.
    pub camera: Option<ProbeCamera>,
    /// Width and height of the picture, in pixels; `None` for that view's.
    pub size: Option<[u32; 2]>,
    /// In pixels from the top left corner.
    pub pixel: [f64; 2],
    /// Whether it is asked where highlights lie.
    pub wants_highlights: bool,
}

/// A request that ends in a record, under its sender's name for it; or why it has no meaning.
#[derive(Debug)]
pub struct RecordRequest {
    /// The sender's name.
    pub op_id: String,
    /// What is asked for.
    pub request: Result<RecordAction, ServerError>,
}

/// What is asked for, before a document answers it.
#[derive(Debug)]
pub enum RecordAction {
    /// A command.
    Edit(RequestedEdit),
    /// Commands as one step, each in the document that those before it leave.
    Group(Vec<RequestedEdit>),
    /// To commit a gesture of this name.
    Commit(String),
    /// To take back a step.
    Undo(UndoScope),
    /// To take back an undo.
    Redo(UndoScope),
}

/// A command, and the latest record that its sender knew.
#[derive(Clone, Debug)]
pub struct RequestedEdit {
    /// `None` where the sender does not say.
    pub base_seq: Option<u64>,
    /// What to do.
    pub command: RequestedCommand,
}

/// What to do, by ids or names.
#[derive(Clone, Debug)]
pub enum RequestedCommand {
    /// What means the same in every document.
    Command(Command),
    /// Setting what an address names, by ids or names.
    Set {
        /// As in [`protocol::Command::Set`], with names or ids.
        target: String,
        /// As in [`protocol::Command::Set`].
        value: serde_json::Value,
    },
}

impl RequestedCommand {
    /// The command that it is in `document`.
    pub fn of(&self, document: &Document) -> Result<Command, ServerError> {
        match self {
            Self::Command(command) => Ok(command.clone()),
            Self::Set { target, value } => {
                let target = document.address_by_id(target).map_err(edit::EditRefusal::from)?;
                Ok(protocol::Command::Set { target, value: value.clone() }.try_into()?)
            }
        }
    }

    /// Whether the scene has something to say of it ([`needs_scene`]).
    fn needs_scene(&self) -> bool {
        matches!(self, Self::Command(command) if needs_scene(command))
    }
}

impl RecordRequest {
    /// Whether the scene has something to say of it ([`needs_scene`]), unless it came before.
    pub fn needs_scene(&self) -> bool {
        match &self.request {
            Ok(RecordAction::Edit(edit)) => edit.command.needs_scene(),
            Ok(RecordAction::Group(edits)) => edits.iter().any(|edit| edit.command.needs_scene()),
            Ok(RecordAction::Commit(_) | RecordAction::Undo(_) | RecordAction::Redo(_)) | Err(_) => false,
        }
    }
}

/// Whether only the scene can say what comes of a command, which takes a while: where the drag of a feature leads, or how far a
/// light reaches that is bent.
pub fn needs_scene(command: &Command) -> bool {
    matches!(command, Command::DragFeature { .. } | Command::BendLight { .. })
}

/// What a message of a client requests. What is wrong with it is for the session to answer, in its turn.
pub async fn client_request(message: ClientMessage, scenes: &SceneCache) -> ClientRequest {
    parse(message, scenes).await.unwrap_or_else(ClientRequest::Invalid)
}

async fn parse(message: ClientMessage, scenes: &SceneCache) -> Result<ClientRequest, ServerError> {
    Ok(match message {
        ClientMessage::Hello { .. } => return Err(ServerError::Hello),
        ClientMessage::OpenView {
            source: ViewSource::Own(camera),
            width,
            height,
            camera_revision,
            settings,
            interaction,
            stats,
        } => ClientRequest::OpenView {
            camera: valid_camera(camera)?,
            camera_revision,
            settings: settings.map(TryInto::try_into).transpose()?.unwrap_or_default(),
            interaction: interaction.unwrap_or_default(),
            stats,
            size: view_size(width, height)?,
        },
        ClientMessage::OpenView { source: ViewSource::Follow(leader), stats, .. } => {
            ClientRequest::Follow { leader, stats }
        }
        ClientMessage::SetCamera { camera, camera_revision } => {
            ClientRequest::SetCamera { camera: valid_camera(camera)?, camera_revision }
        }
        ClientMessage::SetView { settings, stats, camera_revision } => {
            ClientRequest::SetView { settings: settings.try_into()?, stats, camera_revision }
        }
        ClientMessage::Viewport { width, height } => ClientRequest::Resize(view_size(width, height)?),
        ClientMessage::Ack { frame } => ClientRequest::Ack(frame),
        ClientMessage::RequestKeyFrame { frame } => ClientRequest::RequestKeyFrame(frame),
        ClientMessage::Edit { op_id, base_seq, command } => {
            let request = asked_edit(command, Some(base_seq), scenes).await;
            ClientRequest::Step(step(op_id, request.map(RecordAction::Edit))?)
        }
        ClientMessage::GestureCommit { gesture, op_id } => {
            ClientRequest::Step(step(op_id, label(gesture).map(RecordAction::Commit))?)
        }
        ClientMessage::Undo { op_id, scope } => {
            ClientRequest::Step(step(op_id, Ok(RecordAction::Undo(scope.into())))?)
        }
        ClientMessage::Redo { op_id, scope } => {
            ClientRequest::Step(step(op_id, Ok(RecordAction::Redo(scope.into())))?)
        }
        ClientMessage::GestureBegin { gesture, light, base_seq } => {
            ClientRequest::BeginGesture { gesture: label(gesture)?, light: LightId(light), base_seq }
        }
        ClientMessage::GestureUpdate { gesture, update, command } => {
            let command = Command::try_from(command).map_err(ServerError::from);
            ClientRequest::UpdateGesture { gesture: label(gesture)?, update, command }
        }
        ClientMessage::GestureCancel { gesture } => ClientRequest::CancelGesture(label(gesture)?),
        ClientMessage::Presence { selection } => ClientRequest::Select(selection),
        ClientMessage::History {} => ClientRequest::History,
        ClientMessage::Probe { probe, pixel, camera, size, highlights } => {
            ClientRequest::Probe(ProbeQuestion {
                probe: label(probe)?,
                camera,
                size,
                pixel,
                wants_highlights: highlights,
            })
        }
        ClientMessage::Ping { sent } => ClientRequest::Ping(sent),
    })
}

/// A step under its sender's name for it.
pub fn step(op_id: String, request: Result<RecordAction, ServerError>) -> Result<RecordRequest, ServerError> {
    Ok(RecordRequest { op_id: label(op_id)?, request })
}

/// A command as it is asked for. A scene that it loads is decoded here, outside of the session's task, a demo's
/// name becomes that of its bytes, and what it is called is looked up where the command does not say.
pub async fn asked_edit(
    mut command: protocol::Command,
    base_seq: Option<u64>,
    scenes: &SceneCache,
) -> Result<RequestedEdit, ServerError> {
    if let protocol::Command::Set { target, value } = command {
        return Ok(RequestedEdit { base_seq, command: RequestedCommand::Set { target, value } });
    }
    if let protocol::Command::LoadScene { scene, name } = &mut command {
        name.as_deref().map_or(Ok(()), check_scene_name)?;
        let (asset, called) = scenes.resolve(scene).await?;
        *scene = asset.to_string();
        name.get_or_insert(called);
    }
    Ok(RequestedEdit { base_seq, command: RequestedCommand::Command(command.try_into()?) })
}

/// Who it is, within limits.
pub fn actor(wire: protocol::Actor) -> Result<Actor, ServerError> {
    Ok(Actor { id: label(wire.id)?, name: label(wire.name)? })
}

/// A name that a client chose, within limits.
fn label(text: String) -> Result<String, ServerError> {
    if text.len() > MAX_LABEL_BYTES {
        let what = "a name of an actor, an operation, a gesture or a probe";
        return Err(ServerError::TooLarge { what, limit: MAX_LABEL_BYTES, unit: "bytes" });
    }
    Ok(text)
}

/// A camera that makes a picture.
pub fn valid_camera(wire: protocol::Camera) -> Result<Camera, ServerError> {
    let camera = Camera::from(wire);
    camera.check().map_err(|why| edit::EditRefusal::from(document::EditError::InvalidCamera(why)))?;
    Ok(camera)
}

/// A size that can be streamed.
fn view_size(width: u32, height: u32) -> Result<[u32; 2], ServerError> {
    if width == 0 || height == 0 {
        return Err(ServerError::BadMessage("a view has no pixels: give it a width and a height".into()));
    }
    if width > MAX_VIEW_SIDE || height > MAX_VIEW_SIDE {
        let (what, limit) = ("a side of a view", MAX_VIEW_SIDE as usize);
        return Err(ServerError::TooLarge { what, limit, unit: "pixels" });
    }
    if width * height > MAX_VIEW_PIXELS {
        let (what, limit) = ("a view", MAX_VIEW_PIXELS as usize);
        return Err(ServerError::TooLarge { what, limit, unit: "pixels" });
    }
    Ok([width, height])
}
