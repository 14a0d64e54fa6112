//! Sizes of pictures as options.

use std::str::FromStr;

use protocol::{RenderLimits, RenderRefusal};

/// Limits of pictures.
pub const LIMITS: RenderLimits = RenderLimits::COMMAND_LINE;

/// Size of a picture in pixels, each side within [`LIMITS`].
#[derive(Clone, Copy, Debug)]
pub struct Size {
    pub width: u32,
    pub height: u32,
}

impl FromStr for Size {
    type Err = RenderRefusal;

    fn from_str(text: &str) -> Result<Self, RenderRefusal> {
        LIMITS.parse_size(text).map(|[width, height]| Self { width, height })
    }
}
