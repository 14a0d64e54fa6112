//! The device that commands draw with.

use std::sync::Arc;

use cli::say;
use render::{Gpu, RenderError};

/// Opens the best device, and says so where its driver is slow for no need.
pub fn open() -> Result<Arc<Gpu>, RenderError> {
    let gpu = Gpu::new()?;
    if let Some(advice) = gpu.advice() {
        say(&format!("note: {advice}"));
    }
    Ok(Arc::new(gpu))
}
