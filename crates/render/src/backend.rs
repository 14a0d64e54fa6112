//! Choice of GPU or CPU for pictures.

/// Backend that draws pictures: surfaces, shadow maps, light contributions and their sum, and AOVs. Moving and final
/// pictures use the same one, so both show the same shadows.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Backend {
    /// The graphics device, through wgpu.
    Wgpu,
    /// The CPU, through the crate `relight`.
    Native,
}

impl Backend {
    /// Returns the name on command lines and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgpu => "wgpu",
            Self::Native => "native",
        }
    }
}
