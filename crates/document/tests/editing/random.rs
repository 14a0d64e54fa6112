//! Commands at random: most of them valid in the document that they are aimed at, some not.

use document::{AssetHash, CameraId, CameraParameter, Command, Document, LightParameter, PointParameter};
use glam::{DQuat, DVec3};
use light::{BendyLight, Decay, Direction, EndMode, Frame, SpotLight};
use light::{Light, LightId, LightKind};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::{Camera, Projection};

/// Any command, of light and camera numbers that [`aimed`] turns into ids. `scenes` are those that can be loaded.
pub fn command(scenes: &'static [AssetHash]) -> impl Strategy<Value = Command> {
    let light = || (0..8_u64).prop_map(LightId);
    let camera = || (0..8_u64).prop_map(CameraId);
    let load = move |index: usize| Command::LoadScene {
        asset: scenes[index % scenes.len()],
        name: format!("scene {index}"),
    };
    let place_light = (light(), option(vector()), option(rotation()), option(positive()));
    let place_camera = (camera(), option(vector()), option(rotation()));
    let insert = (light(), 0..8_usize, option(vector()), option(small()), option(color()), option(small()));
    prop_oneof![
        1 => (0..8_usize).prop_map(load),
        2 => any_light().prop_map(|light| Command::AddLight(Box::new(light))),
        1 => light().prop_map(Command::RemoveLight),
        3 => place_light.prop_map(|(light, translation, rotation, scale)| {
            Command::PlaceLight { light, translation, rotation, scale }
        }),
        8 => (light(), light_parameter()).prop_map(|(light, parameter)| Command::SetLight { light, parameter }),
        8 => (light(), 0..6_usize, point_parameter())
            .prop_map(|(light, point, parameter)| Command::SetPoint { light, point, parameter }),
        3 => insert.prop_map(|(light, point, position, radius, color, intensity)| {
            Command::InsertPoint { light, point, position, radius, color, intensity }
        }),
        2 => (light(), 0..6_usize).prop_map(|(light, point)| Command::RemovePoint { light, point }),
        1 => any_camera().prop_map(Command::AddCamera),
        1 => camera().prop_map(Command::RemoveCamera),
        2 => place_camera.prop_map(|(camera, translation, rotation)| {
            Command::PlaceCamera { camera, translation, rotation }
        }),
        2 => (camera(), camera_parameter())
            .prop_map(|(camera, parameter)| Command::SetCamera { camera, parameter }),
    ]
}

/// The command with its numbers turned into ids that `document` has, where it has any.
pub fn aimed(mut command: Command, document: &Document) -> Command {
    let lights: Vec<LightId> = document.lights().keys().copied().collect();
    let cameras: Vec<CameraId> = document.cameras().keys().copied().collect();
    match &mut command {
        Command::RemoveLight(light)
        | Command::PlaceLight { light, .. }
        | Command::SetLight { light, .. }
        | Command::SetPoint { light, .. }
        | Command::InsertPoint { light, .. }
        | Command::RemovePoint { light, .. } => {
            *light = *lights.get(light.0 as usize % lights.len().max(1)).unwrap_or(light);
        }
        Command::RemoveCamera(camera)
        | Command::PlaceCamera { camera, .. }
        | Command::SetCamera { camera, .. } => {
            *camera = *cameras.get(camera.0 as usize % cameras.len().max(1)).unwrap_or(camera);
        }
        Command::LoadScene { .. } | Command::AddLight(_) | Command::AddCamera(_) => {}
    }
    command
}

fn option<T: std::fmt::Debug>(value: impl Strategy<Value = T>) -> impl Strategy<Value = Option<T>> {
    proptest::option::of(value)
}

/// Often the same few numbers, so that a command may find its value already there.
fn real() -> impl Strategy<Value = f64> {
    prop_oneof![Just(0.0), Just(-0.0), Just(1.0), -4.0..4.0]
}

fn small() -> impl Strategy<Value = f64> {
    prop_oneof![9 => 0.0..0.3, 1 => Just(-1.0)]
}

fn positive() -> impl Strategy<Value = f64> {
    0.1..4.0
}

fn vector() -> impl Strategy<Value = DVec3> {
    (real(), real(), real()).prop_map(|(x, y, z)| DVec3::new(x, y, z))
}

fn color() -> impl Strategy<Value = DVec3> {
    (0.0..2.0, 0.0..2.0, 0.0..2.0).prop_map(|(r, g, b)| DVec3::new(r, g, b))
}

fn rotation() -> impl Strategy<Value = DQuat> {
    prop_oneof![
        9 => (vector(), -3.0..3.0).prop_map(|(axis, angle)| {
            DQuat::from_axis_angle(axis.try_normalize().unwrap_or(DVec3::Y), angle)
        }),
        1 => Just(DQuat::from_xyzw(0.0, 0.0, 0.0, 0.0)),
    ]
}

fn name() -> impl Strategy<Value = String> {
    "[a-z\"\\\\\u{e9}]{0,6}"
}

fn any_light() -> impl Strategy<Value = Light> {
    let bendy = vec((-0.3..0.3, -0.3..0.3, 0.05..0.3), 2..6).prop_map(|steps| {
        let along = |i: usize, (x, y): (f64, f64)| DVec3::new(x, y, -(i as f64 + 1.0));
        let bends = steps.iter().enumerate().map(|(i, &(x, y, _))| along(i, (x, y)));
        let points: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(bends).collect();
        let radii = std::iter::once(0.1).chain(steps.iter().map(|step| step.2)).collect();
        LightKind::Bendy(BendyLight::new(points, radii))
    });
    let spot = (color(), option(positive()))
        .prop_map(|(color, range)| LightKind::Spot(SpotLight { color, range, ..SpotLight::default() }));
    (name(), prop_oneof![3 => bendy.boxed(), 1 => spot.boxed()]).prop_map(|(name, kind)| Light { name, kind })
}

fn light_parameter() -> impl Strategy<Value = LightParameter> {
    use LightParameter as P;
    prop_oneof![
        name().prop_map(P::Name),
        vector().prop_map(P::Translation),
        rotation().prop_map(P::Rotation),
        real().prop_map(P::Scale),
        (0.0..100.0).prop_map(P::ConeAngle),
        (0.0..1.1).prop_map(P::ConeSoftness),
        prop_oneof![Just(Decay::None), Just(Decay::Linear), Just(Decay::InverseSquare)].prop_map(P::Decay),
        vector().prop_map(P::Up),
        prop_oneof![Just(Frame::RotationMinimizing), Just(Frame::Up)].prop_map(P::Frame),
        prop_oneof![Just(Direction::Tube), Just(Direction::Path)].prop_map(P::Direction),
        prop_oneof![Just(EndMode::Cut), Just(EndMode::Extend)].prop_map(P::EndMode),
        color().prop_map(P::Color),
        real().prop_map(P::Intensity),
        option(positive()).prop_map(P::Range),
    ]
}

fn point_parameter() -> impl Strategy<Value = PointParameter> {
    use PointParameter as P;
    prop_oneof![
        4 => (-0.5..0.5, -0.5..0.5, -6.0..0.0).prop_map(|(x, y, z)| P::Position(DVec3::new(x, y, z))),
        3 => small().prop_map(P::Radius),
        1 => color().prop_map(P::Color),
        1 => real().prop_map(P::Intensity),
    ]
}

fn projection() -> impl Strategy<Value = Projection> {
    prop_oneof![
        (0.1..3.0, option(0.1..9.0), 0.1..1.0, option(1.0..9.0)).prop_map(
            |(yfov, aspect_ratio, znear, zfar)| Projection::Perspective { yfov, aspect_ratio, znear, zfar }
        ),
        (0.1..3.0, option(0.1..9.0), 0.0..1.0, 0.5..9.0).prop_map(|(ymag, aspect_ratio, znear, zfar)| {
            Projection::Orthographic { ymag, aspect_ratio, znear, zfar }
        }),
    ]
}

fn any_camera() -> impl Strategy<Value = Camera> {
    (name(), vector(), rotation(), projection()).prop_map(|(name, translation, rotation, projection)| {
        Camera { name, translation, rotation, projection }
    })
}

fn camera_parameter() -> impl Strategy<Value = CameraParameter> {
    prop_oneof![
        name().prop_map(CameraParameter::Name),
        vector().prop_map(CameraParameter::Translation),
        rotation().prop_map(CameraParameter::Rotation),
        projection().prop_map(CameraParameter::Projection),
    ]
}
