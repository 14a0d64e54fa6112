//! Why a picture cannot be made.

use thiserror::Error;

/// Why a picture cannot be made. Each sentence says what to change.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ReferenceError {
    /// A picture without pixels or samples.
    #[error(
        "this view has no pixels or no samples: give it a width, a height and at least one sample a pixel"
    )]
    EmptyView,
    /// An impossible camera.
    #[error("the camera's {0}: correct the camera")]
    Camera(&'static str),
    /// A factor of the fill outside its domain.
    #[error("the fill cannot be {0} times the scene's: give a factor from 0 to {max}", max = scene::View::FILL_RANGE.end())]
    Fill(f64),
    /// An AOV of a light that is not there.
    #[error("there is no light {index} to show, this picture has {count}: choose one of them or another AOV")]
    NoSuchLight {
        /// The index asked for.
        index: usize,
        /// How many lights there are.
        count: usize,
    },
    /// A point that is not in the picture.
    #[error(
        "({x}, {y}) is not in a picture of {}x{} pixels: x goes from 0 to less than {}, y from 0 to less than {}",
        size[0], size[1], size[0], size[1]
    )]
    OffPicture {
        /// In pixels from the left.
        x: f64,
        /// In pixels from the top.
        y: f64,
        /// Width and height of the picture.
        size: [u32; 2],
    },
    /// A wireframe.
    #[error(
        "the reference follows light along its curve and has no shadow map to draw a wireframe of: take the GPU for it"
    )]
    NoShadowMap,
}
