//! How far out a light reaches around its axis.

use super::own;
use crate::parameters::RADIAL_FALLOFF;
use crate::{Light, Piece};

/// The share of its way out at which a light has its edge, over the angle around its axis.
#[derive(Clone, Debug, PartialEq)]
pub struct Radial {
    /// In order, from before 0 degrees to after 360; none for an edge that is the same all around.
    pub pieces: Vec<Piece>,
}

impl Radial {
    /// That of a checked light.
    pub fn of(light: &Light) -> Self {
        let falloff = own(light, RADIAL_FALLOFF).flatten();
        Self { pieces: falloff.map_or_else(Vec::new, |falloff| falloff.pieces()) }
    }

    /// Whether it is 1 all around.
    pub fn is_even(&self) -> bool {
        self.pieces.is_empty()
    }

    /// The share at a place across the light.
    pub fn share(&self, v: f64, w: f64) -> f64 {
        if self.is_even() {
            return 1.0;
        }
        let degrees = angle_around(v, w);
        let Some(piece) = self.pieces.iter().rfind(|piece| piece.from <= degrees) else { return 1.0 };
        let [from, to] = piece.values;
        from + (to - from) * ((degrees - piece.from) * piece.inverse_length).clamp(0.0, 1.0)
    }
}

/// Degrees from V, the left as seen along the light, towards W, its top: 0 to 360.
fn angle_around(v: f64, w: f64) -> f64 {
    let degrees = libm::atan2(w, v).to_degrees();
    if degrees < 0.0 { degrees + 360.0 } else { degrees }
}
