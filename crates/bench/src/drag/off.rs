//! Measures the error of a drag, by methods that share nothing with the solvers.

use std::cell::RefCell;

use drag::Feature;
use glam::{DMat2, DVec2, DVec3};
use light::CheckedLight;
use reference::{ReferenceLight, ShadedPoint};
use scene::pixel_of;

use super::stage::TrialScene;
use super::trial::Trial;

/// Step in pixels of the finite differences from which Newton's method takes its slope.
const GRADIENT_STEP_PX: f64 = 0.25;

/// Angle in degrees within which a surface faces the light.
const TURNED_DEGREES: f64 = 0.1;

/// Distance in pixels between the points from which Newton's method starts, if it finds no center from the cursor.
const START_SPACING_PX: f64 = 24.0;

/// Error of a drag's equation at M', the surface at the end of the drag. It is computed by the light's own `locate`,
/// and by the surface and shadow of the reference.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquationError {
    /// Residual of the drag's equation at M': radii for shadow and hotspot, radians for the others.
    pub residual: f64,
    /// The residual in pixels of the picture for shadow and hotspot, in degrees for the others.
    pub px_or_degrees: f64,
}

impl EquationError {
    /// Computes the error at M' under `light`. `None` if M' is outside of the light, if M' is not in shadow, or if the
    /// caster is not between the source and M'.
    pub fn at_target(stage: &TrialScene, trial: &Trial, light: &CheckedLight) -> Option<Self> {
        let to = stage.surface(trial.drag.to)?;
        let there = stage.locate(light, to.position)?;
        let across = |v: f64, w: f64| {
            let residual = (there.v - v).hypot(there.w - w);
            Self { residual, px_or_degrees: residual * there.radius / per_pixel(stage, trial.drag.to, &to) }
        };
        let turned = |wanted: DVec3| {
            let residual = there.direction.cross(wanted).length().atan2(there.direction.dot(wanted));
            Self { residual, px_or_degrees: residual.to_degrees() }
        };
        match trial.kind.feature {
            Feature::Shadow => {
                let pivot = stage.locate(light, trial.pivot_in_scene?)?;
                let is_dark = !stage.reference.sample(&ReferenceLight::new(light), &to)?.is_visible;
                (is_dark && pivot.t < there.t).then(|| across(pivot.v, pivot.w))
            }
            Feature::Hotspot => Some(across(trial.from.v, trial.from.w)),
            Feature::Highlight => Some(turned(to.mirror_direction())),
            Feature::Diffuse => Some(turned(to.normal)),
        }
    }

    /// True if the error is less than half a pixel or a tenth of a degree, at which the drag counts as converged.
    pub fn is_landed(&self, feature: Feature) -> bool {
        self.px_or_degrees < if matches!(feature, Feature::Shadow | Feature::Hotspot) { 0.5 } else { TURNED_DEGREES }
    }
}

/// Returns the world units that a pixel covers at a surface, by the nearest of the four adjacent pixels.
fn per_pixel(stage: &TrialScene, pixel: DVec2, surface: &ShadedPoint) -> f64 {
    let beside = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y]
        .into_iter()
        .filter_map(|step| Some(stage.seen(pixel + step)?.position.distance(surface.position)));
    beside.fold(f64::INFINITY, f64::min).clamp(1e-4 * surface.depth, 0.01 * surface.depth)
}

/// Returns the distance in pixels from the cursor to the feature under `light`; `None` if the feature is not in the
/// picture.
pub fn distance_px(stage: &TrialScene, trial: &Trial, light: &CheckedLight) -> Option<f64> {
    match trial.kind.feature {
        Feature::Shadow => {
            let pivot = stage.locate(light, trial.pivot_in_scene?)?;
            nearest_on_light_path(stage, trial, light, (pivot.v, pivot.w), pivot.t)
        }
        Feature::Hotspot => nearest_on_light_path(stage, trial, light, (trial.from.v, trial.from.w), 0.0),
        Feature::Highlight | Feature::Diffuse => nearest_centre(stage, trial, light),
    }
}

/// Returns the distance in pixels from the cursor to the nearest visible surface that the light path (v, w) meets past
/// the parameter `after`.
fn nearest_on_light_path(
    stage: &TrialScene,
    trial: &Trial,
    light: &CheckedLight,
    (v, w): (f64, f64),
    after: f64,
) -> Option<f64> {
    let (bvh, tube) = (&stage.reference.bvh, light.tube()?);
    let size = bvh.posed.half_extent.length();
    let path = bvh.bent_path(tube, v, w);
    let met = RefCell::new(Vec::new());
    // Beyond the end of a light with an extended end, the path goes on for the distance between scene and source.
    let last = &tube.segments[tube.segments.len() - 1].curve;
    let speed = 2.0 * last.d1.length() * tube.placement.world_per_tube;
    let far = 4.0 * (size + (tube.placement.translation - stage.origin()).length());
    let t_end = tube.n as f64 + if tube.segments.len() > tube.n { far / speed } else { 0.0 };
    bvh.first_bent_hit(&path, t_end, |hit| {
        if hit.t > after && bvh.passes_alpha_test(&bvh.triangle(hit.triangle), hit.barycentrics) {
            met.borrow_mut().push(hit.position);
        }
        false
    });
    let distance = |position: &DVec3| {
        let pixel = pixel_of(&stage.view.camera, stage.view.size, *position, stage.origin())?;
        // Hidden surfaces are not in the picture.
        let is_seen = stage.seen(pixel)?.position.distance(*position) < 1e-6 * size;
        is_seen.then(|| pixel.distance(trial.drag.to))
    };
    met.into_inner().iter().filter_map(distance).min_by(f64::total_cmp)
}

/// Returns the distance in pixels to the nearest point at which light arrives along the mirror direction or the normal.
/// Newton's method over the picture starts from the cursor and, if that finds none, from points all over the picture.
fn nearest_centre(stage: &TrialScene, trial: &Trial, light: &CheckedLight) -> Option<f64> {
    let cursor = trial.drag.to;
    let is_diffuse = trial.kind.feature == Feature::Diffuse;
    if is_diffuse && EquationError::at_target(stage, trial, light).is_some_and(|off| off.px_or_degrees < TURNED_DEGREES)
    {
        return Some(0.0);
    }
    if let Some(centre) = centre(stage, trial, light, cursor) {
        return Some(centre.distance(cursor));
    }
    let size = stage.size();
    let (columns, rows) = ((size.x / START_SPACING_PX) as u32, (size.y / START_SPACING_PX) as u32);
    let starts = (0..columns * rows).map(|k| {
        let cell = DVec2::new(f64::from(k % columns) + 0.5, f64::from(k / columns) + 0.5);
        cell * START_SPACING_PX
    });
    let centres = starts.filter_map(|start| centre(stage, trial, light, start));
    centres.map(|centre| centre.distance(cursor)).min_by(f64::total_cmp)
}

/// Finds a pixel at which light arrives along the mirror direction or the normal, by Newton's method from the pixel
/// `start`.
fn centre(stage: &TrialScene, trial: &Trial, light: &CheckedLight, start: DVec2) -> Option<DVec2> {
    let off = |pixel: DVec2| {
        let seen = stage.seen(pixel)?;
        let wanted = if trial.kind.feature == Feature::Diffuse { seen.normal } else { seen.mirror_direction() };
        let direction = stage.locate(light, seen.position)?.direction;
        let (right, up) = wanted.any_orthonormal_pair();
        (direction.dot(wanted) > 0.0).then(|| DVec2::new(direction.dot(right), direction.dot(up)))
    };
    let mut pixel = start;
    for _ in 0..20 {
        let here = off(pixel)?;
        if here.length() < 1e-9 {
            return Some(pixel);
        }
        let beside = |step: DVec2| Some((off(pixel + step)? - here) / GRADIENT_STEP_PX);
        let slope = DMat2::from_cols(beside(DVec2::X * GRADIENT_STEP_PX)?, beside(DVec2::Y * GRADIENT_STEP_PX)?);
        if slope.determinant().abs() < 1e-300 {
            return None;
        }
        let step = slope.inverse() * here;
        pixel -= step.clamp_length_max(0.1 * stage.size().x);
        if step.length() < 1e-6 {
            return Some(pixel);
        }
    }
    None
}
