//! Faces of a bent shadow map. A face is a picture of the tube's homogeneous coordinates (V, W, R); a line that is
//! straight there is straight on each face.
//!
//! Most tubes have one face that covers the whole width, uniform in v and w. A tube that opens wide has faces of a cube
//! around its axis, as a wide spotlight has; (V, W, R / slope) serve as positions.

use glam::{DMat3, DVec3};
use light::{ControlPoint, Light};

/// Length of the arrays of faces in the shaders.
pub(super) const MAX_FACES: usize = 5;
/// Largest slope of a tube with one face, `tan 60 degrees`. Beyond it, texels at the center of a cone are wider than
/// those of cube faces at half the resolution.
const LARGEST_SLOPE: f64 = 1.732_050_807_568_877;

#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Faces {
    /// Tube radius divided by the depth of the map's cube; `None` for a map with one face.
    slope: Option<f64>,
}

/// Returns the number of faces of a light's map.
pub(crate) fn face_count(light: &Light) -> usize {
    Faces::of(light).count()
}

impl Faces {
    /// Chooses the faces by the mean slope of the tube, from its first control point to its last along the others. That
    /// is the slope of a straight cone, and stays small for a tube that opens wide only at its tip.
    pub fn of(light: &Light) -> Self {
        let points = light.points();
        let length: f64 = points.windows(2).map(|pair| pair[0].position.distance(pair[1].position)).sum();
        let radius = |point: Option<&ControlPoint>| point.map_or(0.0, |point| point.radius);
        let slope = (radius(points.last()) - radius(points.first())) / length;
        Self { slope: (slope > LARGEST_SLOPE).then_some(slope) }
    }

    /// Returns the number of faces: the front, and for a cube also +V, -V, +W and -W.
    pub fn count(self) -> usize {
        if self.is_cube() { MAX_FACES } else { 1 }
    }

    pub fn is_cube(self) -> bool {
        self.slope.is_some()
    }

    /// Returns the slope of the cube. It is 1 for a single face, where x and y are v and w.
    pub fn slope(self) -> f64 {
        self.slope.unwrap_or(1.0)
    }

    /// Returns the matrix from (V, W, R) to a face's (x, y, depth).
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

    /// Returns the least and greatest x / depth and y / depth of the part of a face that is in the tube.
    pub fn limits(self, face: usize) -> [[f64; 2]; 2] {
        if face == 0 { [[-1.0, 1.0]; 2] } else { [[-1.0, 1.0], [self.slope().recip(), 1.0]] }
    }
}
