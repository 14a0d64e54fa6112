//! Demo scene `vases`: two vases on a table, after the paper's "Tabletop Vases" (about 15,000 triangles).

use glam::{DAffine3, DVec2, DVec3, Vec4};
use light::Light;
use light::parameters::{CONE_SOFTNESS, NAME, TRANSLATION};
use scene::{Camera, Fill, Material, Mesh, Node, Primitive, Projection, Scene};

use super::lathe::lathe;
use super::stage::{Cyclorama, contents, look_at};
use crate::LoadedScene;

/// Version of the scene. Raise it whenever the scene changes, because logs refer to the scene by it.
pub const VERSION: u32 = 1;

/// Builds the scene `vases`.
pub fn vases() -> LoadedScene {
    let mut scene = Scene { fill: fill(), ..Scene::default() };
    let table =
        Cyclorama { half_width: 7.0, front_z: 6.0, bend_z: -1.7, bend_radius: 1.6, height: 5.0, strips: 20 };
    add_node(&mut scene, matte("table", [0.58, 0.55, 0.51]), table.surface(), DVec3::ZERO);
    add_node(
        &mut scene,
        glaze("blue vase", [0.035, 0.13, 0.46], 0.28),
        lathe(&bottle()),
        DVec3::new(-0.62, 0.0, 0.25),
    );
    add_node(
        &mut scene,
        glaze("orange vase", [0.80, 0.24, 0.035], 0.34),
        lathe(&jar()),
        DVec3::new(0.62, 0.0, -0.50),
    );
    LoadedScene { scene, contents: contents(key(), camera()), name: None, notes: Vec::new() }
}

/// Returns the key light. It comes from the upper left front, down over the vases, and bends towards the
/// camera. The shadows curve, while those of a spotlight would be straight.
///
/// The table has one row per control point. Positions are in world space; the light's local space starts at the
/// first.
fn key() -> Light {
    #[rustfmt::skip]
    let rows = [
        //     position                 radius
        ([-2.90,  3.50,  2.20],          0.40),
        ([-1.90,  2.30,  0.30],          1.10),
        ([-0.10,  0.85, -0.55],          1.75),
        ([ 1.70, -0.45, -0.20],          1.85),
        ([ 3.10, -1.50,  1.20],          1.90),
    ];
    let color = DVec3::new(1.0, 0.87, 0.70);
    let intensity = 4.0;

    let source = DVec3::from_array(rows[0].0);
    let points = rows.iter().map(|(position, _)| DVec3::from_array(*position) - source).collect();
    let light = Light::bendy(points, rows.iter().map(|(_, radius)| *radius).collect());
    light
        .with(NAME, "key".into())
        .with(TRANSLATION, source)
        .with(CONE_SOFTNESS, 0.3)
        .map_points(|_, point| (point.color, point.intensity) = (color, intensity))
}

/// Returns a cool sky over a warm table, weak enough that the shadow stays dark.
fn fill() -> Fill {
    Fill { sky: DVec3::new(0.10, 0.115, 0.145), ground: DVec3::new(0.070, 0.060, 0.050) }
}

/// Returns a camera that frames both vases and their shadows at the paper's 686 x 382.
fn camera() -> Camera {
    let translation = DVec3::new(0.30, 2.30, 4.5);
    Camera {
        name: "camera".into(),
        translation,
        rotation: look_at(translation, DVec3::new(0.24, 0.37, 0.0)),
        projection: Projection::Perspective {
            yfov: 24.0_f64.to_radians(),
            aspect_ratio: None,
            znear: 0.1,
            zfar: None,
        },
    }
}

/// Returns the profile of a tall vase with a narrow neck, 1.1 high, as control points of radius and height; see
/// [`lathe`].
fn bottle() -> Vec<DVec2> {
    let outside = [
        (0.0, 0.03),
        (0.12, 0.03),
        (0.175, 0.0),
        (0.205, 0.0),
        (0.205, 0.05),
        (0.29, 0.16),
        (0.40, 0.36),
        (0.36, 0.60),
        (0.17, 0.74),
        (0.095, 0.88),
        (0.125, 1.0),
        (0.205, 1.075),
    ];
    let lip_and_inside = [
        (0.215, 1.10),
        (0.19, 1.105),
        (0.105, 1.01),
        (0.07, 0.88),
        (0.14, 0.74),
        (0.32, 0.59),
        (0.36, 0.36),
        (0.25, 0.16),
        (0.10, 0.07),
        (0.0, 0.07),
    ];
    outside.into_iter().chain(lip_and_inside).map(DVec2::from).collect()
}

/// Returns the profile of a round, low vase, 0.8 high, as control points of radius and height; see [`lathe`].
fn jar() -> Vec<DVec2> {
    let outside = [
        (0.0, 0.03),
        (0.10, 0.03),
        (0.155, 0.0),
        (0.185, 0.0),
        (0.19, 0.04),
        (0.33, 0.10),
        (0.47, 0.30),
        (0.45, 0.52),
        (0.27, 0.63),
        (0.165, 0.67),
        (0.17, 0.73),
        (0.235, 0.775),
    ];
    let lip_and_inside = [
        (0.245, 0.795),
        (0.22, 0.80),
        (0.14, 0.735),
        (0.125, 0.66),
        (0.24, 0.60),
        (0.41, 0.50),
        (0.43, 0.31),
        (0.30, 0.13),
        (0.10, 0.07),
        (0.0, 0.07),
    ];
    outside.into_iter().chain(lip_and_inside).map(DVec2::from).collect()
}

fn glaze(name: &str, rgb: [f32; 3], roughness: f32) -> Material {
    let [r, g, b] = rgb;
    Material { name: name.into(), base_color: Vec4::new(r, g, b, 1.0), roughness, ..Material::default() }
}

fn matte(name: &str, rgb: [f32; 3]) -> Material {
    glaze(name, rgb, 0.85)
}

/// Adds a node named after its material, with `surface` as its only primitive.
fn add_node(scene: &mut Scene, material: Material, surface: Primitive, at: DVec3) {
    let (name, primitive) = (material.name.clone(), Primitive { material: scene.materials.len(), ..surface });
    scene.materials.push(material);
    scene.nodes.push(Node {
        name: name.clone(),
        parent: None,
        parent_from_local: DAffine3::from_translation(at),
        mesh: Some(scene.meshes.len()),
    });
    scene.meshes.push(Mesh { name, primitives: vec![primitive] });
}

#[cfg(test)]
mod tests {
    use light::Tube;

    use super::*;

    #[test]
    fn vases_have_the_papers_size() {
        let scene = vases().scene;
        let triangles = scene::pose(scene.clone()).triangle_count();
        assert!((14_000..16_000).contains(&triangles), "{triangles}");
        for (mesh, height) in scene.meshes[1..].iter().zip([1.1, 0.8]) {
            let top = mesh.primitives[0].positions.iter().fold(0.0_f32, |most, p| most.max(p.y));
            assert!((top - height).abs() < 0.02, "{} is {top} high", mesh.name);
        }
    }

    /// The tube fulfils `R kappa < 1` everywhere (light model, section 3), with a margin for edits.
    #[test]
    fn key_light_does_not_fold() {
        let light = key();
        let most = |tube: &Tube<f64>| tube.r_kappa_max().into_iter().fold(0.0, f64::max);
        assert_eq!(light.points().len(), 5, "three segments");
        assert!(most(&Tube::new(&light).unwrap()) < 0.9);
        let light = light.map_points(|_, point| point.radius *= 2.0);
        assert!(Tube::new(&light).is_err(), "a tube twice as wide folds");
    }
}
