//! Drags that land: a shadow, a hotspot, a highlight or a surface's brightest side is taken in the picture and put elsewhere, and
//! the light is moved or bent so that it lies there.
//!
//! [`drag`] is a function of the scene, the light as it was when the drag began, and the two points of the picture: it does not
//! depend on how the cursor got there. All is done in f64 with rays against the posed scene ([`raycast::Bvh`]); no picture is
//! read, so that the same drag gives the same bits on every machine.
//!
//! What is solved (light model, section 7): unknowns are a placement, or offsets of control points; two equations say that the
//! feature lies under the cursor; limits keep the tube from folding; pins hold what is to stay, as further equations and limits.
//! Of all that fulfils them the smallest change is taken, by
//! [sequential quadratic programming](https://en.wikipedia.org/wiki/Sequential_quadratic_programming) along the way from where the
//! drag began to where the cursor is.
//!
//! What a drag costs is counted in steps ([`WorkBudget`]) and bounded. No clock is read, so that past the bound too the same drag gives
//! the same bits on every machine.

mod bound;
mod direct;
mod drag;
mod dragged_feature;
mod flow;
mod goal;
mod matrix;
mod moves;
mod occlusion;
mod pins;
mod point_in_light;
mod quadratic;
mod reach;
mod request;
mod scene_visibility;
mod slide;
mod solve;
mod start;
mod step;
mod work;

pub use drag::{drag, drag_budgeted};
pub use dragged_feature::highlight_near;
pub use request::{
    Drag, DragLimit, DragPin, DragRefusal, DragResult, DragStatus, Feature, PinKind, RadiusMode, Viewport,
};
pub use slide::{Slide, slide_point};
pub use work::{MAX_DRAG_STEPS, STEPS_BETWEEN_CHECKS, WorkBudget};

/// What solves drags of features: its name and its version, which grows with every change after which a drag may give another
/// light.
pub const SOLVER: (&str, u32) = ("flow", 4);
