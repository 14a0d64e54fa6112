//! Solver for drags of a light's features: a user takes a shadow, hotspot, highlight or the lit side of a surface in a
//! picture and puts it elsewhere, and the solver moves or bends the light accordingly.
//!
//! [`drag`] is a function of the scene, the light at the start of the drag and the two points of the picture, and does
//! not depend on the cursor's route. It works in f64 with rays against the posed scene ([`raycast::Bvh`]) and reads no
//! picture, so the same drag gives the same bits on every machine. The crate knows no document and no clock.
//!
//! The unknowns are a placement, or offsets of control points (light model, section 7). Two equations say that the
//! feature lies under the cursor. Limits keep the tube from folding and the feature where it can be seen, and pins add
//! equations and limits. Of the lights that are left, the solver takes one whose picture changes little, by a fixed chain
//! of strictly convex steps (docs/decisions/14-drag-solver.md).
//!
//! The cost of a drag is counted in steps and bounded ([`WorkBudget`]), so that a drag past the bound gives the same
//! bits too. Begin with `drag.rs` (drags), `alternatives.rs` (what may follow), `solve.rs` (one drag), `landing.rs` (a drag to one
//! pixel), `chain.rs` (the solver), `problem.rs` (equations, rows and limits) and `moves.rs` (unknowns).

mod alternatives;
mod bound;
mod chain;
mod convex_step;
mod drag;
mod dragged_feature;
mod held_pins;
mod landing;
mod linked_copy;
mod matrix;
mod moves;
mod occlusion;
mod overlap;
mod past_caster;
mod picture_change;
mod picture_metric;
mod pin_state;
mod pinned_slide;
mod pins;
mod point_in_light;
mod problem;
mod request;
mod slide;
mod solve;
mod start;
mod taken_feature;
mod visibility;
mod work;

pub use drag::{drag, drag_alternatives, drag_budgeted, drag_least_change};
pub use dragged_feature::highlight_near;
pub use held_pins::first_broken_pin;
pub use pinned_slide::{place_along_pins, slide_point_along_pins};
pub use request::{
    Alternative, Constraint, Drag, DragChoice, DragLimit, DragOutcome, DragPin, DragRefusal, DragResult, DragStatus,
    Feature, LightCopy, NumberedPin, PinKind, PinTarget, RadiusMode, Viewport,
};
pub use slide::{Slide, slide_point};
pub use work::{MAX_DRAG_STEPS, STEPS_BETWEEN_CHECKS, WorkBudget};

/// Name and version of the solver. The version grows with every change after which a drag may give another light.
pub const SOLVER: (&str, u32) = ("picture", 9);
