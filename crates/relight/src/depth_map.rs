//! What a light sees first: a depth a texel, on each face of its shadow map.

use crate::lanes::LANES;

/// The faces of a shadow map, each `side` by `side` texels, rows from the top. What depths mean, and which of two wins,
/// is the light's.
///
/// Behind each row there is room for sixteen texels that begin in it; what lies there means nothing.
#[derive(Clone, Debug, Default)]
pub struct DepthMap {
    side: usize,
    faces: usize,
    texels: Vec<f32>,
}

/// Texels from one row to the next where so many are on each side. Not a power of two, by which all rows would lie in the same few
/// lines of the cache.
pub(crate) fn stride(side: usize) -> usize {
    side.next_multiple_of(LANES) + LANES
}

impl DepthMap {
    /// A map of so many faces, whose depths are yet to be drawn.
    pub fn new(side: usize, faces: usize) -> Self {
        Self { side, faces, texels: vec![0.0; faces * side * stride(side)] }
    }

    /// Texels along each side of a face.
    pub fn side(&self) -> usize {
        self.side
    }

    /// How many faces there are.
    pub fn faces(&self) -> usize {
        self.faces
    }

    /// Texels from one row to the next.
    pub(crate) fn stride(&self) -> usize {
        stride(self.side)
    }

    /// All depths, face after face, with the room behind rows.
    pub(crate) fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// A face's rows, from the top.
    pub fn rows(&self, face: usize) -> impl Iterator<Item = &[f32]> {
        let length = self.side * self.stride();
        self.texels[face * length..][..length].chunks(self.stride()).map(|row| &row[..self.side])
    }

    /// The same, to be changed.
    pub fn rows_mut(&mut self, face: usize) -> impl Iterator<Item = &mut [f32]> {
        let (side, stride) = (self.side, self.stride());
        self.face_mut(face).chunks_mut(stride).map(move |row| &mut row[..side])
    }

    /// A face's depths with the room behind rows, to be drawn to.
    pub(crate) fn face_mut(&mut self, face: usize) -> &mut [f32] {
        let length = self.side * self.stride();
        &mut self.texels[face * length..][..length]
    }
}
