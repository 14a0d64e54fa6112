//! Parameters of a document: the rows of lights, control points and cameras, and their addresses.

use std::fmt;

use light::{LightId, MAX_NAME_BYTES, Parameter, ParameterKind, ParameterOf, ParameterOwner, ParameterTouches};

use crate::CameraId;

/// Entry for cameras in the owners of a parameter. A change of a camera invalidates no picture, because views have
/// cameras of their own.
const OF_CAMERA: &[ParameterOf] =
    &[ParameterOf { owner: ParameterOwner::Camera, default: None, touches: ParameterTouches::Nothing }];

const CAMERA: Parameter = Parameter {
    name: "",
    path: "",
    owners: OF_CAMERA,
    kind: ParameterKind::Projection,
    animates: true,
    needs: None,
    group: "Camera",
    label: "",
    doc: "",
};

/// Parameters of cameras. [`crate::CameraParameter`] holds their values.
static CAMERA_ROWS: &[&Parameter] = &[
    &Parameter {
        name: "name",
        path: "name",
        kind: ParameterKind::Text { max_bytes: MAX_NAME_BYTES },
        animates: false,
        label: "Name",
        doc: "Name for people and for `--camera`.",
        ..CAMERA
    },
    &Parameter {
        name: "translation",
        path: "translation",
        kind: ParameterKind::Vector { unit: "world units", step: 0.01 },
        label: "Position",
        doc: "World position of the eye.",
        ..CAMERA
    },
    &Parameter {
        name: "rotation",
        path: "rotation",
        kind: ParameterKind::Rotation,
        label: "Rotation",
        doc: "Rotation from camera to world axes. A camera looks along its local -Z with +Y up.",
        ..CAMERA
    },
    &Parameter {
        name: "projection",
        path: "projection",
        label: "Projection",
        doc: "How it projects: perspective or orthographic, with its angle or size, shape and planes.",
        ..CAMERA
    },
];

/// Returns all parameters.
pub fn parameters() -> impl Iterator<Item = &'static Parameter> {
    light::parameters().iter().chain(CAMERA_ROWS).copied()
}

/// Object in a document that has parameters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ParameterTarget {
    Light(LightId),
    /// Control point, by its index.
    Point(LightId, usize),
    Camera(CameraId),
}

impl fmt::Display for ParameterTarget {
    /// Writes the target's part of an address: `/lights/3`, `/lights/3/points/2`, `/cameras/1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Light(light) => write!(f, "/lights/{light}"),
            Self::Point(light, point) => write!(f, "/lights/{light}/points/{point}"),
            Self::Camera(camera) => write!(f, "/cameras/{camera}"),
        }
    }
}

impl ParameterTarget {
    /// Parses an address into its target and the name of the parameter; `None` if it is not an address. An address is a
    /// JSON pointer into the document, with ids instead of list indices: `/lights/3/coneAngle`,
    /// `/lights/3/points/2/position`.
    pub fn from_address(address: &str) -> Option<(Self, &str)> {
        let parts: Vec<&str> = address.strip_prefix('/')?.split('/').collect();
        // Canonical digits: no sign, no leading zero.
        let number = |text: &str| text.parse().ok().filter(|number: &u64| number.to_string() == text);
        match parts[..] {
            ["lights", light, "points", point, name] => {
                let point = usize::try_from(number(point)?).ok()?;
                Some((Self::Point(LightId(number(light)?), point), name))
            }
            ["lights", light, name] => Some((Self::Light(LightId(number(light)?)), name)),
            ["cameras", camera, name] => Some((Self::Camera(CameraId(number(camera)?)), name)),
            _ => None,
        }
    }
}
