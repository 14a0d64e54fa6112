//! Pictures' sizes as options take them.

use std::str::FromStr;

use protocol::{RenderLimits, RenderRefusal};

/// How large a picture may be.
pub const LIMITS: RenderLimits = RenderLimits::COMMAND_LINE;

/// Pixels of a picture, each side within [`LIMITS`].
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// From left to right.
    pub width: u32,
    /// From top to bottom.
    pub height: u32,
}

impl FromStr for Size {
    type Err = RenderRefusal;

    fn from_str(text: &str) -> Result<Self, RenderRefusal> {
        LIMITS.parse_size(text).map(|[width, height]| Self { width, height })
    }
}
