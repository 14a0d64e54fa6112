//! How texels are blended.

/// Percentage-closer filters: each texel is compared by itself, and the answers are blended.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ShadowFilter {
    /// The nearest texel alone.
    Nearest,
    /// 2 x 2 texels, by the distances of their centres.
    #[default]
    Bilinear,
    /// 4 x 4 texels: nine bilinear look-ups a texel apart.
    Pcf3x3,
}

impl ShadowFilter {
    /// Every filter, in the order of the variants.
    pub const ALL: [Self; 3] = [Self::Nearest, Self::Bilinear, Self::Pcf3x3];
}
