//! The header before the payload of a frame: section 8 of the protocol.

use crate::StreamError;

/// Size of a frame header in bytes.
pub const HEADER_BYTES: usize = 64;

/// The only kind of frame in version 1.
const PICTURE: u8 = 1;

/// Encoding of the payload.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Codec {
    /// Lossy, while something moves.
    Jpeg,
    /// Lossless.
    Png,
}

/// Flags of a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct FrameFlags {
    /// The frame needs no earlier frame and replaces all of them.
    pub is_key: bool,
    /// The frame belongs to the lossless picture of a still view.
    pub is_settled: bool,
    /// This tile completes the picture.
    pub is_last_tile: bool,
}

/// Rectangle of a picture that a frame holds, in pixels from the top left.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameTile {
    pub x: u16,
    pub y: u16,
    pub width: u16,
    pub height: u16,
}

/// Content of a frame, its origin and its times.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FrameHeader {
    pub codec: Codec,
    pub flags: FrameFlags,
    /// Number of the view on its connection.
    pub view: u32,
    /// Number of the frame. Counts from 1 on each connection.
    pub frame: u64,
    /// Sequence number of the latest log record that the frame shows.
    pub log_seq: u64,
    /// Revision of the view's camera.
    pub camera_revision: u32,
    /// Revision of the session's live gestures.
    pub live_revision: u32,
    /// Samples per pixel.
    pub samples: u16,
    /// Divisor of the shadow maps' texels per side. 1 at full size.
    pub shadow_map_divisor: u16,
    /// Position of the payload in the picture.
    pub tile: FrameTile,
    /// Width of the whole picture in pixels.
    pub width: u16,
    /// Height of the whole picture in pixels.
    pub height: u16,
    /// Microseconds from the change to the start of the render.
    pub wait_us: u32,
    pub render_us: u32,
    pub encode_us: u32,
    /// Width of the view in pixels. A picture that is reduced while something moves is shown at this size.
    pub view_width: u16,
    /// Height of the view in pixels.
    pub view_height: u16,
}

impl FrameHeader {
    /// Returns the header in its wire form. The payload follows it.
    pub fn to_bytes(&self) -> [u8; HEADER_BYTES] {
        let mut bytes = [0; HEADER_BYTES];
        let mut put = |offset: usize, field: &[u8]| bytes[offset..offset + field.len()].copy_from_slice(field);
        let codec = match self.codec {
            Codec::Jpeg => 1,
            Codec::Png => 2,
        };
        put(0, &[PICTURE, codec]);
        put(2, &self.flags.to_bits().to_le_bytes());
        put(4, &self.view.to_le_bytes());
        put(8, &self.frame.to_le_bytes());
        put(16, &self.log_seq.to_le_bytes());
        put(24, &self.camera_revision.to_le_bytes());
        put(28, &self.live_revision.to_le_bytes());
        put(32, &self.samples.to_le_bytes());
        put(34, &self.shadow_map_divisor.to_le_bytes());
        let FrameTile { x, y, width, height } = self.tile;
        for (index, side) in [x, y, width, height, self.width, self.height].into_iter().enumerate() {
            put(36 + 2 * index, &side.to_le_bytes());
        }
        put(48, &self.wait_us.to_le_bytes());
        put(52, &self.render_us.to_le_bytes());
        put(56, &self.encode_us.to_le_bytes());
        put(60, &self.view_width.to_le_bytes());
        put(62, &self.view_height.to_le_bytes());
        bytes
    }

    /// Reads the header at the beginning of a message. The payload begins at [`HEADER_BYTES`].
    pub fn from_bytes(message: &[u8]) -> Result<Self, StreamError> {
        let header: &[u8; HEADER_BYTES] = message.first_chunk().ok_or(StreamError::Short(message.len()))?;
        let u16_at = |offset: usize| u16::from_le_bytes(array_at(header, offset));
        let u32_at = |offset: usize| u32::from_le_bytes(array_at(header, offset));
        let u64_at = |offset: usize| u64::from_le_bytes(array_at(header, offset));
        if header[0] != PICTURE {
            return Err(StreamError::Unknown { field: "kind", value: header[0].into() });
        }
        let codec = match header[1] {
            1 => Codec::Jpeg,
            2 => Codec::Png,
            other => return Err(StreamError::Unknown { field: "codec", value: other.into() }),
        };
        Ok(Self {
            codec,
            flags: FrameFlags::from_bits(u16_at(2))?,
            view: u32_at(4),
            frame: u64_at(8),
            log_seq: u64_at(16),
            camera_revision: u32_at(24),
            live_revision: u32_at(28),
            samples: u16_at(32),
            shadow_map_divisor: u16_at(34),
            tile: FrameTile { x: u16_at(36), y: u16_at(38), width: u16_at(40), height: u16_at(42) },
            width: u16_at(44),
            height: u16_at(46),
            wait_us: u32_at(48),
            render_us: u32_at(52),
            encode_us: u32_at(56),
            view_width: u16_at(60),
            view_height: u16_at(62),
        })
    }
}

fn array_at<const N: usize>(header: &[u8; HEADER_BYTES], offset: usize) -> [u8; N] {
    std::array::from_fn(|k| header[offset + k])
}

impl FrameFlags {
    const KEY: u16 = 1;
    const SETTLE: u16 = 2;
    const LAST_TILE: u16 = 4;

    fn to_bits(self) -> u16 {
        let bit = |set: bool, bit: u16| if set { bit } else { 0 };
        bit(self.is_key, Self::KEY) | bit(self.is_settled, Self::SETTLE) | bit(self.is_last_tile, Self::LAST_TILE)
    }

    fn from_bits(bits: u16) -> Result<Self, StreamError> {
        if bits & !(Self::KEY | Self::SETTLE | Self::LAST_TILE) != 0 {
            return Err(StreamError::Unknown { field: "flags", value: bits.into() });
        }
        let has = |bit: u16| bits & bit != 0;
        Ok(Self { is_key: has(Self::KEY), is_settled: has(Self::SETTLE), is_last_tile: has(Self::LAST_TILE) })
    }
}
