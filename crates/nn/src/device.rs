//! Devices that tensors live on. burn 0.22 chooses the backend by a value, not by a type, so this is the one place that names it.

use std::fmt;
use std::panic::{self, AssertUnwindSafe, catch_unwind};
use std::str::FromStr;
use std::sync::{Arc, Mutex, PoisonError};

pub use burn::tensor::Device;
use burn::tensor::Tensor;

use crate::numbers::read;

/// Returns the device for inference: burn's `flex` backend on the CPU (SIMD, all cores).
pub fn inference() -> Device {
    Device::flex()
}

/// Returns the device for training: as [`inference`], and tensors created on it record what gradients need.
pub fn training() -> Device {
    inference().autodiff()
}

/// Device that networks learn on: `cpu`, `cuda:N` or `wgpu`.
///
/// The same numbers come out up to rounding; on the CPU they are the same to the last bit each time.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub enum Processor {
    /// All cores.
    #[default]
    Cpu,
    /// The NVIDIA card of this number (`cuda` is `cuda:0`).
    Cuda(usize),
    /// The card that the system prefers, by Vulkan, Metal or DirectX 12. The environment variable
    /// `CUBECL_WGPU_DEFAULT_DEVICE` names another one: `DiscreteGpu(1)`, `IntegratedGpu(0)`, `Cpu`.
    Wgpu,
}

/// A [`Processor`] that cannot be had.
#[derive(Debug, thiserror::Error)]
pub enum DeviceError {
    /// Not one of the names.
    #[error("device: expected cpu, cuda:N or wgpu, got '{0}'")]
    Unknown(String),
    /// The program was built without it.
    #[error("this build has no {0}; build with --features {0}")]
    NotBuilt(&'static str),
    /// There is no such card, or its driver does not work.
    #[error("device {processor}: expected a card that can be used, got: {why}")]
    Absent {
        /// The device asked for.
        processor: Processor,
        /// The driver's message.
        why: String,
    },
}

impl Processor {
    /// Returns those that this build knows how to open.
    pub fn built() -> Vec<Self> {
        let mut all = vec![Self::Cpu];
        if cfg!(feature = "cuda") {
            all.push(Self::Cuda(0));
        }
        if cfg!(feature = "wgpu") {
            all.push(Self::Wgpu);
        }
        all
    }

    /// Opens it, and computes something on it: a card without a driver is noticed here and not in the middle of a run.
    ///
    /// # Errors
    /// This build or this machine has none.
    pub fn open(self) -> Result<Device, DeviceError> {
        let device = match self {
            Self::Cpu => return Ok(inference()),
            Self::Cuda(card) => cuda(card)?,
            Self::Wgpu => wgpu()?,
        };
        let absent = |why: String| DeviceError::Absent { processor: self, why };
        match attempt(|| read(Tensor::<1>::ones([4], &device).sum())).map_err(absent)? {
            Ok(sum) if sum == [4.0] => Ok(device),
            Ok(sum) => Err(absent(format!("1 + 1 + 1 + 1 = {sum:?}"))),
            Err(error) => Err(absent(error.to_string())),
        }
    }
}

#[cfg(feature = "cuda")]
fn cuda(card: usize) -> Result<Device, DeviceError> {
    Ok(Device::cuda(card))
}

#[cfg(not(feature = "cuda"))]
fn cuda(_: usize) -> Result<Device, DeviceError> {
    Err(DeviceError::NotBuilt("cuda"))
}

#[cfg(feature = "wgpu")]
fn wgpu() -> Result<Device, DeviceError> {
    Ok(Device::wgpu(burn::tensor::DeviceKind::DefaultDevice))
}

#[cfg(not(feature = "wgpu"))]
fn wgpu() -> Result<Device, DeviceError> {
    Err(DeviceError::NotBuilt("wgpu"))
}

/// Returns what `work` gives, or the first message of its panic, here or on a thread of its own: the tensor library has no other
/// way to say that there is no card.
fn attempt<T>(work: impl FnOnce() -> T) -> Result<T, String> {
    let said = Arc::new(Mutex::new(None));
    let ear = Arc::clone(&said);
    let usual = panic::take_hook();
    panic::set_hook(Box::new(move |panic| {
        let mut said = ear.lock().unwrap_or_else(PoisonError::into_inner);
        let text = panic.payload_as_str().unwrap_or("nothing");
        said.get_or_insert_with(|| text.lines().next().unwrap_or_default().to_owned());
    }));
    let result = catch_unwind(AssertUnwindSafe(work));
    panic::set_hook(usual);
    result.map_err(|_| said.lock().unwrap_or_else(PoisonError::into_inner).take().unwrap_or_default())
}

impl FromStr for Processor {
    type Err = DeviceError;

    fn from_str(text: &str) -> Result<Self, DeviceError> {
        let unknown = || DeviceError::Unknown(text.to_owned());
        match text.split_once(':') {
            None if text == "cpu" => Ok(Self::Cpu),
            None if text == "wgpu" => Ok(Self::Wgpu),
            None if text == "cuda" => Ok(Self::Cuda(0)),
            Some(("cuda", card)) => card.parse().map(Self::Cuda).map_err(|_| unknown()),
            _ => Err(unknown()),
        }
    }
}

impl fmt::Display for Processor {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Cpu => f.write_str("cpu"),
            Self::Cuda(card) => write!(f, "cuda:{card}"),
            Self::Wgpu => f.write_str("wgpu"),
        }
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn names_are_read_as_they_are_written() {
        for processor in [Processor::Cpu, Processor::Cuda(3), Processor::Wgpu] {
            assert_eq!(processor.to_string().parse::<Processor>().unwrap(), processor);
        }
        assert_eq!("cuda".parse::<Processor>().unwrap(), Processor::Cuda(0));
        for wrong in ["", "gpu", "cuda:", "cuda:-1", "wgpu:x", "cpu:0"] {
            let error = wrong.parse::<Processor>().unwrap_err().to_string();
            assert!(error.contains("cuda:N") && error.contains(&format!("'{wrong}'")), "{error}");
        }
    }

    #[test]
    fn the_first_panic_of_an_attempt_is_what_is_told() {
        assert_eq!(attempt(|| 4), Ok(4));
        let failed = attempt(|| {
            let deep = std::thread::spawn(|| panic!("no adapter\nat all"));
            deep.join().unwrap()
        });
        assert_eq!(failed, Err::<(), _>("no adapter".into()));
    }

    #[test]
    fn the_cpu_is_always_there_and_a_device_that_was_not_built_says_how_to_build_it() {
        assert_eq!(Processor::Cpu.open().unwrap(), inference());
        if cfg!(not(feature = "cuda")) {
            assert!(Processor::Cuda(0).open().unwrap_err().to_string().contains("--features cuda"));
        }
        if cfg!(not(feature = "wgpu")) {
            assert!(Processor::Wgpu.open().unwrap_err().to_string().contains("--features wgpu"));
        }
    }
}
