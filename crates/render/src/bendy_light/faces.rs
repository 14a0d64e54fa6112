//! The faces of a bent shadow map: pictures of the homogeneous coordinates (V, W, R) of the tube, on each of which what
//! is straight there is straight.
//!
//! One face holds the whole width of most tubes, evenly in v and w. A tube that opens wide needs what a straight
//! spotlight needs: the faces of a cube about its axis, for which (V, W, R / slope) are as good as positions.

use glam::{DMat3, DVec3};
use light::{ControlPoint, Light};

use crate::ShadowSettings;
use crate::shadow_settings::MapSize;

/// Length of the arrays of faces in the shaders.
pub(super) const MAX_FACES: usize = 5;
/// Largest slope of a tube of one face, `tan 60 degrees`: past it the texels at the middle of a cone would be wider than
/// those of a cube's faces at half the resolution.
const LARGEST_SLOPE: f64 = 1.732_050_807_568_877;

/// The faces of a light's map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Faces {
    /// Radius over the depth of the cube; `None` for one face.
    slope: Option<f64>,
}

/// How large a light's map is.
pub(crate) fn map_size(light: &Light, shadows: &ShadowSettings) -> MapSize {
    shadows.map_size(Faces::of(light).count())
}

impl Faces {
    /// By the mean slope of the tube, from its first control point to its last along the others: that of a straight
    /// cone, and not much of one that opens wide at its tip alone.
    pub fn of(light: &Light) -> Self {
        let points = light.points();
        let length: f64 = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
        let radius = |point: Option<&ControlPoint>| point.map_or(0.0, |point| point.radius);
        let slope = (radius(points.last()) - radius(points.first())) / length;
        Self { slope: (slope > LARGEST_SLOPE).then_some(slope) }
    }

    /// The front, and for a cube those of +V, -V, +W and -W.
    pub fn count(self) -> usize {
        if self.is_cube() { MAX_FACES } else { 1 }
    }

    pub fn is_cube(self) -> bool {
        self.slope.is_some()
    }

    /// 1 where there is one face, on which x and y are v and w.
    pub fn slope(self) -> f64 {
        self.slope.unwrap_or(1.0)
    }

    /// From (V, W, R) to a face's (x, y, depth).
    pub fn face_from_tube(self, face: usize) -> DMat3 {
        let ahead = DVec3::Z / self.slope();
        let sign = if face % 2 == 1 { 1.0 } else { -1.0 };
        let rows = match face {
            0 => [DVec3::X, DVec3::Y, ahead],
            1 | 2 => [DVec3::Y, ahead, DVec3::X * sign],
            _ => [DVec3::X, ahead, DVec3::Y * sign],
        };
        DMat3::from_cols_array_2d(&rows.map(|row| row.to_array())).transpose()
    }

    /// The least and the greatest x / depth and y / depth of a face that lie in the tube.
    pub fn limits(self, face: usize) -> [[f64; 2]; 2] {
        if face == 0 { [[-1.0, 1.0]; 2] } else { [[-1.0, 1.0], [self.slope().recip(), 1.0]] }
    }
}
