//! Drag that keeps the rest of the picture: to the cursor, or as far along the straight way to it as the feature lands.

use glam::DVec2;
use light::{CheckedLight, Light};
use raycast::{Bvh, SeenPoint};

use crate::chain::follow;
use crate::drag::{CONVERGED_PX, DragStart, SAME_POINT_TOLERANCE, limit_unmoved, pick, seen_at};
use crate::dragged_feature::DraggedFeature;
use crate::goal::TakenFeature;
use crate::moves::Unknowns;
use crate::occlusion::Occlusion;
use crate::picture_metric::PictureMetric;
use crate::point_in_light::PointInLight;
use crate::problem::{Problem, Tracked};
use crate::request::{Drag, DragLimit, DragResult, DragStatus, Feature, NumberedPin, RadiusMode};
use crate::work::WorkBudget;

/// Number of parts of the way whose ends are tried, from the cursor backwards, before the last part is halved.
const PARTS: u32 = 8;

/// Least share of the way that a limited drag covers. A drag that covers less leaves the light as it is.
const LEAST_SHARE: f64 = 1.0 / 3.0;

/// Drags a feature of `light` from one point of a picture to another, and changes the rest of the picture as little as
/// it can. Counts the steps in `work`. Keeps `pins` if the drag has none of its own: the directions and shadows that
/// they name, but not yet that a point is lit or shadowed, nor that the source stays out of surfaces.
///
/// If the feature does not land under the cursor, the result is that of the same drag to the last pixel of the straight
/// way at which it lands. With less than a third of the way, the light stays as it is.
pub fn drag_by_picture(
    bvh: &Bvh,
    light: &CheckedLight,
    drag: &Drag,
    pins: &[NumberedPin],
    work: &WorkBudget,
) -> DragResult {
    let pins = drag.pins.as_deref().unwrap_or(pins);
    let (picked, mut result) = pick(bvh, light, drag, work);
    let occlusion = Occlusion::new(bvh, light, work);
    match DragStart::new(&occlusion, light, drag, pins, &picked) {
        Err(refusal) => result.outcome.status = DragStatus::Refused(refusal),
        Ok(start) => {
            let origin = bvh.posed.origin_in_world;
            result.outcome.pivot_world = start.caster.map(|caster| caster.position + origin);
            PictureDrag::new(&occlusion, light, drag, start).run(&mut result);
        }
    }
    if work.is_exhausted() {
        result.light = light.light().clone();
        limit_unmoved(&mut result, drag);
    }
    result
}

/// Drag that keeps the picture, to any end.
struct PictureDrag<'a> {
    occlusion: &'a Occlusion<'a>,
    light: &'a CheckedLight,
    drag: &'a Drag,
    start: DragStart<'a>,
    metric: PictureMetric,
    /// Unknowns, and those to try if the tube would fold with them.
    unknowns: Vec<Unknowns>,
}

/// Light with the feature at a pixel.
struct Landing {
    light: Light,
    residual_px: f64,
    shadowed_by: Option<usize>,
    iterations: usize,
}

impl<'a> PictureDrag<'a> {
    fn new(occlusion: &'a Occlusion<'a>, light: &'a CheckedLight, drag: &'a Drag, start: DragStart<'a>) -> Self {
        // The wish of a dragged hotspot is that the picture changes.
        let metric = if drag.feature == Feature::Hotspot {
            PictureMetric::default()
        } else {
            PictureMetric::new(occlusion, &drag.view, &start.placed, start.caster.map(|caster| caster.node))
        };
        let unknowns = match &start.unknowns {
            Unknowns::Points { points, radii: RadiusMode::Follow, unit } => [RadiusMode::Keep, RadiusMode::Follow]
                .map(|radii| Unknowns::Points { points: points.clone(), radii, unit: *unit })
                .to_vec(),
            unknowns => vec![unknowns.clone()],
        };
        Self { occlusion, light, drag, start, metric, unknowns }
    }

    /// Drags the feature to the cursor, or as far as it lands, and writes the result.
    fn run(&self, result: &mut DragResult) {
        let (from, to) = (self.drag.from, self.drag.to);
        let distance = from.distance(to);
        let land = |share: f64| self.land(from.lerp(to, share));
        let mut limit = match land(1.0) {
            Ok(landing) => return self.write(landing, DragStatus::Landed, result),
            Err(limit) => limit,
        };
        // The farthest of a few places at which the feature lands, then the last pixel before it no longer does.
        let share_of = |part: u32| f64::from(part) / f64::from(PARTS);
        let parts = (1..PARTS).rev().take_while(|part| share_of(part + 1) > LEAST_SHARE);
        let reached = parts.map(share_of).find_map(|share| Some((share, land(share).ok()?)));
        let (mut share, mut landing) = reached.map_or((0.0, None), |(share, landing)| (share, Some(landing)));
        let mut beyond = share + 1.0 / f64::from(PARTS);
        while landing.is_some() && (beyond - share) * distance > 1.0 {
            let middle = f64::midpoint(share, beyond);
            match land(middle) {
                Ok(found) => (share, landing) = (middle, Some(found)),
                Err(found) => (beyond, limit) = (middle, found),
            }
        }
        match landing {
            Some(landing) if share >= LEAST_SHARE => {
                let residual_px = distance * (1.0 - share);
                self.write(Landing { residual_px, ..landing }, DragStatus::Limited(limit), result);
            }
            _ => (result.outcome.status, result.outcome.residual_px) = (DragStatus::Limited(limit), distance),
        }
    }

    fn write(&self, landing: Landing, status: DragStatus, result: &mut DragResult) {
        let nodes = &self.occlusion.bvh.posed.scene.nodes;
        result.light = landing.light;
        result.outcome.status = status;
        result.outcome.residual_px = landing.residual_px;
        result.outcome.iterations = landing.iterations;
        result.outcome.shadowed_by = landing.shadowed_by.map(|node| nodes[node].name.clone());
    }

    /// Drags the feature to a pixel.
    fn land(&self, pixel: DVec2) -> Result<Landing, DragLimit> {
        let to = seen_at(self.occlusion.bvh, &self.drag.view, pixel, self.occlusion.work);
        let to = to.filter(|to| self.occlusion.is_node_lit(to.node)).ok_or(DragLimit::NoDescent)?;
        let mut limit = DragLimit::NoDescent;
        for unknowns in &self.unknowns {
            match self.land_with(unknowns, pixel, to) {
                Err(DragLimit::Fold) => limit = DragLimit::Fold,
                landed_or_limited => return landed_or_limited,
            }
        }
        Err(limit)
    }

    fn land_with(&self, unknowns: &Unknowns, pixel: DVec2, to: SeenPoint) -> Result<Landing, DragLimit> {
        let taken = self.start.taken(self.drag.feature, to);
        let problem = Problem {
            start: self.light,
            unknowns,
            scene_light: self.start.placed.clone(),
            taken: &taken,
            metric: &self.metric,
            pins: &self.start.pins,
            folds: self.light.tube().map_or_else(Vec::new, light::Tube::r_kappa_max),
        };
        let near = problem.tracked_at_start(self.start.feature_t());
        let end = follow(&problem, &near, self.drag.from.distance(pixel))?;
        let moved = CheckedLight::new(unknowns.light(self.light.light(), &end.x)).map_err(|_| DragLimit::Fold)?;
        let (residual_px, shadowed_by) = self.judge(&taken, &moved, &end.tracked, pixel)?;
        Ok(Landing { light: moved.light().clone(), residual_px, shadowed_by, iterations: end.iterations })
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
        let (bvh, view) = (self.occlusion.bvh, &self.drag.view);
        let residual_px = DraggedFeature { bvh, view, taken, placed: &placed }.distance_px(tracked.feature, pixel);
        let least_px = if taken.feature == Feature::Diffuse { 0.0 } else { CONVERGED_PX };
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
        let is_dark = self.occlusion.is_unlit(&placed, &counts, &taken.to);
        let Some(pivot) = taken.pivot else {
            // A feature that was lit stays lit.
            let was_dark = self.occlusion.is_unlit(&self.start.placed, &self.start.coords, &taken.from);
            return if is_dark && !was_dark { Err(DragLimit::NoDescent) } else { Ok((residual_px, None)) };
        };
        let first = self.occlusion.first_caster(&placed, &counts, &taken.to);
        let first = first.filter(|_| is_dark).ok_or(DragLimit::NoDescent)?;
        let is_the_pivot = pivot.distance(first.position) < SAME_POINT_TOLERANCE * pivot.distance(taken.to.position);
        Ok((residual_px, (!is_the_pivot).then_some(first.node)))
    }
}
