//! What a light sees first: a depth a texel, on each face of its shadow map.

/// The faces of a shadow map, each `side` by `side` texels, rows from the top. What depths mean, and which of two wins,
/// is the light's.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DepthMap {
    side: usize,
    faces: usize,
    texels: Vec<f32>,
}

impl DepthMap {
    /// A map of so many faces, whose depths are yet to be drawn.
    pub fn new(side: usize, faces: usize) -> Self {
        Self { side, faces, texels: vec![0.0; faces * side * side] }
    }

    /// Texels along each side of a face.
    pub fn side(&self) -> usize {
        self.side
    }

    /// How many faces there are.
    pub fn faces(&self) -> usize {
        self.faces
    }

    /// All depths, face after face.
    pub(crate) fn texels(&self) -> &[f32] {
        &self.texels
    }

    /// A face's depths, row after row.
    pub fn face(&self, face: usize) -> &[f32] {
        let length = self.side * self.side;
        &self.texels[face * length..][..length]
    }

    /// The same, to be drawn to.
    pub fn face_mut(&mut self, face: usize) -> &mut [f32] {
        let length = self.side * self.side;
        &mut self.texels[face * length..][..length]
    }

    /// Of its texels.
    pub fn bytes(&self) -> u64 {
        size_of_val(self.texels.as_slice()) as u64
    }
}
