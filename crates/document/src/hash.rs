//! Hash of a document, by which two machines compare their content.

mod format_2;

use std::fmt;

use drag::{DragPin, PinKind, PinTarget};
use glam::{DQuat, DVec3};
use scene::{Camera, Projection};
use sha2::{Digest, Sha256};

use crate::{Document, LightPin, NumberedLight};

pub use format_2::was_in_format_2;

/// First log format whose hashes are computed as in this version.
pub const FIRST_FORMAT_OF_HASH: u32 = 3;

/// Bit of the tag of a pin that is of a node.
const NODE_PIN: u8 = 0x80;

/// SHA-256 over a document's content, shown as 64 hexadecimal digits.
///
/// It covers all that [`Document::apply`] can change, with ids and numberings: the scene by the hash of its bytes,
/// lights by their own digests ([`light::Revisions::content`]), numbers by their bits, with -0 as 0, names by their
/// UTF-8. It does not cover the scene's label, numbers of removed objects, and parameters at their defaults, so that a
/// new parameter changes no hash.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct DocumentHash(pub [u8; 32]);

impl fmt::Display for DocumentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(const_hex::const_encode::<32, false>(&self.0).as_str())
    }
}

impl fmt::Debug for DocumentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Document {
    /// Computes the hash of the current content.
    pub fn hash(&self) -> DocumentHash {
        let mut walk = HashWriter(Sha256::new());
        walk.text("bendylights document 3");
        self.hash_with(walk, |walk, placed| walk.0.update(placed.light.digest().0))
    }

    /// Computes the hash as in logs of `format`. Formats 1 and 2 cover the fields that lights had then. A light with
    /// later values gets another hash than one without, so that no such log can hide them.
    pub fn hash_of_format(&self, format: u32) -> DocumentHash {
        if format >= FIRST_FORMAT_OF_HASH {
            return self.hash();
        }
        let mut walk = HashWriter(Sha256::new());
        walk.text("bendylights document 1");
        self.hash_with(walk, |walk, placed| {
            walk.light(placed.light.light());
            if !format_2::covers(placed.light.light()) {
                walk.0.update(placed.light.digest().0);
            }
        })
    }

    fn hash_with(&self, mut walk: HashWriter, light: impl Fn(&mut HashWriter, &NumberedLight)) -> DocumentHash {
        match &self.scene {
            None => walk.tag(0),
            Some(scene) => {
                walk.tag(1);
                walk.0.update(scene.asset.0);
            }
        }
        walk.number(self.lights.len() as u64);
        for (id, placed) in &self.lights {
            walk.number(id.0);
            walk.number(placed.layout.0);
            light(&mut walk, placed);
        }
        walk.number(self.cameras.len() as u64);
        for (id, camera) in &self.cameras {
            walk.number(id.0);
            walk.camera(camera);
        }
        // A document without pins keeps the hash from before pins existed.
        if !self.pins.is_empty() {
            walk.text("pins");
            walk.number(self.pins.len() as u64);
            for (id, pin) in &self.pins {
                walk.number(id.0);
                walk.pin(pin);
            }
        }
        DocumentHash(walk.0.finalize().into())
    }
}

/// Hash of a sequence of values. The length of a value that varies in length is hashed before the value, so that
/// adjacent values cannot be confused.
struct HashWriter(Sha256);

impl HashWriter {
    fn tag(&mut self, tag: u8) {
        self.0.update([tag]);
    }

    fn number(&mut self, number: u64) {
        self.0.update(number.to_le_bytes());
    }

    fn real(&mut self, real: f64) {
        // Adding 0 turns -0 into 0 and changes no other number.
        self.0.update((real + 0.0).to_bits().to_le_bytes());
    }

    fn each(&mut self, reals: impl IntoIterator<Item = f64>) {
        for real in reals {
            self.real(real);
        }
    }

    fn vector(&mut self, vector: DVec3) {
        self.each(vector.to_array());
    }

    fn rotation(&mut self, rotation: DQuat) {
        self.each(rotation.to_array());
    }

    fn option(&mut self, real: Option<f64>) {
        self.tag(u8::from(real.is_some()));
        self.real(real.unwrap_or(0.0));
    }

    fn text(&mut self, text: &str) {
        self.number(text.len() as u64);
        self.0.update(text);
    }

    fn pin(&mut self, LightPin { light, pin }: &LightPin) {
        let DragPin { kind, at, caster, is_hard } = pin;
        self.number(light.0);
        let kind = match kind {
            PinKind::Direction => 0,
            PinKind::Lit => 1,
            PinKind::Shadowed => 2,
            PinKind::Shadow => 3,
            PinKind::Look => 4,
            PinKind::Coordinates => 5,
        };
        match at {
            PinTarget::Point(at) => {
                self.tag(kind);
                self.vector(*at);
            }
            PinTarget::Node(node) => {
                self.tag(NODE_PIN | kind);
                self.text(node);
            }
        }
        self.tag(u8::from(caster.is_some()));
        self.text(caster.as_deref().unwrap_or_default());
        self.tag(u8::from(*is_hard));
    }

    fn camera(&mut self, camera: &Camera) {
        let Camera { name, translation, rotation, projection } = camera;
        self.text(name);
        self.vector(*translation);
        self.rotation(*rotation);
        // A camera without an aspect ratio keeps the hash from before aspect ratios existed.
        match *projection {
            Projection::Perspective { yfov, aspect_ratio, znear, zfar } => {
                self.tag(if aspect_ratio.is_some() { 2 } else { 0 });
                self.each(aspect_ratio);
                self.each([yfov, znear]);
                self.option(zfar);
            }
            Projection::Orthographic { ymag, aspect_ratio, znear, zfar } => {
                self.tag(if aspect_ratio.is_some() { 3 } else { 1 });
                self.each(aspect_ratio);
                self.each([ymag, znear, zfar]);
            }
        }
    }
}
