//! `bendylights replay --resolve`: solves the drags of a log again, and compares the results with the log.

use std::collections::BTreeSet;
use std::sync::Arc;

use document::{
    AssetHash, Command, CommandContext, Document, EditError, execute_command, needs_solution, solve_command,
};
use drag::{DragOutcome, SOLVER, WorkBudget};
use edit::Session;
use glam::DQuat;
use light::{Light, LightId};
use protocol::{Action, Command as WireCommand, Record};
use raycast::Bvh;
use serde_json::json;
use store::Assets;

use crate::known_scenes;

/// Results of all drags.
#[derive(Clone, Copy, Debug, Default)]
struct ResolvedCounts {
    /// Number of drags of features and of control points in the log. Drags of one light in one group count as one.
    drags: usize,
    /// Number of drags that again gave the light of the log, bit for bit.
    same: usize,
    /// Largest difference between another result and the light in the log.
    drift: f64,
    /// Sequence number of the record with that difference.
    drift_seq: Option<u64>,
    /// Number of drags that are refused now.
    refused: usize,
    /// Number of drags that another solver made, or another version of this solver.
    other_solver: usize,
}

/// Solves the drags of a log again, in order.
pub struct Resolver<'a> {
    assets: Option<&'a Assets>,
    /// Latest scene, prepared for rays.
    scene: Option<(AssetHash, Arc<Bvh>)>,
    resolved: ResolvedCounts,
    /// First record whose scene is missing, and the hash of that scene.
    missing: Option<(u64, AssetHash)>,
}

impl<'a> Resolver<'a> {
    /// Returns a resolver that looks for scenes in `assets` and among the demos.
    pub fn new(assets: Option<&'a Assets>) -> Self {
        Self { assets, scene: None, resolved: ResolvedCounts::default(), missing: None }
    }

    /// Solves the drags of a record again and counts the results. `after` is the session after the record.
    pub fn visit(&mut self, record: &Record, after: &Session) {
        if !holds_drag(&record.action) {
            return;
        }
        // The record has been read and replayed before, so the conversion succeeds.
        let Ok(record) = edit::Record::try_from(record.clone()) else { return };
        let mut before = after.document().clone();
        let inverses: Vec<_> = record.changes.iter().rev().map(document::Change::inverse).collect();
        if before.apply(&inverses).is_err() {
            return;
        }
        let commands = record.action.commands();
        let is_drag = |command: &Command| matches!(command, Command::DragFeature { .. } | Command::DragPoint { .. });
        let drags = commands.iter().filter(|(command, _)| is_drag(command));
        let dragged: BTreeSet<LightId> = drags.filter_map(|(command, _)| command.light()).collect();
        self.resolved.drags += dragged.len();
        let is_of_other = |(_, outcome): &(_, Option<&DragOutcome>)| {
            outcome.is_some_and(|outcome| (outcome.solver.as_str(), outcome.version) != SOLVER)
        };
        self.resolved.other_solver += commands.iter().filter(|command| is_of_other(command)).count();
        for (command, _) in commands {
            match self.solve_again(&before, command, record.seq) {
                Some(Ok(again)) => before = again,
                Some(Err(_)) => {
                    self.resolved.refused += dragged.len();
                    return;
                }
                None => return,
            }
        }
        for light in dragged {
            self.compare(&before, after.document(), light, record.seq);
        }
    }

    /// Returns the document after `command`, whose drags are solved again; `None` if the scene is missing.
    fn solve_again(&mut self, before: &Document, command: &Command, seq: u64) -> Option<Result<Document, EditError>> {
        let mut context = CommandContext::default();
        let solved = if needs_solution(before, command) {
            let bvh = match before.scene() {
                None => Arc::new(Bvh::new(scene::pose(scene::Scene::default(), 0.0))),
                Some(scene) => self.bvh(scene.asset).or_else(|| {
                    self.missing = self.missing.or(Some((seq, scene.asset)));
                    None
                })?,
            };
            match solve_command(before, command, context.scene_bounds, &bvh, &WorkBudget::new(&|_| true)) {
                Ok(solved) => Some(solved),
                Err(error) => return Some(Err(error)),
            }
        } else {
            None
        };
        context.solved = solved.as_ref();
        Some(execute_command(before, command, context).map(|edited| edited.document))
    }

    fn bvh(&mut self, asset: AssetHash) -> Option<Arc<Bvh>> {
        if let Some((known, bvh)) = &self.scene
            && *known == asset
        {
            return Some(Arc::clone(bvh));
        }
        let bvh = Arc::new(Bvh::new(scene::pose(known_scenes::load(self.assets, &asset)?, 0.0)));
        self.scene = Some((asset, Arc::clone(&bvh)));
        Some(bvh)
    }

    fn compare(&mut self, again: &Document, logged: &Document, light: LightId, seq: u64) {
        let of = |document: &Document| document.lights().get(&light).map(|placed| placed.light.light().clone());
        let (Some(again), Some(logged)) = (of(again), of(logged)) else { return };
        if again == logged {
            self.resolved.same += 1;
            return;
        }
        let drift = drift(&again, &logged);
        if self.resolved.drift_seq.is_none() || drift > self.resolved.drift {
            (self.resolved.drift, self.resolved.drift_seq) = (drift, Some(seq));
        }
    }

    /// Returns the results as JSON, or the first record whose scene is missing and that scene.
    pub fn into_json(self) -> Result<String, (u64, AssetHash)> {
        let ResolvedCounts { drags, same, drift, drift_seq, refused, other_solver } = self.resolved;
        let answer = json!({
            "drags": drags,
            "same": same,
            "drift": drift,
            "drift_seq": drift_seq,
            "refused": refused,
            "other_solver": other_solver,
        });
        self.missing.map_or(Ok(answer.to_string()), Err)
    }
}

/// Returns true if the action has a command that a solver executes.
fn holds_drag(action: &Action) -> bool {
    let is_drag =
        |command: &WireCommand| matches!(command, WireCommand::DragFeature(_) | WireCommand::DragPoint { .. });
    match action {
        Action::Edit { command, .. } | Action::Gesture { command, .. } => is_drag(command),
        Action::Group { edits, .. } => edits.iter().any(|edit| is_drag(&edit.command)),
        Action::Undo { .. } | Action::Redo { .. } => false,
    }
}

/// Returns the largest difference between two lights in the values that drags change: transforms and control
/// points.
fn drift(a: &Light, b: &Light) -> f64 {
    let (at, bt) = (a.transform(), b.transform());
    let turned = |q: DQuat, r: DQuat| (q - r).length();
    let points = a.points().iter().zip(b.points());
    let of_points = points.map(|(p, q)| p.position.distance(q.position).max((p.radius - q.radius).abs()));
    of_points.fold(at.translation.distance(bt.translation).max(turned(at.rotation, bt.rotation)), f64::max)
}
