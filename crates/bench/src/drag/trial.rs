//! Random lights over a scene, and random drags of their features.

use drag::{Drag, Feature, RadiusMode};
use fastrand::Rng;
use glam::{DQuat, DVec2, DVec3};
use light::parameters::{END_MODE, ROTATION, TRANSLATION};
use light::{CheckedLight, EndMode, Light, TubePoint};
use reference::ReferenceLight;

use super::stage::TrialScene;

/// Every feature that can be dragged.
pub const FEATURES: [Feature; 4] = [Feature::Shadow, Feature::Hotspot, Feature::Highlight, Feature::Diffuse];

/// Length of the longest small drag, as a share of the picture's width.
const SMALL: f64 = 0.1;

/// Maximum number of lights tried until one has the feature in the picture.
const LIGHTS: usize = 4_000;

/// Maximum number of ends tried for a light.
const ENDS: usize = 30;

/// Kind of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TrialKind {
    pub feature: Feature,
    /// True if control points are dragged, false if the light moves as a whole.
    pub deforms: bool,
    /// True if the drag is at least a tenth of the picture's width long.
    pub is_large: bool,
}

impl TrialKind {
    /// Returns all sixteen kinds.
    pub fn all() -> impl Iterator<Item = Self> {
        let motions = [(false, false), (false, true), (true, false), (true, true)];
        let of = move |feature| motions.map(|(deforms, is_large)| Self { feature, deforms, is_large });
        FEATURES.into_iter().flat_map(of)
    }

    /// Returns the name of the feature in drag files.
    pub fn feature_name(self) -> &'static str {
        match self.feature {
            Feature::Shadow => "shadow",
            Feature::Hotspot => "hotspot",
            Feature::Highlight => "highlight",
            Feature::Diffuse => "diffuse",
        }
    }

    /// Returns the name of the kind of motion: `deforming` if control points move, `rigid` if the light moves as a
    /// whole.
    pub fn points_name(self) -> &'static str {
        if self.deforms { "deforming" } else { "rigid" }
    }

    /// Returns the name of the drag's length: `small` or `large`.
    pub fn distance_name(self) -> &'static str {
        if self.is_large { "large" } else { "small" }
    }
}

/// A light, and a drag of its feature.
#[derive(Clone, Debug)]
pub struct Trial {
    pub kind: TrialKind,
    /// Light before the drag.
    pub light: CheckedLight,
    pub drag: Drag,
    /// Tube coordinates of the start of the drag.
    pub from: TubePoint,
    /// First point at which the light path meets a caster, in scene space, for the drag of a shadow. `None` for other
    /// features.
    pub pivot_in_scene: Option<DVec3>,
}

impl Trial {
    /// Returns the seed of the drag with this number, independent of other drags (FNV-1a).
    pub fn seed(seed: u64, scene: &str, kind: TrialKind, number: usize) -> u64 {
        let text = format!("{seed} {scene} {kind:?} {number}");
        text.bytes().fold(0xcbf2_9ce4_8422_2325, |hash, byte| (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3))
    }

    /// Makes a random drag of the given kind, the same for the same seed. It starts where the feature is visible and
    /// ends on a visible surface inside of the initial light. `None` if no such drag was found.
    pub fn random(stage: &TrialScene, kind: TrialKind, seed: u64) -> Option<Self> {
        let mut rng = Rng::with_seed(seed);
        (0..LIGHTS).find_map(|_| trial(stage, kind, &mut rng))
    }
}

fn trial(stage: &TrialScene, kind: TrialKind, rng: &mut Rng) -> Option<Trial> {
    let aim = stage.seen(pixel(rng, stage))?;
    let extent = stage.reference.bvh.posed.half_extent.length().min(1.5 * aim.depth);
    let light = light(rng, aim.position + stage.origin(), extent)?;
    let begin = start_on_feature(stage, kind.feature, rng, light)?;
    let width = stage.size().x;
    let to = (0..ENDS).find_map(|_| {
        let to = if kind.is_large { pixel(rng, stage) } else { begin.pixel + in_ball(rng).truncate() * SMALL * width };
        let is_in_picture = to.cmpge(DVec2::ZERO).all() && to.cmplt(stage.size()).all();
        let is_large = to.distance(begin.pixel) >= SMALL * width;
        let fits = is_in_picture && is_large == kind.is_large;
        let seen = stage.seen(to).filter(|_| fits)?;
        stage.locate(&begin.light, seen.position).map(|_| to)
    })?;
    let points = kind.deforms.then(|| points(rng, begin.light.light().points().len()));
    let drag = Drag {
        feature: kind.feature,
        points,
        radii: RadiusMode::Keep,
        view: stage.view.clone(),
        from: begin.pixel,
        to,
        pins: None,
        source_outside: false,
        choice: None,
    };
    Some(Trial { kind, light: begin.light, drag, from: begin.coords, pivot_in_scene: begin.pivot })
}

/// Light, and a pixel at which it has the feature to drag.
struct TrialStart {
    light: CheckedLight,
    pixel: DVec2,
    coords: TubePoint,
    pivot: Option<DVec3>,
}

fn start_on_feature(stage: &TrialScene, feature: Feature, rng: &mut Rng, light: CheckedLight) -> Option<TrialStart> {
    let pixel = pixel(rng, stage);
    let surface = stage.surface(pixel)?;
    let mut light = light;
    if let Some(wanted) = match feature {
        Feature::Shadow | Feature::Hotspot => None,
        Feature::Highlight => Some(surface.mirror_direction()),
        Feature::Diffuse => Some(surface.normal),
    } {
        // Rotated about the surface until the feature has its center there.
        let has = stage.locate(&light, surface.position)?.direction;
        light = turned(&light, surface.position + stage.origin(), DQuat::from_rotation_arc(has, wanted))?;
    }
    let coords = stage.locate(&light, surface.position)?;
    let is_lit = stage.reference.sample(&ReferenceLight::new(&light), &surface)?.is_visible;
    if is_lit == (feature == Feature::Shadow) {
        return None;
    }
    let pivot = if is_lit { None } else { Some(stage.first_caster(&light, &coords, &surface)?) };
    Some(TrialStart { light, pixel, coords, pivot })
}

/// Chooses the last two control points, all but the source, or any.
fn points(rng: &mut Rng, count: usize) -> Vec<usize> {
    match rng.u8(0..3) {
        0 => vec![count - 2, count - 1],
        1 => (1..count).collect(),
        _ => {
            let any: Vec<usize> = (1..count).filter(|_| rng.bool()).collect();
            if any.is_empty() { vec![rng.usize(1..count)] } else { any }
        }
    }
}

/// Rotates `light` as a whole about a point in the world.
fn turned(light: &CheckedLight, about: DVec3, turn: DQuat) -> Option<CheckedLight> {
    let light = light.light().clone();
    let (translation, rotation) = (light.get(TRANSLATION), light.get(ROTATION));
    let light =
        light.with(TRANSLATION, about + turn * (translation - about)).with(ROTATION, (turn * rotation).normalize());
    CheckedLight::new(light).ok()
}

fn uniform(rng: &mut Rng, a: f64, b: f64) -> f64 {
    a + (b - a) * rng.f64()
}

fn pixel(rng: &mut Rng, stage: &TrialScene) -> DVec2 {
    DVec2::new(rng.f64(), rng.f64()) * stage.size()
}

fn in_ball(rng: &mut Rng) -> DVec3 {
    loop {
        let vector = DVec3::from_array(std::array::from_fn(|_| uniform(rng, -1.0, 1.0)));
        if vector.length_squared() <= 1.0 {
            return vector;
        }
    }
}

/// Makes a light from above, aimed at `aim`, about `size` away, with one to four segments and a random bend. One in
/// four ends a little past `aim`, the others continue.
fn light(rng: &mut Rng, aim: DVec3, size: f64) -> Option<CheckedLight> {
    let vector = in_ball(rng);
    let back = DVec3::new(vector.x, vector.y.abs().max(0.3), vector.z).normalize();
    let source = aim + back * size * uniform(rng, 0.6, 1.2);
    let length = 1.3 * source.distance(aim);
    let segments = rng.usize(1..5);
    let bend = uniform(rng, 0.0, 0.35) * length;
    let wide = uniform(rng, 0.08, 0.3) * length;
    let along = light::greville_abscissae(segments).into_iter().map(|g| g / segments as f64);
    let (points, radii) = along
        .map(|g| {
            let aside = if g > 0.0 { in_ball(rng) * (bend * g) } else { DVec3::ZERO };
            (DVec3::new(0.0, 0.0, -g * length) + aside, wide * (0.1 + 0.9 * g))
        })
        .unzip();
    let end_mode = if rng.u8(0..4) == 0 { EndMode::Cut } else { EndMode::Extend };
    let light = Light::bendy(points, radii).with(TRANSLATION, source).with(END_MODE, end_mode);
    CheckedLight::new(light.with(ROTATION, DQuat::from_rotation_arc(DVec3::NEG_Z, -back))).ok()
}
