//! The properties of lights, control points and cameras: what each is now, and setting it.

use light::{BendyLight, SpotLight};

use crate::{CameraParameter, LightParameter, PointParameter};
use light::{Light, LightKind};
use scene::Camera;

/// The value that `light` has of the same parameter as `like`; `None` where its kind has no such parameter.
pub fn light_parameter(light: &Light, like: &LightParameter) -> Option<LightParameter> {
    use LightParameter as P;
    let (transform, cone_angle, cone_softness, decay) = match &light.kind {
        LightKind::Bendy(b) => (&b.transform, b.cone_angle, b.cone_softness, b.decay),
        LightKind::Spot(s) => (&s.transform, s.cone_angle, s.cone_softness, s.decay),
    };
    Some(match (like, &light.kind) {
        (P::Name(_), _) => P::Name(light.name.clone()),
        (P::Translation(_), _) => P::Translation(transform.translation),
        (P::Rotation(_), _) => P::Rotation(transform.rotation),
        (P::Scale(_), _) => P::Scale(transform.scale),
        (P::ConeAngle(_), _) => P::ConeAngle(cone_angle),
        (P::ConeSoftness(_), _) => P::ConeSoftness(cone_softness),
        (P::Decay(_), _) => P::Decay(decay),
        (P::Up(_), LightKind::Bendy(bendy)) => P::Up(bendy.up),
        (P::Frame(_), LightKind::Bendy(bendy)) => P::Frame(bendy.frame),
        (P::Direction(_), LightKind::Bendy(bendy)) => P::Direction(bendy.direction),
        (P::EndMode(_), LightKind::Bendy(bendy)) => P::EndMode(bendy.end_mode),
        (P::Color(_), LightKind::Spot(spot)) => P::Color(spot.color),
        (P::Intensity(_), LightKind::Spot(spot)) => P::Intensity(spot.intensity),
        (P::Range(_), LightKind::Spot(spot)) => P::Range(spot.range),
        _ => return None,
    })
}

/// Sets what the light's kind has; the caller has seen that it has it.
pub fn set_light(light: &mut Light, parameter: &LightParameter) {
    use LightParameter as P;
    let (transform, cone_angle, cone_softness, decay) = match &mut light.kind {
        LightKind::Bendy(b) => (&mut b.transform, &mut b.cone_angle, &mut b.cone_softness, &mut b.decay),
        LightKind::Spot(s) => (&mut s.transform, &mut s.cone_angle, &mut s.cone_softness, &mut s.decay),
    };
    match parameter {
        P::Name(name) => light.name.clone_from(name),
        P::Translation(translation) => transform.translation = *translation,
        P::Rotation(rotation) => transform.rotation = *rotation,
        P::Scale(scale) => transform.scale = *scale,
        P::ConeAngle(degrees) => *cone_angle = *degrees,
        P::ConeSoftness(share) => *cone_softness = *share,
        P::Decay(new) => *decay = *new,
        P::Up(_) | P::Frame(_) | P::Direction(_) | P::EndMode(_) => {
            if let LightKind::Bendy(bendy) = &mut light.kind {
                set_bendy(bendy, parameter);
            }
        }
        P::Color(_) | P::Intensity(_) | P::Range(_) => {
            if let LightKind::Spot(spot) = &mut light.kind {
                set_spot(spot, parameter);
            }
        }
    }
}

fn set_bendy(bendy: &mut BendyLight, parameter: &LightParameter) {
    match *parameter {
        LightParameter::Up(up) => bendy.up = up,
        LightParameter::Frame(frame) => bendy.frame = frame,
        LightParameter::Direction(direction) => bendy.direction = direction,
        LightParameter::EndMode(end_mode) => bendy.end_mode = end_mode,
        _ => {}
    }
}

fn set_spot(spot: &mut SpotLight, parameter: &LightParameter) {
    match *parameter {
        LightParameter::Color(color) => spot.color = color,
        LightParameter::Intensity(intensity) => spot.intensity = intensity,
        LightParameter::Range(range) => spot.range = range,
        _ => {}
    }
}

/// The value that control point `point` has of the same parameter as `like`; `None` where there is no such point.
pub fn point_parameter(bendy: &BendyLight, point: usize, like: &PointParameter) -> Option<PointParameter> {
    Some(match like {
        PointParameter::Position(_) => PointParameter::Position(*bendy.points.get(point)?),
        PointParameter::Radius(_) => PointParameter::Radius(*bendy.radii.get(point)?),
        PointParameter::Color(_) => PointParameter::Color(*bendy.colors.get(point)?),
        PointParameter::Intensity(_) => PointParameter::Intensity(*bendy.intensities.get(point)?),
    })
}

pub fn set_point(bendy: &mut BendyLight, point: usize, parameter: PointParameter) {
    match parameter {
        PointParameter::Position(position) => bendy.points[point] = position,
        PointParameter::Radius(radius) => bendy.radii[point] = radius,
        PointParameter::Color(color) => bendy.colors[point] = color,
        PointParameter::Intensity(intensity) => bendy.intensities[point] = intensity,
    }
}

pub fn camera_parameter(camera: &Camera, like: &CameraParameter) -> CameraParameter {
    match like {
        CameraParameter::Name(_) => CameraParameter::Name(camera.name.clone()),
        CameraParameter::Translation(_) => CameraParameter::Translation(camera.translation),
        CameraParameter::Rotation(_) => CameraParameter::Rotation(camera.rotation),
        CameraParameter::Projection(_) => CameraParameter::Projection(camera.projection),
    }
}

pub fn set_camera(camera: &mut Camera, parameter: &CameraParameter) {
    match parameter {
        CameraParameter::Name(name) => camera.name.clone_from(name),
        CameraParameter::Translation(translation) => camera.translation = *translation,
        CameraParameter::Rotation(rotation) => camera.rotation = *rotation,
        CameraParameter::Projection(projection) => camera.projection = *projection,
    }
}
