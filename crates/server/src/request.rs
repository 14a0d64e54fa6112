//! Requests of clients and programs, converted from their messages.

use document::{Command, Document, EditError, needs_solution};
use edit::{Actor, UndoScope};
use light::LightId;
use protocol::{ClientMessage, Interaction, ProbeCamera, ViewSource};
use scene::Camera;
use store::check_scene_name;

use crate::ServerError;
use crate::error::check_size;
use crate::limits::{MAX_LABEL_BYTES, MAX_VIEW_PIXELS, MAX_VIEW_SIDE};
use crate::outboxes::ClientId;
use crate::scenes::SceneCache;
use crate::views::ViewSettings;

/// A request of a client to its session.
#[derive(Debug)]
pub enum ClientRequest {
    /// Opens a view of the client's own.
    OpenView {
        parameters: ViewParameters,
        /// True if the client wants statistics of each frame.
        stats: bool,
    },
    /// Follows the view of another client.
    Follow {
        leader: ClientId,
        /// True if the client wants statistics of each frame.
        stats: bool,
    },
    /// Moves the camera of the client's own view.
    SetCamera {
        camera: Camera,
        /// Number that the client gives the camera.
        camera_revision: u32,
    },
    /// Changes the settings of the client's own view.
    SetView {
        settings: ViewSettings,
        /// True if the client wants statistics of each frame from now on. `None` changes nothing.
        stats: Option<bool>,
        /// Number that the client gives the camera from now on.
        camera_revision: u32,
    },
    /// Changes the size of the client's own view, in pixels.
    Resize([u32; 2]),
    /// Acknowledges a shown frame.
    Ack(u64),
    /// Requests a key frame, because the client could not decode the frame of this number.
    RequestKeyFrame(u64),
    /// Requests a record.
    Step(RecordRequest),
    /// Begins to drag a light.
    BeginGesture {
        /// Name that the client gives the gesture.
        gesture: String,
        light: LightId,
        /// Number of the latest record that the client knew.
        base_seq: u64,
    },
    /// Latest state of a drag.
    UpdateGesture {
        gesture: String,
        /// Number that the client gives the update.
        update: u64,
        /// Command with the state of the drag, or the reason why the message holds no valid command.
        command: Result<Command, ServerError>,
    },
    /// Ends a drag without a record.
    CancelGesture(String),
    /// Selects a light.
    Select(Option<u64>),
    /// Asks for the steps that undo and redo would revert.
    History,
    /// Asks for the reasons why a pixel is lit or not.
    Probe(ProbeQuestion),
    /// Asks for a pong that repeats the number.
    Ping(f64),
    /// A message that could not be read or is not allowed.
    Invalid(ServerError),
}

impl ClientRequest {
    /// True if the request changes a picture that its sender already sees, so the sender waits for each picture of it.
    /// A new view waits for its first picture like a watching client. Otherwise dozens of new views would each count
    /// like the view of a client that drags.
    pub fn is_interactive(&self) -> bool {
        self.may_edit() || matches!(self, Self::SetCamera { .. } | Self::SetView { .. } | Self::Resize(_))
    }

    /// True if the request may change the document or a gesture.
    pub fn may_edit(&self) -> bool {
        matches!(self, Self::Step(_) | Self::BeginGesture { .. } | Self::UpdateGesture { .. } | Self::CancelGesture(_))
    }
}

/// Camera, settings and size of a view.
#[derive(Clone, Debug)]
pub struct ViewParameters {
    pub camera: Camera,
    /// Number that the client gives the camera.
    pub camera_revision: u32,
    pub settings: ViewSettings,
    /// Parts of the picture that may be reduced while something moves.
    pub interaction: Interaction,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// A question about a pixel.
#[derive(Debug)]
pub struct ProbeQuestion {
    /// Name that the client gives the question.
    pub probe: String,
    /// `None` for the camera of the client's view.
    pub camera: Option<ProbeCamera>,
    /// Width and height of the picture in pixels. `None` for the size of the client's view.
    pub size: Option<[u32; 2]>,
    /// Pixels from the top left corner.
    pub pixel: [f64; 2],
    /// True if the client asks for the positions of highlights.
    pub wants_highlights: bool,
}

/// Request to add a record to the log, under the operation id that its sender chose. `request` is an error if the
/// message could not be converted.
#[derive(Debug)]
pub struct RecordRequest {
    pub op_id: String,
    pub request: Result<RecordAction, ServerError>,
}

/// Content of a request for a record. Names in it are not yet looked up in a document.
#[derive(Debug)]
pub enum RecordAction {
    Edit(RequestedEdit),
    /// Commands as one step, each in the document after the ones before it.
    Group(Vec<RequestedEdit>),
    /// Commits the gesture of this id.
    Commit(String),
    /// Reverts a step.
    Undo(UndoScope),
    /// Reverts an undo.
    Redo(UndoScope),
}

/// A command, and the latest record that its sender knew.
#[derive(Clone, Debug)]
pub struct RequestedEdit {
    /// `None` if the sender does not give it.
    pub base_seq: Option<u64>,
    pub command: RequestedCommand,
}

/// Command, whose address may have names in place of ids.
#[derive(Clone, Debug)]
pub enum RequestedCommand {
    /// A command that means the same in every document.
    Command(Command),
    /// Sets the property at an address.
    Set {
        /// Address like that of [`protocol::Command::Set`], with names or ids.
        target: String,
        /// Value like that of [`protocol::Command::Set`].
        value: serde_json::Value,
        ignore_pins: bool,
    },
}

impl RequestedCommand {
    /// Resolves the command in `document`.
    pub fn of(&self, document: &Document) -> Result<Command, ServerError> {
        match self {
            Self::Command(command) => Ok(command.clone()),
            Self::Set { target, value, ignore_pins } => {
                let (target, ignore_pins) = (document.address_by_id(target)?, *ignore_pins);
                Ok(protocol::Command::Set { target, value: value.clone(), ignore_pins }.try_into()?)
            }
        }
    }

    /// Returns the command if it depends on the scene ([`needs_scene`]) in `document`.
    pub fn if_it_needs_scene(&self, document: &Document) -> Option<Command> {
        match self {
            Self::Command(command) => needs_scene(command, document).then(|| command.clone()),
            // Without hard pins there is nothing to look up.
            Self::Set { .. } if document.pins().values().any(|held| held.pin.is_hard) => {
                self.of(document).ok().filter(|command| needs_scene(command, document))
            }
            Self::Set { .. } => None,
        }
    }
}

impl RecordRequest {
    /// True if the request depends on the scene ([`needs_scene`]) in `document`, unless it was carried out before.
    pub fn needs_scene(&self, document: &Document) -> bool {
        let edits = match &self.request {
            Ok(RecordAction::Edit(edit)) => std::slice::from_ref(edit),
            Ok(RecordAction::Group(edits)) => edits,
            _ => &[],
        };
        edits.iter().any(|edit| edit.command.if_it_needs_scene(document).is_some())
    }
}

/// True if only the scene determines the result of a command, which takes a while: the result of a feature drag, the
/// range of a light that is bent, or the hard pins that an edit keeps.
pub fn needs_scene(command: &Command, document: &Document) -> bool {
    matches!(command, Command::BendLight { .. }) || needs_solution(document, command)
}

/// Converts a message of a client. The caller makes an error a `ClientRequest::Invalid`, which the session answers in the
/// order of messages.
pub async fn client_request(message: ClientMessage, scenes: &SceneCache) -> Result<ClientRequest, ServerError> {
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
        } => {
            let camera = valid_camera(camera)?;
            let settings = settings.map(TryInto::try_into).transpose()?.unwrap_or_default();
            let (interaction, size) = (interaction.unwrap_or_default(), view_size(width, height)?);
            let parameters = ViewParameters { camera, camera_revision, settings, interaction, size };
            ClientRequest::OpenView { parameters, stats }
        }
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
            let request = requested_edit(command, Some(base_seq), scenes).await;
            ClientRequest::Step(step(op_id, request.map(RecordAction::Edit))?)
        }
        ClientMessage::GestureCommit { gesture, op_id } => {
            ClientRequest::Step(step(op_id, label(gesture).map(RecordAction::Commit))?)
        }
        ClientMessage::Undo { op_id, scope } => ClientRequest::Step(step(op_id, Ok(RecordAction::Undo(scope.into())))?),
        ClientMessage::Redo { op_id, scope } => ClientRequest::Step(step(op_id, Ok(RecordAction::Redo(scope.into())))?),
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
        ClientMessage::Probe { probe, pixel, camera, size, highlights } => ClientRequest::Probe(ProbeQuestion {
            probe: label(probe)?,
            camera,
            size,
            pixel,
            wants_highlights: highlights,
        }),
        ClientMessage::Ping { sent } => ClientRequest::Ping(sent),
    })
}

/// Makes a request for a record and checks the length of its operation id.
pub fn step(op_id: String, request: Result<RecordAction, ServerError>) -> Result<RecordRequest, ServerError> {
    Ok(RecordRequest { op_id: label(op_id)?, request })
}

/// Converts a command. Decodes a scene that it loads, outside the session's task, replaces a demo's name by the hash of
/// its bytes, and looks up the scene's name if the command does not give it.
pub async fn requested_edit(
    mut command: protocol::Command,
    base_seq: Option<u64>,
    scenes: &SceneCache,
) -> Result<RequestedEdit, ServerError> {
    if let protocol::Command::Set { target, value, ignore_pins } = command {
        return Ok(RequestedEdit { base_seq, command: RequestedCommand::Set { target, value, ignore_pins } });
    }
    if let protocol::Command::LoadScene { scene, name } = &mut command {
        name.as_deref().map_or(Ok(()), check_scene_name)?;
        let (asset, known_name) = scenes.resolve(scene).await?;
        *scene = asset.to_string();
        name.get_or_insert(known_name);
    }
    Ok(RequestedEdit { base_seq, command: RequestedCommand::Command(command.try_into()?) })
}

/// Converts an actor and checks its limits.
pub fn actor(wire: protocol::Actor) -> Result<Actor, ServerError> {
    Ok(Actor { id: label(wire.id)?, name: label(wire.name)? })
}

/// Checks the length of a name that a client chose.
fn label(text: String) -> Result<String, ServerError> {
    check_size("a name of an actor, an operation, a gesture or a probe", text.len(), MAX_LABEL_BYTES, "bytes")?;
    Ok(text)
}

/// Converts a camera and checks it.
pub fn valid_camera(wire: protocol::Camera) -> Result<Camera, ServerError> {
    let camera = Camera::from(wire);
    camera.check().map_err(EditError::InvalidCamera)?;
    Ok(camera)
}

/// Checks that a view of that size can be streamed.
fn view_size(width: u32, height: u32) -> Result<[u32; 2], ServerError> {
    if width == 0 || height == 0 {
        return Err(ServerError::bad_message("a view has no pixels: give it a width and a height"));
    }
    check_size("a side of a view", width.max(height) as usize, MAX_VIEW_SIDE as usize, "pixels")?;
    check_size("a view", (width * height) as usize, MAX_VIEW_PIXELS as usize, "pixels")?;
    Ok([width, height])
}
