//! Parameters of cameras: reading and setting.

use scene::Camera;

use crate::CameraParameter;

/// Returns the value of `camera` for the parameter of `like`.
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
