//! All that can be set in a document: the rows of lights and control points, and those of cameras; and what one of them
//! is called in a document.

use std::fmt;

use light::{Kind, LightId, MAX_NAME_BYTES, Of, Owner, Parameter, Touches};

use crate::CameraId;

/// Of a camera: no picture shows its change, views have cameras of their own.
const OF_CAMERA: &[Of] = &[Of { owner: Owner::Camera, default: None, touches: Touches::Nothing }];

const CAMERA: Parameter = Parameter {
    name: "",
    path: "",
    of: OF_CAMERA,
    kind: Kind::Projection,
    animates: true,
    needs: None,
    group: "Camera",
    label: "",
    doc: "",
};

/// The rows of cameras, whose values [`crate::CameraParameter`] holds.
static CAMERA_ROWS: &[&Parameter] = &[
    &Parameter {
        name: "name",
        path: "name",
        kind: Kind::Text { max_bytes: MAX_NAME_BYTES },
        animates: false,
        label: "Name",
        doc: "Name for people and for `--camera`.",
        ..CAMERA
    },
    &Parameter {
        name: "translation",
        path: "translation",
        kind: Kind::Vector { unit: "world units", step: 0.01 },
        label: "Position",
        doc: "World position of the eye.",
        ..CAMERA
    },
    &Parameter {
        name: "rotation",
        path: "rotation",
        kind: Kind::Rotation,
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

/// Every row.
pub fn parameters() -> impl Iterator<Item = &'static Parameter> {
    light::parameters().iter().chain(CAMERA_ROWS).copied()
}

/// What has parameters in a document.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// A light.
    Light(LightId),
    /// A control point, by its index.
    Point(LightId, usize),
    /// A camera.
    Camera(CameraId),
}

impl fmt::Display for Target {
    /// Its part of an address: `/lights/3`, `/lights/3/points/2`, `/cameras/1`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Light(light) => write!(f, "/lights/{light}"),
            Self::Point(light, point) => write!(f, "/lights/{light}/points/{point}"),
            Self::Camera(camera) => write!(f, "/cameras/{camera}"),
        }
    }
}

impl Target {
    /// What an address names, and the name of the parameter; `None` where it is none. An address is a JSON pointer into the
    /// document, with ids in place of places in lists: `/lights/3/coneAngle`, `/lights/3/points/2/position`.
    pub fn of_address(address: &str) -> Option<(Self, &str)> {
        let parts: Vec<&str> = address.strip_prefix('/')?.split('/').collect();
        // As numbers are written: no sign, no leading zero.
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
