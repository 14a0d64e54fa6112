//! What clients and programs send, as the session's task understands it.

use edit::{Actor, Request};
use light::LightId;
use protocol::{ClientMessage, ViewSource};
use store::check_scene_name;

use crate::ServerError;
use crate::limits::{MAX_LABEL_BYTES, MAX_VIEW_PIXELS, MAX_VIEW_SIDE};
use crate::room::{Ask, Step};
use crate::scenes::Scenes;

/// What a message of a client asks for. What is wrong with it is for the session to tell, in its turn.
pub async fn understand(message: ClientMessage, scenes: &Scenes) -> Ask {
    asked(message, scenes).await.unwrap_or_else(Ask::Nonsense)
}

async fn asked(message: ClientMessage, scenes: &Scenes) -> Result<Ask, ServerError> {
    Ok(match message {
        ClientMessage::Hello { .. } => return Err(ServerError::Hello),
        ClientMessage::OpenView { source: ViewSource::Own(camera), width, height, camera_revision } => {
            Ask::OpenView { camera: sound(camera)?, camera_revision, size: view_size(width, height)? }
        }
        ClientMessage::OpenView { source: ViewSource::Follow(client), .. } => Ask::Follow(client),
        ClientMessage::SetCamera { camera, camera_revision } => {
            Ask::SetCamera { camera: sound(camera)?, camera_revision }
        }
        ClientMessage::Viewport { width, height } => Ask::Resize(view_size(width, height)?),
        ClientMessage::Ack { frame } => Ask::Ack(frame),
        ClientMessage::Edit { op_id, base_seq, command } => {
            let request = edit_request(command, Some(base_seq), scenes).await;
            Ask::Step(step(op_id, request)?)
        }
        ClientMessage::GestureCommit { gesture, op_id } => {
            Ask::Step(step(op_id, label(gesture).map(Request::Commit))?)
        }
        ClientMessage::Undo { op_id, scope } => Ask::Step(step(op_id, Ok(Request::Undo(scope.into())))?),
        ClientMessage::Redo { op_id, scope } => Ask::Step(step(op_id, Ok(Request::Redo(scope.into())))?),
        ClientMessage::GestureBegin { gesture, light, base_seq } => {
            Ask::BeginGesture { gesture: label(gesture)?, light: LightId(light), base_seq }
        }
        ClientMessage::GestureUpdate { gesture, update, command } => {
            let command = document::Command::try_from(command).map_err(ServerError::from);
            Ask::UpdateGesture { gesture: label(gesture)?, update, command }
        }
        ClientMessage::GestureCancel { gesture } => Ask::CancelGesture(label(gesture)?),
        ClientMessage::Presence { selection } => Ask::Select(selection),
        ClientMessage::History {} => Ask::History,
        ClientMessage::Ping { sent } => Ask::Ping(sent),
    })
}

/// A step under its sender's name for it.
pub fn step(op_id: String, request: Result<Request, ServerError>) -> Result<Step, ServerError> {
    Ok(Step { op_id: label(op_id)?, request })
}

/// The request for a command. A scene that it loads is decoded here, outside of the session's task, a demo's
/// name becomes that of its bytes, and what it is called is looked up where the command does not say.
pub async fn edit_request(
    mut command: protocol::Command,
    base_seq: Option<u64>,
    scenes: &Scenes,
) -> Result<Request, ServerError> {
    if let protocol::Command::LoadScene { scene, name } = &mut command {
        name.as_deref().map_or(Ok(()), check_scene_name)?;
        let (asset, called) = scenes.resolve(scene).await?;
        *scene = asset.to_string();
        name.get_or_insert(called);
    }
    Ok(Request::Edit { base_seq, command: command.try_into()? })
}

/// Who it is, within limits.
pub fn actor(wire: protocol::Actor) -> Result<Actor, ServerError> {
    Ok(Actor { id: label(wire.id)?, name: label(wire.name)? })
}

/// A name that a client chose, within limits.
fn label(text: String) -> Result<String, ServerError> {
    if text.len() > MAX_LABEL_BYTES {
        let what = "a name of an actor, an operation or a gesture";
        return Err(ServerError::TooLarge { what, limit: MAX_LABEL_BYTES, unit: "bytes" });
    }
    Ok(text)
}

/// A camera that makes a picture.
fn sound(wire: protocol::Camera) -> Result<scene::Camera, ServerError> {
    let camera = scene::Camera::from(wire);
    camera.check().map_err(|why| edit::Refusal::from(document::EditError::InvalidCamera(why)))?;
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
