//! Radius of a light's edge around its axis.

use super::own_value;
use crate::lanes::Lanes;
use crate::parameters::RADIAL_FALLOFF;
use crate::{Light, LinearPiece};

/// Radius of a light's edge over the angle around its axis, as a share of the full radius.
#[derive(Clone, Debug, PartialEq)]
pub struct EdgeOutline {
    /// Pieces in order, from before 0 degrees to after 360; empty if the edge is the same all around.
    pub pieces: Vec<LinearPiece>,
}

impl EdgeOutline {
    /// Makes an outline of a checked light.
    pub fn of(light: &Light) -> Self {
        let falloff = own_value(light, RADIAL_FALLOFF).flatten();
        Self { pieces: falloff.map_or_else(Vec::new, |falloff| falloff.pieces()) }
    }

    /// Returns true if the edge has the full radius all around.
    pub fn is_uniform(&self) -> bool {
        self.pieces.is_empty()
    }

    /// Returns the radius of the edge, as a share of the full radius, in the direction of (v, w) from the axis.
    #[inline(always)]
    pub fn share<F: Lanes>(&self, v: F, w: F) -> F {
        let (zero, one) = (F::of(0.0), F::of(1.0));
        if self.is_uniform() {
            return one;
        }
        let degrees = angle_around(v, w);
        let mut share = one;
        // The last piece that begins before the angle applies.
        for piece in &self.pieces {
            let [from, to] = piece.values.map(F::of);
            let start = F::of(piece.start_degrees);
            let u = ((degrees - start) * F::of(piece.inverse_length)).within(zero, one);
            share = F::select(degrees.ge(start), from + (to - from) * u, share);
        }
        share
    }
}

/// Returns the angle in degrees from V, the left as seen along the light, towards W, its top: 0 to 360.
#[inline(always)]
fn angle_around<F: Lanes>(v: F, w: F) -> F {
    let degrees = w.atan2(v) * F::of(180.0 / std::f64::consts::PI);
    F::select(degrees.lt(F::of(0.0)), degrees + F::of(360.0), degrees)
}
