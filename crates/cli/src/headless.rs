//! Running on a machine without a window system.

use std::env;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Turns off Mesa's `VK_LAYER_MESA_device_select`.
const NO_DEVICE_SELECT: &str = "NODEVICE_SELECT";

/// Starts the program again, where it must be, so that opening the GPU writes nothing to standard error. Call
/// it before anything is read or written.
///
/// Mesa's Vulkan layer that selects a device asks the window system which one it draws with. Where none runs,
/// libwayland writes an error about `XDG_RUNTIME_DIR` at each question. The layer goes by the environment,
/// and a running process cannot change its own safely; a new one can be given another.
pub fn restart_without_window_system() {
    if env::var_os("XDG_RUNTIME_DIR").is_some() || env::var_os(NO_DEVICE_SELECT).is_some() {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // Comes back only where it fails; then the noise stays and the work goes on.
        let _ = Command::new(program).args(env::args_os().skip(1)).env(NO_DEVICE_SELECT, "1").exec();
    }
}
