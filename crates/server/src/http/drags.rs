//! `POST /sessions/S/drags`: solves drags of features without an edit.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use axum::extract::State;
use document::{Command, CommandSolution, Document, EditError, check_drag, execute_command};
use drag::{
    Drag, DragResult as Solved, DragStatus, LightCopy, NumberedPin, WorkBudget, drag_alternatives, drag_budgeted,
};
use light::{CheckedLight, LightId};
use protocol::RenderLimits;
use protocol::drag_file::{DragCamera, DragResult, FileDrag, NameOrIndex};
use raycast::Bvh;

use super::answer::{HandlerResult, json};
use super::read::{JsonBody, SessionName};
use super::render::default_camera;
use super::thumbnail::draw_thumbnail;
use crate::ServerError;
use crate::charges::Payer;
use crate::limits::{MAX_DRAGS, MAX_DRAGS_WITH_ALTERNATIVES};
use crate::request::valid_camera;
use crate::room::SessionSnapshot;
use crate::scenes::DecodedScene;
use crate::solver::SolveTurn;
use crate::state::App;

/// A drag with its names resolved in the document.
#[derive(Clone)]
struct ResolvedDrag {
    id: LightId,
    light: Arc<CheckedLight>,
    drag: Drag,
    /// True for all alternatives, with pictures.
    wants_alternatives: bool,
    /// Pins of the light in the document.
    pins: Vec<NumberedPin>,
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
    let SessionSnapshot { document, scene, lease, .. } = state.rooms.snapshot(&name).await?;
    let drags = drags.iter().map(|drag| resolve_drag(drag, &document, &scene)).collect::<Result<Vec<_>, _>>()?;
    let draws = drags.iter().filter(|drag| drag.wants_alternatives).count();
    if draws > MAX_DRAGS_WITH_ALTERNATIVES {
        let what = "drags with `alternatives` in a request";
        return Err(ServerError::TooMany { what, limit: MAX_DRAGS_WITH_ALTERNATIVES });
    }
    let _permit = (draws > 0).then(|| state.stills.acquire(&name)).transpose()?;
    let bvh = scene.bvh().await?;
    let mut answers = Vec::with_capacity(drags.len());
    for drag in drags {
        // If the connection ends, this future is dropped and the running solve is cancelled.
        let (bvh, solved_drag) = (Arc::clone(&bvh), drag.clone());
        let solve = move |turn: &mut SolveTurn| solve_drag(&bvh, &solved_drag, turn);
        let (best, all, seconds) = state.services.solver.run(Payer::program(&name), solve).await?;
        let mut answer = DragResult::new(&best, &all, seconds);
        for (alternative, solved) in answer.alternatives.iter_mut().zip(&all) {
            if let Some(after) = document_after(&document, &scene, &drag, solved) {
                let drawn = draw_thumbnail(&state, (&name, &lease), &after, &scene, &drag.drag.view);
                alternative.thumbnail = Some(drawn.await?);
            }
        }
        answers.push(answer);
    }
    Ok(json(&answers))
}

/// Solves a drag and, if asked for, its alternatives. Returns the result, the alternatives and the duration in seconds.
fn solve_drag(bvh: &Bvh, resolved: &ResolvedDrag, turn: &mut SolveTurn) -> (Solved, Vec<Solved>, f64) {
    let began = Instant::now();
    let ResolvedDrag { light, drag, pins, wants_alternatives, .. } = resolved;
    let turn = RefCell::new(turn);
    let may_continue = |steps| turn.borrow_mut().may_continue(steps);
    let work = WorkBudget::new(&may_continue);
    let solve_all = || drag_alternatives(bvh, light, drag, pins, &work);
    let all = if *wants_alternatives { solve_all() } else { Vec::new() };
    let best = all.first().cloned().unwrap_or_else(|| drag_budgeted(bvh, light, drag, pins, &work));
    (best, all, began.elapsed().as_secs_f64())
}

/// Returns the document after a drag. `None` if the drag was refused, or if the document has no room for its copy.
fn document_after(document: &Document, scene: &DecodedScene, drag: &ResolvedDrag, solved: &Solved) -> Option<Document> {
    if let DragStatus::Refused(_) = solved.outcome.status {
        return None;
    }
    // Pins of the request are no pins of the document.
    let copy = solved.copy.clone().map(|copy| LightCopy { pins: Vec::new(), ..copy });
    let solved = CommandSolution::Drag(Box::new(Solved { copy, ..solved.clone() }));
    let command = Command::DragFeature { light: drag.id, drag: Box::new(drag.drag.clone()) };
    Some(execute_command(document, &command, scene.context(None, Some(&solved))).ok()?.document)
}

/// Resolves the names of lights and cameras in the document. A drag without pins of its own gets the document's.
fn resolve_drag(file_drag: &FileDrag, document: &Document, scene: &DecodedScene) -> Result<ResolvedDrag, ServerError> {
    let size = RenderLimits::HTTP.check_size(file_drag.size)?;
    if size.contains(&0) {
        return Err(EditError::EmptyViewport.into());
    }
    let camera = match &file_drag.camera {
        None => default_camera(document, scene, f64::from(size[0]) / f64::from(size[1])),
        Some(DragCamera::Own(camera)) => valid_camera((**camera).clone())?,
        Some(DragCamera::Listed(name)) => {
            let camera = match name {
                NameOrIndex::Index(index) => document.cameras().values().nth(*index),
                NameOrIndex::Name(name) => document.cameras().get(&document.find_camera(name)?),
            };
            camera.cloned().ok_or_else(|| not_found("camera", name))?
        }
    };
    let light_of = |name: &NameOrIndex| light_named(document, name);
    let id = light_of(&file_drag.light)?;
    let drag = file_drag.to_domain(camera, |name| light_of(name).is_ok_and(|light| light == id));
    check_drag(&drag)?;
    file_drag.pins.iter().flatten().try_for_each(|pin| light_of(&pin.light).map(|_| ()))?;
    let light = document.lights().get(&id).map(|placed| Arc::clone(&placed.light)).ok_or(ServerError::Internal)?;
    let pins = document.pins_of(id).map(|(id, pin)| NumberedPin { number: id.0, pin: pin.clone() }).collect();
    Ok(ResolvedDrag { id, light, drag, wants_alternatives: file_drag.alternatives, pins })
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
