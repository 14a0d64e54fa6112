//! Random pins, and a test that they hold, by the reference's visibility and the light's `locate`.

use bench::drag::{Trial, TrialScene};
use drag::{DragPin, PinKind};
use fastrand::Rng;
use glam::{DVec2, DVec3};
use light::{CheckedLight, TubePoint};
use reference::{ReferenceLight, ShadedPoint};

/// Number of pixels tried for all pins of a drag.
const PIXELS: usize = 400;

/// Minimum cosine between a pinned surface and the light there: a pin at grazing light cannot be kept.
const LEAST_COSINE: f64 = 0.1;

/// Minimum distance of a caster from the surface, as a share of the surface's distance from the camera.
const CONTACT: f64 = 1e-6;

/// Allowed error of a hard pin: degrees of a direction, pixels of a shadow.
const DEGREES: f64 = 0.1;
const PIXELS_OFF: f64 = 0.5;

/// A pin on a visible surface, with the state before the drag.
#[derive(Clone, Debug)]
pub struct StudyPin {
    /// The pin in the product's form.
    pub pin: DragPin,
    pub surface: ShadedPoint,
    /// Tube coordinates of the surface before the drag.
    pub place: TubePoint,
    /// Caster point of a pinned shadow, in scene space. `None` for other pins.
    pub pivot: Option<DVec3>,
    /// World units that a pixel covers at the pinned surface.
    pub per_pixel: f64,
}

/// Makes `count` pins of random kinds that hold before the drag, with a random choice of hard ones. `None` if not
/// enough were found.
pub fn random_pins(stage: &TrialScene, trial: &Trial, count: usize, seed: u64) -> Option<Vec<StudyPin>> {
    let mut rng = Rng::with_seed(seed);
    let size = DVec2::from(stage.view.size.map(f64::from));
    let pixels = (0..PIXELS).map(|_| (DVec2::new(rng.f64(), rng.f64()) * size, rng.bool(), rng.bool()));
    let pixels: Vec<_> = pixels.collect();
    let drawn = pixels.into_iter().filter_map(|(pixel, stays, is_hard)| {
        let surface = stage.surface(pixel)?;
        let sample = stage.reference.sample(&ReferenceLight::new(&trial.light), &surface)?;
        let seen = stage.seen(pixel)?;
        let direction = sample.coords.direction;
        if seen.normal.dot(direction).min(seen.geometric_normal.dot(direction)) < LEAST_COSINE {
            return None;
        }
        let kind = match (sample.is_visible, stays) {
            (true, true) => PinKind::Lit,
            (true, false) => PinKind::Direction,
            (false, true) => PinKind::Shadowed,
            (false, false) => PinKind::Shadow,
        };
        let place = stage.locate(&trial.light, surface.position)?;
        let pivot = if kind == PinKind::Shadow {
            let bvh = &stage.reference.bvh;
            let path = bvh.bent_path(trial.light.tube()?, place.v, place.w);
            let near = CONTACT * surface.depth;
            let hit = bvh.first_bent_hit(&path, place.t, |hit| {
                let is_solid = bvh.passes_alpha_test(&bvh.triangles[hit.triangle], hit.barycentrics);
                is_solid && hit.position.distance(surface.position) > near
            })?;
            Some(hit.position)
        } else {
            None
        };
        let beside = stage
            .seen(pixel + DVec2::X)
            .map_or(f64::INFINITY, |beside| beside.position.distance(surface.position));
        let per_pixel = beside.clamp(1e-4 * surface.depth, 0.01 * surface.depth);
        let pin = DragPin { kind, at: surface.position + stage.origin(), caster: None, is_hard };
        let pinned = StudyPin { pin, surface, place, pivot, per_pixel };
        pinned.holds(stage, &trial.light).then_some(pinned)
    });
    let pins: Vec<_> = drawn.take(count).collect();
    (pins.len() == count).then_some(pins)
}

impl StudyPin {
    /// True if the pin is preserved in a light, within half a pixel or a tenth of a degree.
    pub fn holds(&self, stage: &TrialScene, light: &CheckedLight) -> bool {
        let is_lit = || {
            stage
                .reference
                .sample(&ReferenceLight::new(light), &self.surface)
                .is_some_and(|sample| sample.is_visible)
        };
        let Some(place) = stage.locate(light, self.surface.position) else { return false };
        match (self.pin.kind, self.pivot) {
            (PinKind::Direction, _) => {
                let angle = place
                    .direction
                    .cross(self.place.direction)
                    .length()
                    .atan2(place.direction.dot(self.place.direction));
                angle.to_degrees() < DEGREES
            }
            (PinKind::Lit, _) => is_lit(),
            (PinKind::Shadow, Some(pivot)) => stage.locate(light, pivot).is_some_and(|pivot| {
                let off = (pivot.v - place.v).hypot(pivot.w - place.w) * place.radius / self.per_pixel;
                pivot.t < place.t && off < PIXELS_OFF
            }),
            (PinKind::Shadowed | PinKind::Shadow, _) => !is_lit(),
        }
    }
}
