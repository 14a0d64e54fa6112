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

/// Largest value of a limit, and its texts.
struct LimitRow {
    max_value: u64,
    quantity: &'static str,
    fix: &'static str,
}

impl ImportLimit {
    fn row(self) -> LimitRow {
        let row = |max_value, quantity, fix| LimitRow { max_value, quantity, fix };
        let (fewer, simpler, smaller) = ("join or leave out objects", "simplify the meshes", "scale the pictures down");
        match self {
            Self::BytesRead => {
                row(MAX_BYTES_READ, "bytes in the scene's files", "split the scene or compress its pictures")
            }
            Self::JsonDepth => row(MAX_JSON_DEPTH, "levels of nested JSON", "export it again without custom data"),
            Self::JsonValues => row(MAX_JSON_VALUES, "values in the JSON", fewer),
            Self::Nodes => row(MAX_NODES, "nodes and instances", fewer),
            Self::Vertices => row(MAX_VERTICES, "vertices", simpler),
            Self::Triangles => row(MAX_TRIANGLES, "triangles", simpler),
            Self::ImagePixels => row(MAX_IMAGE_PIXELS, "pixels in one picture", smaller),
            Self::ImageSide => row(MAX_IMAGE_SIDE, "pixels along one side of a picture", smaller),
            Self::TextureBytes => row(MAX_TEXTURE_BYTES, "bytes of decoded pictures", smaller),
            Self::Coordinate => {
                row(MAX_COORDINATE, "world units from the origin", "move the scene to the origin or scale it down")
            }
        }
    }

    /// Returns the largest value allowed.
    pub fn max_value(self) -> u64 {
        self.row().max_value
    }

    /// Returns the name of the counted quantity.
    pub fn quantity(self) -> &'static str {
        self.row().quantity
    }

    /// Returns advice for the author of the file.
    pub fn fix(self) -> &'static str {
        self.row().fix
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
