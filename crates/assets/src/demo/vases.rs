//! Demo scene `vases`: two vases on a table, after the paper's "Tabletop Vases" (about 15,000 triangles).

use glam::{DAffine3, DVec3};
use light::Light;
use scene::{Fill, Scene};

use super::lathe::lathe;
use super::stage::{Cyclorama, add_node, camera, key_light, key_point, loaded, paint};
use crate::LoadedScene;

/// Version of the scene. Raise it whenever the scene changes, because logs refer to the scene by it.
pub const VERSION: u32 = 1;

/// Builds the scene `vases`.
pub fn vases() -> LoadedScene {
    // A cool sky over a warm table, weak enough that the shadow stays dark.
    let fill = Fill { sky: DVec3::new(0.10, 0.115, 0.145), ground: DVec3::new(0.070, 0.060, 0.050) };
    let mut scene = Scene { fill, ..Scene::default() };
    let table = Cyclorama { half_width: 7.0, front_z: 6.0, bend_z: -1.7, bend_radius: 1.6, height: 5.0, strips: 20 };
    add_node(&mut scene, "table", paint([0.58, 0.55, 0.51], 0.85), table.surface(), DAffine3::IDENTITY);
    let at = DAffine3::from_translation(DVec3::new(-0.62, 0.0, 0.25));
    add_node(&mut scene, "blue vase", paint([0.035, 0.13, 0.46], 0.28), lathe(&bottle()), at);
    let at = DAffine3::from_translation(DVec3::new(0.62, 0.0, -0.50));
    add_node(&mut scene, "orange vase", paint([0.80, 0.24, 0.035], 0.34), lathe(&jar()), at);
    // It frames both vases and their shadows at the paper's 686 x 382.
    loaded(scene, key(), camera(DVec3::new(0.30, 2.30, 4.5), DVec3::new(0.24, 0.37, 0.0), 24.0))
}

/// Returns the key light. It comes from the upper left front, down over the vases, and bends towards the
/// camera. The shadows curve, while those of a spotlight would be straight.
fn key() -> Light {
    let points = vec![
        key_point([-2.90, 3.50, 2.20], 0.40, 4.0),
        key_point([-1.90, 2.30, 0.30], 1.10, 4.0),
        key_point([-0.10, 0.85, -0.55], 1.75, 4.0),
        key_point([1.70, -0.45, -0.20], 1.85, 4.0),
        key_point([3.10, -1.50, 1.20], 1.90, 4.0),
    ];
    key_light(DVec3::new(1.0, 0.87, 0.70), points)
}

/// Returns the profile of a tall vase with a narrow neck, 1.1 high, as control points of radius and height; see
/// [`lathe`].
fn bottle() -> Vec<(f64, f64)> {
    let foot = [(0.0, 0.03), (0.12, 0.03), (0.175, 0.0), (0.205, 0.0), (0.205, 0.05)];
    let belly = [(0.29, 0.16), (0.40, 0.36), (0.36, 0.60), (0.17, 0.74)];
    let neck = [(0.095, 0.88), (0.125, 1.0), (0.205, 1.075)];
    let lip = [(0.215, 1.10), (0.19, 1.105), (0.105, 1.01)];
    let inside = [(0.07, 0.88), (0.14, 0.74), (0.32, 0.59), (0.36, 0.36), (0.25, 0.16), (0.10, 0.07), (0.0, 0.07)];
    [&foot[..], &belly, &neck, &lip, &inside].concat()
}

/// Returns the profile of a round, low vase, 0.8 high, as control points of radius and height; see [`lathe`].
fn jar() -> Vec<(f64, f64)> {
    let foot = [(0.0, 0.03), (0.10, 0.03), (0.155, 0.0), (0.185, 0.0), (0.19, 0.04)];
    let belly = [(0.33, 0.10), (0.47, 0.30), (0.45, 0.52), (0.27, 0.63)];
    let neck = [(0.165, 0.67), (0.17, 0.73), (0.235, 0.775)];
    let lip = [(0.245, 0.795), (0.22, 0.80), (0.14, 0.735)];
    let inside = [(0.125, 0.66), (0.24, 0.60), (0.41, 0.50), (0.43, 0.31), (0.30, 0.13), (0.10, 0.07), (0.0, 0.07)];
    [&foot[..], &belly, &neck, &lip, &inside].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn vases_have_the_papers_size() {
        let scene = vases().scene;
        let triangles = scene::pose(scene.clone(), 0.0).triangle_count();
        assert!((14_000..16_000).contains(&triangles), "{triangles}");
        for (mesh, height) in scene.meshes[1..].iter().zip([1.1, 0.8]) {
            let top = mesh.primitives[0].positions.iter().fold(0.0_f32, |most, p| most.max(p.y));
            assert!((top - height).abs() < 0.02, "{} is {top} high", mesh.name);
        }
    }
}
