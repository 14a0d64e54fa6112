//! Tests shadows of simplified casters: their position, the surfaces that stay lit, and deliberate faults.

use std::f64::consts::{PI, TAU};

use glam::{DAffine3, DQuat, DVec3, Vec3};
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, DECAY, END_MODE, RANGE, ROTATION, TRANSLATION};
use light::{Decay, EndMode, Light, LightInstance, Tube};
use scene::{MapScale, Material, Primitive, Scene};

use crate::frame::{Frame, SceneBackend};
use crate::wgpu::bendy_light::tests::{add_mesh, alone, position, renderer, view};
use crate::wgpu::bendy_light::walk;
use crate::{Aov, Renderer, ShadowSettings, View};

/// Radius of the ball in world units; the bowl has a larger one.
const RADIUS: f64 = 0.6;
const CENTRE: DVec3 = DVec3::new(0.1, 2.4, 0.0);
const MESH_ERROR: f64 = 0.01 * RADIUS;

/// Returns a part of a unit sphere, from the pole at -y up to the angle `end`. Triangles share no vertices, so shading
/// has an edge on each side. Front faces are outside, or inside.
fn sphere(end: f64, rows: u32, columns: u32, inside: bool) -> Primitive {
    let point = |row: u32, column: u32| {
        let polar = end * f64::from(row) / f64::from(rows);
        let (sine, cosine) = (TAU * f64::from(column % columns) / f64::from(columns)).sin_cos();
        let around = if row == 0 || (row == rows && end == PI) { 0.0 } else { polar.sin() };
        DVec3::new(around * cosine, -polar.cos(), around * sine).as_vec3()
    };
    let mut primitive = Primitive::default();
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        let [a, b, c, d] = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| point(row + i, column + j));
        for corners in [[a, b, c], [a, c, d]] {
            let [a, b, c] = if inside { [corners[0], corners[2], corners[1]] } else { corners };
            let normal = (b - a).cross(c - a).normalize_or_zero();
            primitive.indices.extend((0..3).map(|k| primitive.positions.len() as u32 + k));
            primitive.positions.extend([a, b, c]);
            primitive.normals.extend([normal; 3]);
        }
    }
    primitive
}

/// Returns a square from -1 to 1 that faces up, in `side` times `side` quads.
fn square(side: u32) -> Primitive {
    let at = |k: u32| 2.0 * k as f32 / side as f32 - 1.0;
    let points = (0..=side).flat_map(|i| (0..=side).map(move |j| Vec3::new(at(i), 0.0, at(j))));
    let quads = (0..side).flat_map(|i| (0..side).map(move |j| i * (side + 1) + j));
    Primitive {
        positions: points.collect(),
        normals: vec![Vec3::Y; (side as usize + 1).pow(2)],
        indices: quads.flat_map(|k| [k, k + 1, k + side + 2, k, k + side + 2, k + side + 1]).collect(),
        ..Primitive::default()
    }
}

fn scene_of<const N: usize>(parts: [(Primitive, f64, DVec3); N]) -> Scene {
    let mut scene = Scene { materials: vec![Material::default()], ..Scene::default() };
    for (primitive, scale, at) in parts {
        let placement = DAffine3::from_scale_rotation_translation(DVec3::splat(scale), DQuat::IDENTITY, at);
        add_mesh(&mut scene, primitive, placement);
    }
    scene.check().expect("sound");
    scene
}

/// Returns a ball of 36,864 triangles over a floor of two.
fn ball() -> Scene {
    ball_over(8.0)
}

/// Returns the ball over a floor that extends `floor` to each side.
pub(crate) fn ball_over(floor: f64) -> Scene {
    scene_of([(sphere(PI, 96, 192, false), RADIUS, CENTRE), (square(1), floor, DVec3::ZERO)])
}

/// Returns a shallow bowl. Light from above falls into it without touching its rim.
fn bowl() -> Scene {
    scene_of([(sphere(PI / 4.0, 96, 192, true), 2.0, DVec3::new(0.5, 2.2, 0.0))])
}

/// Returns lights from 6 units up, pointing down: a spotlight, the equal BendyLight, and one that bends. Each has its
/// straight or bent reference light.
pub(crate) fn lights() -> [(Light, Light); 3] {
    let spot = Light::spot()
        .with(CONE_ANGLE, 18.0)
        .with(RANGE, Some(7.0))
        .with(DECAY, Decay::None)
        .with(CONE_SOFTNESS, 0.0)
        .with(TRANSLATION, DVec3::Y * 6.0)
        .with(ROTATION, DQuat::from_rotation_x(-PI / 2.0));
    let straight = light::bend(&spot, 2).expect("sound");
    let points = [(0., 0., 0.), (0., 0., -1.5), (0., 0., -3.2), (0.9, 0., -4.9), (1.9, 0., -6.5)];
    let points = points.map(|(x, y, z)| DVec3::new(x, y, z)).to_vec();
    let bent = Light::bendy(points, vec![0.2, 0.8, 1.2, 1.5, 1.8])
        .with_transform(spot.transform())
        .with(END_MODE, EndMode::Cut);
    [(spot, straight.clone()), (straight.clone(), straight), (bent.clone(), bent)]
}

fn all() -> Vec<LightInstance> {
    LightInstance::numbered(lights().map(|(light, _)| light)).expect("lights")
}

fn settings(mesh_error: f64) -> ShadowSettings {
    ShadowSettings { mesh_error, straighten: false, ..ShadowSettings::default() }
}

/// Makes casters with one mesh error while lookups assume another.
fn plant(renderer: &mut Renderer, assumed: f64, made: f64) {
    // Both settings discard the maps drawn before.
    for mesh_error in [made, assumed] {
        renderer.set_shadow_settings(settings(mesh_error)).expect("sound");
    }
    let Frame { backend, scene, .. } = renderer.wgpu();
    scene.casters = scene.casters_within(backend.device(), made).expect("made").into();
}

/// Returns the number of dark and lit floor points in the light, and number of wrong ones whose light path passes the
/// ball's edge by more than `slack`, with maps of a given scale.
pub(crate) fn floor(
    renderer: &mut Renderer,
    shadow_map: MapScale,
    (light, bent): &(Light, Light),
    slack: f64,
) -> ([usize; 2], usize) {
    let tube = Tube::new(bent).expect("valid");
    let mut picture = |aov| renderer.render(&View { shadow_map, ..view(aov) }, &alone(light)).expect("drawn");
    let (depth, visibility) = (picture(Aov::Depth), picture(Aov::Visibility));
    let (mut counts, mut wrong) = ([0; 2], 0);
    for (pixel, seen) in visibility.pixels.iter().enumerate().filter(|(_, seen)| seen[3] == 1.0) {
        let point = position(&view(Aov::Depth), &depth, pixel);
        let Some(root) = tube.nearest_root(tube.placement.tube_from_world(point)).filter(|_| point.y < 1e-4) else {
            continue;
        };
        let (v, w) = (root.v_len / root.radius, root.w_len / root.radius);
        let t = root.segment as f64 + root.u;
        let on_path = |k: u32| tube.placement.world_from_tube(walk::point_at(&tube, t * f64::from(k) / 1000.0, v, w));
        let nearest = (0..=1000).map(|k| on_path(k).distance(CENTRE)).fold(f64::INFINITY, f64::min);
        let outside = nearest - RADIUS;
        if outside.abs() > slack {
            counts[usize::from(outside > 0.0)] += 1;
            wrong += usize::from(seen[0] != if outside > 0.0 { 1.0 } else { 0.0 });
        }
    }
    (counts, wrong)
}

/// Returns the number of pixels that light reaches at more than 6 degrees, and number of those in shadow.
fn shadowed(renderer: &mut Renderer, light: &Light, on: impl Fn(DVec3) -> bool) -> (usize, usize) {
    let mut picture = |aov| renderer.render(&view(aov), &alone(light)).expect("drawn");
    let [visibility, direction, normal, depth] =
        [Aov::Visibility, Aov::Direction, Aov::Normal, Aov::Depth].map(&mut picture);
    let vector = |picture: &crate::Picture, pixel: usize| {
        let [x, y, z, _] = picture.pixels[pixel].map(f64::from);
        DVec3::new(x, y, z)
    };
    let facing = |&pixel: &usize| {
        visibility.pixels[pixel][3] == 1.0
            && vector(&direction, pixel).dot(vector(&normal, pixel)) > 0.1
            && on(position(&view(Aov::Depth), &depth, pixel))
    };
    let reached: Vec<_> = (0..visibility.pixels.len()).filter(facing).collect();
    (reached.len(), reached.iter().filter(|&&pixel| visibility.pixels[pixel][0] < 1.0).count())
}

/// Asserts that no pixel `on` a part of the scene is in shadow, of more than `least` that light reaches.
fn assert_lit(renderer: &mut Renderer, light: &Light, least: usize, on: impl Fn(DVec3) -> bool) {
    let (reached, false_shadow) = shadowed(renderer, light, on);
    let mesh_error = renderer.wgpu().shadow_maps.shadows().mesh_error;
    assert!(reached > least && false_shadow == 0, "{false_shadow} of {reached} at {mesh_error}, {light:?}");
}

/// Far fewer triangles cast the ball's shadow, within the error of its position, and the lit side stays lit.
#[test]
fn a_simplified_ball_casts_its_shadow() {
    // Three texels of the map, 2 R / 2048 wide with R at most 2.3, and the ball's own facets.
    let slack = MESH_ERROR + 3.0 * 2.3 / 1024.0;
    let mut renderer = renderer(&ball());
    renderer.set_shadow_settings(settings(MESH_ERROR)).expect("sound");
    let scene = &renderer.wgpu().scene;
    let (before, after) = (scene.triangle_count, scene.casters.triangle_count);
    assert!((100..before / 10).contains(&after), "{after} of {before} triangles");
    assert!(scene.casters.vertex_count < after, "none that no triangle has");
    for light in &lights() {
        let ([dark, lit], wrong) = floor(&mut renderer, MapScale::Full, light, slack);
        assert!(dark > 500 && lit > 500, "{dark} dark, {lit} lit");
        assert_eq!(wrong, 0, "{:?}", light.0);
        assert_lit(&mut renderer, &light.0, 300, |point| point.y > 1.0);
    }

    // Deliberate fault that the check must detect: ten times the error.
    plant(&mut renderer, MESH_ERROR, 10.0 * MESH_ERROR);
    for light in &lights() {
        assert!(floor(&mut renderer, MapScale::Full, light, slack).1 > 0, "a coarse ball went unseen");
    }
}

/// A bowl's simplified facets are in front of its surface. It stays lit because lookups know the error.
#[test]
fn a_simplified_bowl_stays_lit() {
    let mut renderer = renderer(&bowl());
    for light in &lights() {
        for error in [0.5 * MESH_ERROR, 3.0 * MESH_ERROR] {
            renderer.set_shadow_settings(settings(error)).expect("sound");
            assert_lit(&mut renderer, &light.0, 2000, |_| true);
        }
        // Deliberate fault that the check must detect: lookups that assume no error, or a tenth of it.
        for assumed in [0.0, MESH_ERROR] {
            plant(&mut renderer, assumed, 10.0 * MESH_ERROR);
            assert!(shadowed(&mut renderer, &light.0, |_| true).1 > 100, "assumed {assumed}");
        }
    }
}

/// A plane of many triangles simplifies to few, and does not shadow itself.
#[test]
fn a_simplified_plane_stays_lit() {
    let mut renderer = renderer(&scene_of([(square(40), 8.0, DVec3::ZERO)]));
    renderer.set_shadow_settings(settings(0.05)).expect("sound");
    let left = renderer.wgpu().scene.casters.triangle_count;
    assert!(left < 20, "{left} of 3,200 triangles");
    for light in &lights() {
        assert_lit(&mut renderer, &light.0, 2000, |_| true);
    }
}

/// With error 0, maps use the scene's own triangles, before and after a setting with an error.
#[test]
fn without_an_error_maps_use_the_scenes_triangles() {
    let mut renderer = renderer(&ball());
    let triangles = |renderer: &mut Renderer| {
        let scene = &renderer.wgpu().scene;
        (scene.casters.triangle_count, scene.triangle_count)
    };
    let lights = all();
    let at_first = triangles(&mut renderer);
    assert_eq!(at_first.0, at_first.1);
    let exact = renderer.render(&view(Aov::Beauty), &lights).expect("drawn");
    renderer.set_shadow_settings(settings(MESH_ERROR)).expect("sound");
    assert!(triangles(&mut renderer).0 < at_first.0);
    let simplified = renderer.render(&view(Aov::Beauty), &lights).expect("drawn");
    renderer.set_shadow_settings(settings(0.0)).expect("sound");
    assert_eq!(triangles(&mut renderer), at_first);
    assert_ne!(simplified, exact, "a planted change is seen");
    assert_eq!(renderer.render(&view(Aov::Beauty), &lights).expect("drawn"), exact);
}

/// The picture is the same if settings come before the scene or after it, and with another scene in between.
#[test]
fn the_order_of_scene_and_settings_does_not_matter() {
    let lights = all();
    let mut scene_first = renderer(&ball());
    scene_first.set_shadow_settings(settings(MESH_ERROR)).expect("sound");
    let mut settings_first = renderer(&Scene::default());
    settings_first.set_shadow_settings(settings(MESH_ERROR)).expect("sound");
    settings_first.set_scene(&scene::pose(bowl(), 0.0)).expect("fits");
    settings_first.set_scene(&scene::pose(ball(), 0.0)).expect("fits");
    let picture = |renderer: &mut Renderer| renderer.render(&view(Aov::Beauty), &lights).expect("drawn");
    let expected = picture(&mut scene_first);
    assert_eq!(picture(&mut settings_first), expected);
    scene_first.set_scene(&scene::pose(bowl(), 0.0)).expect("fits");
    assert_ne!(picture(&mut scene_first), expected, "a planted change is seen");
}
