//! Sessions, lights and pins that rows need, made over HTTP before anything is measured.

use light::parameters::NAME;
use protocol::{Camera, Command};
use serde_json::{Value, json};

use crate::{BenchError, Response, ServerAddress};

/// Width and height in pixels of the picture in which features are dragged.
pub(super) const SIZE: [u32; 2] = [640, 360];
/// Number of edits in one request.
const EDITS: usize = 250;
/// Control points in a drag: the most that a server accepts.
const MAX_CHOSEN: usize = 128;

/// A pixel, and the world position that it sees.
#[derive(Clone, Copy, Debug)]
pub(super) struct LitPixel {
    pub pixel: [f64; 2],
    pub at: [f64; 3],
}

/// Light of a session, with data for dragging its features.
#[derive(Clone, Debug)]
pub(super) struct Draggable {
    pub light: u64,
    /// Number of the light's control points.
    points: usize,
    camera: Camera,
    /// Pixels that the light reaches.
    pub lit: Vec<LitPixel>,
}

pub(super) fn make_session(address: &ServerAddress, session: &str, scene: &str) -> Result<(), BenchError> {
    post(address, "/sessions", &json!({"name": session, "scene": scene})).map(drop)
}

/// Posts JSON and returns the JSON of the response; an error if the server refuses.
pub(super) fn post(address: &ServerAddress, path: &str, body: &Value) -> Result<Value, BenchError> {
    read(&address.post(path, body.to_string().as_bytes())?)
}

/// Requests a session's document.
pub(super) fn document(address: &ServerAddress, session: &str) -> Result<Value, BenchError> {
    let mut state = read(&address.get(&format!("/sessions/{session}"))?)?;
    Ok(state["document"].take())
}

/// Returns the id of the first light of a session; 0 if there is none.
pub(super) fn first_light(address: &ServerAddress, session: &str) -> Result<u64, BenchError> {
    Ok(document(address, session)?["lights"][0]["id"].as_u64().unwrap_or_default())
}

fn read(response: &Response) -> Result<Value, BenchError> {
    if !(200..300).contains(&response.status) {
        return Err(BenchError::Refused(response.text()));
    }
    Ok(serde_json::from_slice(&response.body)?)
}

/// Returns the commands that straighten a light and bend it again into `segments` segments.
pub(super) fn rebend(light: u64, segments: usize) -> [Value; 2] {
    [
        json!({"type": "straightenLight", "light": light}),
        json!({"type": "bendLight", "light": light, "segments": segments}),
    ]
}

/// Edits a session; the first rejected command is an error.
pub(super) fn edit(address: &ServerAddress, session: &str, actor: &str, commands: &[Value]) -> Result<(), BenchError> {
    for commands in commands.chunks(EDITS) {
        let edits: Vec<Value> = commands.iter().map(|command| json!({"command": command})).collect();
        let body = json!({"actor": {"id": actor, "name": actor}, "edits": edits});
        let answer = post(address, &format!("/sessions/{session}/edits"), &body)?;
        let mut results = answer["results"].as_array().into_iter().flatten();
        if let Some(rejected) = results.find(|result| result["status"] == "rejected") {
            return Err(BenchError::Refused(rejected["message"].to_string()));
        }
    }
    Ok(())
}

/// Changes the name of a light. No picture depends on it, but every drag of the light does.
pub(super) fn rename(light: u64, n: u64) -> Command {
    Command::SetLight { light, parameter: NAME.to(format!("name {n}")).into(), ignore_pins: false }
}

/// Adds a light like the first of a session, straightened and bent into `segments` segments if given. Returns its id.
pub(super) fn add_light(
    address: &ServerAddress,
    session: &str,
    actor: &str,
    segments: Option<usize>,
) -> Result<u64, BenchError> {
    let light = &document(address, session)?["lights"][0]["light"];
    edit(address, session, actor, &[json!({"type": "addLight", "light": light})])?;
    let document = document(address, session)?;
    let added = document["lights"].as_array().and_then(|lights| lights.last()?["id"].as_u64());
    let id = added.ok_or_else(|| BenchError::Refused("it added no light".into()))?;
    if let Some(segments) = segments {
        edit(address, session, actor, &rebend(id, segments))?;
    }
    Ok(id)
}

/// Adds `pins` pins to a light at pixels that it lights, two of them hard.
pub(super) fn pin(
    address: &ServerAddress,
    session: &str,
    actor: &str,
    light: u64,
    pins: usize,
) -> Result<Draggable, BenchError> {
    let document = document(address, session)?;
    let lights = document["lights"].as_array().map_or(&[][..], Vec::as_slice);
    let index = lights.iter().position(|placed| placed["id"] == light).unwrap_or_default();
    let points = lights.get(index).and_then(|placed| placed["light"]["points"].as_array()).map_or(0, Vec::len);
    let camera = serde_json::from_value(document["cameras"][0]["camera"].clone())?;
    let lit = lit_pixels(address, session, index)?;
    let kinds = ["direction", "lit"];
    let pin = |n: usize| {
        let at = lit[n * 7 % lit.len()].at;
        json!({"type": "addPin", "pin": {"kind": kinds[n % 2], "light": light, "at": at, "hard": n < 2}})
    };
    let commands: Vec<Value> = (0..pins).map(pin).collect();
    edit(address, session, actor, &commands)?;
    Ok(Draggable { light, points, camera, lit })
}

/// Finds pixels that a light reaches, by drags of hotspots to their own position. `index` is the light's position in
/// the order of the session's lights.
fn lit_pixels(address: &ServerAddress, session: &str, index: usize) -> Result<Vec<LitPixel>, BenchError> {
    let seen = (120..340).step_by(20).flat_map(|y| (60..600).step_by(20).map(move |x| (x, y)));
    let drags: Vec<Value> = seen
        .map(|(x, y)| [f64::from(x) + 0.5, f64::from(y) + 0.5])
        .map(|at| json!({"light": index, "kind": "hotspot", "size": SIZE, "from": at, "to": at, "pins": []}))
        .collect();
    let answers = post(address, &format!("/sessions/{session}/drags"), &json!(drags))?;
    let pairs = drags.iter().zip(answers.as_array().into_iter().flatten());
    let lit: Vec<LitPixel> = pairs
        .filter(|(_, answer)| answer["status"] == "landed")
        .filter_map(|(drag, answer)| {
            let pixel = serde_json::from_value(drag["from"].clone()).ok()?;
            Some(LitPixel { pixel, at: serde_json::from_value(answer["fromWorld"].clone()).ok()? })
        })
        .collect();
    if lit.is_empty() {
        return Err(BenchError::Refused("no pixel is lit by the light that is to be dragged".into()));
    }
    Ok(lit)
}

impl Draggable {
    /// Returns the command that drags a hotspot, the `n`th of many such drags, by as many control points as a drag may
    /// use, without the source.
    pub fn command(&self, n: usize) -> Result<Command, BenchError> {
        let from = self.lit[self.lit.len() / 2].pixel;
        let to = self.lit[(self.lit.len() / 2 + 1 + n % 5) % self.lit.len()].pixel;
        let movable = self.points.saturating_sub(1);
        let chosen = movable.min(MAX_CHOSEN);
        let points: Vec<usize> = (0..chosen).map(|k| 1 + k * movable / chosen).collect();
        let command = json!({
            "type": "dragFeature", "light": self.light, "kind": "hotspot", "points": points, "radii": "solve",
            "camera": self.camera, "size": SIZE, "from": from, "to": to,
        });
        Ok(serde_json::from_value(command)?)
    }
}
