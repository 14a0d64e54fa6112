//! `POST /sessions/S/drags`: where drags of features would lead, without an edit.

use std::cell::RefCell;
use std::sync::Arc;
use std::time::Instant;

use axum::body::Bytes;
use axum::extract::State;
use axum::http::HeaderMap;
use document::{Document, EditError, MAX_CHOSEN_POINTS, MAX_PINS};
use drag::{Viewport, Work, drag_within};
use light::{CheckedLight, LightId};
use protocol::RenderLimits;
use protocol::drag_file::{Drag, Dragged, NameOrIndex};
use raycast::Bvh;

use super::answer::{Answer, json};
use super::read::{SessionName, read_json};
use super::render::default_camera;
use crate::ServerError;
use crate::limits::MAX_DRAGS;
use crate::room::{Message, Snapshot};
use crate::scenes::Decoded;
use crate::solver::Turn;
use crate::state::AppState;
use crate::turns::Payer;

/// A drag with what its names mean in the document.
struct Question {
    light: Arc<CheckedLight>,
    view: Viewport,
    drag: drag::Drag,
    /// What the answer calls each pin.
    pins: Vec<usize>,
}

/// Every drag from the document as it is, whatever the others do.
pub async fn answer(
    State(state): State<Arc<AppState>>,
    SessionName(name): SessionName,
    headers: HeaderMap,
    body: Bytes,
) -> Answer {
    let drags: Vec<Drag> = read_json(&headers, &body)?;
    if drags.len() > MAX_DRAGS {
        return Err(ServerError::TooMany { what: "drags in a request", limit: MAX_DRAGS });
    }
    let Snapshot { document, scene, .. } = state.rooms.find(&name).await?.request(Message::Snapshot).await?;
    let questions = drags.iter().map(|asked| question(asked, &document, &scene));
    let questions = questions.collect::<Result<Vec<_>, _>>()?;
    let bvh = scene.bvh().await?;
    let mut answers = Vec::with_capacity(questions.len());
    for question in questions {
        // Where the request's connection ends this future is dropped, and what is being solved is given up.
        let bvh = Arc::clone(&bvh);
        let solve = move |turn: &mut Turn| dragged(&bvh, &question, turn);
        answers.push(state.backend.solver.run(Payer::program(&name), solve).await?);
    }
    Ok(json(&answers))
}

fn dragged(bvh: &Bvh, question: &Question, turn: &mut Turn) -> Dragged {
    let began = Instant::now();
    let turn = RefCell::new(turn);
    let goes_on = |steps| turn.borrow_mut().goes_on(steps);
    let work = Work::new(&goes_on);
    let landing = drag_within(bvh, &question.view, &question.light, &question.drag, &work);
    let name = |node: usize| bvh.posed.scene.nodes[node].name.clone();
    Dragged::new(&landing, &question.pins, name, began.elapsed().as_secs_f64())
}

/// What is asked, with the lights and cameras of the document for their names and, where the drag has no pins of its own, the
/// document's.
fn question(asked: &Drag, document: &Document, scene: &Decoded) -> Result<Question, ServerError> {
    let size = RenderLimits::HTTP.check_size(asked.size)?;
    if size.contains(&0) {
        return Err(edit::Refusal::from(EditError::NoPicture).into());
    }
    let chosen = asked.points.as_ref().map_or(0, Vec::len);
    let pinned = asked.pins.as_ref().map_or(0, Vec::len);
    for (what, count, limit) in [("control points", chosen, MAX_CHOSEN_POINTS), ("pins", pinned, MAX_PINS)] {
        if count > limit {
            return Err(edit::Refusal::from(EditError::TooManyChosen { what, limit }).into());
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
                NameOrIndex::Name(name) => Some(document.find_camera(name).map_err(edit::Refusal::from)?),
            };
            let camera = id.and_then(|id| document.cameras().get(&id));
            camera.cloned().ok_or_else(|| none_at("camera", wanted))?
        }
    };
    let light =
        document.lights().get(&id).map(|placed| Arc::clone(&placed.light)).ok_or(ServerError::Fault)?;
    Ok(Question { light, view: Viewport { camera, size }, drag, pins })
}

/// The light of that name, or of that index among all.
fn light_named(document: &Document, wanted: &NameOrIndex) -> Result<LightId, ServerError> {
    match wanted {
        NameOrIndex::Index(index) => document.lights().keys().nth(*index).copied(),
        NameOrIndex::Name(name) => Some(document.find_light(name).map_err(edit::Refusal::from)?),
    }
    .ok_or_else(|| none_at("light", wanted))
}

fn none_at(what: &'static str, wanted: &NameOrIndex) -> ServerError {
    let remedy = "give the name or the index of one of the document's";
    ServerError::NotFound { what, name: wanted.to_string().chars().take(64).collect(), remedy }
}
