//! What is asked, and what comes of it.

use glam::{DVec2, DVec3};
use light::Light;
use scene::Camera;

/// A picture that is dragged in.
#[derive(Clone, Debug, PartialEq)]
pub struct Viewport {
    /// Who looks.
    pub camera: Camera,
    /// Its width and height in pixels.
    pub size: [u32; 2],
}

/// A feature of a light, and where it goes.
#[derive(Clone, Debug, PartialEq)]
pub struct Drag {
    /// What is dragged.
    pub feature: Feature,
    /// The control points that take part, by their indices; `None` moves the light as a whole.
    pub points: Option<Vec<usize>>,
    /// What becomes of radii where control points take part.
    pub radii: RadiusMode,
    /// Where the feature is taken, in pixels from the picture's top left corner.
    pub from: DVec2,
    /// Where it goes.
    pub to: DVec2,
    /// What is to stay as it is.
    pub pins: Vec<DragPin>,
    /// Whether the source may not go through a surface.
    pub source_outside: bool,
}

/// What is to stay as it is at a point while the light is dragged. It has to be so when the drag begins.
#[derive(Clone, Debug, PartialEq)]
pub struct DragPin {
    /// What stays.
    pub kind: PinKind,
    /// Where, in the world: on a surface.
    pub at: DVec3,
    /// Of [`PinKind::Shadow`]: the node that throws it, by its name or its path; `None` for the first that light meets.
    pub caster: Option<String>,
    /// Whether it stays whatever is asked, or as far as that lets it.
    pub is_hard: bool,
}

/// What stays at a point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum PinKind {
    /// The direction from which light arrives and, as far as what is asked lets it, how much of it, so that the surface looks as it
    /// did.
    Direction,
    /// That light arrives.
    Lit,
    /// That something stands in the light's way.
    Shadowed,
    /// The shadow of the very point of the caster that throws it now.
    Shadow,
}

/// What is dragged. M is the surface seen where the drag begins, M' the one seen where it ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Feature {
    /// The shadow on M: what throws it comes to lie on the way of the light to M'.
    Shadow,
    /// The part of the light that M lies in: it comes to lie on M'.
    Hotspot,
    /// The highlight: at M' the light arrives along the mirror direction.
    Highlight,
    /// Where a surface is brightest: at M' the light arrives along the normal.
    Diffuse,
}

/// What becomes of radii while control points move.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum RadiusMode {
    /// They stay.
    #[default]
    Keep,
    /// Those of the moving points are unknowns too.
    Solve,
    /// Those that would make the tube fold shrink, and come back.
    Follow,
}

/// What came of a drag.
#[derive(Clone, Debug, PartialEq)]
pub struct DragResult {
    /// Whether the feature lies under the cursor.
    pub status: DragStatus,
    /// The light, which can be evaluated: the one that the drag began with where it was refused.
    pub light: Light,
    /// On the screen, from the cursor to where the feature lies now, in pixels; infinite where it is not in the picture.
    pub residual_px: f64,
    /// The node that shadows M' too, where a shadow was dragged and another caster stands in the light's way.
    pub shadowed_by: Option<usize>,
    /// Steps that the solver took.
    pub iterations: usize,
    /// Where the drag began, in the world; `None` where no surface is seen.
    pub from_world: Option<DVec3>,
    /// Where it ended.
    pub to_world: Option<DVec3>,
    /// Of a shadow: the point that throws it.
    pub pivot_world: Option<DVec3>,
}

/// Whether the feature lies under the cursor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragStatus {
    /// It does, within half a pixel.
    Converged,
    /// It lies as near as the light may bring it.
    Limited(DragLimit),
    /// Nothing was moved.
    Refused(DragRefusal),
}

/// What keeps a light from going on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragLimit {
    /// The tube would fold over itself.
    Fold,
    /// A radius would be less than nothing.
    Radius,
    /// The place under the cursor would lie outside the light.
    TubeEdge,
    /// No small change brings the feature nearer.
    NoDescent,
    /// The source would go through a surface.
    SourceInside,
    /// What is pinned would not stay, by the pin's index.
    Pin(usize),
    /// Finding a nearer light takes more steps than a drag may take ([`crate::MAX_DRAG_STEPS`]).
    TooMuchWork,
}

/// Why nothing can be moved.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DragRefusal {
    /// Where the drag begins there is no surface.
    NothingAtStart,
    /// The cursor is off the surfaces, or on one that the light may not show on.
    NothingAtEnd,
    /// The surface where the drag begins lies outside the light, or the light may not show on it.
    OutsideTheLight,
    /// Where a shadow is to be taken there is none.
    NoShadow,
    /// Control points were named, and the light has none.
    NotBendy,
    /// A control point was named that the light does not have, or its source.
    NoSuchPoint,
    /// None of the control points that take part acts on the light there.
    NoWeight,
    /// A hard pin, by its index, holds what is not so: its point is outside the light, or is not lit, not in shadow, or
    /// not in that caster's shadow.
    PinDoesNotHold(usize),
}
