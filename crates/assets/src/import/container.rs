//! Parsing of a scene file: the GLB container, limits on the JSON, and the JSON itself.

use std::borrow::Cow;
use std::collections::BTreeMap;

use gltf::json::Root;
use serde_json::Value;
use serde_json::value::{RawValue, to_raw_value};

use crate::fault::{excerpt, invalid_gltf};
use crate::limits::MAX_MESSAGE_CHARS;
use crate::{AssetFault, ImportLimit};

/// JSON object whose members keep their text, sorted by name.
pub type Members = BTreeMap<String, Box<RawValue>>;

/// Parts of a scene file.
#[derive(Debug)]
pub struct Container<'a> {
    /// JSON text.
    pub json: &'a [u8],
    /// Binary chunk of a GLB.
    pub bin: Option<&'a [u8]>,
}

const GLB_HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;

/// Splits a GLB (glTF 2.0, section 4.4) into its chunks. Any other input is treated as JSON.
pub fn split(bytes: &[u8]) -> Result<Container<'_>, AssetFault> {
    if bytes.is_empty() {
        return Err(invalid_gltf("it is empty"));
    }
    if !bytes.starts_with(b"glTF") {
        return Ok(Container { json: bytes, bin: None });
    }
    let (Some(version), Some(length)) = (u32_at(bytes, 4), u32_at(bytes, 8)) else {
        return Err(invalid_gltf("it ends inside its header"));
    };
    if version != 2 {
        return Err(invalid_gltf(format!("its GLB container has version {version} instead of 2")));
    }
    if length > bytes.len() {
        return Err(invalid_gltf(format!("it is cut off after {} of {length} bytes", bytes.len())));
    }
    let chunks = bytes.get(GLB_HEADER_BYTES..length).unwrap_or_default();
    let (json, rest) = chunk(chunks)?;
    if json.kind != b"JSON" {
        return Err(invalid_gltf("its first chunk is not JSON"));
    }
    let second = if rest.is_empty() { None } else { Some(chunk(rest)?.0) };
    let bin = second.filter(|chunk| chunk.kind == b"BIN\0").map(|chunk| chunk.data);
    Ok(Container { json: json.data, bin })
}

/// Chunk of a GLB.
struct Chunk<'a> {
    kind: &'a [u8],
    data: &'a [u8],
}

/// Returns the first chunk and the bytes after it.
fn chunk(bytes: &[u8]) -> Result<(Chunk<'_>, &[u8]), AssetFault> {
    let cut = || invalid_gltf("one of its chunks is longer than the file");
    let length = u32_at(bytes, 0).ok_or_else(cut)?;
    let kind = bytes.get(4..CHUNK_HEADER_BYTES).ok_or_else(cut)?;
    let (data, rest) = bytes[CHUNK_HEADER_BYTES..].split_at_checked(length).ok_or_else(cut)?;
    Ok((Chunk { kind, data }, rest))
}

fn u32_at(bytes: &[u8], at: usize) -> Option<usize> {
    let four = bytes.get(at..at + 4)?.try_into().ok()?;
    Some(u32::from_le_bytes(four) as usize)
}

/// Parses the JSON, after a check of its depth and its number of values.
pub fn parse(json: &[u8]) -> Result<Root, AssetFault> {
    check_json_bounds(json)?;
    let parsed = without_idle_channels(json).and_then(|json| Root::from_slice(&json));
    parsed.map_err(|error| invalid_gltf(excerpt(&error.to_string(), 2 * MAX_MESSAGE_CHARS)))
}

/// Removes animation channels that target no node. The `gltf` crate does not parse them, extensions use them,
/// and glTF 2.0 says to ignore them (section 3.11).
fn without_idle_channels(json: &[u8]) -> serde_json::Result<Cow<'_, [u8]>> {
    let mut document: Members = serde_json::from_slice(json)?;
    let Some(raw) = document.get_mut("animations") else { return Ok(Cow::Borrowed(json)) };
    let mut animations: Value = serde_json::from_str(raw.get())?;
    let mut dropped = false;
    for animation in animations.as_array_mut().into_iter().flatten() {
        let channels = animation.get_mut("channels").and_then(Value::as_array_mut);
        if let Some(channels) = channels {
            let before = channels.len();
            channels.retain(|channel| channel["target"].as_object().is_none_or(|to| to.contains_key("node")));
            dropped |= channels.len() < before;
        }
    }
    if !dropped {
        return Ok(Cow::Borrowed(json));
    }
    *raw = to_raw_value(&animations)?;
    serde_json::to_vec(&document).map(Cow::Owned)
}

/// Checks the depth and the number of values by counting brackets and commas outside strings. At most one value
/// follows each of them.
fn check_json_bounds(json: &[u8]) -> Result<(), AssetFault> {
    let (mut depth, mut values) = (0_u64, 0_u64);
    let (mut in_string, mut escaped) = (false, false);
    for &byte in json {
        match byte {
            _ if escaped => escaped = false,
            b'\\' if in_string => escaped = true,
            b'"' => in_string = !in_string,
            _ if in_string => {}
            b'{' | b'[' => {
                depth += 1;
                values += 1;
                ImportLimit::JsonDepth.check(depth)?;
            }
            b'}' | b']' => depth = depth.saturating_sub(1),
            b',' => values += 1,
            _ => {}
        }
    }
    ImportLimit::JsonValues.check(values)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn brackets_and_commas_in_strings_do_not_count() {
        let text = format!(r#"{{"a\"":"{}"}}"#, "[,".repeat(2 << 20));
        assert!(check_json_bounds(text.as_bytes()).is_ok());
        assert!(check_json_bounds(text.replace('"', " ").as_bytes()).is_err(), "the same outside strings is refused");
    }

    #[test]
    fn a_chunk_of_another_kind_is_passed_over() {
        let glb = |second: &[u8]| {
            let mut bytes = b"glTF\x02\0\0\0\x20\0\0\0\x04\0\0\0JSON{}  \x00\0\0\0".to_vec();
            bytes.extend(second);
            bytes
        };
        assert!(split(&glb(b"BIN\0")).unwrap().bin.is_some());
        assert!(split(&glb(b"XYZ\0")).unwrap().bin.is_none());
    }
}
