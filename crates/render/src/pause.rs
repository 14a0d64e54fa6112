//! Pauses of pictures that are drawn in turns.

/// Returns true after a piece of work if the picture pauses.
pub(crate) type Pause<'a> = &'a dyn Fn(DrawnPiece) -> bool;

/// A piece of work that is drawn and waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DrawnPiece {
    /// The shadow map of a light; its cost does not depend on the picture's size.
    ShadowMap,
    /// Work on each pixel.
    Pixels,
}
