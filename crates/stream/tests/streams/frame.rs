//! The header on the wire, byte by byte.

use proptest::prelude::*;
use stream::{Codec, FrameFlags, FrameHeader, FrameTile, HEADER_BYTES, StreamError};

/// Returns a header in which each field has its own bytes, so a field at a wrong offset shows.
fn header() -> FrameHeader {
    FrameHeader {
        codec: Codec::Png,
        flags: FrameFlags { is_key: true, is_settled: false, is_last_tile: true },
        view: 0x0403_0201,
        frame: 0x1817_1615_1413_1211,
        log_seq: 0x2827_2625_2423_2221,
        camera_revision: 0x3433_3231,
        live_revision: 0x3837_3635,
        samples: 0x4241,
        shadow_map_divisor: 0x4443,
        tile: FrameTile { x: 0x5251, y: 0x5453, width: 0x5655, height: 0x5857 },
        width: 0x6261,
        height: 0x6463,
        wait_us: 0x7473_7271,
        render_us: 0x7877_7675,
        encode_us: 0x8483_8281,
        view_width: 0x8685,
        view_height: 0x8887,
    }
}

/// The offsets of section 8, written out.
#[test]
fn fields_stand_where_the_protocol_says() {
    #[rustfmt::skip]
    let expected: [u8; HEADER_BYTES] = [
        1, 2, 5, 0, 0x01, 0x02, 0x03, 0x04,
        0x11, 0x12, 0x13, 0x14, 0x15, 0x16, 0x17, 0x18,
        0x21, 0x22, 0x23, 0x24, 0x25, 0x26, 0x27, 0x28,
        0x31, 0x32, 0x33, 0x34, 0x35, 0x36, 0x37, 0x38,
        0x41, 0x42, 0x43, 0x44, 0x51, 0x52, 0x53, 0x54,
        0x55, 0x56, 0x57, 0x58, 0x61, 0x62, 0x63, 0x64,
        0x71, 0x72, 0x73, 0x74, 0x75, 0x76, 0x77, 0x78,
        0x81, 0x82, 0x83, 0x84, 0x85, 0x86, 0x87, 0x88,
    ];
    assert_eq!(header().to_bytes(), expected);
    let jpeg = FrameHeader { codec: Codec::Jpeg, flags: FrameFlags::default(), ..header() };
    assert_eq!(jpeg.to_bytes()[..4], [1, 1, 0, 0]);
    let settle = FrameHeader { flags: FrameFlags { is_settled: true, ..FrameFlags::default() }, ..header() };
    assert_eq!(settle.to_bytes()[2..4], [2, 0]);
}

#[test]
fn a_message_that_is_no_frame_is_refused_with_a_sentence() {
    let with = |offset: usize, value: u8| {
        let mut bytes = header().to_bytes();
        bytes[offset] = value;
        FrameHeader::from_bytes(&bytes).expect_err("not a frame")
    };
    assert_eq!(with(0, 2), StreamError::Unknown { field: "kind", value: 2 });
    assert_eq!(with(1, 0), StreamError::Unknown { field: "codec", value: 0 });
    assert_eq!(with(2, 8), StreamError::Unknown { field: "flags", value: 8 });
    let short = FrameHeader::from_bytes(&header().to_bytes()[..63]).expect_err("cut off");
    assert_eq!(short.to_string(), "a frame begins with 64 bytes of header, but the message has 63: send it whole");
}

proptest! {
    /// Any message is either read or refused. A header that is read is written back unchanged.
    #[test]
    fn a_header_that_is_read_is_written_back(
        mut message in proptest::collection::vec(any::<u8>(), 0..80),
        sound in any::<bool>(),
    ) {
        if sound && message.len() >= HEADER_BYTES {
            (message[0], message[1], message[2], message[3]) = (1, 1 + message[1] % 2, message[2] % 8, 0);
        }
        if let Ok(header) = FrameHeader::from_bytes(&message) {
            prop_assert_eq!(&header.to_bytes()[..], &message[..HEADER_BYTES]);
        } else {
            prop_assert!(!sound || message.len() < HEADER_BYTES);
        }
    }
}
