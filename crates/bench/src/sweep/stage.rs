//! Scenes of a sweep: objects on floors of every size, between walls, in rooms and under roofs, and scenes from files.

use std::sync::Arc;

use fastrand::Rng;
use glam::{DAffine3, DQuat, DVec3};
use reference::Reference;
use scene::{Camera, Fill, Material, Primitive, Scene, framing_camera};

use crate::solids::{GREY, PlacedPrimitive, ball, block, camera, scene_of, square, vase};

const NO_FILL: Fill = Fill { sky: DVec3::ZERO, ground: DVec3::ZERO };

/// Floor under the objects, and their surroundings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Surroundings {
    /// Objects extend past the floor on all sides.
    SmallFloor,
    /// The floor ends where the objects do.
    EqualFloor,
    /// The floor is several times as wide as the objects.
    WideFloor,
    /// A wide floor with walls along two of its sides.
    Walls,
    /// A floor, a ceiling and three walls.
    Room,
    /// A roof on posts over a wide floor.
    Roof,
}

impl Surroundings {
    pub const ALL: [Self; 6] =
        [Self::SmallFloor, Self::EqualFloor, Self::WideFloor, Self::Walls, Self::Room, Self::Roof];

    pub fn name(self) -> &'static str {
        match self {
            Self::SmallFloor => "smallFloor",
            Self::EqualFloor => "equalFloor",
            Self::WideFloor => "wideFloor",
            Self::Walls => "walls",
            Self::Room => "room",
            Self::Roof => "roof",
        }
    }
}

/// A scene with a camera, and the region in which lights are placed. Lengths are in world units.
#[derive(Debug)]
pub(super) struct SweepStage {
    pub name: String,
    pub reference: Reference,
    pub camera: Camera,
    /// Center of the objects, on the floor; world position.
    pub ground_in_world: DVec3,
    /// Radius within which the objects lie.
    pub things_radius: f64,
    /// Half the width and the height of the box over `ground_in_world` in which lights are placed.
    pub lights_half: f64,
    pub lights_height: f64,
    /// Radius of a ball around all casters to which a shadow map must be fitted: without a floor that lies in a side of
    /// the scene's bounds.
    pub casters_radius: f64,
}

impl SweepStage {
    /// Makes random objects in the given surroundings, seen by a random camera.
    pub fn random(setting: Surroundings, rng: &mut Rng) -> Self {
        let things = things(rng);
        let (min, max) = bounds(&things);
        let is_thick = rng.u8(..3) == 0;
        let floor = |half_x: f64, half_z: f64, middle: DVec3| {
            if is_thick {
                placed(block(), [half_x, 0.05, half_z], middle - DVec3::Y * 0.05)
            } else {
                placed(square(), [half_x, 1.0, half_z], middle)
            }
        };
        let wide = 3.0 + 7.0 * rng.f64();
        let middle = (min + max) / 2.0 * DVec3::new(1.0, 0.0, 1.0);
        let size = (max - min) / 2.0;
        let wall = |[x, y, z]: [f64; 3], half: [f64; 3]| placed(block(), half, DVec3::new(x, y, z));
        let around: Vec<PlacedPrimitive> = match setting {
            Surroundings::SmallFloor => vec![floor(0.5 * size.x, 0.5 * size.z, middle)],
            Surroundings::EqualFloor => vec![floor(size.x, size.z, middle)],
            Surroundings::WideFloor => vec![floor(wide, wide, DVec3::ZERO)],
            Surroundings::Walls => vec![
                floor(2.5, 2.5, DVec3::ZERO),
                wall([-2.45, 1.0, 0.0], [0.05, 1.0, 2.5]),
                wall([0.0, 0.8, -2.45], [2.5, 0.8, 0.05]),
            ],
            Surroundings::Room => vec![
                floor(2.0, 2.0, DVec3::ZERO),
                wall([-2.05, 1.1, 0.0], [0.05, 1.1, 2.0]),
                wall([2.05, 1.1, 0.0], [0.05, 1.1, 2.0]),
                wall([0.0, 1.1, -2.05], [2.0, 1.1, 0.05]),
                wall([0.0, 2.25, 0.0], [2.0, 0.05, 2.0]),
            ],
            Surroundings::Roof => {
                let post = |x: f64, z: f64| wall([x, 0.9, z], [0.05, 0.9, 0.05]);
                vec![
                    floor(wide, wide, DVec3::ZERO),
                    post(-1.2, -1.2),
                    post(1.2, -1.2),
                    post(-1.2, 1.2),
                    post(1.2, 1.2),
                    wall([0.0, 1.85, 0.0], [1.4, 0.05, 1.4]),
                ]
            }
        };
        let is_side = matches!(setting, Surroundings::SmallFloor | Surroundings::EqualFloor | Surroundings::WideFloor)
            && !is_thick
            && min.y >= 0.0;
        // The size is 0.03 to 30 world units, and the distance from the world's origin up to a hundred times that.
        let things_radius = 10_f64.powf(rng.f64() * 3.0 - 1.5);
        let ground_in_world =
            if rng.bool() { direction(rng) * (100.0 * things_radius * rng.f64()) } else { DVec3::ZERO };
        let world =
            DAffine3::from_scale_rotation_translation(DVec3::splat(things_radius), DQuat::IDENTITY, ground_in_world);
        let parts = things.into_iter().chain(around);
        let parts = parts.map(|PlacedPrimitive(mesh, placement)| PlacedPrimitive(mesh, world * placement));
        let material = Material { base_color: GREY, metallic: 0.0, double_sided: true, ..Material::default() };
        let scene = Scene { fill: NO_FILL, ..scene_of(material, parts) };
        let eye = eye(setting, rng);
        let target = DVec3::new(0.4 * (rng.f64() - 0.5), 0.1 + 0.5 * rng.f64(), 0.4 * (rng.f64() - 0.5));
        let [eye, target] = [eye, target].map(|point| ground_in_world + point * things_radius);
        let camera = look(eye, target, 0.6 + 0.4 * rng.f64());
        let reference = Reference::new(scene::pose(scene, 0.0));
        let whole = reference.bvh.posed.half_extent.length();
        let is_room = setting == Surroundings::Room;
        Self {
            name: format!("{}{}", setting.name(), if is_thick { "Thick" } else { "" }),
            casters_radius: if is_side { whole.min(things_radius * (max - min).length() / 2.0) } else { whole },
            reference,
            camera,
            ground_in_world,
            things_radius,
            lights_half: things_radius * if is_room { 1.8 } else { 2.2 },
            lights_height: things_radius * if is_room { 2.0 } else { 4.0 },
        }
    }

    /// Makes a stage of a scene from a file, seen by its first camera or by one that frames it.
    pub fn of_file(name: &str, scene: Scene, cameras: &[Camera], aspect_ratio: f64) -> Self {
        let posed = scene::pose(Scene { fill: NO_FILL, ..scene }, 0.0);
        let first = cameras.first().cloned();
        let camera = first.unwrap_or_else(|| framing_camera(&posed.bounds(), aspect_ratio));
        let (half, middle) = (posed.half_extent, posed.origin_in_world);
        Self {
            name: name.into(),
            reference: Reference::new(Arc::clone(&posed)),
            camera,
            ground_in_world: middle - DVec3::Y * half.y,
            things_radius: 0.4 * half.length(),
            lights_half: 0.9 * half.x.min(half.z),
            lights_height: 1.9 * half.y,
            casters_radius: half.length(),
        }
    }
}

impl SweepStage {
    /// True if no surface is nearer to a world position than `share` of the scene's half diagonal, in any of 26
    /// directions.
    pub fn is_clear(&self, position: DVec3, share: f64) -> bool {
        let posed = &self.reference.bvh.posed;
        let reach = share * posed.half_extent.length();
        let from = position - posed.origin_in_world;
        let steps = (0..27).map(|k| DVec3::new(f64::from(k % 3), f64::from(k / 3 % 3), f64::from(k / 9)) - 1.0);
        steps.filter(|step| *step != DVec3::ZERO).all(|step| {
            let ray = step.normalize() * reach;
            self.reference.bvh.first_hit(from, ray, [0.0, 1.0], |_| true).is_none()
        })
    }
}

/// Makes three to seven objects on the floor or above it, within a unit of the origin.
fn things(rng: &mut Rng) -> Vec<PlacedPrimitive> {
    let count = rng.usize(3..=7);
    (0..count)
        .map(|_| {
            let size = 0.12 + 0.3 * rng.f64();
            let (sin, cos) = (rng.f64() * std::f64::consts::TAU).sin_cos();
            let out = 0.7 * rng.f64().sqrt();
            let over = if rng.bool() { 0.0 } else { 0.6 * rng.f64() };
            let position = DVec3::new(out * cos, over, out * sin);
            let turned = DQuat::from_rotation_y(rng.f64() * 6.0);
            let part = |mesh: Primitive, scale: DVec3, rotation: DQuat, middle: DVec3| {
                PlacedPrimitive(mesh, DAffine3::from_scale_rotation_translation(scale, rotation, middle))
            };
            match rng.u8(..6) {
                0 => part(ball(24), DVec3::splat(size), turned, position + DVec3::Y * size),
                1 => {
                    let half = size * DVec3::new(1.0, 0.3 + rng.f64(), 0.3 + rng.f64());
                    part(block(), half, turned, position + DVec3::Y * half.y)
                }
                2 => {
                    let half = DVec3::new(0.03, 0.2 + 0.4 * rng.f64(), 0.03);
                    part(block(), half, turned, position + DVec3::Y * half.y)
                }
                3 => {
                    let half = DVec3::new(0.35, 0.012, 0.25);
                    let leaning = DQuat::from_axis_angle(direction(rng), rng.f64() * 1.5);
                    // High enough to be clear of the floor at any angle.
                    part(block(), half, leaning, position + DVec3::Y * 0.45)
                }
                4 => part(vase(30), DVec3::splat(size), turned, position),
                _ => {
                    // A nearly upright sheet, through the floor or clear of it. Nothing hides light leaks at its foot.
                    let half = DVec3::new(0.4, 1.0, 0.1 + 0.3 * rng.f64());
                    let upright = DQuat::from_rotation_x(std::f64::consts::FRAC_PI_2 + 0.6 * (rng.f64() - 0.5));
                    let up = (turned * upright * DVec3::Z).y.abs() * half.z;
                    let over = if rng.bool() { 0.05 * rng.f64() + 0.02 } else { -0.05 * up };
                    let foot = DVec3::new(position.x, up + over, position.z);
                    part(square(), half, turned * upright, foot)
                }
            }
        })
        .collect()
}

/// Returns a random unit vector, uniform over all directions.
pub(super) fn direction(rng: &mut Rng) -> DVec3 {
    loop {
        let v = DVec3::new(rng.f64(), rng.f64(), rng.f64()) * 2.0 - 1.0;
        if (0.01..=1.0).contains(&v.length_squared()) {
            return v.normalize();
        }
    }
}

fn eye(setting: Surroundings, rng: &mut Rng) -> DVec3 {
    let (from, to) = match setting {
        Surroundings::Walls => (10.0, 80.0),
        Surroundings::Room => (65.0, 115.0),
        _ => (0.0, 360.0),
    };
    let around: f64 = (from + (to - from) * rng.f64()).to_radians();
    let low = if setting == Surroundings::Roof { 5.0 } else { 10.0 };
    let high = if matches!(setting, Surroundings::Room | Surroundings::Roof) { 25.0 } else { 60.0 };
    let up = (low + (high - low) * rng.f64()).to_radians();
    let distance = 2.4 + 1.4 * rng.f64();
    DVec3::new(around.cos() * up.cos(), up.sin(), around.sin() * up.cos()) * distance + DVec3::Y * 0.2
}

/// Returns the camera that looks from a world position to another, with a near plane at a fiftieth of the distance.
pub(super) fn look(eye: DVec3, target: DVec3, yfov: f64) -> Camera {
    camera(eye, target, yfov, 0.02 * eye.distance(target))
}

fn placed(mesh: Primitive, half: [f64; 3], middle: DVec3) -> PlacedPrimitive {
    let parent_from_local = DAffine3::from_scale_rotation_translation(DVec3::from_array(half), DQuat::IDENTITY, middle);
    PlacedPrimitive(mesh, parent_from_local)
}

fn bounds(parts: &[PlacedPrimitive]) -> (DVec3, DVec3) {
    let positions = parts.iter().flat_map(|PlacedPrimitive(mesh, placement)| {
        mesh.positions.iter().map(|position| placement.transform_point3(position.as_dvec3()))
    });
    positions.fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(min, max), p| (min.min(p), max.max(p)))
}
