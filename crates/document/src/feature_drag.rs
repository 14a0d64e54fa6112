//! Drag of a shadow, a hotspot, a highlight or diffuse light: request and outcome.

use drag::{DragStatus, Feature, RadiusMode, Viewport};
use glam::{DVec2, DVec3};

/// Request for a drag of a light's feature in a picture, as [`drag::Drag`]. The drag keeps the document's pins of the
/// light.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureDrag {
    pub feature: Feature,
    /// Indices of the control points that move; `None` moves the light as a whole.
    pub points: Option<Vec<usize>>,
    /// Handling of the radii, if control points move.
    pub radii: RadiusMode,
    /// Camera and size of the picture.
    pub view: Viewport,
    /// Start of the drag, in pixels from the picture's top left corner.
    pub from: DVec2,
    /// End of the drag, in the same pixels.
    pub to: DVec2,
    /// True if the source may not pass through a surface.
    pub source_outside: bool,
}

/// Outcome of a drag of a feature, except for the light itself. A record stores it beside the changes. Nothing depends
/// on it.
#[derive(Clone, Debug, PartialEq)]
pub struct DragOutcome {
    /// Name of the solver.
    pub solver: String,
    /// Version of the solver. Another version may give another light.
    pub version: u32,
    /// Status of the drag. A pin is identified by the number of its [`PinId`](crate::PinId), not by an index.
    pub status: DragStatus,
    /// Distance on the screen from the cursor to the feature, in pixels; infinite if the feature is not in the picture.
    pub residual_px: f64,
    /// Name of the node that shadows the surface under the cursor besides the node of the dragged shadow.
    pub shadowed_by: Option<String>,
    /// Number of steps of the solver.
    pub iterations: usize,
    /// World position at the start of the drag; `None` if no surface is there.
    pub from_world: Option<DVec3>,
    /// World position at the end of the drag; `None` if no surface is there.
    pub to_world: Option<DVec3>,
    /// World position of the caster's point of a dragged shadow.
    pub pivot_world: Option<DVec3>,
}
