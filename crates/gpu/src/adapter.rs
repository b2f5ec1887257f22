//! Which adapter draws, and what to tell the user when it is not the one they paid for.

use std::path::Path;

use meniscus_core::Flaw;
use serde::Serialize;

use crate::GpuError;

/// What to install on a machine without any Vulkan driver.
pub const INSTALL_HINT: &str = "Install a driver: the GPU's own, or Mesa's software driver with \
     `apt-get install -y --no-install-recommends mesa-vulkan-drivers libvulkan1` (Debian, Ubuntu)";

/// How the user wants the adapter chosen.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct AdapterChoice {
    /// Index in [`list_adapters`] or part of the name, case-insensitive; `None`: best GPU, else software.
    /// `WGPU_ADAPTER_NAME` is used when this is `None`.
    pub adapter: Option<String>,
    /// Refuse software adapters.
    pub require_gpu: bool,
}

/// An adapter as listed to the user.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct AdapterSummary {
    /// Name the driver gives.
    pub name: String,
    /// `vulkan`, ...
    pub backend: String,
    /// `DiscreteGpu`, `IntegratedGpu`, `Cpu`, ...
    pub device_type: String,
    /// Driver name and version.
    pub driver: String,
}

impl AdapterSummary {
    pub(crate) fn of(info: &wgpu::AdapterInfo) -> Self {
        Self {
            name: info.name.clone(),
            backend: info.backend.to_string(),
            device_type: format!("{:?}", info.device_type),
            driver: format!("{} {}", info.driver, info.driver_info).trim().to_owned(),
        }
    }

    /// Whether the CPU draws.
    pub fn is_software(&self) -> bool {
        self.is(wgpu::DeviceType::Cpu)
    }

    /// Whether it is a GPU with memory of its own.
    pub fn is_discrete(&self) -> bool {
        self.is(wgpu::DeviceType::DiscreteGpu)
    }

    fn is(&self, kind: wgpu::DeviceType) -> bool {
        self.device_type == format!("{kind:?}")
    }
}

pub(crate) fn instance() -> wgpu::Instance {
    let descriptor = wgpu::InstanceDescriptor {
        backends: wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY),
        flags: wgpu::InstanceFlags::empty().with_env(),
        // A resource that does not fit is an error to whoever makes it; beyond, drivers lose the device with all that is on it.
        memory_budget_thresholds: wgpu::MemoryBudgetThresholds {
            for_resource_creation: Some(95),
            for_device_loss: None,
        },
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    };
    wgpu::Instance::new(descriptor)
}

/// All adapters, best first: discrete, integrated, virtual, software.
pub fn list_adapters() -> Vec<AdapterSummary> {
    sorted_adapters(&instance()).iter().map(|a| AdapterSummary::of(&a.get_info())).collect()
}

fn sorted_adapters(instance: &wgpu::Instance) -> Vec<wgpu::Adapter> {
    let backends = wgpu::Backends::from_env().unwrap_or(wgpu::Backends::PRIMARY);
    let mut adapters = pollster::block_on(instance.enumerate_adapters(backends));
    adapters.sort_by_key(|a| rank(a.get_info().device_type));
    adapters
}

fn rank(kind: wgpu::DeviceType) -> u8 {
    match kind {
        wgpu::DeviceType::DiscreteGpu => 0,
        wgpu::DeviceType::IntegratedGpu => 1,
        wgpu::DeviceType::VirtualGpu => 2,
        wgpu::DeviceType::Other => 3,
        wgpu::DeviceType::Cpu => 4,
    }
}

/// Picks the adapter and, when software draws on a machine that has a GPU, the flaw that says so.
pub(crate) fn choose(
    instance: &wgpu::Instance,
    choice: &AdapterChoice,
) -> Result<(wgpu::Adapter, Option<Flaw>), GpuError> {
    let adapters = sorted_adapters(instance);
    let summaries: Vec<_> = adapters.iter().map(|a| AdapterSummary::of(&a.get_info())).collect();
    let index = pick(
        &summaries,
        choice,
        std::env::var("WGPU_ADAPTER_NAME").ok().as_deref(),
        gpu_advice(Path::new("/")),
    )?;
    let software = summaries[index].is_software();
    let explicit = choice.adapter.is_some();
    let flaw = (software && !explicit)
        .then(|| gpu_advice(Path::new("/")))
        .flatten()
        .map(|advice| Flaw::SoftwareAdapter { advice });
    Ok((adapters.into_iter().nth(index).expect("pick returns an index of the list"), flaw))
}

/// The choice itself, over plain data so that it can be tested: `advice` is what a machine with a GPU node gets told.
fn pick(
    adapters: &[AdapterSummary],
    choice: &AdapterChoice,
    env_name: Option<&str>,
    advice: Option<String>,
) -> Result<usize, GpuError> {
    let names = || {
        adapters.iter().enumerate().map(|(i, a)| format!("{i}: {}", a.name)).collect::<Vec<_>>().join(", ")
    };
    if adapters.is_empty() {
        return Err(GpuError::NoAdapter);
    }
    let wanted = choice.adapter.as_deref().or(env_name);
    let index = match wanted {
        None => 0,
        Some(wanted) => {
            let found = match wanted.trim().parse::<usize>() {
                Ok(index) => (index < adapters.len()).then_some(index),
                Err(_) if wanted.trim().is_empty() => None,
                Err(_) => adapters
                    .iter()
                    .position(|a| a.name.to_lowercase().contains(&wanted.trim().to_lowercase())),
            };
            found.ok_or_else(|| GpuError::NoSuchAdapter { wanted: wanted.to_owned(), available: names() })?
        }
    };
    if choice.require_gpu && adapters[index].is_software() {
        return Err(GpuError::OnlySoftware {
            available: names(),
            advice: advice.unwrap_or_else(|| {
                "Install the GPU's own Vulkan driver, or leave out --require-gpu to draw on the CPU"
                    .to_owned()
            }),
        });
    }
    Ok(index)
}

/// If the machine has a GPU's device node, why Vulkan may not see it and what to do. `root` is `/` outside of tests.
fn gpu_advice(root: &Path) -> Option<String> {
    let exists = |path: &str| root.join(path).exists();
    if exists("dev/nvidiactl") || exists("dev/nvidia0") {
        return Some(
            "an NVIDIA device node is there but Vulkan does not show the GPU. In a container, start it with \
             NVIDIA_DRIVER_CAPABILITIES=graphics,compute,utility; check that nvidia_icd.json is in /etc/vulkan/icd.d or \
             /usr/share/vulkan/icd.d (else point VK_DRIVER_FILES at it); on machines without X its \"library_path\" must \
             name libEGL_nvidia.so.0 instead of libGLX_nvidia.so.0"
                .to_owned(),
        );
    }
    if exists("dev/kfd") {
        return Some(
            "an AMD device node (/dev/kfd) is there but Vulkan does not show the GPU: install mesa-vulkan-drivers and give \
             the user access to /dev/dri/renderD* (group render)"
                .to_owned(),
        );
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn adapter(name: &str, device_type: wgpu::DeviceType) -> AdapterSummary {
        AdapterSummary {
            name: name.into(),
            backend: "vulkan".into(),
            device_type: format!("{device_type:?}"),
            driver: String::new(),
        }
    }

    #[test]
    fn picks_by_order_index_and_name() {
        let list = [
            adapter("GeForce", wgpu::DeviceType::DiscreteGpu),
            adapter("llvmpipe (LLVM)", wgpu::DeviceType::Cpu),
        ];
        let by = |name: &str| AdapterChoice { adapter: Some(name.into()), require_gpu: false };
        assert_eq!(pick(&list, &AdapterChoice::default(), None, None).unwrap(), 0);
        assert_eq!(pick(&list, &AdapterChoice::default(), Some("llvm"), None).unwrap(), 1);
        assert_eq!(pick(&list, &by("1"), None, None).unwrap(), 1);
        assert_eq!(pick(&list, &by("LLVMPIPE"), None, None).unwrap(), 1);
        // The software adapter's name holds a 5; a number is an index all the same.
        let numbered = [adapter("llvmpipe (LLVM 15.0.6)", wgpu::DeviceType::Cpu)];
        assert!(pick(&numbered, &by("5"), None, None).is_err());
        assert!(pick(&numbered, &by(" "), None, None).is_err());
        let error = pick(&list, &by("radeon"), None, None).unwrap_err().to_string();
        assert!(error.contains("radeon") && error.contains("0: GeForce"), "{error}");
    }

    #[test]
    fn require_gpu_refuses_software_and_says_what_to_do() {
        let software = [adapter("llvmpipe", wgpu::DeviceType::Cpu)];
        let choice = AdapterChoice { adapter: None, require_gpu: true };
        let error = pick(&software, &choice, None, Some("mount the device".into())).unwrap_err().to_string();
        assert!(error.contains("mount the device"), "{error}");
        assert!(matches!(pick(&[], &choice, None, None), Err(GpuError::NoAdapter)));
    }

    #[test]
    fn a_device_node_is_noticed() {
        let root = std::env::temp_dir().join(format!("meniscus-adapter-{}", std::process::id()));
        std::fs::create_dir_all(root.join("dev")).unwrap();
        assert_eq!(gpu_advice(&root), None);
        std::fs::write(root.join("dev/nvidiactl"), "").unwrap();
        assert!(gpu_advice(&root).unwrap().contains("NVIDIA_DRIVER_CAPABILITIES"));
        std::fs::remove_dir_all(&root).unwrap();
    }
}
