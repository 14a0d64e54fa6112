//! Light files: JSON with one light, or an array of lights.

use light::CheckedLight;
use serde::{Deserialize, Serialize};
use serde_json::ser::Formatter;
use serde_json::value::RawValue;
use std::io::{self, Write};

use crate::error::{from_json, seeded_from_json};
use crate::light::{LightSeed, WireLightType};
use crate::{FileError, Light};

/// Reads a light file's text: one light, or an array of them, each valid. An empty array holds no lights. Long names are
/// cut, as those of glTF files are.
pub fn parse(text: &str) -> Result<Vec<CheckedLight>, FileError> {
    if !text.trim_start().starts_with('[') {
        return Ok(vec![parse_light(text)?]);
    }
    // Each light's own text, so that its `type` can choose how it is read and the reason still names the field.
    from_json::<Vec<Box<RawValue>>>(text)?
        .iter()
        .enumerate()
        .map(|(index, light)| parse_light(light.get()).map_err(|error| error.of_light(index)))
        .collect()
}

fn parse_light(text: &str) -> Result<CheckedLight, FileError> {
    #[derive(Deserialize)]
    #[serde(expecting = "a light: an object with `type`, `points`, `radii` and so on")]
    struct Typed {
        r#type: WireLightType,
    }
    let WireLightType(owner) = from_json::<Typed>(text)?.r#type;
    let mut light = seeded_from_json(text, LightSeed(owner))?;
    light.cut_name();
    CheckedLight::try_from(light).map_err(|reason| FileError::Model { place: String::new(), reason })
}

/// A light file's text with one light: a line a field, every field given, ending without a newline.
///
/// [`parse`] gives the same light back, bit for bit. The light's numbers must be finite, as those of every
/// valid light are.
pub fn to_json(light: &light::Light) -> String {
    let mut text = Vec::new();
    Light::from(light)
        .serialize(&mut serde_json::Serializer::with_formatter(&mut text, LinePerField::default()))
        .expect("a light has string keys and is written to memory");
    String::from_utf8(text).expect("serde_json writes UTF-8")
}

/// The outermost object's fields on lines of their own, everything inside them in one line.
#[derive(Default)]
struct LinePerField {
    depth: usize,
}

impl Formatter for LinePerField {
    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth += 1;
        writer.write_all(b"{")
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.depth -= 1;
        writer.write_all(if self.depth == 0 { b"\n}" } else { b"}" })
    }

    fn begin_object_key<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b"," })?;
        writer.write_all(match (self.depth, first) {
            (1, _) => b"\n  ",
            (_, true) => b"",
            (_, false) => b" ",
        })
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        writer.write_all(b": ")
    }

    fn begin_array_value<W: ?Sized + Write>(&mut self, writer: &mut W, first: bool) -> io::Result<()> {
        writer.write_all(if first { b"" } else { b", " })
    }
}
