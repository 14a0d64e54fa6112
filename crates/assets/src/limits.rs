//! Limits of imported scenes.
//!
//! Together the limits keep one load under 2 GiB of memory and, on one core, under 20 seconds.

use std::collections::BTreeMap;

use crate::AssetFault;

/// Maximum number of bytes of the scene file and of all files that it refers to. Large scenes have 100 to 300 MB.
pub const MAX_BYTES_READ: u64 = 512 << 20;
/// Maximum depth of nested JSON. glTF needs about 10. The parser recurses, so the limit must stay far below its stack.
pub const MAX_JSON_DEPTH: u64 = 64;
/// Maximum number of values in the JSON. Two bytes of text become up to a kilobyte in memory, so a limit of bytes is
/// not enough.
pub const MAX_JSON_VALUES: u64 = 1 << 20;
/// Maximum number of placed nodes, including instances. Each costs a matrix and a draw.
pub const MAX_NODES: u64 = 1 << 18;
/// Maximum number of stored vertices. Each has 48 bytes with all attributes.
pub const MAX_VERTICES: u64 = 8 << 20;
/// Maximum number of drawn triangles. A mesh that two nodes use counts twice. The renderer processes each triangle for
/// each light.
pub const MAX_TRIANGLES: u64 = 16 << 20;
/// Maximum number of pixels of one picture: 8192 x 8192, the largest texture within WebGPU's default limits.
pub const MAX_IMAGE_PIXELS: u64 = 1 << 26;
/// Maximum number of pixels along one side of a picture, which follows from the same limit of WebGPU.
pub const MAX_IMAGE_SIDE: u64 = 8192;
/// Maximum number of bytes of all decoded pictures together.
pub const MAX_TEXTURE_BYTES: u64 = 512 << 20;
/// Maximum absolute value of world coordinates. The renderer squares and multiplies them in f32, whose range ends at
/// 3e38.
pub const MAX_COORDINATE: u64 = 1_000_000_000;
/// Maximum number of characters of a name. Longer names are cut.
pub const MAX_NAME_CHARS: usize = 200;
/// Maximum number of characters of untrusted text that a message shows.
pub const MAX_MESSAGE_CHARS: usize = 80;

/// Limits that a file can exceed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum ImportLimit {
    /// [`MAX_BYTES_READ`]
    BytesRead,
    /// [`MAX_JSON_DEPTH`]
    JsonDepth,
    /// [`MAX_JSON_VALUES`]
    JsonValues,
    /// [`MAX_NODES`]
    Nodes,
    /// [`MAX_VERTICES`]
    Vertices,
    /// [`MAX_TRIANGLES`]
    Triangles,
    /// [`MAX_IMAGE_PIXELS`]
    ImagePixels,
    /// [`MAX_IMAGE_SIDE`]
    ImageSide,
    /// [`MAX_TEXTURE_BYTES`]
    TextureBytes,
    /// [`MAX_COORDINATE`]
    Coordinate,
}

impl ImportLimit {
    /// Returns the largest value allowed.
    pub fn max_value(self) -> u64 {
        match self {
            Self::BytesRead => MAX_BYTES_READ,
            Self::JsonDepth => MAX_JSON_DEPTH,
            Self::JsonValues => MAX_JSON_VALUES,
            Self::Nodes => MAX_NODES,
            Self::Vertices => MAX_VERTICES,
            Self::Triangles => MAX_TRIANGLES,
            Self::ImagePixels => MAX_IMAGE_PIXELS,
            Self::ImageSide => MAX_IMAGE_SIDE,
            Self::TextureBytes => MAX_TEXTURE_BYTES,
            Self::Coordinate => MAX_COORDINATE,
        }
    }

    /// Returns the name of the counted quantity.
    pub fn quantity(self) -> &'static str {
        match self {
            Self::BytesRead => "bytes in the scene's files",
            Self::JsonDepth => "levels of nested JSON",
            Self::JsonValues => "values in the JSON",
            Self::Nodes => "nodes and instances",
            Self::Vertices => "vertices",
            Self::Triangles => "triangles",
            Self::ImagePixels => "pixels in one picture",
            Self::ImageSide => "pixels along one side of a picture",
            Self::TextureBytes => "bytes of decoded pictures",
            Self::Coordinate => "world units from the origin",
        }
    }

    /// Returns advice for the author of the file.
    pub fn fix(self) -> &'static str {
        match self {
            Self::BytesRead => "split the scene or compress its pictures",
            Self::JsonDepth => "export it again without custom data",
            Self::JsonValues | Self::Nodes => "join or leave out objects",
            Self::Vertices | Self::Triangles => "simplify the meshes",
            Self::ImagePixels | Self::ImageSide | Self::TextureBytes => "scale the pictures down",
            Self::Coordinate => "move the scene to the origin or scale it down",
        }
    }

    /// Returns an error if `found` exceeds the limit.
    pub fn check(self, found: u64) -> Result<(), AssetFault> {
        if found > self.max_value() { Err(AssetFault::Limit { limit: self, found }) } else { Ok(()) }
    }
}

/// Amounts that one load has used so far, by limit.
#[derive(Debug, Default)]
pub struct Budget(BTreeMap<ImportLimit, u64>);

impl Budget {
    /// Adds `amount` to the use of `limit`, and returns an error if it exceeds the limit. Call it before the
    /// allocation.
    pub fn spend(&mut self, limit: ImportLimit, amount: u64) -> Result<(), AssetFault> {
        let spent = self.0.entry(limit).or_default();
        *spent = spent.saturating_add(amount);
        limit.check(*spent)
    }
}
