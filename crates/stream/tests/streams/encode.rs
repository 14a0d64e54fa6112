//! Output of the encoders, read back with another library.

#![expect(clippy::disallowed_methods, reason = "what is expected is computed within bounds, not to the bit")]

use image::RgbImage;
use stream::{MOVING_QUALITY, StreamError, jpeg, png};

/// Returns a smooth picture with one hard edge, like a lit scene.
fn picture(width: u16, height: u16) -> Vec<u8> {
    let pixel = |x: u16, y: u16| {
        let shade = if u32::from(x) * 2 > u32::from(width) { 40 } else { 0 };
        [(x / 2 % 200) as u8 + shade, (y / 2 % 200) as u8 + shade, 90, 255]
    };
    (0..height).flat_map(|y| (0..width).flat_map(move |x| pixel(x, y))).collect()
}

fn decoded(bytes: &[u8]) -> RgbImage {
    image::load_from_memory(bytes).expect("a sound picture").into_rgb8()
}

/// Returns the root mean square of the difference of all channels, in steps of 1/255.
fn error(rgba: &[u8], decoded: &RgbImage) -> f64 {
    let pairs = rgba.chunks_exact(4).flat_map(|pixel| &pixel[..3]).zip(decoded.as_raw());
    let (sum, count) =
        pairs.fold((0.0, 0.0), |(sum, count), (&a, &b)| (sum + (f64::from(a) - f64::from(b)).powi(2), count + 1.0));
    f64::sqrt(sum / count)
}

#[test]
fn png_gives_every_colour_back() {
    for (width, height) in [(1, 1), (1, 9), (17, 3), (64, 48)] {
        let pixels = picture(width, height);
        let back = decoded(&png(&pixels, width, height).unwrap());
        assert_eq!(back.dimensions(), (width.into(), height.into()));
        assert_eq!(error(&pixels, &back), 0.0);
        // Deliberate fault that the check must detect: one channel of one pixel is off by one.
        let mut damaged = pixels;
        damaged[0] ^= 1;
        assert!(error(&damaged, &back) > 0.0);
    }
}

/// Higher quality takes more bytes and gives a smaller error. Sizes that are no multiple of a block come back whole.
#[test]
fn jpeg_comes_closer_with_quality() {
    let (width, height) = (131, 67);
    let pixels = picture(width, height);
    let of = |quality| {
        let bytes = jpeg(&pixels, width, height, quality).unwrap();
        let back = decoded(&bytes);
        assert_eq!(back.dimensions(), (width.into(), height.into()));
        (bytes.len(), error(&pixels, &back))
    };
    let [low, moving, high] = [of(20), of(MOVING_QUALITY), of(98)];
    assert!(low.0 < moving.0 && moving.0 < high.0, "{low:?} {moving:?} {high:?}");
    assert!(low.1 > moving.1 && moving.1 > high.1, "{low:?} {moving:?} {high:?}");
}

#[test]
fn pixels_of_another_size_are_refused_with_a_sentence() {
    let pixels = picture(4, 4);
    let refused = png(&pixels, 4, 5).expect_err("a row is missing");
    assert_eq!(refused.to_string(), "a picture of 4x5 has 80 bytes, not 64: pass 4 bytes for each pixel");
    assert_eq!(jpeg(&pixels, 4, 5, 85), Err(refused));
    assert_eq!(png(&[], 0, 4), Err(StreamError::Empty { width: 0, height: 4 }));
    assert_eq!(jpeg(&[], 4, 0, 85), Err(StreamError::Empty { width: 4, height: 0 }));
    for quality in [0, 101] {
        assert_eq!(jpeg(&pixels, 4, 4, quality), Err(StreamError::JpegQuality(quality)));
    }
}
