//! How far a feature lies from where it should, by ways that share nothing with what moved it.

use std::cell::RefCell;

use drag::Feature;
use glam::{DMat2, DVec2, DVec3};
use light::CheckedLight;
use reference::{ReferenceLight, ShadedPoint};
use scene::pixel_of;

use super::stage::TrialScene;
use super::trial::Trial;

/// How far pixels are apart that tell how a direction changes over the picture.
const GRADIENT_STEP_PX: f64 = 0.25;

/// Degrees within which a surface is turned to the light.
const TURNED_DEGREES: f64 = 0.1;

/// Pixels between places from which a centre is looked for where none is found from the cursor.
const START_SPACING_PX: f64 = 24.0;

/// Where M' lies in a light, by the light's own `locate` and the reference's surface and shadow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EquationError {
    /// How far the equation of the drag is from holding at M': shadow and hotspot in radii, the others in radians.
    pub residual: f64,
    /// The same in pixels across the picture, of shadow and hotspot; degrees of the others.
    pub px_or_degrees: f64,
}

impl EquationError {
    /// Of M' under `light`; `None` where the light does not hold it, or where a shadow is none or would fall on what throws it.
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

    /// Whether that is within what landing means: half a pixel, or a tenth of a degree.
    pub fn is_landed(&self, feature: Feature) -> bool {
        self.px_or_degrees
            < if matches!(feature, Feature::Shadow | Feature::Hotspot) { 0.5 } else { TURNED_DEGREES }
    }
}

/// World units a pixel covers at a surface: of its neighbours the one that is nearest.
fn per_pixel(stage: &TrialScene, pixel: DVec2, surface: &ShadedPoint) -> f64 {
    let beside = [DVec2::X, DVec2::Y, DVec2::NEG_X, DVec2::NEG_Y]
        .into_iter()
        .filter_map(|step| Some(stage.seen(pixel + step)?.position.distance(surface.position)));
    beside.fold(f64::INFINITY, f64::min).clamp(1e-4 * surface.depth, 0.01 * surface.depth)
}

/// On the screen, from the cursor to where the feature lies under `light`, in pixels; `None` where it is not in the picture.
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

/// Of the surfaces that a way of the light meets past `to`, the one that is seen nearest to the cursor.
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
    // Past the end of a light that goes on, as far as the scene and the source are apart.
    let last = &tube.segments[tube.segments.len() - 1].curve;
    let speed = 2.0 * last.d1.length() * tube.placement.world_per_tube;
    let far = 4.0 * (size + (tube.placement.translation - stage.origin()).length());
    let t_end = tube.n as f64 + if tube.segments.len() > tube.n { far / speed } else { 0.0 };
    bvh.first_bent_hit(&path, t_end, |hit| {
        if hit.t > after && bvh.passes_alpha_test(&bvh.triangles[hit.triangle], hit.barycentrics) {
            met.borrow_mut().push(hit.position);
        }
        false
    });
    let distance = |position: &DVec3| {
        let pixel = pixel_of(&stage.view.camera, stage.view.size, *position, stage.origin())?;
        // What is hidden is not in the picture.
        let is_seen = stage.seen(pixel)?.position.distance(*position) < 1e-6 * size;
        is_seen.then(|| pixel.distance(trial.drag.to))
    };
    met.into_inner().iter().filter_map(distance).min_by(f64::total_cmp)
}

/// The nearest place at which light arrives along the mirror direction or the normal: by Newton's method over the picture,
/// from the cursor, and where that finds none, from all over it.
fn nearest_centre(stage: &TrialScene, trial: &Trial, light: &CheckedLight) -> Option<f64> {
    let cursor = trial.drag.to;
    let is_diffuse = trial.kind.feature == Feature::Diffuse;
    if is_diffuse
        && EquationError::at_target(stage, trial, light).is_some_and(|off| off.px_or_degrees < TURNED_DEGREES)
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

/// The centre that Newton's method finds from a pixel.
fn centre(stage: &TrialScene, trial: &Trial, light: &CheckedLight, start: DVec2) -> Option<DVec2> {
    let off = |pixel: DVec2| {
        let seen = stage.seen(pixel)?;
        let wanted =
            if trial.kind.feature == Feature::Diffuse { seen.normal } else { seen.mirror_direction() };
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
        let slope =
            DMat2::from_cols(beside(DVec2::X * GRADIENT_STEP_PX)?, beside(DVec2::Y * GRADIENT_STEP_PX)?);
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
