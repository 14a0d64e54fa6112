//! Packing of a scene of several files into one file.

use std::path::Path;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use gltf::json::Root;
use serde_json::value::to_raw_value;

use super::container::{self, Members};
use super::{ImportReport, addresses, check};
use crate::fault::invalid_gltf;
use crate::{AssetFault, ImportLimit};

/// Media type of bytes of unknown type.
const ANY_BYTES: &str = "application/octet-stream";

/// Returns the bytes of one file that holds the whole scene at `path`.
pub fn pack(path: &Path) -> Result<Vec<u8>, AssetFault> {
    let mut report = ImportReport::default();
    let bytes = addresses::read_file(path, &mut report.budget)?;
    let container = container::split(&bytes)?;
    let root = check::check_document(container::parse(container.json)?, &mut report.notes)?;
    if is_self_contained(&root) {
        return Ok(bytes);
    }
    let buffers = addresses::buffers(&root, container.bin, Some(path), &mut report.budget)?;
    let buffers = buffers.iter().map(|bytes| Some(data_address(ANY_BYTES, bytes)));
    let mut images = Vec::new();
    for image in &root.images {
        let bytes = image.uri.as_deref().map(|uri| addresses::read(uri, Some(path), &mut report.budget));
        images.push(bytes.transpose()?.map(|bytes| data_address(picture_type(&bytes), &bytes)));
    }
    let packed = with_addresses(container.json, [("buffers", buffers.collect()), ("images", images)]);
    let packed = packed.map_err(|error| invalid_gltf(error.to_string()))?;
    // The packed file must be loadable too, and it is a third longer than its source files.
    ImportLimit::BytesRead.check(packed.len() as u64)?;
    Ok(packed)
}

fn is_self_contained(root: &Root) -> bool {
    let buffers = root.buffers.iter().filter_map(|buffer| buffer.uri.as_deref());
    let images = root.images.iter().filter_map(|image| image.uri.as_deref());
    buffers.chain(images).all(addresses::is_data)
}

fn data_address(media_type: &str, bytes: &[u8]) -> String {
    format!("data:{media_type};base64,{}", STANDARD.encode(bytes))
}

/// Returns the media type by the picture's first bytes, because declared types are often wrong.
fn picture_type(bytes: &[u8]) -> &'static str {
    image::guess_format(bytes).map_or(ANY_BYTES, |format| format.to_mime_type())
}

/// Returns the JSON with new addresses for the items of some arrays, and everything else unchanged.
fn with_addresses(json: &[u8], arrays: [(&str, Vec<Option<String>>); 2]) -> serde_json::Result<Vec<u8>> {
    let mut document: Members = serde_json::from_slice(json)?;
    for (array, addresses) in arrays {
        let Some(raw) = document.get_mut(array) else { continue };
        let mut items: Vec<Members> = serde_json::from_str(raw.get())?;
        for (item, address) in items.iter_mut().zip(addresses) {
            if let Some(address) = address {
                item.insert("uri".into(), to_raw_value(&address)?);
            }
        }
        *raw = to_raw_value(&items)?;
    }
    serde_json::to_vec(&document)
}
