//! Device and backend of commands.

use std::sync::Arc;

use clap::ValueEnum;
use cli::print_note;
use render::{Backend, Gpu, MemoryBudget, RenderError};

/// Option for the backend of shadows and lights.
#[derive(clap::Args)]
pub struct BackendArgs {
    /// Backend that draws shadows and lights of pictures
    #[arg(long, value_enum, default_value = "auto", value_name = "WHO")]
    backend: BackendChoice,
}

#[derive(Clone, Copy, ValueEnum)]
enum BackendChoice {
    /// Native where the graphics driver draws on the processor anyway, wgpu elsewhere
    Auto,
    /// The processor, on all cores, for machines without a GPU; the driver draws AOVs alone
    Native,
    /// The graphics driver, be it a GPU's or a software one
    Wgpu,
}

impl BackendArgs {
    /// Returns the requested backend, or `None` if the device is to decide.
    pub fn wanted(&self) -> Option<Backend> {
        match self.backend {
            BackendChoice::Auto => None,
            BackendChoice::Native => Some(Backend::Native),
            BackendChoice::Wgpu => Some(Backend::Wgpu),
        }
    }
}

/// Opens the best device with the wgpu backend. Prints a note if its driver is needlessly slow.
pub fn open() -> Result<Arc<Gpu>, RenderError> {
    let gpu = Gpu::open(MemoryBudget::default(), Some(Backend::Wgpu))?;
    if let Some(advice) = gpu.advice() {
        print_note(&format!("note: {advice}"));
    }
    Ok(Arc::new(gpu))
}
