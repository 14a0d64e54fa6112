//! Errors of the reference renderer.

use thiserror::Error;

/// Error of a picture or a probe. Each message says what to change.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReferenceError {
    /// The view has no pixels or no samples.
    #[error("this view has no pixels or no samples: give it a width, a height and at least one sample a pixel")]
    EmptyView,
    /// The camera makes no picture.
    #[error("the camera's {0}: correct the camera")]
    Camera(&'static str),
    /// The factor of the fill light is out of range.
    #[error("the fill cannot be {0} times the scene's: give a factor from 0 to {max}", max = scene::View::FILL_RANGE.end())]
    Fill(f64),
    /// The AOV belongs to a light that does not exist.
    #[error("there is no light {index} to show, this picture has {count}: choose one of them or another AOV")]
    NoSuchLight {
        /// Requested index.
        index: usize,
        /// Number of lights.
        count: usize,
    },
    /// The point lies outside the picture.
    #[error(
        "({x}, {y}) is not in a picture of {}x{} pixels: x goes from 0 to less than {}, y from 0 to less than {}",
        size[0], size[1], size[0], size[1]
    )]
    OffPicture {
        /// Pixels from the left.
        x: f64,
        /// Pixels from the top.
        y: f64,
        /// Width and height of the picture in pixels.
        size: [u32; 2],
    },
    /// The AOV is a wireframe.
    #[error(
        "the reference follows light along its curve and has no shadow map to draw a wireframe of: take the GPU for it"
    )]
    NoShadowMap,
}
