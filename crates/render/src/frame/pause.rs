//! Pauses of pictures that are drawn in turns.

/// Returns true after a piece of work if the picture pauses.
pub(crate) type Pause<'a> = &'a dyn Fn(DrawnPiece) -> bool;

/// Piece of work after which drawing a picture may pause. The renderer waits until it is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DrawnPiece {
    /// The shadow map of a light; its cost does not depend on the picture's size.
    ShadowMap,
    /// Work whose cost grows with the number of pixels.
    Pixels,
}
