//! Choice of GPU or CPU for shadows and lights.

use wgpu::{Adapter, DeviceType, DownlevelFlags};

/// Device that draws shadow maps, light contributions and their sum for pictures of the beauty. Moving and final
/// pictures use the same one, so both show the same shadows. wgpu always draws the G-buffer and every other AOV.
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

    /// Returns the default for `adapter`: the CPU if the graphics device itself is a CPU.
    pub(crate) fn of(adapter: &Adapter) -> Self {
        let is_processor = adapter.get_info().device_type == DeviceType::Cpu;
        if is_processor && Self::Native.works_with(adapter) { Self::Native } else { Self::Wgpu }
    }

    /// True if this backend can draw with `adapter`. GL cannot read back depths, which the native backend needs.
    pub(crate) fn works_with(self, adapter: &Adapter) -> bool {
        let flags = adapter.get_downlevel_capabilities().flags;
        self == Self::Wgpu || flags.contains(DownlevelFlags::DEPTH_TEXTURE_AND_BUFFER_COPIES)
    }
}
