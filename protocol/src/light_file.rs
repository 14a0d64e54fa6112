//! Light files: JSON with one light or an array of lights.

use light::CheckedLight;
use serde::{Deserialize, Serialize};
use serde_json::ser::Formatter;
use serde_json::value::RawValue;
use std::io::{self, Write};

use crate::error::{from_json, seeded_from_json};
use crate::light::{LightSeed, WireLightType};
use crate::{FileError, Light};

/// Parses the text of a light file, and checks each light. An empty array holds no lights. Long names are cut,
/// like those in glTF files.
pub fn parse(text: &str) -> Result<Vec<CheckedLight>, FileError> {
    if !text.trim_start().starts_with('[') {
        return Ok(vec![parse_light(text)?]);
    }
    // Each light is parsed from its own text, so that its `type` selects the parser and an error still names
    // the field.
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
    CheckedLight::try_from(light).map_err(|reason| FileError::Model { path: String::new(), reason })
}

/// Returns the text of a light file with one light: each field in a line, all fields present, no newline at the
/// end.
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

/// JSON formatter that puts each field of the outermost object in a line of its own.
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
