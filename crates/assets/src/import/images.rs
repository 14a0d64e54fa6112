//! Decoding of pictures, after a check of their size.

use std::borrow::Cow;
use std::io::Cursor;

use gltf::json;
use image::{ImageFormat, ImageReader, Limits};

use super::{ImportReport, ImportSource, addresses};
use crate::fault::{excerpt, invalid_gltf};
use crate::limits::{MAX_IMAGE_SIDE, MAX_MESSAGE_CHARS, MAX_TEXTURE_BYTES};
use crate::{AssetFault, ImportLimit};

/// Decodes the picture at `index` in the file. Its first bytes select the format, because declared types are
/// often wrong.
pub fn read(source: &ImportSource, index: usize, report: &mut ImportReport) -> Result<scene::Image, AssetFault> {
    let bytes = bytes(source, &source.root.images[index], report)?;
    let refuse = |why: String| AssetFault::Picture { image: index, why: excerpt(&why, 2 * MAX_MESSAGE_CHARS) };
    let format = image::guess_format(&bytes).map_err(|error| refuse(error.to_string()))?;
    if !matches!(format, ImageFormat::Png | ImageFormat::Jpeg | ImageFormat::WebP) {
        return Err(refuse(format!("{} is not a format of glTF", format.to_mime_type())));
    }
    let size = ImageReader::with_format(Cursor::new(&*bytes), format).into_dimensions();
    let (width, height) = size.map_err(|error| refuse(error.to_string()))?;
    if width == 0 || height == 0 {
        return Err(refuse("it has no pixels".into()));
    }
    let pixels = u64::from(width) * u64::from(height);
    ImportLimit::ImageSide.check(u64::from(width.max(height)))?;
    ImportLimit::ImagePixels.check(pixels)?;
    report.budget.spend(ImportLimit::TextureBytes, 4 * pixels)?;

    let mut reader = ImageReader::with_format(Cursor::new(&*bytes), format);
    let mut limits = Limits::default();
    limits.max_image_width = Some(MAX_IMAGE_SIDE as u32);
    limits.max_image_height = Some(MAX_IMAGE_SIDE as u32);
    limits.max_alloc = Some(MAX_TEXTURE_BYTES);
    reader.limits(limits);
    let rgba8 = reader.decode().map_err(|error| refuse(error.to_string()))?.into_rgba8().into_raw();
    Ok(scene::Image { width, height, rgba8 })
}

fn bytes<'s>(
    source: &'s ImportSource,
    image: &json::Image,
    report: &mut ImportReport,
) -> Result<Cow<'s, [u8]>, AssetFault> {
    match (&image.uri, image.buffer_view.and_then(|view| source.root.get(view))) {
        (Some(uri), _) => Ok(Cow::Owned(addresses::read(uri, source.file, &mut report.budget)?)),
        (None, Some(view)) => {
            let start = view.byte_offset.unwrap_or_default().0 as usize;
            let bytes = source.buffers.get(view.buffer.value());
            let bytes = bytes.and_then(|b| b.get(start..start + view.byte_length.0 as usize));
            Ok(Cow::Borrowed(bytes.unwrap_or_default()))
        }
        (None, None) => Err(invalid_gltf("a picture has no data")),
    }
}
