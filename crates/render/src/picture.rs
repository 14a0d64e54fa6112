//! Pictures, and their PNG files.

use image::{Rgb, RgbImage};
use light::LightInstance;
use png::{BitDepth, ColorType, Compression, SrgbRenderingIntent};

use crate::exposure;
use crate::{Aov, RenderError, View};

/// Raw linear values of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct Picture {
    /// In pixels.
    pub width: u32,
    /// In pixels.
    pub height: u32,
    /// Rows from the top, `width * height` pixels.
    pub pixels: Vec<[f32; 4]>,
}

/// Background of a PNG, where a pixel shows no surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Background {
    /// Black, as on a screen.
    #[default]
    Black,
    /// Transparent: alpha is the share of a pixel that surfaces cover, and colors are those of the surfaces alone.
    Transparent,
}

/// Pixels that were read back, for a screen, for programs, or for both.
#[derive(Clone, Debug, PartialEq)]
pub enum Pixels {
    /// RGBA for a screen, 8 bits per channel, rows from the top.
    Display {
        /// In pixels.
        width: u32,
        /// In pixels.
        height: u32,
        /// Four bytes per pixel.
        bytes: Vec<u8>,
    },
    /// Linear values, for programs.
    Raw(Picture),
    /// Linear values, and RGBA for a screen with four bytes per pixel, both from one drawing.
    Both(Picture, Vec<u8>),
}

/// Form in which files need the pixels of a picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileNeeds {
    /// RGBA for a screen, for a PNG of the beauty.
    Display,
    /// Linear values, for an EXR or for a PNG of another AOV.
    Values,
    /// Linear values and RGBA for a screen, both from one drawing.
    Both,
}

impl FileNeeds {
    /// Returns the form that the files of an AOV need. `png` is the background of a PNG, `None` for no PNG. `exr` is
    /// true for an EXR.
    pub fn of(aov: Aov, png: Option<Background>, exr: bool) -> Self {
        let is_shown = aov == Aov::Beauty && png == Some(Background::Black);
        match (is_shown, exr) {
            (true, false) => Self::Display,
            (true, true) => Self::Both,
            (false, _) => Self::Values,
        }
    }
}

impl Pixels {
    /// Returns the linear values, if present.
    pub fn values(&self) -> Option<&Picture> {
        match self {
            Self::Raw(picture) | Self::Both(picture, _) => Some(picture),
            Self::Display { .. } => None,
        }
    }

    /// Encodes a readable PNG of `view` under `lights`: the screen's bytes if present, else the values by
    /// [`Picture::to_png`].
    pub fn to_png(
        &self,
        view: &View,
        lights: &[LightInstance],
        background: Background,
    ) -> Result<Vec<u8>, RenderError> {
        let shown = |bytes: &[u8]| {
            let pixels = bytes.as_chunks::<4>().0.iter();
            let rgb: Vec<u8> = pixels.flat_map(|[r, g, b, _]| [*r, *g, *b]).collect();
            png_of(view, ColorType::Rgb, &rgb)
        };
        match self {
            Self::Display { bytes, .. } => shown(bytes),
            Self::Both(_, bytes) if background == Background::Black => shown(bytes),
            Self::Raw(picture) | Self::Both(picture, _) => picture.to_png(view, lights, background),
        }
    }
}

impl Picture {
    /// Encodes a readable PNG, with an sRGB chunk, of a picture of `view` under `lights` by any renderer. Compression
    /// of a large picture takes seconds.
    ///
    /// Depth is bright where near. Directions and normals are `(x + 1) / 2`, positions a share of the box that all of
    /// them fill. t is a ramp over the light's segments, dark at joints. (v, w) are hue and distance from the curve.
    /// The beauty is tone-mapped as by [`crate::Renderer::render_display`]. A wireframe's edges are white. Pixels
    /// without a value are black.
    pub fn to_png(
        &self,
        view: &View,
        lights: &[LightInstance],
        background: Background,
    ) -> Result<Vec<u8>, RenderError> {
        let segments = segments(lights.get(view.light));
        let (color_type, bytes) = match background {
            Background::Black => (ColorType::Rgb, visualize(self, view, segments).into_raw()),
            Background::Transparent => {
                let shown = visualize(&self.without_background(view.aov), view, segments);
                let with_alpha = shown.pixels().zip(&self.pixels).flat_map(|(Rgb([r, g, b]), [.., alpha])| {
                    [*r, *g, *b, (alpha.clamp(0.0, 1.0) * 255.0).round() as u8]
                });
                (ColorType::Rgba, with_alpha.collect())
            }
        };
        png_of(view, color_type, &bytes)
    }

    /// Returns the beauty of the surfaces alone, without the share of black background in edge pixels.
    fn without_background(&self, aov: Aov) -> Self {
        let mut picture = self.clone();
        if aov == Aov::Beauty {
            for [color @ .., alpha] in picture.pixels.iter_mut().filter(|[.., alpha]| *alpha > 0.0) {
                *color = color.map(|c| c / *alpha);
            }
        }
        picture
    }
}

/// Encodes a PNG of `view`'s size with an sRGB chunk.
fn png_of(view: &View, color_type: ColorType, bytes: &[u8]) -> Result<Vec<u8>, RenderError> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, view.width, view.height);
    encoder.set_color(color_type);
    encoder.set_depth(BitDepth::Eight);
    encoder.set_compression(Compression::Fast);
    encoder.set_source_srgb(SrgbRenderingIntent::Perceptual);
    let refused = |why: png::EncodingError| RenderError::Encode(why.to_string());
    let mut writer = encoder.write_header().map_err(refused)?;
    writer.write_image_data(bytes).map_err(refused)?;
    writer.finish().map_err(refused)?;
    Ok(file)
}

/// Returns the end of t's range in a light: its number of segments, 1 for a spotlight.
fn segments(instance: Option<&LightInstance>) -> usize {
    instance.and_then(|instance| instance.light.tube()).map_or(1, |tube| tube.n)
}

/// A screen color, each channel 0 to 1.
type Color = [f32; 3];

/// Returns the picture of `view` for a screen; black where a pixel has no value. `segments` is the end of t's range.
///
/// - depth: near is bright, far is dark, over the range in the picture;
/// - position: x, y and z over the range of each;
/// - normal, direction: `(x + 1) / 2`;
/// - t: a ramp over `[0, segments]`, dark at joints;
/// - vw: hue by the angle around the curve, brightness by the distance from it in radii;
/// - beauty: exposed and tone-mapped;
/// - visibility: unchanged;
/// - wireframe: t's ramp with the edges in white, darker outside the tube.
fn visualize(picture: &Picture, view: &View, segments: usize) -> RgbImage {
    let exposed = exposure::from_stops(view.exposure);
    let color: &dyn Fn(usize, [f32; 4]) -> Color = match view.aov {
        Aov::Beauty => &|_, [x, y, z, _]| tone_mapped([x, y, z].map(|c| exposure::exposed(c, exposed))),
        Aov::Visibility => &|_, [x, y, z, _]| [x, y, z],
        Aov::Normal | Aov::Direction => &|_, [x, y, z, _]| [x, y, z].map(|c| 0.5 + 0.5 * c),
        Aov::Position => {
            let [x, y, z] = [0, 1, 2].map(|channel| range(picture, channel));
            &move |_, [a, b, c, _]| {
                [(a, x), (b, y), (c, z)].map(|(at, (low, high))| (at - low) / (high - low).max(f32::MIN_POSITIVE))
            }
        }
        Aov::Depth => {
            let (near, far) = range(picture, 0);
            &move |_, [depth, ..]| [1.0 - 0.9 * (depth - near) / (far - near).max(f32::MIN_POSITIVE); 3]
        }
        Aov::T => &|index, [t, ..]| {
            let shade = if is_at_joint(picture, index) { 0.3 } else { 1.0 };
            ramp(t / segments as f32).map(|c| c * shade)
        },
        Aov::Vw => &|_, [v, w, ..]| hue_around(v, w),
        Aov::Wireframe => &|index, [t, edge, ..]| {
            let shade = if is_in_tube(picture, index) { 0.7 } else { 0.3 };
            ramp(t / segments as f32).map(|c| shade * (c + (1.0 - c) * edge))
        },
    };
    RgbImage::from_fn(picture.width, picture.height, |x, y| {
        let index = (y * picture.width + x) as usize;
        let pixel = picture.pixels[index];
        let shown = if has_value(pixel) { color(index, pixel) } else { [0.0; 3] };
        Rgb(shown.map(|c| (c.clamp(0.0, 1.0) * 255.0).round() as u8))
    })
}

/// Tone-maps linear radiance as in `display.wgsl`: Khronos PBR Neutral, then sRGB.
fn tone_mapped(linear: Color) -> Color {
    const START: f32 = 0.8 - 0.04;
    const DESATURATION: f32 = 0.15;
    let low = linear.into_iter().fold(f32::INFINITY, f32::min);
    let offset = if low < 0.08 { low - 6.25 * low * low } else { 0.04 };
    let color = linear.map(|c| c - offset);
    let peak = color.into_iter().fold(f32::NEG_INFINITY, f32::max);
    let mapped = if peak < START {
        color
    } else {
        let room = 1.0 - START;
        let new_peak = 1.0 - room * room / (peak + room - START);
        let white = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
        color.map(|c| (c * (new_peak / peak)) * (1.0 - white) + new_peak * white)
    };
    mapped.map(|c| {
        let c = c.clamp(0.0, 1.0);
        if c <= 0.003_130_8 { 12.92 * c } else { 1.055 * c.powf(1.0 / 2.4) - 0.055 }
    })
}

/// True unless the alpha is 0, as for a pixel without a surface, or out of the light's reach.
fn has_value([.., alpha]: [f32; 4]) -> bool {
    alpha > 0.0
}

/// Returns the smallest and largest value of a channel.
fn range(picture: &Picture, channel: usize) -> (f32, f32) {
    let values = picture.pixels.iter().filter(|pixel| has_value(**pixel)).map(|pixel| pixel[channel]);
    values.fold((f32::INFINITY, f32::NEG_INFINITY), |(low, high), x| (low.min(x), high.max(x)))
}

/// True if the pixel to the right or below is in another segment.
fn is_at_joint(picture: &Picture, index: usize) -> bool {
    let width = picture.width as usize;
    let here = picture.pixels[index];
    let right = (index % width + 1 < width).then_some(index + 1);
    [right, Some(index + width)].into_iter().flatten().any(|neighbour| {
        picture.pixels.get(neighbour).is_some_and(|&there| has_value(there) && here[0].floor() != there[0].floor())
    })
}

/// True if a pixel of a wireframe is in the tube.
fn is_in_tube(picture: &Picture, index: usize) -> bool {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let from_middle = |at: usize, size: usize| (2 * at + 1) as f32 - size as f32;
    from_middle(index % width, width).hypot(from_middle(index / width, height)) <= width.min(height) as f32
}

/// Returns a ramp from dark blue over green to yellow, uniform in lightness, for `x` from 0 to 1.
fn ramp(x: f32) -> Color {
    const STOPS: [Color; 5] =
        [[0.17, 0.11, 0.42], [0.12, 0.34, 0.60], [0.10, 0.56, 0.55], [0.45, 0.75, 0.33], [0.99, 0.91, 0.24]];
    let x = x.clamp(0.0, 1.0) * (STOPS.len() - 1) as f32;
    let i = (x as usize).min(STOPS.len() - 2);
    let share = x - i as f32;
    std::array::from_fn(|k| STOPS[i][k] + (STOPS[i + 1][k] - STOPS[i][k]) * share)
}

/// Returns the hue by the angle of (v, w), red along +v; from gray on the curve to full saturation at the tube's edge.
fn hue_around(v: f32, w: f32) -> Color {
    let (turn, rho) = (w.atan2(v) / std::f32::consts::TAU, v.hypot(w).min(1.0));
    std::array::from_fn(|k| {
        // Each channel is full within a sixth of a turn of its own hue and zero a third away.
        let away = (turn - k as f32 / 3.0).rem_euclid(1.0);
        let hue = (2.0 - 6.0 * away.min(1.0 - away)).clamp(0.0, 1.0);
        0.5 + (hue - 0.5) * rho
    })
}

#[cfg(test)]
mod tests {
    use scene::{Scene, framing_camera};

    use super::*;

    /// Returns the bytes of a row of pixels.
    fn row(aov: Aov, pixels: &[[f32; 4]]) -> Vec<[u8; 3]> {
        let picture = Picture { width: pixels.len() as u32, height: 1, pixels: pixels.to_vec() };
        let view =
            View { aov, ..View::beauty(framing_camera(&scene::pose(Scene::default(), 0.0).bounds(), 1.0), [1, 1]) };
        visualize(&picture, &view, 2).pixels().map(|pixel| pixel.0).collect()
    }

    #[test]
    fn what_has_no_value_is_black() {
        for aov in [Aov::Depth, Aov::Normal, Aov::T, Aov::Vw, Aov::Direction, Aov::Visibility, Aov::Wireframe] {
            assert_eq!(row(aov, &[[1.0, 1.0, 1.0, 0.0], [f32::NAN, f32::NAN, f32::NAN, 0.0]]), [[0; 3]; 2]);
        }
    }

    #[test]
    fn near_is_bright_and_far_is_dark() {
        let depth = |d| [d, 0.0, 0.0, 1.0];
        let shown = row(Aov::Depth, &[depth(2.0), depth(4.0), depth(6.0)]);
        assert_eq!(shown, [[255; 3], [140; 3], [26; 3]]);
        assert_eq!(row(Aov::Depth, &[depth(3.0); 2]), [[255; 3]; 2], "one depth everywhere");
    }

    #[test]
    fn axes_have_their_colours() {
        assert_eq!(row(Aov::Normal, &[[1.0, 0.0, -1.0, 1.0]]), [[255, 128, 0]]);
        assert_eq!(row(Aov::Vw, &[[1.0, 0.0, 0.0, 1.0], [0.0, 0.0, 0.0, 1.0]]), [[255, 0, 0], [128; 3]]);
        assert_eq!(row(Aov::Visibility, &[[0.5, 0.5, 0.5, 1.0]]), [[128; 3]]);
    }

    #[test]
    fn the_ramp_grows_lighter_and_is_dark_at_joints() {
        let luma = |c: &[u8; 3]| 2 * u32::from(c[0]) + 7 * u32::from(c[1]) + u32::from(c[2]);
        let at = |t: f32| luma(&row(Aov::T, &[[t, 0.0, 0.0, 1.0]])[0]);
        let steps: Vec<u32> = (0..=8).map(|i| at(i as f32 / 4.0)).collect();
        assert!(steps.windows(2).all(|pair| pair[0] < pair[1]), "{steps:?}");
        let joint = row(Aov::T, &[[0.95, 0.0, 0.0, 1.0], [1.05, 0.0, 0.0, 1.0]]);
        assert!(luma(&joint[0]) < luma(&joint[1]) / 2);
    }
}
