//! Scenes that are difficult for bent shadow maps, each in a different way.

use glam::{DAffine3, DQuat, DVec3};
use light::Light;
use light::parameters::TRANSLATION;
use scene::{Material, Scene, View};

use crate::compare::ComparisonSubject;
use crate::solids::{GREY, PlacedPrimitive, ball, block, camera, scene_of, square};

/// Makes all subjects, `width` x `height` pixels.
pub(crate) fn subjects(width: u32, height: u32) -> Vec<ComparisonSubject> {
    let view = view(width, height);
    let subject = |name, parts, light| ComparisonSubject::new(name, grey_scene(parts), light, view.clone());
    vec![
        subject("straight", still_life(), straight()),
        subject("bent", still_life(), bent()),
        subject("tapered", still_life(), tapered()),
        subject("large", beams(), bent()),
        subject("leaves", leaves(), bent()),
    ]
}

/// Returns the view from above, so that the floor shows the whole shadow.
pub(crate) fn view(width: u32, height: u32) -> View {
    let camera = camera(DVec3::new(0.6, 6.2, 5.2), DVec3::new(0.6, 0.4, 0.2), 0.4, 0.1);
    View::beauty(camera, [width, height])
}

/// Returns a light through world positions.
fn light<const N: usize>(points: [[f64; 3]; N], radii: [f64; N]) -> Light {
    let source = DVec3::from_array(points[0]);
    let points = points.map(|point| DVec3::from_array(point) - source).to_vec();
    let light = Light::bendy(points, radii.to_vec()).with(TRANSLATION, source);
    light.map_points(|_, point| point.intensity = 3.0)
}

/// Returns a cone: linear radii on equal steps of a straight line, with the first and last step half as long (light
/// model, section 1).
fn straight() -> Light {
    let (source, end) = (DVec3::new(-2.6, 5.0, 1.2), DVec3::new(2.6, -2.2, -1.0));
    let shares = [0.0, 1.0 / 6.0, 0.5, 5.0 / 6.0, 1.0];
    light(shares.map(|share| source.lerp(end, share).to_array()), shares.map(|share| 2.8 * share))
}

/// Returns a light that starts horizontally and comes down steeply.
fn bent() -> Light {
    light(
        [[-3.4, 2.2, 1.0], [-2.4, 3.6, 0.9], [-0.2, 4.4, 0.5], [1.0, 2.3, 0.1], [1.1, -1.2, -0.2]],
        [0.3, 0.7, 1.0, 1.2, 2.0],
    )
}

/// Returns a light that is wide at its source, narrow in the middle and wide at its end.
fn tapered() -> Light {
    light(
        [[-2.6, 4.4, 1.0], [-1.9, 3.9, 0.8], [-0.6, 3.0, 0.3], [0.6, 1.7, 0.0], [1.3, -1.0, 0.0]],
        [1.3, 1.0, 0.4, 0.9, 2.2],
    )
}

pub(crate) fn place(scale: [f64; 3], turn: f64, at: [f64; 3]) -> DAffine3 {
    let (scale, at) = (DVec3::from_array(scale), DVec3::from_array(at));
    DAffine3::from_scale_rotation_translation(scale, DQuat::from_rotation_y(turn), at)
}

/// Returns a floor of two large triangles.
pub(crate) fn floor() -> PlacedPrimitive {
    let mut floor = square();
    floor.positions.iter_mut().for_each(|corner| *corner *= 6.0);
    PlacedPrimitive(floor, DAffine3::IDENTITY)
}

/// Returns balls and boxes on the floor and above it.
fn still_life() -> Vec<PlacedPrimitive> {
    vec![
        floor(),
        PlacedPrimitive(ball(48), place([0.45; 3], 0.0, [0.2, 0.45, 0.5])),
        PlacedPrimitive(ball(48), place([0.3; 3], 0.0, [1.5, 0.9, -0.5])),
        PlacedPrimitive(block(), place([0.25, 0.6, 0.25], 0.5, [0.9, 0.6, -0.9])),
        PlacedPrimitive(block(), place([0.9, 0.04, 0.06], 0.3, [0.9, 1.3, 0.2])),
        PlacedPrimitive(block(), place([0.05, 0.5, 0.05], 0.2, [1.9, 0.5, 0.6])),
    ]
}

/// Returns long beams that enter and leave the tube, so that most of each lies outside of it.
fn beams() -> Vec<PlacedPrimitive> {
    vec![
        floor(),
        PlacedPrimitive(block(), place([4.0, 0.05, 0.1], 0.4, [0.0, 2.6, 0.2])),
        PlacedPrimitive(block(), place([0.08, 0.06, 4.0], 0.2, [0.2, 1.5, 0.0])),
        PlacedPrimitive(block(), place([0.1, 3.0, 0.1], 0.7, [1.6, 3.0, -0.5])),
    ]
}

/// Returns fifteen hundred small blocks in the air, evenly spaced without repetition (the R3 lattice).
fn leaves() -> Vec<PlacedPrimitive> {
    const PLASTIC: f64 = 1.220_744_084_605_759_5;
    let leaf = |k: u32| {
        let along = |power: i32| (0.5 + f64::from(k) / PLASTIC.powi(power)).fract();
        let at = [-0.6 + 2.6 * along(1), 0.15 + 1.9 * along(2), -1.2 + 2.4 * along(3)];
        PlacedPrimitive(block(), place([0.04, 0.008, 0.025], 6.0 * along(1), at))
    };
    std::iter::once(floor()).chain((0..1500).map(leaf)).collect()
}

/// Makes a grey scene.
pub(crate) fn grey_scene(parts: impl IntoIterator<Item = PlacedPrimitive>) -> Scene {
    scene_of(Material { base_color: GREY, ..Material::default() }, parts)
}
