//! Shadow maps: one depth per texel on each face.

use crate::lanes::LANES;

/// Faces of a shadow map, each `side` by `side` texels, rows from the top. The light defines the meaning of depths, and
/// the rule by which one of two wins.
///
/// Each row has room for sixteen texels that begin in it. The values in that room have no meaning.
#[derive(Clone, Debug, Default)]
pub struct DepthMap {
    side: usize,
    faces: usize,
    texels: Vec<f32>,
}

/// Returns the number of texels from one row to the next, on a face of `side` texels a side. It is not a power of two,
/// which would place all rows in the same few cache lines.
pub(crate) fn stride(side: usize) -> usize {
    side.next_multiple_of(LANES) + LANES
}

impl DepthMap {
    /// Makes a map whose depths are still to be drawn.
    pub fn new(side: usize, faces: usize) -> Self {
        Self { side, faces, texels: vec![0.0; faces * side * stride(side)] }
    }

    /// Returns the number of texels along each side of a face.
    pub fn side(&self) -> usize {
        self.side
    }

    /// Returns the number of faces.
    pub fn faces(&self) -> usize {
        self.faces
    }

    /// Returns the number of texels from one row to the next.
    pub(crate) fn stride(&self) -> usize {
        stride(self.side)
    }

    /// Returns the depths of all faces, with the unused room behind each row.
    pub(crate) fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// Iterates over a face's rows, from the top.
    pub fn rows(&self, face: usize) -> impl Iterator<Item = &[f32]> {
        let length = self.side * self.stride();
        self.texels[face * length..][..length].chunks(self.stride()).map(|row| &row[..self.side])
    }

    /// Iterates over a face's rows mutably, from the top.
    pub fn rows_mut(&mut self, face: usize) -> impl Iterator<Item = &mut [f32]> {
        let (side, stride) = (self.side, self.stride());
        self.face_mut(face).chunks_mut(stride).map(move |row| &mut row[..side])
    }

    /// Returns the depths of a face for drawing, with the unused room behind each row.
    pub(crate) fn face_mut(&mut self, face: usize) -> &mut [f32] {
        let length = self.side * self.stride();
        &mut self.texels[face * length..][..length]
    }
}
