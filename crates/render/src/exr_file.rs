//! EXR files: the AOVs of one view, with the channel names that programs expect, and the picture's origin in the
//! header.
//!
//! | quantity | channels | type |
//! |---|---|---|
//! | beauty | `R`, `G`, `B` | float |
//! | depth | `Z`, infinite in the background | float |
//! | normal | `N.X`, `N.Y`, `N.Z` | half |
//! | position | `P.X`, `P.Y`, `P.Z` | float |
//! | t, vw, wireframe | `t`; `v`, `w`; `t`, `edge` | float |
//! | direction | `direction.X`, `direction.Y`, `direction.Z` | half |
//! | visibility | `visibility` | half |
//!
//! `A`, float, is the share of a pixel that a surface covers; for AOVs of a light, the share that the light reaches. If
//! a file has AOVs of several lights, their channels have the light's name as prefix: `key.visibility`, `key.A`. Half
//! holds a unit vector to 2.4e-4 and a share to as much; sums of radiance need more.

use std::io::Cursor;

use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer};
use exr::meta::attribute::{AttributeValue, Chromaticities, Text};
use exr::meta::header::LayerAttributes;
use exr::prelude::{Blocks, Compression, LineOrder, Vec2};
use glam::{DMat4, DVec2, DVec4};
use half::f16;
use scene::{Camera, Projection, ViewRay};

use crate::{Aov, Picture, RenderError, View};

/// Session, record, scene, overrides and lights from which a picture was made, for the header of its EXR file.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct PictureOrigin {
    /// Name of the session or the scene.
    pub name: Option<String>,
    /// Number of the session's record that the picture shows.
    pub seq: Option<u64>,
    /// Hash of the document.
    pub document_hash: Option<String>,
    /// Hash of the scene, or a name if it has none.
    pub scene: Option<String>,
    /// Overrides of this picture alone: addresses and values as JSON.
    pub set: Option<String>,
    /// Names of the active lights as a JSON array; `None` if all lights of the document are active.
    pub lights: Option<String>,
}

/// Channels of one view.
#[derive(Debug)]
pub struct ExrFile {
    size: [u32; 2],
    channels: Vec<AnyChannel<FlatSamples>>,
}

/// Alpha channel. It is a float channel like the colors, because programs expect `RGBA` to have one type.
const ALPHA: (&str, usize, bool) = ("A", 3, false);

/// Channels of an AOV: name, index among a pixel's four values, and true if half suffices.
fn channels_of(aov: Aov) -> &'static [(&'static str, usize, bool)] {
    match aov {
        Aov::Beauty => &[("R", 0, false), ("G", 1, false), ("B", 2, false)],
        Aov::Depth => &[("Z", 0, false)],
        Aov::Normal => &[("N.X", 0, true), ("N.Y", 1, true), ("N.Z", 2, true)],
        Aov::Position => &[("P.X", 0, false), ("P.Y", 1, false), ("P.Z", 2, false)],
        Aov::T => &[("t", 0, false)],
        Aov::Vw => &[("v", 0, false), ("w", 1, false)],
        Aov::Direction => &[("direction.X", 0, true), ("direction.Y", 1, true), ("direction.Z", 2, true)],
        Aov::Visibility => &[("visibility", 0, true)],
        Aov::Wireframe => &[("t", 0, false), ("edge", 1, false)],
    }
}

impl ExrFile {
    /// Makes a file without channels, for pictures of `size`.
    pub fn new(size: [u32; 2]) -> Self {
        Self { size, channels: Vec::new() }
    }

    /// Returns the bytes per pixel of an AOV, with its alpha.
    pub fn bytes_a_pixel(aov: Aov) -> usize {
        let of = |&(_, _, half): &(&str, usize, bool)| if half { 2 } else { 4 };
        channels_of(aov).iter().chain([&ALPHA]).map(of).sum()
    }

    /// Adds the channels of `aov` from `picture`. `light` prefixes their names if the file has several lights.
    pub fn add(&mut self, aov: Aov, light: Option<&str>, picture: &Picture) {
        let prefixed = |name: &str| light.map_or_else(|| name.to_owned(), |light| format!("{light}.{name}"));
        let value = |index: usize| {
            picture.pixels.iter().map(move |pixel| match aov {
                // The background is infinitely far.
                Aov::Depth if pixel[3] == 0.0 && index == 0 => f32::INFINITY,
                _ => pixel[index],
            })
        };
        for &(name, index, half) in channels_of(aov).iter().chain([&ALPHA]) {
            let name = prefixed(name);
            if self.channels.iter().any(|channel| channel.name == *name.as_str()) {
                continue;
            }
            let samples = if half {
                FlatSamples::F16(value(index).map(f16::from_f32).collect())
            } else {
                FlatSamples::F32(value(index).collect())
            };
            self.channels.push(AnyChannel::new(name.as_str(), samples));
        }
    }

    /// Encodes the file with ZIP compression, on this thread alone. It takes about a second for a few million pixels.
    pub fn into_bytes(self, view: &View, origin: &PictureOrigin) -> Result<Vec<u8>, RenderError> {
        let [width, height] = self.size.map(|side| side as usize);
        let encoding =
            Encoding { compression: Compression::ZIP16, blocks: Blocks::ScanLines, line_order: LineOrder::Increasing };
        let channels = AnyChannels::sort(self.channels.into_iter().collect());
        let layer = Layer::new((width, height), attributes(view, origin), encoding, channels);
        let mut image = Image::from_layer(layer);
        // Rec. 709, whose primaries and white point linear sRGB has.
        image.attributes.chromaticities = Some(Chromaticities {
            red: Vec2(0.64, 0.33),
            green: Vec2(0.3, 0.6),
            blue: Vec2(0.15, 0.06),
            white: Vec2(0.3127, 0.329),
        });
        let mut bytes = Cursor::new(Vec::new());
        let written = image.write().non_parallel().to_buffered(&mut bytes);
        written.map_err(|why| RenderError::Encode(why.to_string()))?;
        let mut bytes = bytes.into_inner();
        sort_attributes(&mut bytes);
        Ok(bytes)
    }
}

/// Bytes of an EXR before its header's attributes: a magic number and a version.
const BEFORE_ATTRIBUTES: usize = 8;

/// Sorts the header's attributes by name. The `exr` crate writes its map of them in a random order, and the same
/// picture must give the same bytes. Each attribute has a name and a type that end with a zero byte, and a length; a
/// zero byte ends the list.
fn sort_attributes(file: &mut [u8]) {
    let mut attributes: Vec<(usize, usize)> = Vec::new();
    let mut at = BEFORE_ATTRIBUTES;
    while file.get(at).is_some_and(|first| *first != 0) {
        let text_end = |from: usize| file[from..].iter().position(|byte| *byte == 0).map(|length| from + length + 1);
        let value = text_end(at).and_then(text_end);
        let length = value.and_then(|value| file.get(value..value + 4)).and_then(|bytes| bytes.try_into().ok());
        let (Some(value), Some(length)) = (value, length) else { return };
        let end = value + 4 + u32::from_le_bytes(length) as usize;
        attributes.push((at, end));
        at = end;
    }
    let mut sorted: Vec<&[u8]> = attributes.iter().map(|&(start, end)| &file[start..end]).collect();
    sorted.sort_unstable();
    let sorted = sorted.concat();
    file[BEFORE_ATTRIBUTES..at].copy_from_slice(&sorted);
}

/// Attributes of the header: standard ones where they exist, and others with the prefix `bendylights.`.
fn attributes(view: &View, origin: &PictureOrigin) -> LayerAttributes {
    let View { camera, samples, fill, .. } = view;
    let camera_from_world = DMat4::from(camera.world_from_camera().inverse());
    let ndc_from_world = ndc_from_camera(camera, [view.width, view.height]) * camera_from_world;
    let [near, far] = planes(&camera.projection);
    let mut attributes = LayerAttributes {
        software_name: Some(text(concat!("BendyLights ", env!("CARGO_PKG_VERSION")))),
        world_to_camera: Some(matrix(camera_from_world)),
        world_to_normalized_device: Some(matrix(ndc_from_world)),
        near_clip_plane: Some(near as f32),
        far_clip_plane: Some(far as f32),
        ..LayerAttributes::default()
    };
    let PictureOrigin { name, seq, document_hash, scene, set, lights } = origin;
    let texts = [
        ("session", name.clone()),
        ("sequence", seq.map(|seq| seq.to_string())),
        ("documentHash", document_hash.clone()),
        ("scene", scene.clone()),
        ("set", set.clone()),
        ("lights", lights.clone()),
        ("camera", Some(camera.name.clone())),
    ];
    for (key, value) in texts {
        let Some(value) = value.filter(|value| !value.is_empty()) else { continue };
        attributes.other.insert(text(&format!("bendylights.{key}")), AttributeValue::Text(text(&value)));
    }
    let samples = i32::try_from(*samples).unwrap_or(i32::MAX);
    attributes.other.insert(text("bendylights.samples"), AttributeValue::I32(samples));
    attributes.other.insert(text("bendylights.fill"), AttributeValue::F64(*fill));
    attributes
}

/// Encodes text as UTF-8, as programs write it, though the format specifies only bytes.
fn text(text: &str) -> Text {
    Text::from_slice_unchecked(text.as_bytes())
}

/// Returns the matrix in OpenEXR's layout. OpenEXR multiplies row vectors from the left, so its rows are the columns
/// here.
fn matrix(from_columns: DMat4) -> [f32; 16] {
    from_columns.to_cols_array().map(|x| x as f32)
}

/// Returns the matrix from camera space (along -Z, +Y up) to -1 to 1 over the picture, y up, and from the near to the
/// far plane.
fn ndc_from_camera(camera: &Camera, size: [u32; 2]) -> DMat4 {
    let [near, far] = planes(&camera.projection);
    // The picture's upper right corner, at a depth of 1.
    let corner = ViewRay::new(camera, size, DVec2::new(size[0].into(), 0.0), camera.translation);
    let corner = camera.world_from_camera().matrix3.transpose() * (corner.origin + corner.direction);
    let rows = match camera.projection {
        Projection::Perspective { .. } => {
            let [a, b] = if far.is_finite() {
                [-(far + near), -2.0 * far * near].map(|x| x / (far - near))
            } else {
                [-1.0, -2.0 * near]
            };
            [DVec4::X / corner.x, DVec4::Y / corner.y, DVec4::new(0.0, 0.0, a, b), -DVec4::Z]
        }
        Projection::Orthographic { .. } => {
            let depth = DVec4::new(0.0, 0.0, -2.0, -(far + near)) / (far - near);
            [DVec4::X / corner.x, DVec4::Y / corner.y, depth, DVec4::W]
        }
    };
    DMat4::from_cols(rows[0], rows[1], rows[2], rows[3]).transpose()
}

fn planes(projection: &Projection) -> [f64; 2] {
    match *projection {
        Projection::Perspective { znear, zfar, .. } => [znear, zfar.unwrap_or(f64::INFINITY)],
        Projection::Orthographic { znear, zfar, .. } => [znear, zfar],
    }
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;

    fn camera(projection: Projection) -> Camera {
        let rotation = DQuat::from_euler(glam::EulerRot::YXZ, 0.4, -0.2, 0.1);
        Camera { name: "cam".into(), translation: DVec3::new(1.0, 2.0, 3.0), rotation, projection }
    }

    /// Points on rays through pixels map to those pixels, and the planes to -1 and 1.
    #[test]
    fn matrices_take_points_to_their_pixels() {
        let perspective = |zfar| Projection::Perspective { yfov: 0.7, aspect_ratio: Some(2.0), znear: 0.5, zfar };
        let orthographic = Projection::Orthographic { ymag: 1.5, aspect_ratio: None, znear: 0.5, zfar: 40.0 };
        for projection in [perspective(None), perspective(Some(40.0)), orthographic] {
            let (camera, size, pixel) = (camera(projection), [64, 36], DVec2::new(50.0, 6.0));
            let view = View::beauty(camera.clone(), size);
            let attributes = attributes(&view, &PictureOrigin::default());
            let ray = ViewRay::new(&camera, size, pixel, DVec3::ZERO);
            for (depth, z) in [(0.5, -1.0), (40.0, 1.0)] {
                let point = (ray.origin + ray.direction * depth).extend(1.0);
                // Multiplies a row vector from the left.
                let times = |matrix: [f32; 16]| {
                    let rows = DMat4::from_cols_array(&matrix.map(f64::from));
                    DVec4::new(
                        point.dot(rows.row(0)),
                        point.dot(rows.row(1)),
                        point.dot(rows.row(2)),
                        point.dot(rows.row(3)),
                    )
                };
                let in_camera = times(attributes.world_to_camera.expect("it has one"));
                assert!((in_camera.z + depth).abs() < 1e-4 * depth, "{in_camera}");
                let clip = times(attributes.world_to_normalized_device.expect("it has one"));
                let ndc = clip / clip.w;
                let expected = DVec2::new(pixel.x / 32.0 - 1.0, 1.0 - pixel.y / 18.0);
                assert!(ndc.truncate().truncate().abs_diff_eq(expected, 1e-5), "{projection:?} {ndc}");
                let endless = matches!(projection, Projection::Perspective { zfar: None, .. });
                assert!(endless && depth > 1.0 || (ndc.z - z).abs() < 1e-4, "{projection:?} {ndc}");
            }
        }
    }
}
