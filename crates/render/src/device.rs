//! Choice of the device that draws pictures.

use std::sync::Arc;

use crate::{Backend, Cpu, Gpu, Host, MemoryBudget, RenderError};

/// An open device. Opening a GPU and compiling its pipelines is slow, so share one; clones are the same device.
#[derive(Clone, Debug)]
pub enum Device {
    /// The GPU, or a CPU with a software driver.
    Wgpu(Arc<Gpu>),
    /// The CPU, without any driver.
    Native(Arc<Cpu>),
}

impl Device {
    /// Opens the device of `backend`. `None` chooses the best GPU, or the CPU if there is none.
    pub fn open(host: Host, backend: Option<Backend>) -> Result<Self, RenderError> {
        Ok(match backend {
            Some(Backend::Native) => Self::Native(Arc::new(Cpu::new(host))),
            Some(Backend::Wgpu) => Self::Wgpu(Arc::new(Gpu::open(host)?)),
            None => match Gpu::best_adapter() {
                Some(adapter) => Self::Wgpu(Arc::new(Gpu::on(&adapter, host)?)),
                None => Self::Native(Arc::new(Cpu::new(host))),
            },
        })
    }

    /// Returns the device with a deliberate fault in its shaders, which tests must detect: `text` is replaced wherever
    /// it occurs in WGSL. Panics if the device is in use, or is the CPU.
    #[cfg(feature = "planted-faults")]
    #[must_use]
    pub fn with_fault(self, text: &'static str, replacement: &'static str) -> Self {
        let Self::Wgpu(gpu) = self else { panic!("the CPU runs no shaders") };
        let gpu = Arc::into_inner(gpu).expect("the device is not in use");
        Self::Wgpu(Arc::new(gpu.with_fault(text, replacement)))
    }

    /// Returns the backend of pictures.
    pub fn backend(&self) -> Backend {
        match self {
            Self::Wgpu(_) => Backend::Wgpu,
            Self::Native(_) => Backend::Native,
        }
    }

    /// Returns the name of the device: for a GPU, with the graphics interface and the driver's version.
    pub fn name(&self) -> String {
        match self {
            Self::Wgpu(gpu) => gpu.adapter_name().to_owned(),
            Self::Native(_) => Cpu::name(),
        }
    }

    /// Returns the name and version that the driver reports; empty for the CPU.
    pub fn driver(&self) -> &str {
        match self {
            Self::Wgpu(gpu) => gpu.driver(),
            Self::Native(_) => "",
        }
    }

    /// Returns a sentence of advice if another version of the driver would draw much faster.
    pub fn advice(&self) -> Option<&str> {
        match self {
            Self::Wgpu(gpu) => gpu.advice(),
            Self::Native(_) => None,
        }
    }

    /// Returns the budget that counts cached data.
    pub fn memory(&self) -> &MemoryBudget {
        match self {
            Self::Wgpu(gpu) => &gpu.host.memory,
            Self::Native(cpu) => &cpu.host.memory,
        }
    }
}
