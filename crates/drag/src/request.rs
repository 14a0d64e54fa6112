//! Requests and results of drags.

use glam::{DVec2, DVec3};
use light::Light;
use raycast::SeenPoint;
use scene::Camera;

/// View in which the user drags.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewport {
    pub camera: Camera,
    /// Width and height in pixels.
    pub size: [u32; 2],
}

/// Request to move a feature of a light in a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Drag {
    pub feature: Feature,
    /// Alternative to solve; `None` moves what `points` and `radii` say.
    pub choice: Option<DragChoice>,
    /// Indices of the control points that may move; `None` moves the whole light. With a choice, `None` is all points
    /// past the source.
    pub points: Option<Vec<usize>>,
    /// Handling of the radii if control points move.
    pub radii: RadiusMode,
    /// Camera and size of the picture.
    pub view: Viewport,
    /// Start of the drag, in pixels from the picture's top left corner.
    pub from: DVec2,
    /// Cursor, in the same pixels.
    pub to: DVec2,
    /// Properties that the drag preserves; `None` for those that are pinned in the document.
    pub pins: Option<Vec<NumberedPin>>,
    /// True if the source may not go through a surface.
    pub source_outside: bool,
}

/// Choice of what follows a dragged feature.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragChoice {
    /// Alternative that lands and changes least of what is lit. It never adds a light.
    Best,
    Only(Alternative),
}

/// Part of a light that follows a dragged feature, while the rest stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Alternative {
    /// Control points, with their radii.
    ControlPoints,
    /// Control points whose radii shrink where the tube would fold, by a fifth at most.
    Narrower,
    /// Placement of the light.
    WholeLight,
    /// Control points that change the light past the caster of a dragged shadow alone, so the caster looks as before.
    PastCaster,
    /// The light without one node, which a copy of the light as it was illuminates: for a shadow its caster, so the caster
    /// looks as before. For another feature the receiver follows alone, and the copy illuminates all else.
    LinkedCopy,
}

impl Alternative {
    /// All alternatives. An earlier one is better where two change the picture nearly alike.
    pub const ALL: [Self; 5] =
        [Self::ControlPoints, Self::Narrower, Self::WholeLight, Self::PastCaster, Self::LinkedCopy];
}

/// Property at a point that a drag of the light preserves. It must be true when the drag begins.
#[derive(Clone, Debug, PartialEq)]
pub struct DragPin {
    pub kind: PinKind,
    pub at: PinTarget,
    /// Name or path of the node that casts the shadow, for [`PinKind::Shadow`]; `None` for the first caster on the
    /// light path.
    pub caster: Option<String>,
    /// True if the drag must preserve the property. False if it preserves the property only as far as it can without
    /// limiting the feature.
    pub is_hard: bool,
}

/// Point or node that a pin holds.
#[derive(Clone, Debug, PartialEq)]
pub enum PinTarget {
    /// World position on a surface.
    Point(DVec3),
    /// Name or path of a node: the pin holds on what the drag's picture shows of it and of the nodes below it.
    Node(String),
}

/// Pin with the number by which a [`DragOutcome`] names it.
#[derive(Clone, Debug, PartialEq)]
pub struct NumberedPin {
    pub number: u64,
    pub pin: DragPin,
}

impl NumberedPin {
    /// Numbers pins by their index.
    pub fn by_index(pins: impl IntoIterator<Item = DragPin>) -> Vec<Self> {
        pins.into_iter().zip(0..).map(|(pin, number)| Self { number, pin }).collect()
    }
}

/// Property that a pin keeps.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinKind {
    /// Direction from which light arrives and, as far as the drag allows, its irradiance.
    Direction,
    /// Look of the surface: the irradiance, the direction from which light arrives, and if it arrives.
    Look,
    /// Light arrives at the point, at least half as much as before.
    Lit,
    /// A caster blocks the light to the point.
    Shadowed,
    /// The point stays in the shadow of the same point of the caster.
    Shadow,
    /// Light coordinates of the point across the light: the same light path reaches it.
    Coordinates,
}

/// Dragged feature of a light. M is the surface point seen at the start of the drag, M' the one under the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// Shadow on M: its caster point moves onto the light path to M'.
    Shadow,
    /// Part of the light at M: it moves to M'.
    Hotspot,
    /// Highlight: light arrives at M' along the mirror direction.
    Highlight,
    /// Brightest side of a surface: light arrives at M' along the normal.
    Diffuse,
}

impl Feature {
    /// Returns the direction from which light arrives at a surface point with a highlight, or else with the lit side.
    pub(crate) fn target_direction(self, seen: &SeenPoint) -> DVec3 {
        if self == Self::Highlight { seen.mirror_direction() } else { seen.normal }
    }
}

/// Handling of radii while control points move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RadiusMode {
    /// Radii stay.
    #[default]
    Keep,
    /// Radii of the moving points are unknowns too.
    Solve,
    /// Radii that would make the tube fold shrink, and grow back.
    Follow,
}

/// Result of a drag.
#[derive(Clone, Debug, PartialEq)]
pub struct DragResult {
    /// A light that can be evaluated. It is the light of the start if the drag was refused.
    pub light: Light,
    /// Light to add, of [`Alternative::LinkedCopy`].
    pub copy: Option<LightCopy>,
    pub outcome: DragOutcome,
}

/// Copy of a light as it was, which illuminates what the dragged light no longer does.
#[derive(Clone, Debug, PartialEq)]
pub struct LightCopy {
    pub light: Light,
    /// Numbers of the pins that hold on what the copy illuminates.
    pub pins: Vec<u64>,
}

/// Outcome of a drag, besides the light.
#[derive(Clone, Debug, PartialEq)]
pub struct DragOutcome {
    /// Name of the solver.
    pub solver: String,
    /// Version of the solver. Another version may give another light.
    pub version: u32,
    pub status: DragStatus,
    /// Alternative that the light follows, if the drag had a choice.
    pub alternative: Option<Alternative>,
    /// Share of the picture's pixels whose light changes by more than a fiftieth of a bright pixel's, from 256 pixels;
    /// `None` if the drag was refused, or if its work is spent.
    pub changed_share: Option<f64>,
    /// Largest change of what a picture shows at a point of a pinned node, 0 to 1, where 1 is the brightness of the pin's
    /// brightest point at the start; `None` without hard pins of nodes, or if the drag was refused.
    pub pinned_change: Option<f64>,
    /// Constraints that the drag relaxed so that the feature lands, each once. From one cursor to the next the light may
    /// jump where they change.
    pub relaxed: Vec<Constraint>,
    /// Distance on the screen from the cursor to the feature, in pixels; infinite if the feature is not in the picture.
    pub residual_px: f64,
    /// Name of the node that shadows M' in place of the dragged caster point, if another caster is on the light path.
    pub shadowed_by: Option<String>,
    /// Number of solver steps.
    pub iterations: usize,
    /// World position of the surface at the start of the drag; `None` if there is no surface.
    pub from_world: Option<DVec3>,
    /// World position of the surface under the cursor; `None` if there is no surface.
    pub to_world: Option<DVec3>,
    /// World position of the caster point of a dragged shadow.
    pub pivot_world: Option<DVec3>,
}

/// Constraint that a drag relaxes where the feature does not land else.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Constraint {
    /// The rest of the picture changes little. Relaxed, it counts a tenth.
    Picture,
    /// Soft pins hold. Relaxed, they do not count.
    SoftPins,
    /// Radii stay. Relaxed, they shrink where the tube would fold ([`RadiusMode::Follow`]).
    Radii,
}

/// Outcome of a drag.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragStatus {
    /// The feature is under the cursor, within half a pixel.
    Landed,
    /// The feature is at the last pixel of the straight way to the cursor that the limit allows.
    Limited(DragLimit),
    /// The drag is refused, and the light is unchanged.
    Refused(DragRefusal),
}

/// Limit that keeps a light from the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragLimit {
    /// The tube would fold over itself.
    Fold,
    /// Distant parts of the tube would overlap, which the light does not allow.
    Overlap,
    /// A radius would be negative.
    Radius,
    /// The point under the cursor would lie outside the light.
    TubeEdge,
    /// No small change brings the feature nearer.
    NoDescent,
    /// The source would go through a surface.
    SourceInside,
    /// The pin with this number would be violated.
    Pin(u64),
    /// The search for a nearer light takes more steps than a drag may take ([`crate::MAX_DRAG_STEPS`]).
    TooMuchWork,
}

/// Reason for which a drag is refused.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragRefusal {
    /// There is no surface at the start of the drag.
    NothingAtStart,
    /// There is no surface under the cursor, or the light's links exclude it.
    NothingAtEnd,
    /// The surface at the start of the drag lies outside the light, or the light's links exclude it.
    OutsideTheLight,
    /// There is no shadow at the start of the drag.
    NoShadow,
    /// The request names control points, and the light has none.
    NotBendy,
    /// The request names a control point that the light does not have, or its source.
    NoSuchPoint,
    /// Moving the chosen control points does not change the light at the start of the drag.
    NoWeight,
    /// The caster lies too near to the shadow for the light to bend between them, or there is no control point past it.
    TooLittleRoom,
    /// The limit lets the feature go less than a third of the way.
    Limited(DragLimit),
    /// The hard pin with this number does not hold at the start: its point is outside the light, or is not lit, not in
    /// shadow, or not in the shadow of the named caster.
    PinDoesNotHold(u64),
}
