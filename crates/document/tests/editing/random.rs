//! Random commands, most of them valid in their document.

use std::sync::Arc;

use document::{AssetHash, CameraId, CameraParameter, Command, Document, LightPin, PinId};
use drag::{Drag, DragPin, Feature, PinKind, PinTarget, RadiusMode, Viewport};
use glam::{DQuat, DVec2, DVec3};
use light::parameters::{
    COLOR, CONE_ANGLE, CONE_SOFTNESS, DECAY, DIRECTION, END_MODE, FRAME, HEIGHT, INTENSITY, NAME, POINT_COLOR,
    POINT_INTENSITY, POSITION, RADIUS, RANGE, ROTATION, SCALE, TRANSLATION, UP, WIDTH,
};
use light::{CheckedLight, Decay, DirectionMode, EndMode, FrameMode, Light, LightId, Setting};
use proptest::collection::vec;
use proptest::prelude::*;
use scene::{Camera, Projection};

/// Generates any command, with light and camera numbers that [`with_existing_ids`] turns into ids. `scenes` can be
/// loaded.
pub fn command(scenes: &'static [AssetHash]) -> impl Strategy<Value = Command> {
    let light = || (0..8_u64).prop_map(LightId);
    let camera = || (0..8_u64).prop_map(CameraId);
    let load =
        move |index: usize| Command::LoadScene { asset: scenes[index % scenes.len()], name: format!("scene {index}") };
    let place_light = (light(), option(vector()), option(rotation()), option(positive()));
    let place_camera = (camera(), option(vector()), option(rotation()));
    let insert = (light(), 0..8_usize, option(vector()), option(small()), option(color()), option(small()));
    prop_oneof![
        1 => (0..8_usize).prop_map(load),
        2 => any_light().prop_map(Command::AddLight),
        1 => light().prop_map(Command::RemoveLight),
        3 => place_light.prop_map(|(light, translation, rotation, scale)| {
            Command::PlaceLight { light, translation, rotation, scale, ignore_pins: true }
        }),
        8 => (light(), light_parameter()).prop_map(|(light, setting)| Command::SetLight { light, setting, ignore_pins: true }),
        8 => (light(), 0..6_usize, point_parameter())
            .prop_map(|(light, point, setting)| Command::SetPoint { light, point, setting, ignore_pins: true }),
        2 => (light(), 0..6_usize, vector(), any::<bool>()).prop_map(|(light, point, position, radii_follow)| {
            Command::DragPoint { light, point, position, radii_follow, ignore_pins: true }
        }),
        1 => (light(), feature_drag())
            .prop_map(|(light, drag)| Command::DragFeature { light, drag: Box::new(drag) }),
        2 => (light(), pin()).prop_map(|(light, pin)| Command::AddPin(LightPin { light, pin })),
        1 => (0..8_u64).prop_map(|pin| Command::RemovePin(PinId(pin))),
        1 => (0..8_u64, any::<bool>()).prop_map(|(pin, is_hard)| Command::SetPin { pin: PinId(pin), is_hard }),
        3 => insert.prop_map(|(light, point, position, radius, color, intensity)| {
            Command::InsertPoint { light, point, position, radius, color, intensity, ignore_pins: true }
        }),
        2 => (light(), 0..6_usize).prop_map(|(light, point)| Command::RemovePoint { light, point, ignore_pins: true }),
        1 => (light(), 0..5_usize, option(positive()), option(1.0..80.0), option(vector())).prop_map(
            |(light, segments, range, cone_angle, toward)| {
                Command::BendLight { light, segments, range, cone_angle, toward, ignore_pins: true }
            }
        ),
        1 => light().prop_map(|light| Command::StraightenLight { light, ignore_pins: true }),
        1 => any_camera().prop_map(Command::AddCamera),
        1 => camera().prop_map(Command::RemoveCamera),
        2 => place_camera.prop_map(|(camera, translation, rotation)| {
            Command::PlaceCamera { camera, translation, rotation }
        }),
        2 => (camera(), camera_parameter())
            .prop_map(|(camera, parameter)| Command::SetCamera { camera, parameter }),
    ]
}

/// Replaces numbers in the command by ids that `document` has, if it has any.
pub fn with_existing_ids(mut command: Command, document: &Document) -> Command {
    let lights: Vec<LightId> = document.lights().keys().copied().collect();
    let cameras: Vec<CameraId> = document.cameras().keys().copied().collect();
    let pins: Vec<PinId> = document.pins().keys().copied().collect();
    match &mut command {
        Command::RemoveLight(light)
        | Command::PlaceLight { light, .. }
        | Command::SetLight { light, .. }
        | Command::SetPoint { light, .. }
        | Command::DragPoint { light, .. }
        | Command::DragFeature { light, .. }
        | Command::AddPin(LightPin { light, .. })
        | Command::InsertPoint { light, .. }
        | Command::RemovePoint { light, .. }
        | Command::BendLight { light, .. }
        | Command::StraightenLight { light, .. } => {
            *light = *lights.get(light.0 as usize % lights.len().max(1)).unwrap_or(light);
        }
        Command::RemoveCamera(camera) | Command::PlaceCamera { camera, .. } | Command::SetCamera { camera, .. } => {
            *camera = *cameras.get(camera.0 as usize % cameras.len().max(1)).unwrap_or(camera);
        }
        Command::RemovePin(pin) | Command::SetPin { pin, .. } => {
            *pin = *pins.get(pin.0 as usize % pins.len().max(1)).unwrap_or(pin);
        }
        Command::LoadScene { .. } | Command::AddLight(_) | Command::AddCamera(_) => {}
    }
    command
}

/// Generates drags of a feature. Its solution is not available here, so a document refuses it.
fn feature_drag() -> impl Strategy<Value = Drag> {
    let feature =
        prop_oneof![Just(Feature::Shadow), Just(Feature::Hotspot), Just(Feature::Highlight), Just(Feature::Diffuse)];
    let radii = prop_oneof![Just(RadiusMode::Keep), Just(RadiusMode::Solve), Just(RadiusMode::Follow)];
    let view = (any_camera(), [1..4096_u32, 1..4096]).prop_map(|(camera, size)| Viewport { camera, size });
    let way = [-1.0..4096.0, -1.0..4096.0, -1.0..4096.0, -1.0..4096.0];
    (feature, option(vec(0..6_usize, 0..4)), radii, view, way, any::<bool>()).prop_map(
        |(feature, points, radii, view, [from_x, from_y, to_x, to_y], source_outside)| {
            let (from, to) = (DVec2::new(from_x, from_y), DVec2::new(to_x, to_y));
            Drag { feature, points, radii, view, from, to, pins: None, source_outside, choice: None }
        },
    )
}

fn pin() -> impl Strategy<Value = DragPin> {
    let kind = prop_oneof![
        Just(PinKind::Direction),
        Just(PinKind::Look),
        Just(PinKind::Lit),
        Just(PinKind::Shadowed),
        Just(PinKind::Shadow),
        Just(PinKind::Coordinates)
    ];
    let fields = (kind, vector(), option(name()), any::<bool>());
    fields.prop_map(|(kind, at, caster, is_hard)| DragPin { kind, at: PinTarget::Point(at), caster, is_hard })
}

fn option<T: std::fmt::Debug>(value: impl Strategy<Value = T>) -> impl Strategy<Value = Option<T>> {
    proptest::option::of(value)
}

/// Generates a number, often one of a few, so that a command may set the present value.
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

/// Generates a valid light: commands take no other.
fn any_light() -> impl Strategy<Value = Arc<CheckedLight>> {
    let bendy = vec((-0.3..0.3, -0.3..0.3, 0.05..0.3), 2..6).prop_map(|steps| {
        let along = |i: usize, (x, y): (f64, f64)| DVec3::new(x, y, -(i as f64 + 1.0));
        let bends = steps.iter().enumerate().map(|(i, &(x, y, _))| along(i, (x, y)));
        let points: Vec<DVec3> = std::iter::once(DVec3::ZERO).chain(bends).collect();
        let radii = std::iter::once(0.1).chain(steps.iter().map(|step| step.2)).collect();
        Light::bendy(points, radii)
    });
    let with_range = |light: fn() -> Light| {
        let fields = (color(), option(positive()));
        fields.prop_map(move |(color, range)| light().with(COLOR, color).with(RANGE, range))
    };
    let directional = (color(), option(positive()), option(positive())).prop_map(|(color, width, height)| {
        Light::directional().with(COLOR, color).with(WIDTH, width).with(HEIGHT, height)
    });
    let shapes = prop_oneof![3 => bendy.boxed(), 1 => with_range(Light::spot).boxed(), 1 => with_range(Light::omni).boxed(), 1 => directional.boxed()];
    (name(), shapes)
        .prop_filter_map("folds", |(name, light)| CheckedLight::new(light.with(NAME, name)).ok().map(Arc::new))
}

fn light_parameter() -> impl Strategy<Value = Setting> {
    prop_oneof![
        name().prop_map(|name| NAME.to(name)),
        vector().prop_map(|translation| TRANSLATION.to(translation)),
        rotation().prop_map(|rotation| ROTATION.to(rotation)),
        real().prop_map(|scale| SCALE.to(scale)),
        (0.0..100.0).prop_map(|angle| CONE_ANGLE.to(angle)),
        (0.0..1.1).prop_map(|softness| CONE_SOFTNESS.to(softness)),
        prop_oneof![Just(Decay::None), Just(Decay::Linear), Just(Decay::InverseSquare)]
            .prop_map(|decay| DECAY.to(decay)),
        vector().prop_map(|up| UP.to(up)),
        prop_oneof![Just(FrameMode::RotationMinimizing), Just(FrameMode::Up)].prop_map(|frame| FRAME.to(frame)),
        prop_oneof![Just(DirectionMode::Tube), Just(DirectionMode::Path)].prop_map(|towards| DIRECTION.to(towards)),
        prop_oneof![Just(EndMode::Cut), Just(EndMode::Extend)].prop_map(|end| END_MODE.to(end)),
        color().prop_map(|color| COLOR.to(color)),
        real().prop_map(|intensity| INTENSITY.to(intensity)),
        option(positive()).prop_map(|range| RANGE.to(range)),
        option(positive()).prop_map(|width| WIDTH.to(width)),
        option(positive()).prop_map(|height| HEIGHT.to(height)),
    ]
}

fn point_parameter() -> impl Strategy<Value = Setting> {
    prop_oneof![
        4 => (-0.5..0.5, -0.5..0.5, -6.0..0.0).prop_map(|(x, y, z)| POSITION.to(DVec3::new(x, y, z))),
        3 => small().prop_map(|radius| RADIUS.to(radius)),
        1 => color().prop_map(|color| POINT_COLOR.to(color)),
        1 => real().prop_map(|intensity| POINT_INTENSITY.to(intensity)),
    ]
}

fn projection() -> impl Strategy<Value = Projection> {
    prop_oneof![
        (0.1..3.0, option(0.1..9.0), 0.1..1.0, option(1.0..9.0))
            .prop_map(|(yfov, aspect_ratio, znear, zfar)| Projection::Perspective { yfov, aspect_ratio, znear, zfar }),
        (0.1..3.0, option(0.1..9.0), 0.0..1.0, 0.5..9.0).prop_map(|(ymag, aspect_ratio, znear, zfar)| {
            Projection::Orthographic { ymag, aspect_ratio, znear, zfar }
        }),
    ]
}

fn any_camera() -> impl Strategy<Value = Camera> {
    let fields = (name(), vector(), rotation(), projection());
    fields.prop_map(|(name, translation, rotation, projection)| Camera { name, translation, rotation, projection })
}

fn camera_parameter() -> impl Strategy<Value = CameraParameter> {
    prop_oneof![
        name().prop_map(CameraParameter::Name),
        vector().prop_map(CameraParameter::Translation),
        rotation().prop_map(CameraParameter::Rotation),
        projection().prop_map(CameraParameter::Projection),
    ]
}
