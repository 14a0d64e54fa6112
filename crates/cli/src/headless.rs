//! Support for machines without a window system.

use std::env;
use std::os::unix::process::CommandExt;
use std::process::Command;

/// Environment variable that turns off Mesa's `VK_LAYER_MESA_device_select`.
const NO_DEVICE_SELECT: &str = "NODEVICE_SELECT";

/// Restarts the program if needed, so that opening the GPU prints nothing to standard error. Call it before any
/// input or output.
///
/// Mesa's Vulkan layer that selects a device asks the window system which device it uses. If none runs,
/// libwayland prints an error about `XDG_RUNTIME_DIR` for each query. The environment controls the layer. A
/// running process cannot change its own environment safely, so this function starts a new process with another
/// one.
pub fn restart_without_window_system() {
    if env::var_os("XDG_RUNTIME_DIR").is_some() || env::var_os(NO_DEVICE_SELECT).is_some() {
        return;
    }
    if let Ok(program) = env::current_exe() {
        // `exec` returns only on failure. The program then goes on with the messages.
        let _ = Command::new(program).args(env::args_os().skip(1)).env(NO_DEVICE_SELECT, "1").exec();
    }
}
