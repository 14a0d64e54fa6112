//! Who draws shadows and lights.

use wgpu::{Adapter, DeviceType, DownlevelFlags};

/// Who draws shadow maps, what lights add and its sum for pictures of the beauty, so that one that moves and one at rest
/// show the same shadows. What pixels see, and pictures of every other AOV, the device draws.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Backend {
    /// The graphics device.
    Wgpu,
    /// The processor, by the crate `relight`.
    Native,
}

impl Backend {
    /// What it is called on command lines and in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::Wgpu => "wgpu",
            Self::Native => "native",
        }
    }

    /// Who draws with `adapter` where nobody says: the processor where that is the graphics device too.
    pub(crate) fn of(adapter: &Adapter) -> Self {
        let is_processor = adapter.get_info().device_type == DeviceType::Cpu;
        if is_processor && Self::Native.works_with(adapter) { Self::Native } else { Self::Wgpu }
    }

    /// Whether it can draw what `adapter` sees: GL gives no depths back.
    pub(crate) fn works_with(self, adapter: &Adapter) -> bool {
        let flags = adapter.get_downlevel_capabilities().flags;
        self == Self::Wgpu || flags.contains(DownlevelFlags::DEPTH_TEXTURE_AND_BUFFER_COPIES)
    }
}
