//! The document's hash: what two machines compare to know that they hold the same.

use std::fmt;

use glam::{DQuat, DVec3};
use light::{BendyLight, Decay, Direction, EndMode, Frame, SpotLight, Transform};
use sha2::{Digest, Sha256};

use crate::{Document, PlacedLight};
use light::{Light, LightKind};
use scene::{Camera, Projection};

/// SHA-256 over a document's content, shown as 64 hexadecimal digits.
///
/// Covered is all that [`Document::apply`] can change, ids and numberings included: the scene by the hash of its
/// bytes, numbers by their bits, with -0 as 0, names by their UTF-8. Not covered are the scene's label and
/// numbers once given out and free again.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
pub struct DocumentHash(pub [u8; 32]);

impl fmt::Display for DocumentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl fmt::Debug for DocumentHash {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        fmt::Display::fmt(self, f)
    }
}

impl Document {
    /// The hash of what it holds now.
    pub fn hash(&self) -> DocumentHash {
        let mut walk = Walk(Sha256::new());
        walk.text("bendylights document 1");
        match self.scene_ref() {
            None => walk.tag(0),
            Some(scene) => {
                walk.tag(1);
                walk.0.update(scene.asset.0);
            }
        }
        walk.number(self.lights().len() as u64);
        for (id, PlacedLight { layout, light }) in self.lights() {
            walk.number(id.0);
            walk.number(layout.0);
            walk.light(light);
        }
        walk.number(self.cameras().len() as u64);
        for (id, camera) in self.cameras() {
            walk.number(id.0);
            walk.camera(camera);
        }
        DocumentHash(walk.0.finalize().into())
    }
}

/// Every field in turn. Structs are taken apart completely, so that a new field cannot be forgotten; what has a
/// length says it first, so that nothing runs into its neighbour.
struct Walk(Sha256);

impl Walk {
    fn tag(&mut self, tag: u8) {
        self.0.update([tag]);
    }

    fn number(&mut self, number: u64) {
        self.0.update(number.to_le_bytes());
    }

    fn real(&mut self, real: f64) {
        // Adding 0 makes -0 to 0 and leaves all else.
        self.0.update((real + 0.0).to_bits().to_le_bytes());
    }

    fn each(&mut self, reals: impl IntoIterator<Item = f64>) {
        for real in reals {
            self.real(real);
        }
    }

    fn reals(&mut self, reals: &[f64]) {
        self.number(reals.len() as u64);
        self.each(reals.iter().copied());
    }

    fn vector(&mut self, vector: DVec3) {
        self.each(vector.to_array());
    }

    fn vectors(&mut self, vectors: &[DVec3]) {
        self.number(vectors.len() as u64);
        self.each(vectors.iter().flat_map(DVec3::to_array));
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

    fn transform(&mut self, transform: &Transform) {
        let Transform { translation, rotation, scale } = transform;
        self.vector(*translation);
        self.rotation(*rotation);
        self.real(*scale);
    }

    fn decay(&mut self, decay: Decay) {
        self.tag(match decay {
            Decay::None => 0,
            Decay::Linear => 1,
            Decay::InverseSquare => 2,
        });
    }

    fn light(&mut self, light: &Light) {
        let Light { name, kind } = light;
        self.text(name);
        match kind {
            LightKind::Bendy(bendy) => {
                self.tag(0);
                self.bendy(bendy);
            }
            LightKind::Spot(spot) => {
                self.tag(1);
                self.spot(spot);
            }
        }
    }

    fn bendy(&mut self, light: &BendyLight) {
        let BendyLight {
            transform,
            points,
            radii,
            colors,
            intensities,
            up,
            cone_angle,
            cone_softness,
            frame,
            direction,
            end_mode,
            decay,
        } = light;
        self.transform(transform);
        self.vectors(points);
        self.reals(radii);
        self.vectors(colors);
        self.reals(intensities);
        self.vector(*up);
        self.real(*cone_angle);
        self.real(*cone_softness);
        self.tag(match frame {
            Frame::RotationMinimizing => 0,
            Frame::Up => 1,
        });
        self.tag(match direction {
            Direction::Tube => 0,
            Direction::Path => 1,
        });
        self.tag(match end_mode {
            EndMode::Cut => 0,
            EndMode::Extend => 1,
        });
        self.decay(*decay);
    }

    fn spot(&mut self, light: &SpotLight) {
        let SpotLight { transform, color, intensity, cone_angle, cone_softness, range, decay } = light;
        self.transform(transform);
        self.vector(*color);
        self.real(*intensity);
        self.real(*cone_angle);
        self.real(*cone_softness);
        self.option(*range);
        self.decay(*decay);
    }

    fn camera(&mut self, camera: &Camera) {
        let Camera { name, translation, rotation, projection } = camera;
        self.text(name);
        self.vector(*translation);
        self.rotation(*rotation);
        // A camera without an aspect ratio has the hash that it had before there were any.
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
