//! Demo scene `arbor`: vine leaves on a lattice over a terrace, and a pierced lantern. It has all kinds of
//! alpha-tested geometry.

use std::f64::consts::TAU;

use glam::{DAffine3, DQuat, DVec2, DVec3, Vec2, Vec4};
use light::Light;
use scene::{Fill, Material, Primitive, Sampler, Scene, TextureRef, Wrap};

use super::cutouts::{lattice, leaf, pierced};
use super::lathe::lathe;
use super::stage::{Cyclorama, add_node, camera, key_light, key_point, loaded, paint};
use crate::LoadedScene;

/// Version of the scene. Raise it whenever the scene changes, because logs refer to the scene by it.
pub const VERSION: u32 = 1;

/// Number of leaves of both kinds.
const LEAVES: u32 = 76;

/// Builds the scene `arbor`.
pub fn arbor() -> LoadedScene {
    // A cool sky over a warm terrace, weak enough that shadows stay dark.
    let fill = Fill { sky: DVec3::new(0.12, 0.135, 0.17), ground: DVec3::new(0.08, 0.07, 0.06) };
    let mut scene = Scene { fill, ..Scene::default() };
    scene.images = vec![leaf(128), lattice(64), pierced(64)];
    let [leaf, lattice, pierced] = [0, 1, 2];

    let terrace = Cyclorama { half_width: 7.0, front_z: 6.0, bend_z: -2.2, bend_radius: 1.6, height: 5.0, strips: 20 };
    add_node(&mut scene, "terrace", paint([0.60, 0.56, 0.50], 0.85), terrace.surface(), DAffine3::IDENTITY);
    let clay = paint([0.55, 0.22, 0.11], 0.85);
    add_node(&mut scene, "pot", clay, lathe(&pot()), DAffine3::from_translation(DVec3::new(-1.05, 0.0, -0.10)));

    let slats = cut_out([0.50, 0.42, 0.31, 1.0], 0.5, lattice, [Wrap::Repeat; 2]);
    add_node(&mut scene, "lattice", slats, panel(), arbor_from_local());
    let clamped = [Wrap::ClampToEdge; 2];
    let vine = cut_out([1.0, 1.0, 0.9, 1.0], 0.5, leaf, clamped);
    add_node(&mut scene, "vine", vine, leaves(|k| k % 4 != 3), arbor_from_local());
    let autumn = cut_out([1.0, 0.40, 0.22, 0.8], 0.3, leaf, clamped);
    add_node(&mut scene, "autumn leaves", autumn, leaves(|k| k % 4 == 3), arbor_from_local());

    let brass = Material {
        metallic: 1.0,
        roughness: 0.45,
        ..cut_out([0.80, 0.60, 0.30, 1.0], 0.4, pierced, [Wrap::MirroredRepeat; 2])
    };
    let at = DAffine3::from_translation(DVec3::new(0.85, 0.0, -0.35));
    add_node(&mut scene, "lantern", brass, lantern(), at);
    // It frames the lattice, the lantern and their light patterns on the terrace.
    loaded(scene, key(), camera(DVec3::new(0.40, 1.95, 4.5), DVec3::new(0.06, 0.50, -0.1), 26.0))
}

/// Returns the key light. It comes from the upper left front through the lattice, then bends down onto the
/// terrace and towards the camera.
fn key() -> Light {
    let points = vec![
        key_point([-2.90, 2.60, 2.10], 0.40, 6.0),
        key_point([-1.95, 2.10, 0.80], 0.75, 6.0),
        key_point([-0.55, 1.40, -0.30], 0.92, 6.0),
        key_point([0.75, 0.45, -0.35], 1.00, 4.5),
        key_point([1.90, -1.10, 0.35], 1.20, 3.5),
    ];
    key_light(DVec3::new(1.0, 0.86, 0.66), points)
}

/// Returns the transform from the lattice's local space, in which it stands in the plane z = 0 with its foot
/// centred at the origin.
fn arbor_from_local() -> DAffine3 {
    DAffine3::from_rotation_translation(DQuat::from_rotation_y(-0.62), DVec3::new(-0.80, 0.0, -0.30))
}

/// Returns two triangles, 1.6 wide and 1.4 high, over which the lattice repeats.
fn panel() -> Primitive {
    let corners = [[-0.8, 0.0], [0.8, 0.0], [0.8, 1.4], [-0.8, 1.4]];
    Primitive {
        positions: corners.map(|[x, y]| DVec3::new(x, y, 0.0).as_vec3()).to_vec(),
        normals: vec![DVec3::Z.as_vec3(); 4],
        // Five and a third laths per metre.
        uvs: corners.map(|[x, y]| (DVec2::new(x, -y) / 0.1875).as_vec2()).to_vec(),
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    }
}

/// Returns the leaves whose index is `included`, in the lattice's local space. They are evenly spaced by the "R2"
/// low-discrepancy sequence, denser towards the top, and have different rotations.
fn leaves(included: impl Fn(u32) -> bool) -> Primitive {
    const PLASTIC: f64 = 1.324_717_957_244_746;
    const SQUARED: f64 = PLASTIC * PLASTIC;
    const FOURTH: f64 = SQUARED * SQUARED;
    const POWERS: [f64; 5] = [PLASTIC, SQUARED, PLASTIC * SQUARED, FOURTH, PLASTIC * FOURTH];
    let mut made = Primitive::default();
    for k in (0..LEAVES).filter(|k| included(*k)) {
        let [x, y, turn, lean, large] = POWERS.map(|power| (0.5 + f64::from(k) / power).fract());
        let at = DVec3::new(1.7 * x - 0.85, 0.2 + 1.3 * libm::sqrt(y), 0.03 + 0.12 * lean);
        let size = 0.09 + 0.07 * large;
        let rotation = DQuat::from_rotation_z(2.6 + 1.1 * (turn - 0.5))
            * DQuat::from_rotation_y(1.4 * (lean - 0.5))
            * DQuat::from_rotation_x(-0.7 * turn);
        add_leaf(&mut made, DAffine3::from_scale_rotation_translation(DVec3::splat(size), rotation, at));
    }
    made
}

/// Adds a leaf from -1 to 1, folded along its midrib. The lower alpha at its tip makes the leaf narrower there.
fn add_leaf(made: &mut Primitive, lattice_from_leaf: DAffine3) {
    const FOLD: f64 = 0.35;
    let first = made.positions.len() as u32;
    for (row, y) in [-1.0, 0.0, 1.0].into_iter().enumerate() {
        for (column, x) in [-1.0, 0.0, 1.0].into_iter().enumerate() {
            // The halves rise from the midrib, and the tip bends down.
            let point = DVec3::new(x, y, FOLD * x.abs() - 0.2 * y * y);
            let normal = DVec3::new(-FOLD * x, 0.4 * y, 1.0).normalize();
            made.positions.push(lattice_from_leaf.transform_point3(point).as_vec3());
            made.normals.push(lattice_from_leaf.transform_vector3(normal).normalize().as_vec3());
            made.uvs.push(Vec2::new(column as f32 / 2.0, 1.0 - row as f32 / 2.0));
            made.colors.push(Vec4::new(1.0, 1.0, 1.0, [1.0, 1.0, 0.75][row]));
        }
    }
    for corner in [0, 1, 3, 4] {
        let [a, b, c, d] = [corner, corner + 1, corner + 4, corner + 3].map(|k| first + k);
        made.indices.extend([a, b, c, a, c, d]);
    }
}

/// Returns an open cylinder, 0.46 high, with eight mirrored pictures around it and three along its height.
fn lantern() -> Primitive {
    const AROUND: u32 = 48;
    const RADIUS: f64 = 0.20;
    let mut made = Primitive::default();
    for k in 0..=AROUND {
        let share = f64::from(k) / f64::from(AROUND);
        let (sin, cos) = libm::sincos(TAU * share);
        for y in [0.0, 0.46] {
            made.positions.push(DVec3::new(RADIUS * sin, y, RADIUS * cos).as_vec3());
            made.normals.push(DVec3::new(sin, 0.0, cos).as_vec3());
            made.uvs.push(DVec2::new(8.0 * share, 3.0 * (1.0 - y / 0.46)).as_vec2());
        }
    }
    for k in (0..2 * AROUND).step_by(2) {
        made.indices.extend([k, k + 2, k + 3, k, k + 3, k + 1]);
    }
    made
}

/// Returns the profile of a low pot as control points of radius and height; see [`lathe`].
fn pot() -> Vec<(f64, f64)> {
    let outside = [(0.0, 0.02), (0.10, 0.02), (0.13, 0.0), (0.15, 0.01), (0.18, 0.12), (0.21, 0.24), (0.23, 0.27)];
    let inside = [(0.23, 0.29), (0.21, 0.29), (0.19, 0.24), (0.16, 0.12), (0.08, 0.08), (0.0, 0.08)];
    [&outside[..], &inside].concat()
}

/// Returns a double-sided, alpha-tested material.
fn cut_out(base_color: [f32; 4], alpha_cutoff: f32, image: usize, [wrap_u, wrap_v]: [Wrap; 2]) -> Material {
    let sampler = Sampler { wrap_u, wrap_v, nearest: false };
    Material {
        base_color: Vec4::from(base_color),
        roughness: 0.6,
        base_color_texture: Some(TextureRef { image, sampler }),
        alpha_cutoff: Some(alpha_cutoff),
        double_sided: true,
        ..Material::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The scene covers every wrap mode and alpha of vertices and materials. Every picture has both opaque and
    /// transparent parts.
    #[test]
    fn the_scene_covers_every_kind_of_alpha_test() {
        let scene = arbor().scene;
        let tested: Vec<_> = scene.materials.iter().filter(|m| m.alpha_cutoff.is_some()).collect();
        for wrap in [Wrap::Repeat, Wrap::MirroredRepeat, Wrap::ClampToEdge] {
            assert!(tested.iter().any(|m| m.base_color_texture.is_some_and(|t| t.sampler.wrap_u == wrap)));
        }
        assert!(tested.iter().any(|m| m.base_color.w < 1.0));
        let vertex_alpha = |p: &Primitive| p.colors.iter().any(|color| color.w < 1.0);
        assert!(scene.meshes.iter().flat_map(|mesh| &mesh.primitives).any(vertex_alpha));
        for image in &scene.images {
            let solid = image.rgba8.iter().skip(3).step_by(4).filter(|alpha| **alpha >= 128).count();
            let share = solid as f64 / f64::from(image.width * image.height);
            assert!((0.1..0.9).contains(&share), "{share}");
        }
    }
}
