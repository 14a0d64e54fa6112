//! Features of a light's profile that are compiled into its lighting pass.

use light::{DistanceRamps, LightProfile, ProfileCurve, SectionOutline};
use relight::ShadowFilter;

/// Values of the constants in `profile.wgsl` and `lighting.wgsl`. They are compiled in, so no light computes a feature
/// that it lacks, and no branch depends on a uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a constant of the shaders by itself")]
pub(crate) struct BakedFilter {
    profile: ProfileCurve,
    /// True if the outline is a superellipse.
    superellipse: bool,
    /// True if the edge is farther out on one side than on another.
    radial: bool,
    /// True if light begins or ends somewhere along its path.
    cut: bool,
    shadowed: bool,
}

impl BakedFilter {
    pub fn of(filter: &LightProfile) -> Self {
        Self {
            profile: filter.profile.curve,
            superellipse: filter.section != SectionOutline::Circle,
            radial: !filter.radial.is_uniform(),
            cut: filter.distance_ramps != DistanceRamps::NONE,
            shadowed: filter.shadow_enable,
        }
    }

    /// Returns sets of constants in which each field has each of its values at least once. Most lights have those of
    /// the first.
    #[cfg(test)]
    pub fn samples() -> [Self; 4] {
        let plain =
            Self { profile: ProfileCurve::Smooth, superellipse: false, radial: false, cut: false, shadowed: true };
        [
            plain,
            Self { profile: ProfileCurve::Linear, shadowed: false, ..plain },
            Self { profile: ProfileCurve::Power, superellipse: true, ..plain },
            Self { profile: ProfileCurve::Cosine, radial: true, cut: true, ..plain },
        ]
    }

    pub fn into_wgsl(self, wgsl: &str) -> String {
        let Self { profile, superellipse, radial, cut, shadowed } = self;
        format!(
            "const PROFILE = {}u;\nconst SUPERELLIPSE = {superellipse};\nconst RADIAL = {radial};\n\
             const CUT = {cut};\nconst SHADOWED = {shadowed};\n{wgsl}",
            profile as u32
        )
    }
}

/// Prepends the constant of `shadow_filter.wgsl` to `wgsl`.
pub(crate) fn with_filter(filter: ShadowFilter, wgsl: &str) -> String {
    format!("const SHADOW_FILTER = {}u;\n{wgsl}", filter as u32)
}
