//! Cameras, and a framing camera for scenes without one.

use glam::{DAffine3, DMat3, DQuat, DVec3};

use light::SceneBounds;

/// Width over height of the picture of a camera without an aspect ratio.
pub const DEFAULT_ASPECT: f64 = 16.0 / 9.0;

/// Camera in world space. It looks along its local -Z with +Y up.
#[derive(Clone, Debug, PartialEq)]
pub struct Camera {
    /// Name for people and for `--camera`.
    pub name: String,
    /// World position of the eye.
    pub translation: DVec3,
    /// Rotation from camera to world axes. It is normalised before use.
    pub rotation: DQuat,
    pub projection: Projection,
}

impl Camera {
    pub fn world_from_camera(&self) -> DAffine3 {
        DAffine3::from_rotation_translation(self.rotation.normalize(), self.translation)
    }

    /// Checks that the numbers make a picture. The error completes a sentence that begins with "the camera's".
    pub fn check(&self) -> Result<(), &'static str> {
        if !self.projection.makes_a_picture() {
            return Err("angle, size or planes make no picture");
        }
        if self.projection.aspect_ratio().is_some_and(|aspect| !(0.0 < aspect && aspect.is_finite())) {
            return Err("aspect ratio is not a number above 0");
        }
        // Rounding may leave a unit quaternion slightly off. A larger deviation cannot be due to rounding.
        let unit = (self.rotation.length_squared() - 1.0).abs() < 1e-3;
        if !unit {
            return Err("rotation is not a quaternion of unit length");
        }
        if self.translation.is_finite() { Ok(()) } else { Err("translation is not finite") }
    }
}

/// Projection, as in glTF.
///
/// If a camera has an aspect ratio, the picture contains all of the frame: a narrower picture keeps the frame's width
/// and shows more above and below, a wider one keeps its height and shows more at the sides. Without an aspect ratio
/// the picture keeps the height.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Projection {
    Perspective {
        /// Full vertical angle of view in radians, more than 0 and less than pi.
        yfov: f64,
        /// Width over height of the frame, more than 0. `None` takes the ratio of the picture.
        aspect_ratio: Option<f64>,
        /// Distance of the near plane, more than 0.
        znear: f64,
        /// Distance of the far plane, more than `znear`; infinite if `None`.
        zfar: Option<f64>,
    },
    Orthographic {
        /// Half the height of the view, more than 0.
        ymag: f64,
        /// Width over height of the frame, more than 0. `None` takes the ratio of the picture.
        aspect_ratio: Option<f64>,
        /// Distance of the near plane, 0 or more.
        znear: f64,
        /// Distance of the far plane, more than `znear`.
        zfar: f64,
    },
}

impl Projection {
    /// Returns the width and height in pixels of a picture without a requested size: 640 by 360, or about as many
    /// pixels in the camera's aspect ratio, with no side longer than `max_side`.
    pub fn default_size(&self, max_side: u32) -> [u32; 2] {
        const PIXELS: f64 = 640.0 * 360.0;
        let aspect = self.aspect_ratio().unwrap_or(DEFAULT_ASPECT);
        let side = |length: f64| (length.round() as u32).clamp(1, max_side);
        [side((PIXELS * aspect).sqrt()), side((PIXELS / aspect).sqrt())]
    }

    /// Returns true if angle, size and planes are in their domains.
    pub fn makes_a_picture(&self) -> bool {
        match *self {
            Self::Perspective { yfov, znear, zfar, .. } => {
                let is_far_valid = zfar.is_none_or(|zfar| znear < zfar && zfar.is_finite());
                0.0 < yfov && yfov < std::f64::consts::PI && 0.0 < znear && znear.is_finite() && is_far_valid
            }
            Self::Orthographic { ymag, znear, zfar, .. } => {
                0.0 < ymag && ymag.is_finite() && 0.0 <= znear && znear < zfar && zfar.is_finite()
            }
        }
    }

    /// Returns the width over height of the frame; `None` if the camera has none.
    pub fn aspect_ratio(&self) -> Option<f64> {
        let (Self::Perspective { aspect_ratio, .. } | Self::Orthographic { aspect_ratio, .. }) = *self;
        aspect_ratio
    }
}

/// Makes a camera that sees all of a scene with the bounds `reach`, from a little above and to the side, for a picture
/// `aspect` wide by 1 high.
///
/// The bounding sphere fits the narrower of the two fields of view (40 degrees vertical).
pub fn framing_camera(reach: &SceneBounds, aspect: f64) -> Camera {
    let SceneBounds { center, half_extent } = *reach;
    // A scene without extent (an empty one) is seen from a fixed distance.
    let radius = if half_extent == DVec3::ZERO { DVec3::ONE.length() } else { half_extent.length().max(1e-6) };
    let yfov = 40.0_f64.to_radians();
    let half_angle = (yfov / 2.0).min(libm::atan(libm::tan(yfov / 2.0) * aspect));
    let distance = radius / libm::sin(half_angle);
    let back = DVec3::new(0.45, 0.42, 1.0).normalize();
    let right = DVec3::Y.cross(back).normalize();
    let rotation = DMat3::from_cols(right, back.cross(right), back);
    let projection = Projection::Perspective { yfov, aspect_ratio: None, znear: distance * 0.01, zfar: None };
    let translation = center + back * distance;
    Camera { name: "framing".into(), translation, rotation: DQuat::from_mat3(&rotation), projection }
}
