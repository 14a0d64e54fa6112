//! Dragged feature, with the path of its target from the start of the drag to the cursor.

use glam::DVec3;
use raycast::SeenPoint;

use crate::point_in_light::PointInLight;
use crate::request::Feature;

/// Dragged feature. M is the surface point at the start of the drag, M' the one under the cursor.
#[derive(Clone, Debug)]
pub(crate) struct TakenFeature {
    pub feature: Feature,
    /// M.
    pub from: SeenPoint,
    /// M'.
    pub to: SeenPoint,
    /// Caster point of a dragged shadow, in scene space.
    pub pivot: Option<DVec3>,
    /// Light coordinates of M at the start of the drag.
    pub start_coords: PointInLight,
    /// Unit directions to the light: at M at the start of the drag, and at M' at its end. Only highlights and lit sides
    /// use them.
    pub directions: [DVec3; 2],
}

impl TakenFeature {
    /// Returns the target of the feature at a share of the path: its position, and the direction to the light there.
    pub fn target(&self, share: f64) -> (DVec3, DVec3) {
        let [from, to] = self.directions;
        (self.from.position.lerp(self.to.position, share), slerp(from, to, share))
    }

    /// Returns a unit vector orthogonal to the target direction at every share of the path.
    pub fn axis(&self) -> DVec3 {
        let [from, to] = self.directions;
        from.cross(to).try_normalize().unwrap_or_else(|| from.any_orthonormal_vector())
    }
}

/// Interpolates unit vectors along the shortest rotation from one to the other.
fn slerp(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    let cos = from.dot(to);
    let across = (to - from * cos).normalize_or_zero();
    let angle = libm::atan2(from.cross(to).length(), cos) * share;
    from * libm::cos(angle) + across * libm::sin(angle)
}
