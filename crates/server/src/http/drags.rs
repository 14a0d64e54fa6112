//! `POST /sessions/S/drags`: solves drags of features without an edit.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use document::{Document, EditError, MAX_CHOSEN_POINTS, MAX_PINS};
use drag::{Viewport, WorkBudget, drag_budgeted};
use light::{CheckedLight, LightId};
use protocol::RenderLimits;
use protocol::drag_file::{Dragged, FileDrag, NameOrIndex};
use raycast::Bvh;

use super::answer::{HandlerResult, json};
use super::read::{SessionName, read_json};
use super::render::default_camera;
use crate::ServerError;
use crate::charges::Payer;
use crate::limits::MAX_DRAGS;
use crate::room::{RoomMessage, SessionSnapshot};
use crate::scenes::DecodedScene;
use crate::solver::SolveTurn;
use crate::state::AppState;

/// A drag with its names resolved in the document.
struct ResolvedFileDrag {
    light: Arc<CheckedLight>,
    view: Viewport,
    drag: drag::Drag,
    /// Number of each pin in the answer.
    pins: Vec<usize>,
}

/// Solves each drag from the current document, independently of the others.
pub async fn answer(
    State(state): State<Arc<AppState>>,
    SessionName(name): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> HandlerResult {
    let drags: Vec<FileDrag> = read_json(&headers, &body)?;
    if drags.len() > MAX_DRAGS {
        return Err(ServerError::TooMany { what: "drags in a request", limit: MAX_DRAGS });
    }
    let SessionSnapshot { document, scene, .. } =
        state.rooms.find(&name).await?.request(RoomMessage::Snapshot).await?;
    let questions = drags.iter().map(|asked| resolve_drag(asked, &document, &scene));
    let questions = questions.collect::<Result<Vec<_>, _>>()?;
    let bvh = scene.bvh().await?;
    let mut answers = Vec::with_capacity(questions.len());
    for question in questions {
        // If the connection ends, this future is dropped and the running solve is cancelled.
        let bvh = Arc::clone(&bvh);
        let solve = move |turn: &mut SolveTurn| dragged(&bvh, &question, turn);
        answers.push(state.backend.solver.run(Payer::program(&name), solve).await?);
    }
    Ok(json(&answers))
}

fn dragged(bvh: &Bvh, question: &ResolvedFileDrag, turn: &mut SolveTurn) -> Dragged {
    let began = Instant::now();
    let turn = RefCell::new(turn);
    let goes_on = |steps| turn.borrow_mut().may_continue(steps);
    let work = WorkBudget::new(&goes_on);
    let landing = drag_budgeted(bvh, &question.view, &question.light, &question.drag, &work);
    let name = |node: usize| bvh.posed.scene.nodes[node].name.clone();
    Dragged::new(&landing, &question.pins, name, began.elapsed().as_secs_f64())
}

/// Resolves the names of lights and cameras in the document. A drag without pins of its own gets the document's.
fn resolve_drag(
    asked: &FileDrag,
    document: &Document,
    scene: &DecodedScene,
) -> Result<ResolvedFileDrag, ServerError> {
    let size = RenderLimits::HTTP.check_size(asked.size)?;
    if size.contains(&0) {
        return Err(edit::EditRefusal::from(EditError::EmptyViewport).into());
    }
    let chosen = asked.points.as_ref().map_or(0, Vec::len);
    let pinned = asked.pins.as_ref().map_or(0, Vec::len);
    for (what, count, limit) in [("control points", chosen, MAX_CHOSEN_POINTS), ("pins", pinned, MAX_PINS)] {
        if count > limit {
            return Err(edit::EditRefusal::from(EditError::TooManyChosen { what, limit }).into());
        }
    }
    let light_of = |wanted: &NameOrIndex| light_named(document, wanted);
    let id = light_of(&asked.light)?;
    asked.pins.iter().flatten().try_for_each(|pin| light_of(&pin.light).map(|_| ()))?;
    let (mut drag, mut pins) = asked.to_domain(|wanted| light_of(wanted).is_ok_and(|light| light == id));
    if asked.pins.is_none() {
        (pins, drag.pins) = document.pins_of(id).map(|(id, pin)| (id.0 as usize, pin.clone())).unzip();
    }
    let camera = match &asked.camera {
        None => default_camera(document, scene, f64::from(size[0]) / f64::from(size[1])),
        Some(wanted) => {
            let id = match wanted {
                NameOrIndex::Index(index) => document.cameras().keys().nth(*index).copied(),
                NameOrIndex::Name(name) => Some(document.find_camera(name).map_err(edit::EditRefusal::from)?),
            };
            let camera = id.and_then(|id| document.cameras().get(&id));
            camera.cloned().ok_or_else(|| not_found("camera", wanted))?
        }
    };
    let light =
        document.lights().get(&id).map(|placed| Arc::clone(&placed.light)).ok_or(ServerError::Internal)?;
    Ok(ResolvedFileDrag { light, view: Viewport { camera, size }, drag, pins })
}

/// Returns the light of that name, or of that index among all lights.
fn light_named(document: &Document, wanted: &NameOrIndex) -> Result<LightId, ServerError> {
    match wanted {
        NameOrIndex::Index(index) => document.lights().keys().nth(*index).copied(),
        NameOrIndex::Name(name) => Some(document.find_light(name).map_err(edit::EditRefusal::from)?),
    }
    .ok_or_else(|| not_found("light", wanted))
}

fn not_found(what: &'static str, wanted: &NameOrIndex) -> ServerError {
    let remedy = "give the name or the index of one of the document's";
    ServerError::NotFound { what, name: wanted.to_string().chars().take(64).collect(), remedy }
}
