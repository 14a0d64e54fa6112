//! Names of drivers, and advice about slow ones.

use wgpu::AdapterInfo;

/// First Mesa version whose software driver skips shader branches that no pixel takes. Older ones run both sides.
const MIN_FAST_MESA: u32 = 25;

/// Returns the name of the device, with the interface and the driver's version.
pub(crate) fn adapter_name(info: &AdapterInfo) -> String {
    let AdapterInfo { name, backend, driver_info, .. } = info;
    if driver_info.is_empty() { format!("{name} ({backend})") } else { format!("{name} ({backend}, {driver_info})") }
}

/// Returns advice, as a sentence, if another version of the driver would draw much faster.
pub(crate) fn advice(info: &AdapterInfo) -> Option<String> {
    let version = info.driver_info.strip_prefix("Mesa ").filter(|_| info.driver == "llvmpipe")?;
    let version = version.split(' ').next()?;
    (major(version)? < MIN_FAST_MESA).then(|| {
        format!(
            "Mesa {version} draws slowly: install mesa-vulkan-drivers {MIN_FAST_MESA} or newer (`make test-packages` \
             does; Debian 12 has it in bookworm-backports)"
        )
    })
}

/// Returns the major version: 22 for `22.3.6` or `22.3.6-devel`; `None` if there is no version.
fn major(version: &str) -> Option<u32> {
    let (major, rest) = version.split_once('.')?;
    let digit = |c: u8| c.is_ascii_digit();
    (major.bytes().all(digit) && rest.bytes().next().is_some_and(digit)).then(|| major.parse().ok())?
}

#[cfg(test)]
mod tests {
    use wgpu::{AdapterInfo, Backend, DeviceType};

    use super::{adapter_name, advice};

    fn info(name: &str, driver: &str, driver_info: &str) -> AdapterInfo {
        let [name, driver, driver_info] = [name, driver, driver_info].map(String::from);
        AdapterInfo { name, driver, driver_info, ..AdapterInfo::new(DeviceType::Cpu, Backend::Vulkan) }
    }

    fn advised(driver: &str, driver_info: &str) -> Option<String> {
        advice(&info("a device", driver, driver_info))
    }

    #[test]
    fn an_old_software_driver_is_named_with_what_to_do() {
        for (says, version) in [
            ("Mesa 22.3.6 (LLVM 15.0.6)", "22.3.6"),
            ("Mesa 24.3.4-1 (LLVM 19.1.7)", "24.3.4-1"),
            ("Mesa 9.0.0-devel (git-0123abc)", "9.0.0-devel"),
            ("Mesa 24.1", "24.1"),
        ] {
            let advice = advised("llvmpipe", says).expect("it is old");
            assert!(advice.starts_with(&format!("Mesa {version} draws slowly: install ")), "{advice}");
        }
    }

    /// New versions, other drivers with any version, and unknown texts.
    #[test]
    fn of_others_nothing_is_said() {
        for says in [
            "Mesa 25.0.7-2~bpo12+1 (LLVM 15.0.6)",
            "Mesa 25.0.0",
            "Mesa 100.1.2 (LLVM 30.0.0)",
            "Mesa 22",
            "Mesa 22.",
            "Mesa .3",
            "Mesa +22.3.6",
            "Mesa -1.3",
            "Mesa 4294967296.0",
            "Mesa  22.3.6",
            "Mesa",
            "Mesa ",
            "mesa 22.3.6",
            "22.3.6",
            "Mesa \u{0662}\u{0662}.3",
            "",
        ] {
            assert_eq!(advised("llvmpipe", says), None, "{says}");
        }
        for driver in ["radv", "Intel open-source Mesa driver", "NVIDIA", "llvmpipe2", ""] {
            assert_eq!(advised(driver, "Mesa 22.3.6 (LLVM 15.0.6)"), None, "{driver}");
        }
    }

    #[test]
    fn a_name_has_the_drivers_version_where_it_has_one() {
        let mesa = info("llvmpipe (LLVM 15.0.6, 256 bits)", "llvmpipe", "Mesa 22.3.6 (LLVM 15.0.6)");
        assert_eq!(adapter_name(&mesa), "llvmpipe (LLVM 15.0.6, 256 bits) (vulkan, Mesa 22.3.6 (LLVM 15.0.6))");
        assert_eq!(adapter_name(&info("a device", "", "")), "a device (vulkan)");
    }
}
