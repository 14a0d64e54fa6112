//! Drags of every size, as numbers that can be drawn at random and changed one at a time.

use bench::drag::{FEATURES, TrialScene};
use drag::{Drag, DragPin, Feature, PinKind, RadiusMode};
use fastrand::Rng;
use glam::{DQuat, DVec2, DVec3};
use light::parameters::{CONE_ANGLE, END_MODE, ROTATION, TRANSLATION};
use light::{CheckedLight, EndMode, Light, MAX_SEGMENTS};
use reference::ReferenceLight;
use scene::{Material, Mesh, Node, Primitive, Scene};

/// Pins that a drag has at most.
pub const MOST_PINS: usize = 256;

/// Halvings of a light's bends until its tube does not fold.
const STRAIGHTENINGS: usize = 40;

/// A drag in numbers. Shares are of 0 to 1.
#[derive(Clone, Debug)]
pub struct WorkCase {
    /// Which of the scenes.
    pub scene: usize,
    /// Where the light is, and its bends.
    pub light_seed: u64,
    /// Segments of the light; 0 for one that cannot be bent.
    pub segments: usize,
    /// How far the light's control points are beside its axis, as a share of its length.
    pub bend: f64,
    /// How wide it is at its end, as a share of its length.
    pub wide: f64,
    /// How many control points are chosen; 0 moves the light as a whole.
    pub chosen: usize,
    /// What becomes of radii.
    pub radii: RadiusMode,
    /// What is dragged.
    pub feature: Feature,
    /// Where it is taken, as shares of the picture.
    pub from: DVec2,
    /// Where it goes.
    pub to: DVec2,
    /// How many pins are asked for; those that do not hold at once are left out.
    pub pins: usize,
    /// Where they are.
    pub pin_seed: u64,
    /// Which share of them is hard.
    pub hard: f64,
    /// Whether the source goes through no surface.
    pub source_outside: bool,
}

/// How large drags are that are drawn.
#[derive(Clone, Copy, Debug)]
pub struct CaseSizes {
    /// Segments of a light at most.
    pub segments: usize,
    /// Chosen control points at most.
    pub chosen: usize,
    /// Pins at most.
    pub pins: usize,
}

impl CaseSizes {
    /// All that can be asked for.
    pub const ALL: Self = Self { segments: MAX_SEGMENTS, chosen: MAX_SEGMENTS + 1, pins: MOST_PINS };
    /// Lights of at most 8 control points, and 3 pins.
    pub const SMALL: Self = Self { segments: 6, chosen: 7, pins: 3 };
}

impl WorkCase {
    /// A random one in one of so many scenes: each size is spread over its powers of two.
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

    /// The same with one of its numbers drawn anew.
    #[must_use]
    pub fn neighbour(&self, rng: &mut Rng, scenes: usize, sizes: CaseSizes) -> Self {
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

    /// The light and the drag in a scene; `None` where the light has none of the feature there.
    pub fn in_scene(&self, stage: &TrialScene) -> Option<(CheckedLight, Drag)> {
        let size = DVec2::from(stage.view.size.map(f64::from));
        let (from, to) = (self.from * size, self.to * size);
        let light = self.light(stage, stage.seen(from)?.position)?;
        let all = light.light().points().len();
        let count = self.chosen.min(all.saturating_sub(1));
        // The last ones: those do most.
        let points = (count > 0).then(|| (all - count..all).collect());
        let pins = self.pins(stage, &light, size);
        let Self { feature, radii, source_outside, .. } = *self;
        Some((light, Drag { feature, points, radii, from, to, pins, source_outside }))
    }

    /// A light from above on `aim`, in scene space.
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
        // Waves of the axis, so that a light of many control points bends as much as one of few.
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

    /// Pins of what the light does where they are.
    fn pins(&self, stage: &TrialScene, light: &CheckedLight, size: DVec2) -> Vec<DragPin> {
        let mut rng = Rng::with_seed(self.pin_seed);
        let source = ReferenceLight::new(light);
        let pins = (0..4 * self.pins).filter_map(|_| {
            let pixel = DVec2::new(rng.f64(), rng.f64()) * size;
            let (stays, is_hard) = (rng.bool(), rng.f64() < self.hard);
            let surface = stage.surface(pixel)?;
            let sample = stage.reference.sample(&source, &surface)?;
            let kind = match (sample.is_visible, stays) {
                (true, true) => PinKind::Lit,
                (true, false) => PinKind::Direction,
                (false, true) => PinKind::Shadowed,
                (false, false) => PinKind::Shadow,
            };
            Some(DragPin { kind, at: surface.position + stage.origin(), caster: None, is_hard })
        });
        pins.take(self.pins).collect()
    }
}

/// Small scenes and large ones: demos, and `count` triangles in one place.
pub fn stages(count: usize, size: [u32; 2]) -> Vec<TrialScene> {
    let demo = |name: &str| {
        let demo = assets::demo(name)?;
        Some(TrialScene::new(&format!("demo:{name}"), demo.scene, &demo.contents.cameras, size))
    };
    let mut stages: Vec<TrialScene> = ["vases"].into_iter().filter_map(demo).collect();
    stages.push(TrialScene::new(&format!("{count} triangles in one place"), pile(count), &[], size));
    stages
}

/// A floor, and triangles through one another above it.
fn pile(count: usize) -> Scene {
    let mut rng = Rng::with_seed(1);
    let mut corner =
        |wide: f32| glam::Vec3::new(rng.f32() - 0.5, rng.f32() * 0.5 + 0.5, rng.f32() - 0.5) * wide;
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
