//! Pauses of a picture that is drawn in turns.

/// Says after a piece of work whether the picture pauses.
pub(crate) type Pause<'a> = &'a dyn Fn(DrawnPiece) -> bool;

/// What has been drawn and waited for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum DrawnPiece {
    /// A light's map, whatever the size of the picture.
    ShadowMap,
    /// Something of each pixel.
    Pixels,
}
