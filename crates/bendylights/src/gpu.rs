//! Device and backend of commands.

use std::sync::Arc;

use clap::ValueEnum;
use cli::print_note;
use render::{Backend, Device, Gpu, Host, RenderError};

/// Option for the backend of pictures.
#[derive(clap::Args)]
pub struct BackendArgs {
    /// Backend that draws pictures
    #[arg(long, value_enum, default_value = "auto", value_name = "WHO")]
    backend: BackendChoice,
}

#[derive(Clone, Copy, ValueEnum)]
enum BackendChoice {
    /// wgpu if there is a GPU, native otherwise
    Auto,
    /// The CPU, on all cores; needs no graphics driver
    Native,
    /// The graphics driver, of a GPU or a software one
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

/// Opens the device of `backend`, or the best one. Prints a note if its driver is needlessly slow.
pub fn open(backend: Option<Backend>) -> Result<Device, RenderError> {
    let device = Device::open(Host::default(), backend)?;
    if let Some(advice) = device.advice() {
        print_note(&format!("note: {advice}"));
    }
    Ok(device)
}

/// Opens the best device with a graphics driver.
pub fn open_gpu() -> Result<Arc<Gpu>, RenderError> {
    let gpu = Gpu::open(Host::default())?;
    if let Some(advice) = gpu.advice() {
        print_note(&format!("note: {advice}"));
    }
    Ok(Arc::new(gpu))
}
