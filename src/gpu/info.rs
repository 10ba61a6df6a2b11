//! What is known of a device, and which one a user's word means.

use super::error::GpuError;

#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum DeviceKind {
    Discrete,
    Integrated,
    Virtual,
    Software,
    Other,
}

/// The limits that matter here, as the driver states them.
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Limits {
    pub max_texel_elements: u32,
    pub max_storage_range: u32,
    /// Largest single allocation, in bytes.
    pub max_allocation: u64,
    /// Largest device-local heap, in bytes.
    pub heap: u64,
    pub max_groups: [u32; 3],
    pub max_group_size: [u32; 3],
    pub max_group_invocations: u32,
    pub max_shared_bytes: u32,
    pub max_push_bytes: u32,
    pub max_storage_bindings: u32,
    pub max_texel_bindings: u32,
}

#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct DeviceInfo {
    /// Place in the list, which `--device N` picks.
    pub index: usize,
    pub name: String,
    pub kind: DeviceKind,
    /// Runs on the CPU (lavapipe, SwiftShader).
    pub is_software: bool,
    /// "llvmpipe", "radv", "NVIDIA".
    pub driver: String,
    /// "Mesa 22.3.6 (LLVM 15.0.6)".
    pub driver_version: String,
    /// "1.3.230".
    pub api_version: String,
    pub vendor_id: u32,
    pub device_id: u32,
    pub subgroup_size: u32,
    /// Nanoseconds a tick of the compute queue's clock; 0 where it has none.
    pub timestamp_period_ns: f32,
    pub limits: Limits,
    /// Why it cannot be used, if so.
    pub problem: Option<String>,
}

impl DeviceInfo {
    /// "llvmpipe (LLVM 15.0.6, 256 bits), Mesa 22.3.6 (LLVM 15.0.6)": enough to repeat a measurement.
    pub fn title(&self) -> String {
        format!("{}, {}", self.name, self.driver_version)
    }

    /// What a driver's compiled code may depend on; a key for caches.
    pub fn fingerprint(&self) -> String {
        format!(
            "{}|{}|{}|{}|{:x}:{:x}",
            self.name, self.driver, self.driver_version, self.api_version, self.vendor_id, self.device_id
        )
    }

    fn matches(&self, word: &str) -> bool {
        let word = word.to_lowercase();
        // Mesa calls lavapipe's device llvmpipe; users know the former name.
        let alias = if self.driver.eq_ignore_ascii_case("llvmpipe") { "lavapipe" } else { "" };
        [self.name.as_str(), self.driver.as_str(), alias].iter().any(|s| s.to_lowercase().contains(&word))
    }
}

/// What `--device` may say.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Choice {
    /// A GPU, else software Vulkan, else the CPU reference.
    #[default]
    Auto,
    /// The CPU reference.
    Cpu,
    Index(usize),
    /// Part of a device's or driver's name, case ignored.
    Name(String),
}

impl From<&str> for Choice {
    fn from(word: &str) -> Choice {
        match word {
            "auto" => Choice::Auto,
            "cpu" => Choice::Cpu,
            _ => word.parse().map_or_else(|_| Choice::Name(word.to_owned()), Choice::Index),
        }
    }
}

impl std::fmt::Display for Choice {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Choice::Auto => f.write_str("auto"),
            Choice::Cpu => f.write_str("cpu"),
            Choice::Index(i) => write!(f, "{i}"),
            Choice::Name(name) => f.write_str(name),
        }
    }
}

/// Position in `devices` of the one that `choice` means. `Cpu` means none of them: `NoDevice`.
pub fn choose(devices: &[DeviceInfo], choice: &Choice) -> Result<usize, GpuError> {
    let unknown = || GpuError::UnknownDevice { wanted: choice.to_string(), available: available(devices) };
    let picked = match choice {
        Choice::Cpu => return Err(GpuError::NoDevice),
        Choice::Auto => best(devices, |_| true).ok_or(GpuError::NoDevice)?,
        Choice::Index(index) => devices.get(*index).map(|_| *index).ok_or_else(unknown)?,
        Choice::Name(name) => best(devices, |d| d.matches(name))
            .or_else(|| devices.iter().position(|d| d.matches(name)))
            .ok_or_else(unknown)?,
    };
    match &devices[picked].problem {
        None => Ok(picked),
        Some(missing) => {
            Err(GpuError::MissingFeature { device: devices[picked].name.clone(), missing: missing.clone() })
        }
    }
}

fn best(devices: &[DeviceInfo], accept: impl Fn(&DeviceInfo) -> bool) -> Option<usize> {
    let rank = |d: &DeviceInfo| match d.kind {
        DeviceKind::Discrete => 0,
        DeviceKind::Integrated => 1,
        DeviceKind::Virtual => 2,
        DeviceKind::Other => 3,
        DeviceKind::Software => 4,
    };
    (0..devices.len())
        .filter(|&i| devices[i].problem.is_none() && accept(&devices[i]))
        .min_by_key(|&i| rank(&devices[i]))
}

fn available(devices: &[DeviceInfo]) -> String {
    let listed = devices.iter().map(|d| format!("{} {}", d.index, d.name));
    listed.chain(["cpu".to_owned()]).collect::<Vec<_>>().join("; ")
}
