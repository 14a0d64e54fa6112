//! Tests of grazing light on smooth meshes with few facets.

use glam::{DAffine3, DQuat, DVec3, Vec3};
use light::parameters::DIRECTION;
use light::{CheckedLight, Light};
use reference::{LightSample, Reference, ReferenceLight, ShadedPoint};
use scene::{Aov, Primitive, Scene, View};

use crate::support::{centres, scene_of, sphere, spot, square, view};

/// Returns a light from the side. Seen from the front, half of a ball is lit.
fn key() -> Light {
    spot(DVec3::new(5.0, 2.0, 0.5), DVec3::ZERO)
}

fn front(target: DVec3) -> View {
    let view = view(target + DVec3::new(0.5, 1.0, 4.0), target, Aov::Visibility);
    View { width: 144, height: 96, ..view }
}

/// Returns the same light as a spotlight and as a BendyLight.
fn kinds() -> [CheckedLight; 2] {
    let bent = light::bend(&key(), 3).unwrap().with(DIRECTION, light::DirectionMode::Path);
    [key(), bent].map(|light| CheckedLight::new(light).expect("a light"))
}

/// Returns every point inside the light that the view sees.
fn samples_in_view(scene: &Scene, view: &View, kind: &CheckedLight) -> Vec<(ShadedPoint, LightSample)> {
    let (reference, source) = (Reference::new(scene::pose(scene.clone(), 0.0)), ReferenceLight::new(kind));
    let sample = |surface: ShadedPoint| Some((surface, reference.sample(&source, &surface)?));
    centres(view).filter_map(|pixel| reference.surface(view, pixel)).filter_map(sample).collect()
}

/// A ball is lit where its normal faces the light, however few facets it has.
#[test]
fn the_terminator_of_a_coarse_ball_is_smooth() {
    for facets in [6, 12, 24] {
        let scene = scene_of([(sphere(facets), DAffine3::IDENTITY)]);
        for kind in kinds() {
            let seen = samples_in_view(&scene, &front(DVec3::ZERO), &kind);
            let facing = |surface: &ShadedPoint, light: &LightSample| surface.normal.dot(light.along_path);
            let wrong = seen.iter().filter(|(s, light)| light.is_visible != (facing(s, light) > 0.0)).count();
            assert!(seen.len() > 2000);
            assert_eq!(wrong, 0, "{facets} facets, of {}", seen.len());
            // Deliberate fault that the check must detect, the former behavior: facets that face away are dark and
            // shadow those behind them.
            let (reference, source) = (Reference::new(scene::pose(scene.clone(), 0.0)), ReferenceLight::new(&kind));
            let is_wrong_if_flat = |(surface, light): &&(ShadedPoint, LightSample)| {
                let mut flat = *surface;
                flat.seen.terminator_offset = 0.0;
                reference.sample(&source, &flat).unwrap().is_visible != (facing(surface, light) > 0.0)
            };
            let flat = seen.iter().filter(is_wrong_if_flat).count();
            assert!(flat > 400 / facets as usize, "{facets} facets: {flat}");
        }
    }
}

/// A wall of two triangles, whose normals all lean by 60 degrees as those of leaves do, lets no light through
/// from behind.
#[test]
fn light_from_behind_stays_there() {
    let leaning = Vec3::new(0.0, 0.5, 0.866);
    let wall = Primitive {
        positions: [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| Vec3::new(x, y, 0.0)).into(),
        normals: vec![leaning; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    };
    let scene = scene_of([(wall, DAffine3::IDENTITY)]);
    let behind = spot(DVec3::new(0.0, 3.0, -0.8), DVec3::ZERO);
    for light in [light::bend(&behind, 3).unwrap(), behind] {
        let light = CheckedLight::new(light).expect("a light");
        let seen = samples_in_view(&scene, &front(DVec3::ZERO), &light);
        let faced = |(surface, light): &&(ShadedPoint, LightSample)| surface.normal.dot(light.along_path) > 0.05;
        assert!(seen.iter().filter(faced).count() > 1000);
        assert_eq!(seen.iter().filter(|(_, light)| light.is_visible).count(), 0);
    }
}

/// The shadow of a post on a coarse ball begins at its foot, no farther away than the terminator offset.
#[test]
fn shadows_stay_attached() {
    let size = DVec3::new(0.3, 0.3, 0.6);
    let upright = DAffine3::from_rotation_z(std::f64::consts::FRAC_PI_2);
    let post = DAffine3::from_scale_rotation_translation(size, DQuat::IDENTITY, DVec3::Y) * upright;
    let scene = scene_of([(sphere(12), DAffine3::IDENTITY), (square(), post)]);
    for kind in kinds() {
        let view = view(DVec3::new(-0.6, 4.0, 0.4), DVec3::Y, Aov::Visibility);
        let seen = samples_in_view(&scene, &View { width: 144, height: 96, ..view }, &kind);
        let ball = || seen.iter().filter(|(surface, _)| surface.node == 0);
        let largest = ball().map(|(surface, _)| surface.terminator_offset).fold(0.0, f64::max);
        assert!(largest > 0.01 && largest < 0.035, "{largest}");
        // The post stands in the plane x = 0, and this range lies behind it as seen from the light.
        let beside = |low: f64, high: f64| {
            let within = move |(surface, _): &&(ShadedPoint, LightSample)| {
                surface.position.z.abs() < 0.3 && (low..high).contains(&-surface.position.x)
            };
            let lit = ball().filter(within).filter(|(_, light)| light.is_visible).count();
            (lit, ball().filter(within).count())
        };
        let (lit, count) = beside(3.0 * largest, 0.2);
        assert!(lit == 0 && count > 50, "{lit} of {count}");
        // Control: the light reaches the same range on the other side of the post.
        let (lit, count) = beside(-0.2, -3.0 * largest);
        assert!(lit == count && count > 50, "{lit} of {count}");
    }
}
