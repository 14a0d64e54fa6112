//! Filters of shadow maps.

/// Percentage-closer filter: compares each texel by itself, and blends the answers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadowFilter {
    /// Nearest texel alone.
    Nearest,
    /// Blend of 2 x 2 texels, by the distances of their centers.
    #[default]
    Bilinear,
    /// Blend of 4 x 4 texels: nine bilinear lookups a texel apart.
    Pcf3x3,
}

impl ShadowFilter {
    /// Every filter, in the order of the variants.
    pub const ALL: [Self; 3] = [Self::Nearest, Self::Bilinear, Self::Pcf3x3];
}
