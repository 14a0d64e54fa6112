//! Session with a light, and three people who edit it.

use std::sync::Arc;

use document::{AssetHash, Command, CommandContext, DocumentHash, SceneContents};
use edit::{Actor, EditRefusal, EditRequest, EditSources, Record, Session, UndoScope};
use glam::DVec3;
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, NAME, POSITION, RADIUS};
use light::{CheckedLight, Light, LightId};

/// Scenes that can be loaded: one with a light, one empty.
pub const SCENES: &[AssetHash] = &[AssetHash([1; 32]), AssetHash([2; 32])];
/// Light of [`TestSession::new`].
pub const KEY: LightId = LightId(1);

/// Returns the contents of the scenes above.
fn find_scene(asset: AssetHash) -> Option<SceneContents> {
    let lights = if asset == SCENES[0] { vec![bent_light()] } else { Vec::new() };
    SCENES.contains(&asset).then_some(SceneContents { lights, cameras: Vec::new() })
}

/// Returns a BendyLight with four control points, two units apart, nearly straight.
pub fn bent_light() -> Arc<CheckedLight> {
    let points = (0..4).map(|i| DVec3::new(0.1 * f64::from(i), 0.0, -2.0 * f64::from(i))).collect();
    let light = Light::bendy(points, vec![0.1, 0.4, 0.6, 0.8]).with(NAME, "key".into());
    Arc::new(CheckedLight::new(light).expect("a valid light"))
}

/// Returns the actor with the id `"ada"`, `"ben"` or `"cyd"`.
pub fn actor(id: &str) -> Actor {
    Actor { id: id.into(), name: id.to_uppercase() }
}

/// Session in progress, with all its records.
#[derive(Clone, Default)]
pub struct TestSession {
    pub session: Session,
    pub log: Vec<Record>,
}

impl TestSession {
    /// Makes a session with a light that another actor than these three has added.
    pub fn new() -> Self {
        let mut studio = Self::default();
        studio.edit("rig", Command::AddLight(bent_light()));
        studio
    }

    /// Returns the result of a request with an operation name of its own.
    pub fn ask(&mut self, who: &str, request: EditRequest) -> Result<Record, EditRefusal> {
        let op_id = format!("op {}", self.session.seq() + 1);
        let record = |seq: u64| self.log.get(seq as usize - 1).cloned();
        let reverted = self.session.find_revert(&request, who, &record)?;
        let loaded = match &request {
            EditRequest::Edit { command: Command::LoadScene { asset, .. }, .. } => find_scene(*asset),
            _ => None,
        };
        let context = CommandContext { loaded: loaded.as_ref(), ..CommandContext::default() };
        let sources = EditSources { context, reverted };
        let record = self.session.execute_request(request, &actor(who), &op_id, 0, sources)?;
        self.log.push(record.clone());
        Ok(record)
    }

    /// Returns the record of a request that must succeed.
    pub fn done(&mut self, who: &str, request: EditRequest) -> Record {
        self.ask(who, request).expect("a valid request")
    }

    /// Returns true if a request that must succeed was rebased.
    pub fn is_rebased(&mut self, who: &str, request: EditRequest) -> bool {
        self.done(who, request).action.rebased()
    }

    pub fn edit(&mut self, who: &str, command: Command) -> Record {
        self.done(who, EditRequest::Edit { base_seq: None, command })
    }

    pub fn undo(&mut self, who: &str) -> Record {
        self.done(who, EditRequest::Undo(UndoScope::Mine))
    }

    pub fn redo(&mut self, who: &str) -> Record {
        self.done(who, EditRequest::Redo(UndoScope::Mine))
    }

    pub fn hash(&self) -> DocumentHash {
        self.session.document().hash()
    }

    pub fn light(&self) -> &Light {
        self.session.document().lights()[&KEY].light.light()
    }

    pub fn angle(&self) -> f64 {
        self.light().get(CONE_ANGLE)
    }

    pub fn softness(&self) -> f64 {
        self.light().get(CONE_SOFTNESS)
    }

    pub fn radius(&self, point: usize) -> f64 {
        self.light().points()[point].radius
    }
}

pub fn angle(degrees: f64) -> Command {
    Command::SetLight { light: KEY, setting: CONE_ANGLE.to(degrees), ignore_pins: false }
}

pub fn softness(share: f64) -> Command {
    Command::SetLight { light: KEY, setting: CONE_SOFTNESS.to(share), ignore_pins: false }
}

pub fn radius(point: usize, radius: f64) -> Command {
    Command::SetPoint { light: KEY, point, setting: RADIUS.to(radius), ignore_pins: false }
}

pub fn position(point: usize, x: f64, z: f64) -> Command {
    Command::SetPoint { light: KEY, point, setting: POSITION.to(DVec3::new(x, 0.0, z)), ignore_pins: false }
}

pub fn insert(point: usize) -> Command {
    Command::InsertPoint {
        light: KEY,
        point,
        position: None,
        radius: None,
        color: None,
        intensity: None,
        ignore_pins: false,
    }
}

/// Returns the edit as [`EditRequest::Edit`], by a sender who knew record `base_seq`.
pub fn based(base_seq: u64, command: Command) -> EditRequest {
    EditRequest::Edit { base_seq: Some(base_seq), command }
}
