//! Tests that culled triangles never show in a map.

use glam::{DAffine3, DQuat, DVec3};
use light::Light;
use light::parameters::{CONE_ANGLE, ROTATION, TRANSLATION};
use scene::{Material, Primitive, Scene};
use shadow::{Clusters, TRIANGLES_PER_LEAF, TriangleComponent};
use std::f64::consts::PI;

use super::{BACKENDS, add_mesh, alone, cube, light, renderer_of, view};
use crate::{Aov, Backend, Picture, Renderer, WorkCounters};

/// Returns a ball with a seam and poles, counter-clockwise from outside.
fn ball() -> Primitive {
    const ROWS: u32 = 24;
    const COLUMNS: u32 = 48;
    let mut primitive = Primitive::default();
    for row in 0..=ROWS {
        let polar = PI * f64::from(row) / f64::from(ROWS);
        let around = if row == 0 || row == ROWS { 0.0 } else { polar.sin() };
        for column in 0..=COLUMNS {
            let (sine, cosine) = (2.0 * PI * f64::from(column % COLUMNS) / f64::from(COLUMNS)).sin_cos();
            let point = DVec3::new(around * cosine, polar.cos(), -around * sine).as_vec3();
            primitive.positions.push(point);
            primitive.normals.push(point.normalize());
        }
    }
    for (row, column) in (0..ROWS).flat_map(|row| (0..COLUMNS).map(move |column| (row, column))) {
        let at = |i, j| (row + i) * (COLUMNS + 1) + column + j;
        primitive.indices.extend([at(0, 0), at(1, 0), at(1, 1), at(0, 0), at(1, 1), at(0, 1)]);
    }
    primitive
}

/// Center of a ball around a camera, in the light.
const AROUND_THE_EYE: DVec3 = DVec3::new(-0.95, 2.1, -0.25);

/// Returns a scene of balls and boxes in the light over a floor. Some are thin, and some intersect.
fn scene() -> Scene {
    let material = Material { double_sided: true, ..Material::default() };
    let mut scene = Scene { materials: vec![material], ..Scene::default() };
    let mut add = |primitive: Primitive, scale: DVec3, turn: f64, at: DVec3| {
        let rotation = DQuat::from_rotation_z(turn) * DQuat::from_rotation_y(0.7 * turn);
        add_mesh(&mut scene, primitive, DAffine3::from_scale_rotation_translation(scale, rotation, at));
    };
    add(cube(), DVec3::new(8.0, 0.1, 8.0), 0.0, DVec3::Y * -0.6);
    add(ball(), DVec3::splat(0.25), 0.4, AROUND_THE_EYE);
    for k in 0..14 {
        let share = f64::from(k) / 13.0;
        let at = DVec3::new(-1.0 + 2.4 * share, 3.0 - 2.6 * share, -0.6 + 0.5 * (5.0 * share).sin());
        add(ball(), DVec3::new(0.09, 0.03 + 0.1 * share, 0.12), 7.0 * share, at);
        add(cube(), DVec3::new(0.2, 0.01, 0.05), 11.0 * share, at - DVec3::X * 0.1);
        // A negative scale along one axis turns the mesh inside out, and the importer's rule turns it back.
        add(ball(), DVec3::new(0.04, 0.05, -0.04), share, at + DVec3::Z * 0.25);
    }
    scene.check().expect("sound");
    scene
}

fn shadows(renderer: &mut Renderer, light: &Light) -> Picture {
    renderer.render(&view(Aov::Visibility), &alone(light)).expect("drawn")
}

fn with(backend: Backend, change: impl Fn(&mut Clusters)) -> Renderer {
    let mut renderer = renderer_of(backend, &scene());
    change(renderer.clusters());
    renderer
}

/// Counters of drawing the light's map from scratch.
fn counters(renderer: &mut Renderer) -> WorkCounters {
    let (_, recording) = renderer.record_display(&view(Aov::Beauty), &alone(&light())).expect("drawn");
    recording.counters
}

fn all_of(component: TriangleComponent) -> impl Fn(&mut Clusters) {
    move |clusters| clusters.leaves.iter_mut().for_each(|leaf| leaf.component = component)
}

/// Returns one light of each shape, shining down on the scene. One spotlight's map has one face, the other's five.
fn lights() -> Vec<Light> {
    let down = DQuat::from_rotation_x(-PI / 2.0);
    let above = |light: Light| light.with(TRANSLATION, DVec3::new(-0.9, 4.5, -0.2));
    let spot = |cone_angle| above(Light::spot().with(CONE_ANGLE, cone_angle).with(ROTATION, down));
    vec![
        light(),
        light().with(TRANSLATION, DVec3::new(-0.8, 4.2, 0.1)),
        spot(25.0),
        spot(70.0),
        above(Light::omni()),
        Light::directional().with(ROTATION, down * DQuat::from_rotation_y(0.2)),
    ]
}

/// Back faces of closed components are culled, and every shadow stays the same bit for bit, from outside and from
/// inside a component, where all is dark.
#[test]
fn backs_of_closed_surfaces_show_nowhere() {
    let outside = view(Aov::Visibility);
    let mut inside = outside.clone();
    inside.camera.translation = AROUND_THE_EYE;
    for backend in BACKENDS {
        let mut culled = with(backend, |_| ());
        let leaves = &culled.clusters().leaves;
        assert!(leaves.iter().all(|leaf| leaf.component == TriangleComponent::Closed), "{leaves:?}");
        let mut whole = with(backend, all_of(TriangleComponent::Open));
        // Deliberate fault that the check must detect: with front faces culled instead, light leaks into closed
        // components.
        let mut leaking = with(backend, all_of(TriangleComponent::InsideOut));
        for light in lights() {
            let draw = |renderer: &mut Renderer, view| renderer.render(view, &alone(&light)).expect("drawn");
            for view in [&outside, &inside] {
                let expected = draw(&mut whole, view);
                let shadowed = expected.pixels.iter().filter(|pixel| pixel[0] < 1.0).count();
                assert!(shadowed > 1000, "{backend:?}: {shadowed} pixels in shadow");
                assert!(draw(&mut culled, view) == expected, "{backend:?}: {light:?}");
            }
            assert_eq!(lit(&draw(&mut culled, &inside)), 0, "{backend:?}: within a ball, {light:?}");
            let leaks = lit(&draw(&mut leaking, &inside));
            assert!(leaks > 1000, "{backend:?}: the fault shows in {leaks} pixels only, {light:?}");
        }
    }
}

fn lit(picture: &Picture) -> usize {
    picture.pixels.iter().filter(|pixel| pixel[3] == 1.0 && pixel[0] > 0.0).count()
}

/// Half of the triangles near the light are drawn if all components are closed.
#[test]
fn backs_are_not_drawn() {
    for backend in BACKENDS {
        let [fewer, all] = [with(backend, |_| ()), with(backend, all_of(TriangleComponent::Open))]
            .map(|mut renderer| counters(&mut renderer));
        assert_eq!(fewer.triangles_seen, all.triangles_seen);
        let share = fewer.triangles_drawn as f64 / all.triangles_drawn as f64;
        // Boxes and balls have as many front faces as back faces, except for split triangles and triangles too thin to
        // decide.
        assert!((0.4..0.6).contains(&share), "{backend:?}: {share} of {}", all.triangles_drawn);
    }
}

/// A light that begins inside a closed component hits its back faces.
#[test]
fn light_from_within_hits_backs() {
    let mut around = scene();
    add_mesh(&mut around, ball(), DAffine3::from_translation(light().get(TRANSLATION)));
    for backend in BACKENDS {
        let mut renderer = renderer_of(backend, &around);
        let leaks = lit(&shadows(&mut renderer, &light()));
        assert_eq!(leaks, 0, "{backend:?}: all that light would reach lies behind the ball");
        let clusters = renderer.clusters();
        // Deliberate fault that the check must detect: bounds of the ball that do not contain the light.
        for leaf in &mut clusters.leaves {
            leaf.component_bounds.center += DVec3::splat(100.0);
        }
        let moved = light().with(TRANSLATION, light().get(TRANSLATION) + DVec3::splat(1e-3));
        let leaks = lit(&shadows(&mut renderer, &moved));
        assert!(leaks > 200, "{backend:?}: {leaks}");
    }
}

/// Triangles far from the light are not processed.
#[test]
fn casters_far_from_the_light_are_not_processed() {
    let mut far = scene();
    for k in 0..40 {
        let at = DVec3::new(-6.0 + 0.3 * f64::from(k), 0.5, 6.0);
        add_mesh(&mut far, ball(), DAffine3::from_translation(at));
    }
    for backend in BACKENDS {
        let near = counters(&mut renderer_of(backend, &scene()));
        let both = counters(&mut renderer_of(backend, &far));
        // More triangles divide into leaves elsewhere, so a few other leaves may reach into the light.
        let most = near.triangles_seen + 20 * TRIANGLES_PER_LEAF as u64;
        assert!(near.triangles_seen > 0 && both.triangles_seen <= most, "{near:?}, then {both:?}");
    }
}
