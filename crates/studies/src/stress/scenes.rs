//! Scenes with casters for a light, in the light's own space: the light's transform moves, rotates and scales them.

use std::f64::consts::TAU;

use glam::{DAffine3, DMat3, DQuat, DVec3, Vec3};
use light::{Light, LightInstance, Transform, Tube};
use proptest::prelude::*;
use render::View;
use scene::{Camera, Material, Mesh, Node, Primitive, Projection, Scene};
use serde::Serialize;

use super::light::{LightLimits, as_file, lights, placement, unit_cube};
use super::place::{PointSpec, in_tube, point_at};

/// Width of a picture in pixels.
pub const WIDTH: u32 = 96;
/// Height of a picture in pixels.
pub const HEIGHT: u32 = 64;
/// Vertical field of view of a picture, in radians.
pub const YFOV: f64 = 0.8;

/// A triangle in light-local space, in the scene's precision.
pub type Facet = [[f32; 3]; 3];

/// A light, its casters and receiver, and a camera. Everything except the light's transform is in light-local space.
#[derive(Clone, Debug, Serialize)]
pub struct Shot {
    #[serde(serialize_with = "as_file")]
    pub light: Light,
    pub facets: Vec<Facet>,
    pub eye: [f64; 3],
    pub target: [f64; 3],
}

impl Shot {
    /// Makes the scene of the given facets.
    pub fn scene(&self, facets: &[Facet], materials: Vec<Material>) -> Scene {
        let mut primitive = Primitive::default();
        for facet in facets {
            let [a, b, c] = facet.map(|p| Vec3::from(p).as_dvec3());
            let normal = (b - a).cross(c - a).normalize_or_zero().as_vec3();
            let first = primitive.positions.len() as u32;
            primitive.positions.extend(facet.map(Vec3::from));
            primitive.normals.extend([normal; 3]);
            primitive.indices.extend([first, first + 1, first + 2]);
        }
        let Transform { translation, rotation, scale } = self.light.transform();
        let parent_from_local =
            DAffine3::from_scale_rotation_translation(DVec3::splat(scale), rotation.normalize(), translation);
        Scene {
            nodes: vec![Node { name: String::new(), parent: None, parent_from_local, mesh: Some(0) }],
            meshes: vec![Mesh { name: String::new(), primitives: vec![primitive] }],
            materials,
            ..Scene::default()
        }
    }

    /// Returns the light, checked for a renderer.
    pub fn lights(&self) -> Vec<LightInstance> {
        LightInstance::numbered([self.light.clone()]).expect("cases are valid")
    }

    /// Returns the camera's view of [`Aov::Beauty`].
    pub fn view(&self) -> View {
        let (eye, target): (DVec3, DVec3) = (self.eye.into(), self.target.into());
        let back = (eye - target).try_normalize().unwrap_or(DVec3::Z);
        let right = back.any_orthonormal_vector();
        let axes = DMat3::from_cols(right, back.cross(right), back);
        let transform = self.light.transform();
        let near = transform.scale * eye.distance(target) * 1e-3;
        let camera = Camera {
            name: String::new(),
            translation: transform.world_from_local(eye),
            rotation: transform.rotation.normalize() * DQuat::from_mat3(&axes),
            projection: Projection::Perspective { yfov: YFOV, aspect_ratio: None, znear: near, zfar: None },
        };
        View::beauty(camera, [WIDTH, HEIGHT])
    }
}

/// Casters in a light.
#[derive(Clone, Debug)]
pub enum StressObstacle {
    /// A square across the light, this many radii to each side, tilted by up to `lean`.
    Square { share: f64, lean: DVec3, half: f64 },
    /// A square mesh across the light, with `cells` cells per side, whose vertices are displaced by up to half a cell.
    Wall { share: f64, lean: DVec3, half: f64, cells: usize, strays: Vec<DVec3> },
    /// A triangle between points of the tube.
    Triangle([PointSpec; 3]),
    /// A triangle whose height is this share of the length of its third side.
    Sliver([PointSpec; 2], f64),
    /// A triangle with one corner at the source.
    ThroughSource([PointSpec; 2]),
    /// Triangles of which two or three corners coincide.
    Degenerate(PointSpec, PointSpec),
}

impl StressObstacle {
    /// Returns the triangles in light-local space.
    fn facets(&self, tube: &Tube<f64>, unit: f64) -> Vec<[DVec3; 3]> {
        let at = |place: &PointSpec| place.in_tube_space(tube) * unit;
        match self {
            Self::Square { share, lean, half } => grid(tube, unit, *share, *lean, *half, 1, &[]),
            Self::Wall { share, lean, half, cells, strays } => grid(tube, unit, *share, *lean, *half, *cells, strays),
            Self::Triangle(corners) => vec![corners.each_ref().map(at)],
            Self::Sliver([a, b], height) => {
                let (a, b) = (at(a), at(b));
                vec![[a, b, (a + b) / 2.0 + (b - a).any_orthogonal_vector() * *height]]
            }
            Self::ThroughSource([a, b]) => vec![[DVec3::ZERO, at(a), at(b)]],
            Self::Degenerate(a, b) => vec![[at(a), at(a), at(b)], [at(a); 3]],
        }
    }
}

/// Returns a mesh of `cells` by `cells` squares across the light at a share of its length.
fn grid(
    tube: &Tube<f64>,
    unit: f64,
    share: f64,
    lean: DVec3,
    half: f64,
    cells: usize,
    strays: &[DVec3],
) -> Vec<[DVec3; 3]> {
    let t = share * tube.n as f64;
    let (middle, along) = (point_at(tube, t, 0.0, 0.0), point_at(tube, t, 0.5, 0.0));
    let (i, u) = super::place::split(tube, t);
    let normal = (tube.segments[i].curve.u_hat(u) + lean * 0.8).try_normalize().unwrap_or(DVec3::Z);
    let (x, y) = normal.any_orthonormal_pair();
    let size = half * 2.0 * (along - middle).length();
    let vertex = |column: usize, row: usize| {
        let inner = |k: usize| k > 0 && k < cells;
        let stray = match strays.get(row * (cells + 1) + column) {
            Some(stray) if inner(column) && inner(row) => *stray,
            _ => DVec3::ZERO,
        };
        let share = |k: usize, stray: f64| (2.0 * (k as f64 + 0.45 * stray) / cells as f64 - 1.0) * size;
        let bump = normal * (0.3 * stray.z * size / cells as f64);
        (middle + x * share(column, stray.x) + y * share(row, stray.y) + bump) * unit
    };
    (0..cells * cells)
        .flat_map(|cell| {
            let (column, row) = (cell % cells, cell / cells);
            let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(right, down)| vertex(column + right, row + down));
            [[a, b, c], [a, c, d]]
        })
        .collect()
}

/// Generates squares across a light, at shares of its length from 0.1 to 1.
pub fn square(half: impl Strategy<Value = f64>) -> impl Strategy<Value = StressObstacle> {
    (0.1..1.0, unit_cube(), half).prop_map(|(share, lean, half)| StressObstacle::Square { share, lean, half })
}

/// Generates walls that extend well past the tube's rim.
pub fn wall() -> impl Strategy<Value = StressObstacle> {
    let strays = prop::collection::vec(unit_cube(), 81);
    (0.1..0.8, unit_cube(), 3.0..8.0, 1..8_usize, strays).prop_map(|(share, lean, half, cells, strays)| {
        StressObstacle::Wall { share, lean: lean * 0.6, half, cells, strays }
    })
}

/// Generates triangles of every kind. `degenerate` adds some without area.
pub fn obstacle(degenerate: bool) -> impl Strategy<Value = StressObstacle> {
    let place = || in_tube(2.5).boxed();
    prop_oneof![
        3 => square(0.2..2.0).boxed(),
        3 => [place(), place(), place()].prop_map(StressObstacle::Triangle).boxed(),
        2 => ([place(), place()], 1e-4..0.1).prop_map(|(ends, height)| StressObstacle::Sliver(ends, height)).boxed(),
        1 => [place(), place()].prop_map(StressObstacle::ThroughSource).boxed(),
        1 => square(2.0..60.0).boxed(),
        u32::from(degenerate) => (place(), place()).prop_map(|(a, b)| StressObstacle::Degenerate(a, b)).boxed(),
    ]
}

/// Generates lights that shine on a square, with `others` as casters.
pub fn shots(
    wanted: LightLimits,
    receiver: impl Strategy<Value = StressObstacle>,
    others: impl Strategy<Value = Vec<StressObstacle>>,
) -> impl Strategy<Value = Shot> {
    let camera = (0.3..1.0, 0.0..TAU, 0.2..1.2, 2.0..5.0);
    (lights(wanted), placement(), receiver, others, camera).prop_map(
        |(light, transform, receiver, others, (share, around, lean, distance)): (_, _, _, _, (f64, f64, f64, f64))| {
            let tube = Tube::new(&light).expect("valid");
            let unit = tube.placement.world_per_tube;
            let facets = others.iter().chain([&receiver]).flat_map(|obstacle| obstacle.facets(&tube, unit));
            let facets = facets.map(|facet| facet.map(|p| p.as_vec3().to_array())).collect();
            // The camera looks at the receiver from the side of the light.
            let share = if let StressObstacle::Square { share, .. } = receiver { share } else { share };
            let t = share * tube.n as f64;
            let target = point_at(&tube, t, 0.0, 0.0);
            let rim = point_at(&tube, t, around.cos(), around.sin()) - target;
            let (i, u) = super::place::split(&tube, t);
            let back = -tube.segments[i].curve.u_hat(u) * rim.length().max(1e-3);
            let eye = target + (back * lean.cos() + rim * lean.sin()) * distance;
            Shot {
                light: light.with_transform(transform),
                facets,
                eye: (eye * unit).to_array(),
                target: (target * unit).to_array(),
            }
        },
    )
}
