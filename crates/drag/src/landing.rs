//! Light with the feature of a drag at a pixel.

use glam::DVec2;
use light::CheckedLight;
use raycast::SeenPoint;

use crate::chain::{ChainRule, follow};
use crate::convex_step::StepWeights;
use crate::dragged_feature::DraggedFeature;
use crate::moves::Unknowns;
use crate::occlusion::seen_at;
use crate::picture_metric::PictureMetric;
use crate::pins::Pins;
use crate::point_in_light::PointInLight;
use crate::problem::{Objective, Problem, Tracked};
use crate::request::{Constraint, Drag, DragLimit, DragRefusal, Feature, RadiusMode};
use crate::start::DragStart;
use crate::taken_feature::TakenFeature;
use crate::visibility::Visibility;

/// Largest distance of a landed feature from the cursor, in pixels. The lit side of a surface has to reach 0, since its
/// distance is 0 wherever the surface faces the light closely enough.
const LANDED_PX: f64 = 0.5;

/// Largest distance at which two points of a light path count as the same point, as a share of their distance from the
/// source or from the point under the cursor.
const SAME_POINT_TOLERANCE: f64 = 1e-6;

/// Sub-steps along the feature's way, and further steps at its end.
const SUB_STEPS: usize = 16;
const END_STEPS: usize = 4;

/// Factors of the weights of the picture: the first, and the one if the feature does not land by that.
const PICTURE_WEIGHTS: [f64; 2] = [1.0, 0.1];

/// Cost of checking a light, in steps per control point.
const CHECK_COST_STEPS: u64 = 1_000;

/// Most tangents that are added in a drag. The second number is the most at which soft pins may still add some.
const MAX_TANGENTS: [usize; 2] = [12, 4];

/// Returns the chain along the way of a feature that moves by `px_of_step` pixels in a sub-step.
///
/// A highlight or a lit side turns the light far for each pixel. With a step of less weight its chain overshoots, and the
/// light jumps between neighbouring cursors. A shadow near its caster may ask for any change, which its chain does not
/// follow.
fn rule_of(feature: Feature, px_of_step: f64) -> ChainRule {
    // The weight of a step, and the largest change of the light per pixel, in units of the unknowns.
    let (step, max_change_per_px) = match feature {
        Feature::Shadow => (30.0, 0.05),
        Feature::Hotspot => (30.0, 0.4),
        Feature::Highlight | Feature::Diffuse => (100.0, 0.4),
    };
    ChainRule {
        sub_steps: SUB_STEPS,
        end_steps: END_STEPS,
        weights: StepWeights { change: 3.0, step },
        max_change: max_change_per_px * px_of_step,
        max_rows: f64::INFINITY,
    }
}

/// Drag of a part of the light to any end.
pub(crate) struct DragToAnyEnd<'a> {
    pub start: &'a DragStart<'a>,
    pub drag: &'a Drag,
    unknowns: Unknowns,
}

/// Light with the feature at a pixel.
pub(crate) struct Landing {
    pub light: CheckedLight,
    pub residual_px: f64,
    /// Node that shadows the feature in place of the dragged caster.
    pub shadowed_by: Option<usize>,
    /// Constraints that were relaxed, each once.
    pub relaxed: Vec<Constraint>,
    pub iterations: usize,
}

impl Landing {
    /// Adds a constraint that was relaxed for this landing.
    fn relaxed(mut self, constraint: Constraint) -> Self {
        self.relaxed.push(constraint);
        self
    }
}

impl<'a> DragToAnyEnd<'a> {
    /// Prepares a drag of what `drag` says, or returns the reason to refuse it.
    pub fn new(start: &'a DragStart<'a>, drag: &'a Drag) -> Result<Self, DragRefusal> {
        Ok(Self { start, drag, unknowns: start.unknowns(drag)? })
    }

    /// True if changes of the unknowns do not move the feature.
    pub fn has_no_effect(&self) -> bool {
        let taken = self.start.taken(self.drag.feature, self.start.from);
        let (no_pins, no_metric) = (Pins::default(), PictureMetric::default());
        let problem = Problem { metric: &no_metric, ..self.problem(&taken, &self.unknowns, &no_pins) };
        problem.has_no_effect(&problem.tracked_at_start(self.start.feature_t()))
    }

    /// Drags the feature to a pixel with all pins, and if it does not land, without the soft ones. Without any pins, and
    /// with the source free, the light counts if the hard pins hold in it and its source crossed no surface, and else
    /// the first that does not hold is the limit.
    pub fn land(&self, pixel: DVec2) -> Result<Landing, DragLimit> {
        let (pins, visibility) = (&self.start.pins, self.visibility());
        let landed = self.land_with_pins(pixel, pins, &visibility);
        let Err(limit) = landed else { return landed };
        // Control points leave the source where it is.
        let holds_source = self.drag.source_outside && matches!(self.unknowns, Unknowns::Rigid { .. });
        if pins.states.is_empty() && !holds_source {
            return Err(limit);
        }
        let hard = pins.hard();
        let has_soft_pins = hard.states.len() < pins.states.len();
        let without_soft_pins =
            |landing: Landing| if has_soft_pins { landing.relaxed(Constraint::SoftPins) } else { landing };
        if !hard.states.is_empty() && has_soft_pins {
            let landed = self.land_with_pins(pixel, &hard, &visibility);
            if landed.is_ok() {
                return landed.map(without_soft_pins);
            }
        }
        let anywhere = Visibility { source_outside: false, ..self.visibility() };
        let free = self.land_with_pins(pixel, &Pins::default(), &anywhere).map_err(|_| limit)?;
        let placed = self.start.placed.with(free.light.rays());
        let from = self.start.placed.source();
        match visibility.first_violated_pin(&placed, &hard) {
            Some(pin) => Err(DragLimit::Pin(pin)),
            None if visibility.crossed_surface(from, placed.source() - from).is_some() => Err(DragLimit::SourceInside),
            None => Ok(without_soft_pins(free)),
        }
    }

    /// Returns the largest change of what a picture shows at a point of a hard pin of a node, 0 to 1. `None` without such a
    /// pin.
    pub fn largest_change_of_nodes(&self, moved: &CheckedLight) -> Option<f64> {
        let lights = [&self.start.placed, &self.start.placed.with(moved.rays())];
        self.visibility().largest_change_of_nodes(lights, &self.start.pins)
    }

    /// True if the feature lands at a pixel with the hard pins, by the second weight of the picture. This costs a fraction of
    /// [`Self::land()`], which then lands there too.
    pub fn can_land(&self, pixel: DVec2) -> bool {
        let [_, second] = PICTURE_WEIGHTS;
        self.land_by_weight(pixel, &self.start.pins.hard(), &self.visibility(), second).is_ok()
    }

    /// Drags the feature to a pixel. If it does not land, the picture counts less.
    fn land_with_pins(&self, pixel: DVec2, pins: &Pins, visibility: &Visibility) -> Result<Landing, DragLimit> {
        let land_by = |weight| self.land_by_weight(pixel, pins, visibility, weight);
        let [first, second] = PICTURE_WEIGHTS;
        let landed = land_by(first);
        match landed {
            Err(limit) if !self.start.metric.is_empty() => {
                land_by(second).map(|landing| landing.relaxed(Constraint::Picture)).map_err(|_| limit)
            }
            _ => landed,
        }
    }

    /// Drags the feature to a pixel. Radii that may follow the control points shrink where the tube would fold.
    fn land_by_weight(
        &self,
        pixel: DVec2,
        pins: &Pins,
        visibility: &Visibility,
        weight: f64,
    ) -> Result<Landing, DragLimit> {
        let to = self.surface(pixel)?;
        let unknowns = &self.unknowns;
        let kept = match unknowns {
            Unknowns::Points { points, radii: RadiusMode::Follow, unit } => {
                Some(Unknowns::Points { points: points.clone(), radii: RadiusMode::Keep, unit: *unit })
            }
            _ => None,
        };
        let land = |unknowns| self.land_with(unknowns, pins, visibility, weight, pixel, to);
        match &kept {
            Some(kept) => match land(kept) {
                Err(DragLimit::Fold) => land(unknowns).map(|landing| landing.relaxed(Constraint::Radii)),
                landed_or_limited => landed_or_limited,
            },
            None => land(unknowns),
        }
    }

    fn surface(&self, pixel: DVec2) -> Result<SeenPoint, DragLimit> {
        let occlusion = &self.start.occlusion;
        let to = seen_at(occlusion.bvh, &self.drag.view, pixel, occlusion.work);
        to.filter(|to| occlusion.is_node_lit(to.node)).ok_or(DragLimit::NoDescent)
    }

    fn visibility(&self) -> Visibility<'_> {
        let source_outside = self.drag.source_outside;
        let overlap = self.start.overlap_of(&self.unknowns);
        Visibility { occlusion: &self.start.occlusion, source_outside, overlap }
    }

    fn problem<'p>(&'p self, taken: &'p TakenFeature, unknowns: &'p Unknowns, pins: &'p Pins) -> Problem<'p> {
        let placed = self.start.placed.clone();
        Problem::new(Objective::Feature(taken), self.start.light, unknowns, placed, &self.start.metric, pins)
    }

    fn land_with(
        &self,
        unknowns: &Unknowns,
        pins: &Pins,
        visibility: &Visibility,
        picture_weight: f64,
        pixel: DVec2,
        to: SeenPoint,
    ) -> Result<Landing, DragLimit> {
        let taken = self.start.taken(self.drag.feature, to);
        let mut problem = Problem { picture_weight, ..self.problem(&taken, unknowns, pins) };
        let near = problem.tracked_at_start(self.start.feature_t());
        let px_of_step = self.drag.from.distance(pixel).max(1.0) / SUB_STEPS as f64;
        let rule = rule_of(self.drag.feature, px_of_step);
        let mut iterations = 0;
        // Visibility has no slope. So the drag is solved without it, and an edge that the light crossed becomes a
        // further bound.
        let end = loop {
            let end = follow(&problem, problem.unmoved(), &near, [0.0, 1.0], &rule)?;
            iterations += end.iterations;
            let count = problem.tangents.len();
            if count >= MAX_TANGENTS[0] {
                break end;
            }
            let tangents = visibility.violated_tangents(&problem, &end.x, count < MAX_TANGENTS[1]);
            if tangents.is_empty() {
                break end;
            }
            problem.tangents.extend(tangents);
        };
        if let Some(limit) = visibility.violated_limit(&problem, &end.x) {
            return Err(limit);
        }
        self.start.occlusion.work.spend(CHECK_COST_STEPS * self.start.light.light().points().len() as u64);
        let moved = CheckedLight::new(unknowns.light(self.start.light.light(), &end.x)).map_err(|_| DragLimit::Fold)?;
        let (residual_px, shadowed_by) = self.judge(&taken, &moved, &end.tracked, pixel)?;
        // Rays that the budget cut short meet nothing, so what they say does not count.
        if self.start.occlusion.work.is_exhausted() {
            return Err(DragLimit::TooMuchWork);
        }
        Ok(Landing { light: moved, residual_px, shadowed_by, relaxed: Vec::new(), iterations })
    }

    /// Checks with rays that the feature of a light is at a pixel, and can be seen there. Returns its distance from the
    /// pixel, and the node that shadows it in place of the dragged caster.
    fn judge(
        &self,
        taken: &TakenFeature,
        moved: &CheckedLight,
        tracked: &Tracked,
        pixel: DVec2,
    ) -> Result<(f64, Option<usize>), DragLimit> {
        let placed = self.start.placed.with(moved.rays());
        let (bvh, view) = (self.start.occlusion.bvh, &self.drag.view);
        let residual_px = DraggedFeature { bvh, view, taken, placed: &placed }.distance_px(tracked.feature, pixel);
        let least_px = if taken.feature == Feature::Diffuse { 0.0 } else { LANDED_PX };
        if residual_px > least_px {
            return Err(DragLimit::NoDescent);
        }
        // If paths of a light overlap, the root that counts may differ from the tracked one.
        let counts = placed.locate(taken.to.position, None).ok_or(DragLimit::TubeEdge)?;
        let is_tracked = |coords: &PointInLight, t: f64| (coords.t - t).abs() < SAME_POINT_TOLERANCE * (1.0 + t.abs());
        let caster_counts = |caster| placed.locate(caster, None).is_some_and(|at| is_tracked(&at, tracked.feature[1]));
        if !is_tracked(&counts, tracked.feature[0]) || !taken.pivot.is_none_or(caster_counts) {
            return Err(DragLimit::TubeEdge);
        }
        let is_dark = self.start.occlusion.is_unlit(&placed, &counts, &taken.to);
        let Some(pivot) = taken.pivot else {
            // A feature that was lit stays lit.
            let was_dark = self.start.occlusion.is_unlit(&self.start.placed, &self.start.coords, &taken.from);
            return if is_dark && !was_dark { Err(DragLimit::NoDescent) } else { Ok((residual_px, None)) };
        };
        let first = self.start.occlusion.first_caster(&placed, &counts, &taken.to);
        let first = first.filter(|_| is_dark).ok_or(DragLimit::NoDescent)?;
        let is_the_pivot = pivot.distance(first.position) < SAME_POINT_TOLERANCE * pivot.distance(taken.to.position);
        Ok((residual_px, (!is_the_pivot).then_some(first.node)))
    }
}
