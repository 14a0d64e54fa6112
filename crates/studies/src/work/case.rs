//! Drags of every size, as numbers that can be drawn at random and changed one at a time.

use bench::drag::{FEATURES, TrialScene};
use drag::{Drag, DragPin, Feature, NumberedPin, PinKind, PinTarget, RadiusMode};
use fastrand::Rng;
use glam::{DQuat, DVec2, DVec3};
use light::parameters::{CONE_ANGLE, END_MODE, ROTATION, TRANSLATION};
use light::{CheckedLight, EndMode, Light, MAX_SEGMENTS};
use reference::ReferenceLight;
use scene::{Material, Mesh, Node, Primitive, Scene};

/// Maximum number of pins of a drag.
pub const MOST_PINS: usize = 256;

/// Number of times that the bends of a light are halved until its tube does not fold.
const STRAIGHTENINGS: usize = 40;

/// A drag as numbers. Shares are in 0 to 1.
#[derive(Clone, Debug)]
pub struct WorkCase {
    /// Index of the scene.
    pub scene: usize,
    /// Seed of the light's position and bends.
    pub light_seed: u64,
    /// Segments of the light; 0 for a light that is not a BendyLight.
    pub segments: usize,
    /// Distance of the control points from the light's axis, as a share of its length.
    pub bend: f64,
    /// Radius at its end, as a share of its length.
    pub wide: f64,
    /// Number of chosen control points; 0 moves the light as a whole.
    pub chosen: usize,
    pub radii: RadiusMode,
    pub feature: Feature,
    /// Start of the drag, as shares of the picture.
    pub from: DVec2,
    /// End of the drag, as shares of the picture.
    pub to: DVec2,
    /// Number of pins requested; those on background or outside of the light are left out.
    pub pins: usize,
    /// Seed of the pins' positions.
    pub pin_seed: u64,
    /// Share of the pins that are hard.
    pub hard: f64,
    /// True if the source must pass through no surface.
    pub source_outside: bool,
}

/// Maximum sizes of random drags.
#[derive(Clone, Copy, Debug)]
pub struct CaseSizes {
    /// Maximum number of segments of a light.
    pub segments: usize,
    /// Maximum number of chosen control points.
    pub chosen: usize,
    /// Maximum number of pins.
    pub pins: usize,
}

impl CaseSizes {
    /// The largest drags that the product accepts.
    pub const ALL: Self = Self { segments: MAX_SEGMENTS, chosen: MAX_SEGMENTS + 1, pins: MOST_PINS };
    /// Lights of at most 8 control points, and 3 pins.
    pub const SMALL: Self = Self { segments: 6, chosen: 7, pins: 3 };
}

impl WorkCase {
    /// Makes a random case in one of `scenes` scenes. Each size is log-uniform.
    pub fn random(rng: &mut Rng, scenes: usize, sizes: CaseSizes) -> Self {
        let mut spread = |most: usize| {
            let share = rng.f64();
            ((most as f64 + 1.0).powf(share) - 1.0).round() as usize
        };
        let (segments, chosen, pins) = (spread(sizes.segments), spread(sizes.chosen), spread(sizes.pins));
        let pixel = |rng: &mut Rng| DVec2::new(rng.f64(), rng.f64());
        let from = pixel(rng);
        let to = if rng.bool() { pixel(rng) } else { from + (pixel(rng) - 0.5) * 0.1 };
        Self {
            scene: rng.usize(0..scenes),
            light_seed: rng.u64(..),
            segments,
            bend: 0.35 * rng.f64(),
            wide: 0.08 + 0.22 * rng.f64(),
            chosen,
            radii: [RadiusMode::Keep, RadiusMode::Solve, RadiusMode::Follow][rng.usize(0..3)],
            feature: FEATURES[rng.usize(0..4)],
            from,
            to: to.clamp(DVec2::ZERO, DVec2::ONE),
            pins,
            pin_seed: rng.u64(..),
            hard: if rng.bool() { 0.5 } else { 0.0 },
            source_outside: rng.bool(),
        }
    }

    /// Copies the case and draws one of its numbers again.
    #[must_use]
    pub fn with_one_change(&self, rng: &mut Rng, scenes: usize, sizes: CaseSizes) -> Self {
        let other = Self::random(rng, scenes, sizes);
        let mut next = self.clone();
        match rng.u8(0..13) {
            0 => next.scene = other.scene,
            1 => next.light_seed = other.light_seed,
            2 => next.segments = other.segments,
            3 => next.bend = other.bend,
            4 => next.wide = other.wide,
            5 => next.chosen = other.chosen,
            6 => next.radii = other.radii,
            7 => next.feature = other.feature,
            8 => next.from = other.from,
            9 => next.to = other.to,
            10 => next.pins = other.pins,
            11 => (next.pin_seed, next.hard) = (other.pin_seed, other.hard),
            _ => next.source_outside = other.source_outside,
        }
        next
    }

    /// Makes the light and the drag in a scene; `None` if no surface is at the start or the light is invalid.
    pub fn in_scene(&self, stage: &TrialScene) -> Option<(CheckedLight, Drag)> {
        let size = stage.size();
        let (from, to) = (self.from * size, self.to * size);
        let light = self.light(stage, stage.seen(from)?.position)?;
        let all = light.light().points().len();
        let count = self.chosen.min(all.saturating_sub(1));
        // The last control points, which have the most effect.
        let points = (count > 0).then(|| (all - count..all).collect());
        let pins = self.pins(stage, &light, size);
        let Self { feature, radii, source_outside, .. } = *self;
        let (view, pins) = (stage.view.clone(), Some(NumberedPin::by_index(pins)));
        Some((light, Drag { feature, points, radii, view, from, to, pins, source_outside, choice: None }))
    }

    /// Makes a light from above, aimed at `aim` in scene space.
    fn light(&self, stage: &TrialScene, aim: DVec3) -> Option<CheckedLight> {
        let mut rng = Rng::with_seed(self.light_seed);
        let side = DVec3::new(rng.f64() - 0.5, 0.3 + 0.7 * rng.f64(), rng.f64() - 0.5).normalize();
        let away = (0.4 + 0.6 * rng.f64()) * stage.reference.bvh.posed.half_extent.length();
        let (aim, length) = (aim + stage.origin(), 1.3 * away);
        let place = |light: Light| {
            let turn = DQuat::from_rotation_arc(DVec3::NEG_Z, -side);
            light.with(TRANSLATION, aim + side * away).with(ROTATION, turn)
        };
        if self.segments == 0 {
            return CheckedLight::new(place(match rng.u8(0..3) {
                0 => Light::spot().with(CONE_ANGLE, 35.0),
                1 => Light::omni(),
                _ => Light::directional(),
            }))
            .ok();
        }
        let end_mode = if rng.u8(0..4) == 0 { EndMode::Cut } else { EndMode::Extend };
        // Waves along the axis, so that a light of many control points bends as much as one of few.
        let waves: Vec<DVec3> = (0..4).map(|_| DVec3::new(rng.f64() - 0.5, rng.f64() - 0.5, 0.0)).collect();
        let along = light::greville_abscissae(self.segments);
        let mut bend = self.bend * length;
        (0..STRAIGHTENINGS).find_map(|_| {
            let (points, radii) = along
                .iter()
                .map(|g| g / self.segments as f64)
                .map(|g| {
                    let aside: DVec3 = (0..4).map(|k| waves[k] * (g * (1.0 + k as f64) * 1.5).sin()).sum();
                    (DVec3::new(0.0, 0.0, -g * length) + aside * bend, self.wide * length * (0.1 + 0.9 * g))
                })
                .unzip();
            bend *= 0.5;
            CheckedLight::new(place(Light::bendy(points, radii).with(END_MODE, end_mode))).ok()
        })
    }

    /// Makes pins of the light's present effect at random pixels.
    fn pins(&self, stage: &TrialScene, light: &CheckedLight, size: DVec2) -> Vec<DragPin> {
        let mut rng = Rng::with_seed(self.pin_seed);
        let source = ReferenceLight::new(light);
        let pins = (0..4 * self.pins).filter_map(|_| {
            let pixel = DVec2::new(rng.f64(), rng.f64()) * size;
            let (stays, is_hard) = (rng.bool(), rng.f64() < self.hard);
            let surface = stage.surface(pixel)?;
            let sample = stage.reference.sample(&source, &surface)?;
            let kind = pin_kind(sample.is_visible, stays);
            let at = PinTarget::Point(surface.position + stage.origin());
            Some(DragPin { kind, at, caster: None, is_hard })
        });
        pins.take(self.pins).collect()
    }
}

/// Returns a kind of pin that holds where the light arrives or does not. `stays` pins that alone, and not from where.
fn pin_kind(is_visible: bool, stays: bool) -> PinKind {
    match (is_visible, stays) {
        (true, true) => PinKind::Lit,
        (true, false) => PinKind::Direction,
        (false, true) => PinKind::Shadowed,
        (false, false) => PinKind::Shadow,
    }
}

/// Makes small and large scenes: demos, and `count` triangles at one position.
pub fn stages(count: usize, size: [u32; 2]) -> Vec<TrialScene> {
    let demo = |name: &str| {
        let demo = assets::demo(name)?;
        Some(TrialScene::new(&format!("demo:{name}"), demo.scene, &demo.contents.cameras, size))
    };
    let mut stages: Vec<TrialScene> = ["vases"].into_iter().filter_map(demo).collect();
    stages.push(TrialScene::new(&format!("{count} triangles in one place"), pile(count), &[], size));
    stages
}

/// Returns a floor, and intersecting triangles above it.
fn pile(count: usize) -> Scene {
    let mut rng = Rng::with_seed(1);
    let mut corner = |wide: f32| glam::Vec3::new(rng.f32() - 0.5, rng.f32() * 0.5 + 0.5, rng.f32() - 0.5) * wide;
    let floor = [(-2.0, -2.0), (-2.0, 2.0), (2.0, 2.0), (2.0, -2.0)].map(|(x, z)| glam::Vec3::new(x, 0.0, z));
    let mut positions = floor.to_vec();
    let mut indices = vec![0, 1, 2, 0, 2, 3];
    for _ in 0..count {
        indices.extend((0..3).map(|k| positions.len() as u32 + k));
        positions.extend((0..3).map(|_| corner(1.0)));
    }
    let normals = vec![glam::Vec3::Y; positions.len()];
    let material = Material { double_sided: true, ..Material::default() };
    Scene {
        nodes: vec![Node {
            name: "pile".into(),
            parent: None,
            parent_from_local: glam::DAffine3::IDENTITY,
            mesh: Some(0),
        }],
        meshes: vec![Mesh {
            name: String::new(),
            primitives: vec![Primitive { normals, indices, positions, ..Primitive::default() }],
        }],
        materials: vec![material],
        ..Scene::default()
    }
}
