//! A drag of a shadow, a hotspot, a highlight or diffuse light: what is asked, and how it ended.

use drag::{DragStatus, Feature, RadiusMode, Viewport};
use glam::{DVec2, DVec3};

/// A feature of a light that is dragged in a picture, as [`drag::Drag`]. What is to stay are the document's pins of the light.
#[derive(Clone, Debug, PartialEq)]
pub struct FeatureDrag {
    /// What is dragged.
    pub feature: Feature,
    /// The control points that take part, by their indices; `None` moves the light as a whole.
    pub points: Option<Vec<usize>>,
    /// What becomes of radii where control points take part.
    pub radii: RadiusMode,
    /// The picture that is dragged in.
    pub view: Viewport,
    /// Where the feature is taken, in pixels from the picture's top left corner.
    pub from: DVec2,
    /// Where it goes.
    pub to: DVec2,
    /// Whether the source may not go through a surface.
    pub source_outside: bool,
}

/// How a drag of a feature ended, besides the light. A record holds it beside the changes; nothing depends on it.
#[derive(Clone, Debug, PartialEq)]
pub struct DragOutcome {
    /// What solved it.
    pub solver: String,
    /// Of the solver: another one may give another light.
    pub version: u32,
    /// Whether the feature lies under the cursor. A pin is named by the number of its [`PinId`](crate::PinId), not by an index.
    pub status: DragStatus,
    /// On the screen, from the cursor to where the feature lies, in pixels; infinite where it is not in the picture.
    pub residual_px: f64,
    /// The node that shadows the surface under the cursor besides the one whose shadow was dragged, by its name.
    pub shadowed_by: Option<String>,
    /// Steps that the solver took.
    pub iterations: usize,
    /// Where the drag began, in the world; `None` where no surface is seen.
    pub from_world: Option<DVec3>,
    /// Where it ended.
    pub to_world: Option<DVec3>,
    /// Of a shadow: the point that throws it.
    pub pivot_world: Option<DVec3>,
}
