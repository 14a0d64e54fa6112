//! Converts a fitted bent map to the numbers of its passes.

use glam::{DMat3, DVec3, Mat3};
use light::{MAX_EXTENT, Tube};
use relight::{BentFace, BentMapParams};

use super::faces::MAX_FACES;
use super::fit::{BendyFit, DrawnFace};
use crate::casters::OpenSides;
use crate::settings::ShadowSettings;

/// Shape of a light's bent shadow map: its faces, fitted to the scene, and their number of texels.
#[derive(Clone, Copy, Debug)]
pub struct MapShape {
    fit: BendyFit,
    /// Texels along each side of a face.
    pub side: u32,
    /// Largest distance of the casters, which may be simplified, from the scene's surface, in world units.
    pub mesh_error: f64,
}

impl MapShape {
    pub(super) fn new(fit: BendyFit, side: u32, mesh_error: f64) -> Self {
        Self { fit, side, mesh_error }
    }

    pub fn face_count(&self) -> usize {
        self.fit.faces.count()
    }

    pub fn slope(&self) -> f64 {
        self.fit.faces.slope()
    }

    pub fn is_cube(&self) -> bool {
        self.fit.faces.is_cube()
    }

    /// Returns the range of t that contains casters, with a margin for rounding; `None` if there are none.
    pub fn t_range(&self) -> Option<[f64; 2]> {
        self.fit.t.map(|[first, last]| {
            let room = 1e-3 * (last - first) + 1e-6 * (1.0 + last);
            [(first - room).max(0.0), last + room]
        })
    }

    /// Returns the t that has depth 0. It is 0 for a cube, on whose sides depths are not differences of t.
    pub fn t_base(&self) -> f64 {
        if self.is_cube() { 0.0 } else { self.t_range().map_or(0.0, |[first, _]| first) }
    }

    /// Returns the greatest t of a caster.
    pub fn t_last(&self) -> f64 {
        self.t_range().map_or(1.0, |[_, last]| last)
    }

    /// Returns the range of t that depths from 0 to 1 cover.
    pub fn t_span(&self) -> f64 {
        self.t_last() - self.t_base()
    }

    fn drawn(&self, face: usize) -> DrawnFace {
        self.fit.drawn(face, f64::from(self.side))
    }

    /// Returns the numbers by which surfaces look up the map of a light.
    pub(super) fn params(&self, tube: &Tube<f64>, settings: &ShadowSettings) -> BentMapParams {
        BentMapParams {
            t_base: self.t_base() as f32,
            t_span: self.t_span() as f32,
            t_last: self.t_last() as f32,
            slope: self.is_cube().then(|| self.slope() as f32),
            tolerance_texels: settings.bent_tolerance_texels(),
            // In tube space, at most the extent of a scene: a larger one has the same effect.
            mesh_error: (self.mesh_error / tube.placement.world_per_tube).min(MAX_EXTENT) as f32,
            fits: self.fits(),
            filter: settings.filter,
        }
    }

    /// Returns the center and 1 / half size of each face.
    pub fn fits(&self) -> [[f32; 4]; MAX_FACES] {
        std::array::from_fn(|face| {
            if face >= self.face_count() {
                return [0.0; 4];
            }
            let DrawnFace { center, half } = self.drawn(face);
            [center[0], center[1], half[0].recip(), half[1].recip()].map(|x| x as f32)
        })
    }

    /// Returns the projection of an existing face, from (V, W, R) to (x, y, w).
    pub fn clip_from_mapped(&self, face: usize) -> Mat3 {
        let DrawnFace { center, half } = self.drawn(face);
        let clip_from_face = DMat3::from_cols(
            DVec3::X / half[0],
            DVec3::Y / half[1],
            DVec3::new(-center[0] / half[0], -center[1] / half[1], 1.0),
        );
        (clip_from_face * self.fit.faces.face_from_tube(face)).as_mat3()
    }

    /// True if a face may contain casters.
    pub fn has_casters(&self, face: usize) -> bool {
        self.fit.bounds[face].is_some()
    }

    /// Returns the sides of the casters' bounds through which light enters, and whose casters the map contains.
    pub(crate) fn open_sides(&self) -> OpenSides {
        self.fit.open_sides
    }

    /// Returns a face as it is drawn.
    pub fn face(&self, face: usize) -> BentFace {
        let DrawnFace { center, half } = self.drawn(face);
        let (row, most) = if face == 0 {
            ([1.0, 0.0], 1.0)
        } else {
            ([center[1] + half[1], -2.0 * half[1] / f64::from(self.side)], self.slope())
        };
        BentFace {
            clip_from_mapped: self.clip_from_mapped(face),
            row_divisor: row.map(|x| x as f32),
            depth_per_t: (self.t_span() * most).recip() as f32,
            has_casters: self.has_casters(face),
        }
    }

    /// Returns the width of a texel in world units at the greatest t of any caster.
    pub fn last_texel_in_world(&self, tube: &Tube<f64>) -> f64 {
        let t = self.t_last().max(0.0);
        let segment = (t as usize).min(tube.segments.len() - 1);
        let radius = tube.segments[segment].curve.radius(t - segment as f64);
        radius.abs() * tube.placement.world_per_tube / self.texels_per_vw()
    }

    /// Returns the texels per unit of v and w at the finest texel.
    pub fn texels_per_vw(&self) -> f64 {
        let finest = |face: usize| self.drawn(face).half.map(f64::recip).into_iter().fold(0.0, f64::max);
        let finest = (0..self.face_count()).map(finest).fold(0.0, f64::max);
        // A step of v moves a point on a side of the cube along both of its axes.
        let both = if self.is_cube() { std::f64::consts::SQRT_2 } else { 1.0 };
        0.5 * f64::from(self.side) * finest * self.slope() * both
    }
}
