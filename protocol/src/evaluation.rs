//! Where a point lies in a light, in JSON.

use light::TubeLocation;
use serde::Serialize;

/// Where one world position lies in a light.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Evaluation {
    /// Whether the point is inside the tube.
    pub inside: bool,
    /// Where in the tube; in JSON these fields stand beside the others, and only when `inside`.
    #[serde(flatten)]
    pub point: Option<TubePoint>,
    /// Whether light gets there; in JSON these fields stand beside the others, and only when `inside` and asked
    /// for.
    #[serde(flatten)]
    pub visibility: Option<Visibility>,
    /// Every in-tube solution t, ascending; one at a joint is counted once.
    pub roots: Vec<f64>,
}

/// Whether light gets to a point through a scene.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Visibility {
    /// Whether nothing is in the way.
    pub visible: bool,
    /// Name of the first node on the light's way that stops it; null where none does.
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
    /// Radius of the tube there, in world units.
    pub radius: f64,
    /// Unit vector in world space, from the surface to the light.
    pub direction: [f64; 3],
}

impl Evaluation {
    /// Of a located point, and what was found on its light's way.
    pub fn new(location: &TubeLocation, visibility: Option<Visibility>) -> Self {
        let point = location.point.map(|p| TubePoint {
            segment: p.segment,
            u: p.u,
            t: p.t,
            v: p.v,
            w: p.w,
            radius: p.radius,
            direction: p.direction.to_array(),
        });
        Self { inside: point.is_some(), point, visibility, roots: location.roots.clone() }
    }
}
