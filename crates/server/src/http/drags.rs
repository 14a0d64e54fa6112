//! `POST /sessions/S/drags`: solves drags of features without an edit.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use axum::extract::State;
use document::{Document, EditError, MAX_CHOSEN_POINTS, MAX_PINS};
use drag::{Viewport, WorkBudget, drag_budgeted};
use light::{CheckedLight, LightId};
use protocol::RenderLimits;
use protocol::drag_file::{Dragged, FileDrag, NameOrIndex};
use raycast::Bvh;

use super::answer::{HandlerResult, json};
use super::read::{JsonBody, SessionName};
use super::render::default_camera;
use crate::ServerError;
use crate::charges::Payer;
use crate::limits::MAX_DRAGS;
use crate::room::SessionSnapshot;
use crate::scenes::DecodedScene;
use crate::solver::SolveTurn;
use crate::state::App;

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
    State(state): App,
    SessionName(name): SessionName,
    JsonBody(drags): JsonBody<Vec<FileDrag>>,
) -> HandlerResult {
    if drags.len() > MAX_DRAGS {
        return Err(ServerError::TooMany { what: "drags in a request", limit: MAX_DRAGS });
    }
    let SessionSnapshot { document, scene, .. } = state.rooms.snapshot(&name).await?;
    let drags = drags.iter().map(|drag| resolve_drag(drag, &document, &scene)).collect::<Result<Vec<_>, _>>()?;
    let bvh = scene.bvh().await?;
    let mut answers = Vec::with_capacity(drags.len());
    for drag in drags {
        // If the connection ends, this future is dropped and the running solve is cancelled.
        let bvh = Arc::clone(&bvh);
        let solve = move |turn: &mut SolveTurn| solve_drag(&bvh, &drag, turn);
        answers.push(state.services.solver.run(Payer::program(&name), solve).await?);
    }
    Ok(json(&answers))
}

fn solve_drag(bvh: &Bvh, resolved: &ResolvedFileDrag, turn: &mut SolveTurn) -> Dragged {
    let began = Instant::now();
    let ResolvedFileDrag { light, view, drag, pins } = resolved;
    let turn = RefCell::new(turn);
    let may_continue = |steps| turn.borrow_mut().may_continue(steps);
    let result = drag_budgeted(bvh, view, light, drag, &WorkBudget::new(&may_continue));
    let name = |node: usize| bvh.posed.scene.nodes[node].name.clone();
    Dragged::new(&result, pins, name, began.elapsed().as_secs_f64())
}

/// Resolves the names of lights and cameras in the document. A drag without pins of its own gets the document's.
fn resolve_drag(
    file_drag: &FileDrag,
    document: &Document,
    scene: &DecodedScene,
) -> Result<ResolvedFileDrag, ServerError> {
    let size = RenderLimits::HTTP.check_size(file_drag.size)?;
    if size.contains(&0) {
        return Err(EditError::EmptyViewport.into());
    }
    let chosen = file_drag.points.as_ref().map_or(0, Vec::len);
    let pinned = file_drag.pins.as_ref().map_or(0, Vec::len);
    for (what, count, limit) in [("control points", chosen, MAX_CHOSEN_POINTS), ("pins", pinned, MAX_PINS)] {
        if count > limit {
            return Err(EditError::TooManyChosen { what, limit }.into());
        }
    }
    let light_of = |name: &NameOrIndex| light_named(document, name);
    let id = light_of(&file_drag.light)?;
    file_drag.pins.iter().flatten().try_for_each(|pin| light_of(&pin.light).map(|_| ()))?;
    let (mut drag, mut pins) = file_drag.to_domain(|name| light_of(name).is_ok_and(|light| light == id));
    if file_drag.pins.is_none() {
        (pins, drag.pins) = document.pins_of(id).map(|(id, pin)| (id.0 as usize, pin.clone())).unzip();
    }
    let camera = match &file_drag.camera {
        None => default_camera(document, scene, f64::from(size[0]) / f64::from(size[1])),
        Some(name) => {
            let camera = match name {
                NameOrIndex::Index(index) => document.cameras().values().nth(*index),
                NameOrIndex::Name(name) => document.cameras().get(&document.find_camera(name)?),
            };
            camera.cloned().ok_or_else(|| not_found("camera", name))?
        }
    };
    let light = document.lights().get(&id).map(|placed| Arc::clone(&placed.light)).ok_or(ServerError::Internal)?;
    Ok(ResolvedFileDrag { light, view: Viewport { camera, size }, drag, pins })
}

/// Returns the light of that name, or of that index among all lights.
fn light_named(document: &Document, name: &NameOrIndex) -> Result<LightId, ServerError> {
    match name {
        NameOrIndex::Index(index) => document.lights().keys().nth(*index).copied(),
        NameOrIndex::Name(name) => Some(document.find_light(name)?),
    }
    .ok_or_else(|| not_found("light", name))
}

fn not_found(what: &'static str, name: &NameOrIndex) -> ServerError {
    let remedy = "give the name or the index of one of the document's";
    ServerError::NotFound { what, name: name.to_string().chars().take(64).collect(), remedy }
}
