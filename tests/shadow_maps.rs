//! Compares shadow maps with rays, for lights that need more than one evenly divided map: very wide ones, and those
//! that are much wider than the scene in them.
//!
//! `BENDYLIGHTS_SHADOW_PICTURES=DIR` saves the pictures.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

use std::sync::{Arc, LazyLock, Mutex};

use glam::{DAffine3, DVec3, Vec3};
use light::parameters::{CONE_ANGLE, CONE_SOFTNESS, DECAY, RANGE, TRANSLATION};
use light::{Decay, Light, Transform};
use reference::Reference;
use render::{Picture, Renderer, ShadowSettings};
use scene::{Aov, PosedScene, Primitive, Scene, View};

use crate::boxes::{SIZE, add_mesh, boxes, looking, room, room_view, view};
use crate::pictures::{ComparedPixels, alone, draw_with, renderer, save_picture};

/// A spotlight from `eye` to `target`, and the BendyLight that `bend` makes of it.
fn pair(eye: DVec3, target: DVec3, cone_angle: f64) -> [(&'static str, Light); 2] {
    let transform = Transform { translation: eye, rotation: looking(eye, target, DVec3::X), scale: 1.0 };
    let spot = Light::spot()
        .with_transform(transform)
        .with(CONE_ANGLE, cone_angle)
        .with(CONE_SOFTNESS, 0.0)
        .with(DECAY, Decay::None)
        .with(RANGE, Some(9.0));
    let bent = light::bend(&spot, 2).expect("it can be bent");
    [("spot", spot), ("bent", bent)]
}

/// Draws a picture with a renderer that all tests share. It draws straight BendyLights by their own passes, not as
/// spotlights.
fn drawn(scene: &Arc<PosedScene>, view: &View, light: &Light) -> Picture {
    static SHARED: LazyLock<Mutex<Renderer>> = LazyLock::new(|| {
        let mut renderer = renderer();
        let apart = ShadowSettings { straighten: false, ..ShadowSettings::default() };
        renderer.set_shadow_settings(apart).expect("sound");
        Mutex::new(renderer)
    });
    draw_with(&SHARED, scene, view, &alone(light))
}

/// Pixels away from edges in the reference: the 5 x 5 pixels around have the same visibility and face the same way. In
/// a corner between two walls the filter blends in casters on the other wall.
fn off_edges(scene: &Arc<PosedScene>, view: &View, light: &Light) -> ComparedPixels {
    let reference = Reference::new(Arc::clone(scene));
    let pixels = |aov| {
        let view = View { aov, ..view.clone() };
        reference.render(&view, &alone(light), || {}).expect("it can be followed").pixels
    };
    let (visibility, normals) = (pixels(Aov::Visibility), pixels(Aov::Normal));
    let expected: Vec<_> = visibility
        .iter()
        .zip(normals)
        .map(|(pixel, normal)| (pixel[3] == 1.0).then_some((pixel[0] == 1.0, normal.map(|x| (x * 1e3).round() as i32))))
        .collect();
    let [width, height] = SIZE.map(|side| side as usize);
    let mut found = ComparedPixels::default();
    for (y, x) in (2..height - 2).flat_map(|y| (2..width - 2).map(move |x| (y, x))) {
        let pixel = y * width + x;
        let here = expected[pixel];
        let mut around = (y - 2..=y + 2).flat_map(|y| (x - 2..=x + 2).map(move |x| y * width + x));
        if let Some((lit, _)) = here
            && around.all(|other| expected[other] == here)
        {
            found.push(pixel, lit);
        }
    }
    found
}

/// Saves a picture of visibility in grey.
fn save_visibility(name: &str, picture: &Picture, marks: &[usize]) {
    let grey = |[value, .., alpha]: &[f32; 4]| [(value * 200.0) as u8 + if *alpha > 0.0 { 30 } else { 0 }; 3];
    save_picture(name, picture, marks, grey);
}

/// A picture, and the pixels in which it is compared with the reference.
struct PictureComparison {
    picture: Picture,
    compared: ComparedPixels,
    wrong: Vec<usize>,
}

impl PictureComparison {
    /// Tests that so many pixels are compared, that so many of them are dark, and that none is wrong.
    fn assert_right(&self, what: &str, least: usize, least_dark: usize) {
        let (wrong, dark, count) = (self.wrong.len(), self.compared.dark.len(), self.compared.count());
        println!("{what}: {wrong} of {count} wrong, {dark} dark");
        assert!(count >= least && dark >= least_dark, "{what}: little to see: {dark} of {count} are dark");
        assert_eq!(wrong, 0, "{what}: of {count} pixels, {dark} dark");
    }
}

/// Compares the picture of a light with the reference. Saves it as `name`.
fn compare(scene: &Arc<PosedScene>, view: &View, light: &Light, name: &str) -> PictureComparison {
    let compared = off_edges(scene, view, light);
    let picture = drawn(scene, view, light);
    let wrong = compared.wrong(&picture);
    save_visibility(name, &picture, &wrong);
    PictureComparison { picture, compared, wrong }
}

/// Up to 89.9 degrees, which is the import's limit for glTF's pi / 2, every pixel away from shadow edges is right, for
/// a spotlight and for the BendyLight that equals it.
#[test]
fn very_wide_lights_keep_their_shadows() {
    let scene = scene::pose(room(), 0.0);
    let view = room_view();
    for angle in [50.0, 61.0, 75.0, 85.0, 88.0, 89.9] {
        for (kind, light) in pair(DVec3::new(0.2, 2.2, 0.1), DVec3::new(0.1, 0.0, 0.25), angle) {
            let name = format!("wide-{kind}-{angle}");
            compare(&scene, &view, &light, &name).assert_right(&name, 5001, 501);
        }
    }
}

/// A table half a unit wide with a board above it, and the boxes of `also`.
fn table(also: &[([f64; 3], f64, [f64; 3])]) -> Scene {
    let mut parts = vec![
        ([0.3, 0.01, 0.3], 0.1, [0.0, -0.01, 0.0]),
        ([0.12, 0.004, 0.08], 0.4, [0.02, 0.1, -0.03]),
        ([0.01, 0.06, 0.01], 0.2, [-0.14, 0.06, 0.1]),
    ];
    parts.extend(also);
    boxes(&parts)
}

/// Displacement of shadow edges from the reference in pixels: the number of pixels on the wrong side of an edge over
/// the number of pixels at an edge.
fn displacement(scene: &Arc<PosedScene>, view: &View, light: &Light, name: &str) -> f64 {
    let frame = Reference::new(Arc::clone(scene)).render(view, &alone(light), || {}).expect("it can be followed");
    let picture = drawn(scene, view, light);
    let differs = |&k: &usize| (frame.pixels[k][0] >= 0.5) != (picture.pixels[k][0] >= 0.5);
    let wrong: Vec<_> = (0..picture.pixels.len()).filter(differs).collect();
    save_visibility(name, &picture, &wrong);
    let width = SIZE[0] as usize;
    let is_edge = |a: [f64; 4], b: [f64; 4]| a[0] != b[0] && a[3] == 1.0 && b[3] == 1.0;
    let edges = (0..frame.pixels.len() - width)
        .filter(|&k| [1, width].into_iter().any(|step| is_edge(frame.pixels[k], frame.pixels[k + step])))
        .count();
    assert!(edges > 200, "{edges} pixels at edges");
    wrong.len() as f64 / edges as f64
}

/// Adds a floor as wide as the light, with nothing below it.
fn on_floor(mut scene: Scene) -> Scene {
    let corners = [(-1.0, -1.0), (-1.0, 1.0), (1.0, 1.0), (1.0, -1.0)];
    let floor = Primitive {
        positions: corners.map(|(x, z)| Vec3::new(x * 12.0, -0.02, z * 12.0)).into(),
        normals: vec![Vec3::Y; 4],
        indices: vec![0, 1, 2, 0, 2, 3],
        ..Primitive::default()
    };
    add_mesh(&mut scene, DAffine3::IDENTITY, vec![floor]);
    scene.check().expect("sound");
    scene
}

/// A map is fitted to a box on a floor. The floor casts no shadow, and is drawn up to the border of the map. Beyond it
/// the floor is lit, at any distance along the light, also if the light is bent.
#[test]
fn a_floor_beyond_the_map_is_lit() {
    let scene = scene::pose(on_floor(boxes(&[([0.3; 3], 0.3, [0.0, 0.28, 0.0])])), 0.0);
    let view = view(DVec3::new(0.4, 4.4, 3.4), DVec3::ZERO);
    let [_, (_, straight)] = pair(DVec3::new(-1.2, 4.2, 1.8), DVec3::ZERO, 26.0);
    let bent = |bow: f64| {
        let last = straight.points().len() - 1;
        straight.clone().map_points(|k, point| {
            let along = k as f64 / last as f64;
            point.position.x += bow * along * (1.0 - along);
        })
    };
    for bow in [0.0, 1.0, -2.0] {
        let light = bent(bow);
        let name = format!("floor-{bow}");
        compare(&scene, &view, &light, &name).assert_right(&name, 5001, 5);
    }
}

/// A light forty times as wide as the objects in it has shadows as sharp as one that fits. The planted fault is crumbs
/// at the light's rim: a map that contains them too has texels as wide as one that is not fitted.
#[test]
fn a_map_is_as_fine_as_what_is_in_the_light() {
    let view = view(DVec3::new(0.05, 0.36, 0.17), DVec3::new(-0.01, 0.0, -0.01));
    // 20 wide at the table, which is half a unit wide.
    let crumb = |x: f64, z: f64| ([1e-3; 3], 0.0, [x, 0.2, z]);
    let crumbs = [crumb(9.0, 0.0), crumb(-9.0, 0.0), crumb(0.0, 9.0), crumb(0.0, -9.0)];
    let source = DVec3::new(0.5, 6.0, 0.3);
    let [(_, spot), _] = pair(source, DVec3::new(0.5, 0.0, 0.3), 59.0);
    let points: Vec<_> = [0.0, 2.0, 4.5, 7.0].map(|z| DVec3::new(0.012 * z * z, 0.0, -z)).into();
    let rotation = looking(source, DVec3::ZERO, DVec3::X);
    let tube =
        Light::bendy(points, vec![10.0; 4]).with_transform(Transform { translation: source, rotation, scale: 1.0 });
    for (name, light) in [("spot", spot), ("tube", tube)] {
        let fitted = displacement(&scene::pose(table(&[]), 0.0), &view, &light, &format!("fitted-{name}"));
        let coarse = displacement(&scene::pose(table(&crumbs), 0.0), &view, &light, &format!("coarse-{name}"));
        println!("{name}: edges displaced by {fitted:.3} pixels fitted, {coarse:.3} with crumbs at the rim");
        assert!(fitted * 4.0 < coarse, "{name}: {fitted} pixels fitted, {coarse} with crumbs at the rim");
        // Nothing is behind a floor that is the lower side of the scene, so the map need not contain it.
        let floored = displacement(&scene::pose(on_floor(table(&[])), 0.0), &view, &light, &format!("floored-{name}"));
        println!("{name}: {floored:.3} pixels over a floor as wide as the light");
        assert!(floored * 4.0 < coarse, "{name}: {floored} pixels over a floor, {coarse} with crumbs at the rim");
    }
}

/// Stripes of shadow continue across the edges between the faces of a wide light, and the floor beside them is evenly
/// lit. A face that was drawn slightly rotated is detected.
#[test]
fn no_line_shows_where_faces_meet() {
    // A floor, and bars above it that are rotated about the light.
    let bars = |turn: f64| {
        let bar = |k: i32| {
            let x = f64::from(k) * 0.5 - 2.0;
            ([0.05, 0.02, 2.2], 0.3 + turn, [x * turn.cos(), 0.9, -x * turn.sin()])
        };
        boxes(&[vec![([5.0, 0.1, 5.0], 0.0, [0.0, -0.1, 0.0])], (0..9).map(bar).collect()].concat())
    };
    let scene = scene::pose(bars(0.0), 0.0);
    let view = view(DVec3::new(2.6, 4.0, 2.4), DVec3::new(1.5, 0.0, 1.3));
    let (source, below) = (DVec3::new(0.0, 2.0, 0.0), DVec3::new(0.02, 0.0, 0.01));
    let tan = 80.0_f64.to_radians().tan();
    for (name, light) in pair(source, below, 80.0) {
        let coordinates = drawn(&scene, &View { aov: Aov::Vw, ..view.clone() }, &light);
        // Below 1 on the front face of the cube.
        let slope = |pixel: usize| {
            let [v, w, ..] = coordinates.pixels[pixel].map(|x| f64::from(x) * tan);
            v.abs().max(w.abs())
        };
        let PictureComparison { picture, compared, wrong } = compare(&scene, &view, &light, &format!("seam-{name}"));
        let at_edge = |pixels: &[usize]| pixels.iter().filter(|&&k| (slope(k) - 1.0).abs() < 0.03).count();
        let (dark, lit) = (at_edge(&compared.dark), at_edge(&compared.lit));
        assert!(dark > 30 && lit > 100, "{name}: {dark} of {} pixels are dark", dark + lit);
        assert_eq!(wrong, [0; 0], "{name}: of {}", compared.count());

        // The planted fault: the picture of the front face if it was drawn rotated by three degrees.
        let turned = drawn(&scene::pose(bars(0.05), 0.0), &view, &light);
        let mut patched = picture;
        for (pixel, value) in patched.pixels.iter_mut().enumerate() {
            if slope(pixel) < 1.0 {
                *value = turned.pixels[pixel];
            }
        }
        let caught = compared.wrong(&patched).len();
        assert!(caught > 100, "{name}: a turned front changes only {caught} of {}", compared.count());
    }
}

/// A floor shadows the light that passes through it: the region above it where the light bends back up, or the whole
/// scene if the light comes from below.
#[test]
fn floors_shade_what_is_behind_them() {
    let scene = scene::pose(
        on_floor(boxes(&[([0.5, 0.5, 0.05], 0.3, [1.5, 0.6, 0.0]), ([0.2, 0.2, 0.2], 0.1, [-1.0, 0.4, 0.2])])),
        0.0,
    );
    let view = view(DVec3::new(-1.0, 1.6, 3.4), DVec3::new(0.4, 0.3, 0.0));
    // Down through the floor and up again behind it.
    let points = [[0.0, 0.0, 0.0], [0.4, -1.0, 0.0], [1.2, -1.5, -0.2], [2.2, -0.4, -0.3], [2.6, 1.5, -0.4]];
    let dipping = Light::bendy(points.map(DVec3::from_array).to_vec(), vec![0.3, 0.35, 0.4, 0.4, 0.5])
        .with(TRANSLATION, DVec3::new(-1.2, 1.2, 0.3));
    let [(_, below), (_, bent_below)] = pair(DVec3::new(0.2, -1.5, 0.3), DVec3::new(0.3, 0.5, 0.2), 50.0);
    for (name, light) in [("dipping", dipping), ("below", below), ("bent below", bent_below)] {
        compare(&scene, &view, &light, name).assert_right(name, 0, 301);
    }
}

/// The GPU, the reference and picks share one posed scene: none of them poses it again.
#[test]
fn a_scene_is_posed_once() {
    let scene = scene::pose(room(), 0.0);
    let mut renderer = renderer();
    renderer.set_scene(&scene).expect("it fits");
    let reference = Reference::new(Arc::clone(&scene));
    assert_eq!(Arc::strong_count(&scene), 3, "one each, and this one");
    // A pick, by the reference's hierarchy.
    let above = DVec3::new(0.3, 1.8, 0.2) - scene.origin_in_world;
    let hit = reference.bvh.first_hit(above, DVec3::NEG_Y, [0.0, 10.0], |_| true).expect("the floor");
    assert!((hit.distance - 1.8).abs() < 1e-12, "{}", hit.distance);
    assert!(Arc::ptr_eq(&reference.bvh.posed, &scene));
    // Another scene releases it.
    renderer.set_scene(&scene::pose(Scene::default(), 0.0)).expect("it fits");
    assert_eq!(Arc::strong_count(&scene), 2);
}
