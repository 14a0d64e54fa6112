//! Which of a light's filters its lighting pass is compiled with.

use light::{DistanceRamps, LightProfile, ProfileCurve, SectionOutline};

/// See the constants of `profile.wgsl` and `lighting.wgsl`. They are compiled in, so that no light computes what it does
/// not have, and no branch hangs on a uniform.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a constant of the shaders by itself")]
pub(crate) struct BakedFilter {
    profile: ProfileCurve,
    /// Whether its outline is a superellipse.
    superellipse: bool,
    /// Whether its edge lies farther out to one side than to another.
    radial: bool,
    /// Whether light begins or ends somewhere along its way.
    cut: bool,
    /// Whether anything shadows it.
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

    /// Each value of each field at least once, that of most lights first.
    #[cfg(test)]
    pub fn samples() -> [Self; 4] {
        let plain = Self {
            profile: ProfileCurve::Smooth,
            superellipse: false,
            radial: false,
            cut: false,
            shadowed: true,
        };
        [
            plain,
            Self { profile: ProfileCurve::Linear, shadowed: false, ..plain },
            Self { profile: ProfileCurve::Power, superellipse: true, ..plain },
            Self { profile: ProfileCurve::Cosine, radial: true, cut: true, ..plain },
        ]
    }

    /// `wgsl` with its constants.
    pub fn into_wgsl(self, wgsl: &str) -> String {
        let Self { profile, superellipse, radial, cut, shadowed } = self;
        format!(
            "const PROFILE = {}u;\nconst SUPERELLIPSE = {superellipse};\nconst RADIAL = {radial};\n\
             const CUT = {cut};\nconst SHADOWED = {shadowed};\n{wgsl}",
            profile as u32
        )
    }
}
