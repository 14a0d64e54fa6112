//! Compares lights with straight rays with the reference, which traces every ray on its own.
//!
//! `BENDYLIGHTS_SHADOW_PICTURES=DIR` saves the pictures.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

use std::collections::BTreeSet;
use std::sync::{Arc, LazyLock, Mutex};

use glam::{DQuat, DVec2, DVec3};
use light::parameters::{COLOR, CONE_ANGLE, HEIGHT, INTENSITY, RANGE, ROTATION, TRANSLATION, WIDTH};
use light::{Light, LightInstance};
use reference::{Reference, ReferenceLight, ShadedPoint};
use render::{Culling, Picture, Renderer, ShadowSettings};
use scene::{Aov, PosedScene, View};

use crate::boxes::{self, SIZE, aimed, boxes, looking, room, room_view, view};
use crate::pictures::{
    ComparedPixels, PictureError, alone, draw_with, instances, reduced_culling, renderer, save_picture,
};

fn sun(from: DVec3) -> Light {
    boxes::sun(from, 3.0)
}

fn bulb(at: DVec3) -> Light {
    boxes::bulb(at, 30.0)
}

/// Spotlight so wide that it contains the visible part, aimed past it.
fn lamp(at: DVec3, to: DVec3) -> Light {
    aimed(Light::spot(), at, to).with(CONE_ANGLE, 60.0).with(INTENSITY, 30.0)
}

/// Draws a picture with a renderer that all tests share.
fn drawn(scene: &Arc<PosedScene>, view: &View, lights: &[LightInstance]) -> Picture {
    static SHARED: LazyLock<Mutex<Renderer>> = LazyLock::new(|| Mutex::new(renderer()));
    draw_with(&SHARED, scene, view, lights)
}

/// Maximum width of a texel of a light's map at a point in scene space: a fitted map has smaller ones.
fn texel(light: &LightInstance, scene: &PosedScene, point: DVec3) -> f64 {
    let resolution = f64::from(ShadowSettings::default().resolution);
    match ReferenceLight::new(&light.light) {
        ReferenceLight::Omni(omni) => {
            // A face has half the texels per side, and is 2 wide at a distance of 1.
            2.0 * (point + scene.origin_in_world - omni.translation).length() / (resolution / 2.0 - 4.0)
        }
        ReferenceLight::Spot(cone) => {
            2.0 * cone.tan_outer * (point + scene.origin_in_world - cone.translation).length() / (resolution - 4.0)
        }
        ReferenceLight::Directional(_) => 2.0 * scene.half_extent.length() / (resolution - 4.0),
        ReferenceLight::Bendy(_) => panic!("its map is another test's"),
    }
}

/// Pixels at least two texels away from each edge of a shadow and of a surface in the reference.
fn off_edges(reference: &Reference, view: &View, light: &LightInstance) -> ComparedPixels {
    let source = ReferenceLight::new(&light.light);
    let posed = &reference.bvh.posed;
    let seen = |x: f64, y: f64| reference.surface(view, DVec2::new(x, y) + 0.5);
    // Dark outside of the light, too.
    let visible = |surface: &ShadedPoint| reference.sample(&source, surface).is_some_and(|sample| sample.is_visible);
    let [width, height] = SIZE.map(|side| side as usize);
    let mut found = ComparedPixels::default();
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let Some(surface) = seen(x as f64, y as f64) else { continue };
        // A rasterizer snaps corners to 1/256 pixel: at a silhouette it may see another surface.
        let is_same = |(dx, dy): (f64, f64)| {
            seen(x as f64 + dx, y as f64 + dy).is_some_and(|beside| {
                let height = surface.geometric_normal.dot(beside.position - surface.position);
                beside.geometric_normal == surface.geometric_normal && height.abs() < 1e-6
            })
        };
        if ![(0.02, 0.0), (-0.02, 0.0), (0.0, 0.02), (0.0, -0.02)].into_iter().all(is_same) {
            continue;
        }
        let here = visible(&surface);
        let normal = surface.geometric_normal;
        let sample = reference.sample(&source, &surface);
        // A texel and the filter's radius are as long on the surface as grazing light makes them.
        let towards = sample.map_or(normal, |sample| sample.coords.direction);
        let far = 2.0 * texel(light, posed, surface.position);
        let along = towards.reject_from(normal).normalize_or(normal.any_orthonormal_vector());
        let across = normal.cross(along) * far;
        let along = along * (far / normal.dot(towards).abs().max(1e-3));
        let ring = (0..24).map(|k| {
            let (sin, cos) = (f64::from(k) * std::f64::consts::TAU / 12.0).sin_cos();
            let share = if k < 12 { 1.0 } else { 0.5 };
            (along * cos + across * sin) * share
        });
        let is_clear = |step: DVec3| {
            let mut beside = surface;
            beside.seen.position += step;
            visible(&beside) == here
        };
        // In a corner between surfaces the filter blends in casters on the other surface.
        let is_flat = |step: DVec3| {
            let start = surface.position + normal * (far * 0.5);
            reference.bvh.first_hit(start, step * 1.5, [0.0, 1.0], |_| true).is_none()
        };
        if ring.clone().all(is_clear) && ring.clone().all(is_flat) {
            found.push(y * width + x, here);
        }
    }
    found
}

/// Saves a picture in color.
fn save_colors(name: &str, picture: &Picture, marks: &[usize]) {
    let byte = |x: f32| (x.clamp(0.0, 1.0).powf(1.0 / 2.2) * 255.0) as u8;
    save_picture(name, picture, marks, |value| [0, 1, 2].map(|channel: usize| byte(value[channel])));
}

/// Views of the room.
fn room_views() -> [View; 2] {
    [room_view(), view(DVec3::new(-2.4, 0.7, 3.9), DVec3::new(0.6, 1.2, -0.8))]
}

/// Numbers of compared pixels.
#[derive(Default)]
struct PixelCounts {
    wrong: usize,
    lit: usize,
    dark: usize,
}

impl PixelCounts {
    /// Tests that there is something to see and that none is wrong.
    fn assert_right(&self, what: &str) {
        let Self { wrong, lit, dark } = *self;
        println!("{what}: {wrong} wrong of {}, {dark} dark", lit + dark);
        assert!(lit > 500 && dark > 500, "{what}: {dark} of {} are dark", lit + dark);
        assert_eq!(wrong, 0, "{what}: of {}", lit + dark);
    }
}

/// Compares the picture of `drawn_light` with the reference of `light` in each of the views.
fn compare(reference: &Reference, views: &[View], light: &Light, drawn_light: &Light, name: &str) -> PixelCounts {
    let mut counts = PixelCounts::default();
    for (index, view) in views.iter().enumerate() {
        let compared = off_edges(reference, view, &alone(light)[0]);
        let picture = drawn(&reference.bvh.posed, view, &alone(drawn_light));
        let wrong = compared.wrong(&picture);
        save_colors(&format!("{name}-{index}"), &picture, &wrong);
        counts.wrong += wrong.len();
        counts.lit += compared.lit.len();
        counts.dark += compared.dark.len();
    }
    counts
}

/// On a wide floor at grazing light, with a post as the only caster, no pixel that rays reach is dark; nor far from the
/// world's origin.
#[test]
fn a_floor_never_shadows_itself() {
    for origin in [DVec3::ZERO, DVec3::new(1e7, -3e6, 2e7)] {
        let at = |[x, y, z]: [f64; 3]| (origin + DVec3::new(x, y, z)).to_array();
        let floor = ([50.0, 0.1, 50.0], 0.0, at([0.0, -0.1, 0.0]));
        let with_post = |x: f64| boxes(&[floor, ([0.1, 0.7, 0.1], 0.3, at([x, 0.7, -0.3]))]);
        let scene = scene::pose(with_post(0.4), 0.0);
        let reference = Reference::new(Arc::clone(&scene));
        let view = view(origin + DVec3::new(0.4, 0.9, 3.0), origin);
        let suns = [80_f64, 30.0, 10.0, 2.0, 0.5, 0.1].map(|degrees| {
            let (height, across) = degrees.to_radians().sin_cos();
            (format!("sun {degrees}"), sun(DVec3::new(0.8 * across, height, 0.6 * across)))
        });
        let bulbs = [4.0, 1.0, 0.2, 0.05]
            .map(|height| (format!("bulb {height}"), bulb(origin + DVec3::new(-1.5, height, 0.4))));
        let lamps = [4.0, 1.0, 0.2, 0.05, 0.02].map(|height| {
            let at = origin + DVec3::new(-1.5, height, 0.4);
            (format!("lamp {height}"), lamp(at, origin + DVec3::new(1.0, 0.0, 0.2)))
        });
        for (name, light) in suns.into_iter().chain(bulbs).chain(lamps) {
            let lights = alone(&light);
            let compared = off_edges(&reference, &view, &lights[0]);
            let found = compared.wrong(&drawn(&scene, &view, &lights));
            let (lit, count) = (compared.lit.len(), compared.count());
            println!("{name}: {} wrong of {count}, {lit} lit", found.len());
            assert!(lit > 2000, "{name}: {lit} of {count} are lit");
            assert_eq!(found, [0; 0], "{name} at {origin}");
            if name == "sun 30" {
                // The planted fault: the post is at another position.
                let other = drawn(&scene::pose(with_post(0.8), 0.0), &view, &lights);
                assert!(compared.wrong(&other).len() > 100, "{name}: a post elsewhere goes unseen");
            }
        }
    }
}

/// From above, from all sides, and so low that the light grazes the floor.
#[test]
fn a_directional_lights_shadow_is_where_rays_say() {
    let directions = [
        [0.1, 1.0, 0.05],
        [1.0, 1.0, 0.4],
        [-1.0, 1.2, 0.3],
        [0.3, 0.7, 1.0],
        [-0.4, 0.5, 1.0],
        [0.5, 0.1, 1.0],
        [0.0, 1.0, 0.0],
    ];
    let reference = Reference::new(scene::pose(room(), 0.0));
    for (index, direction) in directions.into_iter().enumerate() {
        let light = sun(DVec3::from_array(direction));
        let counts = compare(&reference, &room_views(), &light, &light, &format!("sun-{index}"));
        counts.assert_right(&format!("{direction:?}"));
    }
    // The planted fault: a directional light rotated by one degree.
    let light = sun(DVec3::from_array(directions[1]));
    let turned = light.get(ROTATION) * DQuat::from_rotation_x(1_f64.to_radians());
    let turned = light.clone().with(ROTATION, turned);
    let PixelCounts { wrong, lit, dark } = compare(&reference, &room_views(), &light, &turned, "sun-planted");
    assert!(wrong > 100, "{wrong} wrong of {}", lit + dark);
}

/// The whole visible part is on each of the six faces in turn.
#[test]
fn an_omni_lights_shadow_is_where_rays_say() {
    let at = DVec3::new(0.2, 1.7, 0.1);
    let light = bulb(at);
    let reference = Reference::new(scene::pose(room(), 0.0));
    compare(&reference, &room_views(), &light, &light, "bulb").assert_right("the whole light");
    let moved = light.clone().with(TRANSLATION, at + DVec3::new(0.1, 0.0, 0.0));
    let planted = compare(&reference, &room_views(), &light, &moved, "bulb-planted");
    assert!(planted.wrong > 100, "the planted fault is seen");

    // Each face alone, in a room with posts before each wall, seen from the light's side.
    let reference = Reference::new(scene::pose(posts(), 0.0));
    let light = bulb(DVec3::ZERO);
    for axis in axes() {
        let direction = light.get(ROTATION) * axis;
        let eye = direction.any_orthonormal_vector() * 0.8 - direction * 0.2;
        let view = view_with_up(eye, direction * 2.0, direction.any_orthonormal_vector());
        compare(&reference, &[view], &light, &light, &format!("face {axis}")).assert_right(&format!("{axis}"));
    }
}

/// The six directions of the axes.
fn axes() -> impl Iterator<Item = DVec3> {
    DVec3::AXES.into_iter().flat_map(|axis| [axis, -axis])
}

/// View from `eye` to `target` of the first light's visibility, with `up` at the top.
fn view_with_up(eye: DVec3, target: DVec3, up: DVec3) -> View {
    let mut view = view(eye, target);
    view.camera.rotation = looking(eye, target, up);
    view
}

/// A closed room, with posts before each of its walls.
fn posts() -> scene::Scene {
    let mut parts = closed(3.0);
    for axis in 0..3 {
        for sign in [-1.0, 1.0] {
            for (k, aside) in [-0.7, 0.0, 0.8].into_iter().enumerate() {
                let mut middle = [aside; 3];
                middle[axis] = 1.3 * sign;
                middle[(axis + 1) % 3] = 0.35 * k as f64 - 0.3;
                parts.push(([0.08, 0.1, 0.12], 0.3 * k as f64, middle));
            }
        }
    }
    boxes(&parts)
}

/// Six thick walls around the origin, with the inner sides at a distance of `half`.
fn closed(half: f64) -> Vec<([f64; 3], f64, [f64; 3])> {
    let wall = |k: usize| {
        let (axis, sign) = (k / 2, if k.is_multiple_of(2) { 1.0 } else { -1.0 });
        let (mut size, mut middle) = ([half + 0.2; 3], [0.0; 3]);
        (size[axis], middle[axis]) = (0.1, sign * (half + 0.1));
        (size, 0.0, middle)
    };
    (0..6).map(wall).collect()
}

/// Inside, every wall is lit up to its edges; outside, nothing is.
#[test]
fn an_omni_light_in_a_closed_box_lights_every_wall_and_leaks_nowhere() {
    let scene = scene::pose(boxes(&closed(2.0)), 0.0);
    let light = alone(&bulb(DVec3::new(0.7, -0.4, 0.9)));
    let lit = |picture: &Picture| picture.pixels.iter().filter(|pixel| pixel[0] > 0.0).count();
    for axis in axes() {
        let seen = |eye, target| drawn(&scene, &view_with_up(eye, target, axis.any_orthonormal_vector()), &light);
        let within = seen(axis * -1.9, axis);
        let dark: Vec<_> = (0..within.pixels.len()).filter(|&k| within.pixels[k][0] < 1.0).collect();
        save_colors(&format!("within-{axis}"), &within, &dark);
        assert_eq!(dark, [0; 0], "{axis}: dark within");
        let mut aside = axis.any_orthonormal_vector() * 3.0;
        aside += axis.cross(aside) * 0.7;
        for eye in [axis * 9.0, axis * 9.0 + aside] {
            assert_eq!(lit(&seen(eye, DVec3::ZERO)), 0, "{axis}: lit without");
        }
    }
    // The planted fault: a displaced wall lets light out, onto the floor outside.
    let mut parts = closed(2.0);
    parts[0].2[0] += 0.5;
    parts.push(([8.0, 0.1, 8.0], 0.0, [0.0, -4.1, 0.0]));
    let leaking = scene::pose(boxes(&parts), 0.0);
    let seen = drawn(&leaking, &view(DVec3::new(9.0, 1.0, 3.0), DVec3::new(3.7, -4.0, 0.0)), &light);
    save_colors("leaking", &seen, &[]);
    assert!(lit(&seen) > 100, "{} pixels are lit", lit(&seen));
}

/// Relative error over the pixels that are away from the shadow edges of every light.
fn relative_rmse(scene: &Arc<PosedScene>, view: &View, lights: &[Light], planted: &[Light], name: &str) -> f64 {
    let reference = Reference::new(Arc::clone(scene));
    let lights = instances(lights);
    let beauty = View { aov: Aov::Beauty, fill: 0.0, ..view.clone() };
    let expected = reference.render(&beauty, &lights, || {}).expect("it can be followed");
    let picture = drawn(scene, &beauty, &instances(planted));
    let compared = |light: &LightInstance| {
        let ComparedPixels { lit, dark } = off_edges(&reference, view, light);
        lit.into_iter().chain(dark).collect::<BTreeSet<_>>()
    };
    let compared: Vec<_> = lights.iter().map(compared).collect();
    save_colors(name, &picture, &[]);
    let expected = expected.pixels.iter().enumerate().map(|(pixel, [r, g, b, _])| {
        compared.iter().all(|pixels| pixels.contains(&pixel)).then_some(DVec3::new(*r, *g, *b))
    });
    let PictureError { relative_rmse, compared } = PictureError::new(&picture, expected);
    assert!(compared > 10_000, "{name}: {compared} pixels are compared");
    relative_rmse
}

/// Away from edges pictures are within 1e-3 of the reference: the difference is f32 rounding.
#[test]
fn pictures_are_those_of_the_reference() {
    let scene = scene::pose(room(), 0.0);
    let window = |light: Light| light.with(WIDTH, Some(4.0)).with(HEIGHT, Some(2.5));
    let lights = [
        ("sun", sun(DVec3::new(1.0, 1.0, 0.4))),
        ("window", window(sun(DVec3::new(-0.3, 1.0, 0.4))).with(TRANSLATION, DVec3::new(-1.0, 9.0, 0.5))),
        ("bulb", bulb(DVec3::new(0.2, 1.7, 0.1))),
        ("bulb-range", bulb(DVec3::new(0.2, 1.7, 0.1)).with(RANGE, Some(2.5))),
    ];
    for (name, light) in lights {
        let all = [light.clone()];
        let error = relative_rmse(&scene, &room_view(), &all, &all, &format!("beauty-{name}"));
        let brighter = [light.clone().with(INTENSITY, light.get(INTENSITY) * 1.01)];
        let planted = relative_rmse(&scene, &room_view(), &all, &brighter, &format!("planted-{name}"));
        println!("{name}: {error:.2e}, 1 % brighter {planted:.2e}");
        assert!(error < 1e-3, "{name}: {error:.2e}");
        assert!(planted > 5e-3, "{name}: {planted:.2e}");
    }
}

/// A directional light through its window, two omni lights and a spotlight together.
#[test]
fn lights_of_all_shapes_add_up() {
    let scene = scene::pose(room(), 0.0);
    let spot = aimed(Light::spot(), DVec3::new(-3.0, 3.5, 2.5), DVec3::new(0.3, 0.6, -0.4))
        .with(CONE_ANGLE, 30.0)
        .with(INTENSITY, 40.0);
    let lights = [
        sun(DVec3::new(1.0, 1.6, 0.4)).with(COLOR, DVec3::new(1.0, 0.9, 0.7)).with(INTENSITY, 1.0),
        bulb(DVec3::new(0.2, 1.7, 0.1)).with(COLOR, DVec3::new(0.3, 0.5, 1.0)).with(INTENSITY, 6.0),
        bulb(DVec3::new(-3.4, 0.8, -1.5)).with(COLOR, DVec3::new(1.0, 0.2, 0.1)).with(RANGE, Some(3.0)),
        spot,
    ];
    let error = relative_rmse(&scene, &room_view(), &lights, &lights, "together");
    // The planted fault: one of the lights is missing.
    let planted = relative_rmse(&scene, &room_view(), &lights, &lights[..3], "together-planted");
    println!("{error:.2e}, without the spotlight {planted:.2e}");
    assert!(error < 1e-3, "{error:.2e}");
    assert!(planted > 0.05, "{planted:.2e}");
}

/// Culling changes no picture, for lights of every shape, including ones outside of the view.
#[test]
fn culling_changes_no_picture() {
    let mut renderer = renderer();
    let scene = scene::pose(room(), 0.0);
    let spot = lamp(DVec3::new(2.5, 3.0, 2.0), DVec3::ZERO).with(CONE_ANGLE, 25.0).with(RANGE, Some(9.0));
    let bent = light::bend(&spot, 3).expect("a cone").map_points(|k, point| {
        point.position.x += [0.0, 0.2, 0.6, 0.2, 0.0][k];
    });
    let beside = bulb(DVec3::new(0.0, 1.0, 400.0)).with(RANGE, Some(2.0));
    let lights = instances(&[
        sun(DVec3::new(1.0, 2.0, 3.0)),
        bulb(DVec3::new(0.0, 1.7, 0.0)),
        lamp(DVec3::new(-1.5, 3.0, 1.0), DVec3::ZERO),
        spot,
        bent,
        beside,
    ]);
    let mut pictures = |culling: Culling, resolution: u32| -> Vec<Picture> {
        let settings = ShadowSettings { culling, resolution, ..ShadowSettings::default() };
        renderer.set_shadow_settings(settings).expect("sound");
        renderer.set_scene(&scene).expect("it fits");
        let views = room_views().into_iter().map(|view| View { aov: Aov::Beauty, ..view });
        views.map(|view| renderer.render(&view, &lights).expect("it can be drawn")).collect()
    };
    let usual = pictures(Culling::ALL, 2048);
    for (_, culling) in reduced_culling() {
        assert!(pictures(culling, 2048) == usual, "{culling:?}");
    }
    // The planted fault: different maps give a different picture.
    assert!(pictures(Culling::ALL, 2000) != usual);
}
