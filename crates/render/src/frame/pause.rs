//! Pauses of pictures that are drawn in turns.

use super::backend::FrameBackend;
use crate::RenderError;

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

/// Waits until a piece of work is drawn. Returns true if drawing the picture pauses now.
pub(crate) fn is_over<B: FrameBackend>(
    backend: &mut B,
    pause: Option<Pause>,
    piece: DrawnPiece,
) -> Result<bool, RenderError> {
    let Some(pause) = pause else { return Ok(false) };
    backend.finish()?;
    Ok(pause(piece))
}
