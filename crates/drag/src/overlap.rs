//! Overlaps of distant parts of a tube, before which drags and slides stop.

use glam::DVec2;
use light::parameters::ALLOW_OVERLAP;
use light::{CheckedLight, LightRays, Tube, TubeOverlap};

use crate::bound::{Bound, hard_bound};
use crate::point_in_light::track_root;
use crate::request::DragLimit;
use crate::work::WorkBudget;

/// Distance that distant parts of a tube keep from each other, in radii. The points at which a tube is tested lie as near
/// to each other that less of a part fits between them.
const CLEARANCE: f64 = 0.05;

/// Room that the solver keeps to that distance, in radii.
const ROOM: f64 = 1e-3;

/// Number of times that an interval is halved to find where a light first overlaps on a way.
const HALVINGS: usize = 12;

/// Costs of a tested cross-section, in steps. This one is for its points, per segment. The next one is for each other
/// cross-section.
const STEPS_OF_POINTS: u64 = 200;
const STEPS_OF_PAIR: u64 = 3;

/// Rule that keeps a tube out of itself.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct OverlapRule {
    /// Distance that distant parts keep; `None` if they may overlap.
    clearance: Option<f64>,
}

impl OverlapRule {
    /// Makes the rule for edits of `light`. Parts of a light that overlap may go on to, and parts that are near each
    /// other may stay so near.
    pub fn new(light: &CheckedLight, work: &WorkBudget) -> Self {
        let tube = light.tube().filter(|_| !light.light().get(ALLOW_OVERLAP));
        let keeps = |clearance: &f64| tube.is_some_and(|tube| overlap(tube, *clearance, work).is_none());
        Self { clearance: [CLEARANCE, 0.0].into_iter().find(keeps) }
    }

    /// Returns a point in two parts of the light that have to keep apart. `None` if the budget is spent.
    pub fn overlap(&self, rays: &LightRays, work: &WorkBudget) -> Option<TubeOverlap> {
        let LightRays::Bent(tube) = rays else { return None };
        overlap(tube, self.clearance?, work)
    }

    /// Finds where the light first overlaps on a way, at whose shares its rays are `rays_at`. `None` if it does not at the
    /// end of the way.
    pub fn first_overlap(&self, rays_at: impl Fn(f64) -> Option<LightRays>, work: &WorkBudget) -> Option<TubeOverlap> {
        self.clearance?;
        let at = |share: f64| self.overlap(&rays_at(share)?, work);
        let mut first = at(1.0)?;
        let (mut apart, mut overlapping) = (0.0, 1.0);
        for _ in 0..HALVINGS {
            let middle = f64::midpoint(apart, overlapping);
            match at(middle) {
                Some(found) => (overlapping, first) = (middle, found),
                None => apart = middle,
            }
        }
        Some(first)
    }
}

/// Computes the distance between the two parts that first met at `met`, as a limit.
pub(crate) fn overlap_bound(met: &TubeOverlap, rays: &LightRays) -> Option<Bound> {
    let LightRays::Bent(tube) = rays else { return None };
    let (segment, u) = tube.segment_at(met.t.min(tube.n as f64));
    let curve = &tube.segments[segment].curve;
    let (v_hat, w_hat) = tube.cross_section(curve, curve.u_hat(u));
    let q = curve.position(u) + (v_hat * met.across.x + w_hat * met.across.y) * curve.radius(u);
    let root = track_root(tube, q, met.other_t);
    let across = DVec2::new(root.v_len, root.w_len) / root.radius.max(f64::MIN_POSITIVE);
    let outside = across.dot(met.other_across.normalize_or(DVec2::X)) - 1.0 - ROOM;
    Some(hard_bound(outside, DragLimit::Overlap))
}

fn overlap(tube: &Tube<f64>, clearance: f64, work: &WorkBudget) -> Option<TubeOverlap> {
    let (sections, segments) = (tube.overlap_section_count() as u64, tube.segments.len() as u64);
    work.spend(sections * (STEPS_OF_PAIR * sections + STEPS_OF_POINTS * segments)).then(|| tube.overlap(clearance))?
}
