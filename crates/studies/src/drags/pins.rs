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
    pub coords: TubePoint,
    /// Caster point of a pinned shadow, in scene space. `None` for other pins.
    pub pivot: Option<DVec3>,
    /// World units that a pixel covers at the pinned surface.
    pub per_pixel: f64,
}

/// Makes `count` pins of random kinds that hold before the drag, with a random choice of hard ones. `None` if not
/// enough were found.
pub fn random_pins(stage: &TrialScene, trial: &Trial, count: usize, seed: u64) -> Option<Vec<StudyPin>> {
    let mut rng = Rng::with_seed(seed);
    let size = stage.size();
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
        let kind = pin_kind(sample.is_visible, stays);
        let coords = stage.locate(&trial.light, surface.position)?;
        let is_pivoted = kind == PinKind::Shadow;
        let pivot = if is_pivoted { Some(stage.first_caster(&trial.light, &coords, &surface)?) } else { None };
        let beside =
            stage.seen(pixel + DVec2::X).map_or(f64::INFINITY, |beside| beside.position.distance(surface.position));
        let per_pixel = beside.clamp(1e-4 * surface.depth, 0.01 * surface.depth);
        let pin = DragPin { kind, at: surface.position + stage.origin(), caster: None, is_hard };
        let pinned = StudyPin { pin, surface, coords, pivot, per_pixel };
        pinned.holds(stage, &trial.light).then_some(pinned)
    });
    let pins: Vec<_> = drawn.take(count).collect();
    (pins.len() == count).then_some(pins)
}

/// Returns a kind of pin that holds where the light arrives or does not. `stays` pins that alone, and not from where.
pub fn pin_kind(is_visible: bool, stays: bool) -> PinKind {
    match (is_visible, stays) {
        (true, true) => PinKind::Lit,
        (true, false) => PinKind::Direction,
        (false, true) => PinKind::Shadowed,
        (false, false) => PinKind::Shadow,
    }
}

impl StudyPin {
    /// True if the pin is preserved in a light, within half a pixel or a tenth of a degree.
    pub fn holds(&self, stage: &TrialScene, light: &CheckedLight) -> bool {
        let is_lit = || {
            stage.reference.sample(&ReferenceLight::new(light), &self.surface).is_some_and(|sample| sample.is_visible)
        };
        let Some(coords) = stage.locate(light, self.surface.position) else { return false };
        match (self.pin.kind, self.pivot) {
            (PinKind::Direction, _) => {
                let (here, before) = (coords.direction, self.coords.direction);
                here.cross(before).length().atan2(here.dot(before)).to_degrees() < DEGREES
            }
            (PinKind::Lit, _) => is_lit(),
            (PinKind::Shadow, Some(pivot)) => stage.locate(light, pivot).is_some_and(|pivot| {
                let off = (pivot.v - coords.v).hypot(pivot.w - coords.w) * coords.radius / self.per_pixel;
                pivot.t < coords.t && off < PIXELS_OFF
            }),
            (PinKind::Shadowed | PinKind::Shadow, _) => !is_lit(),
        }
    }
}
