//! Light coordinates and visibility of a point, in JSON.

use light::TubeLocation;
use serde::Serialize;

/// Evaluation of a light at one world position.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// True if the point is inside the tube.
    pub inside: bool,
    /// Position in the tube. Its fields stand beside the others in JSON, and only if `inside`.
    #[serde(flatten)]
    pub point: Option<TubePoint>,
    /// Visibility of the light. Its fields stand beside the others in JSON, and only if `inside` and requested.
    #[serde(flatten)]
    pub visibility: Option<Visibility>,
    /// All solutions t inside the tube, ascending. A solution at a joint is counted once.
    pub roots: Vec<f64>,
}

/// Visibility of a light from a point in a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Visibility {
    /// True if no occluder lies on the light path.
    pub visible: bool,
    /// Name of the first occluder's node along the light path; `null` if there is none.
    pub occluder: Option<String>,
}

/// [`light::TubePoint`] in JSON.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct TubePoint {
    /// Index of the segment, from 0.
    pub segment: usize,
    /// Parameter in the segment, 0 to 1.
    pub u: f64,
    /// Parameter along the light, `segment + u`.
    pub t: f64,
    /// First cross-section coordinate in units of the radius.
    pub v: f64,
    /// Second cross-section coordinate in units of the radius.
    pub w: f64,
    /// Radius of the tube at t, in world units.
    pub radius: f64,
    /// Unit vector in world space, from the surface to the light.
    pub direction: [f64; 3],
}

impl Evaluation {
    /// Converts a located point, together with the visibility that was traced for it.
    pub fn new(location: &TubeLocation, visibility: Option<Visibility>) -> Self {
        let point = location.point.map(|point| {
            let light::TubePoint { segment, u, t, v, w, radius, direction } = point;
            TubePoint { segment, u, t, v, w, radius, direction: direction.to_array() }
        });
        Self { inside: point.is_some(), point, visibility, roots: location.roots.clone() }
    }
}
