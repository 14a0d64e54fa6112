//! The device that commands draw with.

use std::sync::Arc;

use clap::ValueEnum;
use cli::print_note;
use render::{Backend, Gpu, MemoryBudget, RenderError};

/// Who draws shadows and lights.
#[derive(clap::Args)]
pub struct BackendArgs {
    /// Who draws shadows and lights of pictures
    #[arg(long, value_enum, default_value = "auto", value_name = "WHO")]
    backend: BackendChoice,
}

#[derive(Clone, Copy, ValueEnum)]
enum BackendChoice {
    /// Native where the graphics driver draws on the processor anyway, wgpu elsewhere
    Auto,
    /// The processor, on all cores, for machines without a GPU; the driver still finds what each pixel sees
    Native,
    /// The graphics driver, be it a GPU's or a software one
    Wgpu,
}

impl BackendArgs {
    /// Who was asked for; `None` where that follows from the device.
    pub fn wanted(&self) -> Option<Backend> {
        match self.backend {
            BackendChoice::Auto => None,
            BackendChoice::Native => Some(Backend::Native),
            BackendChoice::Wgpu => Some(Backend::Wgpu),
        }
    }
}

/// Opens the best device, which draws all itself, and says so where its driver is slow for no need.
pub fn open() -> Result<Arc<Gpu>, RenderError> {
    let gpu = Gpu::open(MemoryBudget::default(), Some(Backend::Wgpu))?;
    if let Some(advice) = gpu.advice() {
        print_note(&format!("note: {advice}"));
    }
    Ok(Arc::new(gpu))
}
