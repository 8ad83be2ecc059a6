//! The instruction sets, and the one that this process uses.

use std::fmt;
use std::str::FromStr;
use std::sync::OnceLock;

use fearless_simd::{Level, Simd};

/// Environment variable that forces an instruction set, by its name.
pub const VARIABLE: &str = "LIFELIKE_SIMD";

/// Vector instructions that a [`Task`] is compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum InstructionSet {
    /// Instructions of every machine of this architecture (x86-64: SSE2). Fused multiply-adds are computed in several
    /// instructions: the same bits, slowly.
    Portable,
    /// 128 bits, 64-bit ARM.
    Neon,
    /// 256 bits and fused multiply-add: x86-64 since 2013 (Haswell, Excavator).
    Avx2,
    /// 512 bits: x86-64 since Ice Lake and Zen 4.
    Avx512,
}

/// A computation in vectors of whatever instruction set it is run with.
///
/// `run` and all that it calls in a hot loop must be `#[inline(always)]`, or be another call of [`Simd::vectorize`]: a
/// function of its own is compiled without the instruction set.
pub trait Task {
    /// Result of the task.
    type Output;
    /// Computes with the instructions that `simd` stands for.
    fn run<S: Simd>(self, simd: S) -> Self::Output;
}

/// [`VARIABLE`] names something that this machine has not.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{VARIABLE}: this machine has {expected}, got '{got}'")]
pub struct Unavailable {
    expected: String,
    got: String,
}

impl InstructionSet {
    /// All that have a name, the widest last.
    const ALL: [Self; 4] = [Self::Portable, Self::Neon, Self::Avx2, Self::Avx512];

    /// Returns its name, as [`VARIABLE`] takes it.
    pub fn name(self) -> &'static str {
        match self {
            Self::Portable => "portable",
            Self::Neon => "neon",
            Self::Avx2 => "avx2",
            Self::Avx512 => "avx512",
        }
    }

    /// Returns the instruction sets of this machine, the best one last.
    pub fn available() -> Vec<Self> {
        Self::ALL.into_iter().filter(|set| set.is_available()).collect()
    }

    fn is_available(self) -> bool {
        let level = Level::new();
        match self {
            Self::Portable => cfg!(not(target_arch = "aarch64")),
            #[cfg(target_arch = "aarch64")]
            Self::Neon => level.as_neon().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx2 => level.as_avx2().is_some(),
            #[cfg(target_arch = "x86_64")]
            Self::Avx512 => level.as_avx512().is_some(),
            #[allow(unreachable_patterns)]
            _ => {
                let _ = level;
                false
            }
        }
    }

    /// Returns the best instruction set of this machine.
    pub fn best() -> Self {
        Self::available().last().copied().unwrap_or(Self::Portable)
    }

    /// Returns what [`VARIABLE`] asks for; the best one where it is not set.
    ///
    /// # Errors
    /// It names none of [`Self::available`].
    pub fn from_environment() -> Result<Self, Unavailable> {
        match std::env::var(VARIABLE) {
            Ok(name) => name.parse(),
            Err(_) => Ok(Self::best()),
        }
    }

    /// Returns the instruction set of this process: that of [`Self::from_environment`] when it is first asked for, and the
    /// best one where the variable makes no sense (the command refuses to start then).
    pub fn chosen() -> Self {
        static CHOSEN: OnceLock<InstructionSet> = OnceLock::new();
        *CHOSEN.get_or_init(|| Self::from_environment().unwrap_or_else(|_| Self::best()))
    }

    /// Runs a task with these instructions; with those of [`Self::best`] where the machine lacks them.
    #[inline]
    pub fn run<T: Task>(self, task: T) -> T::Output {
        let level = Level::new();
        #[cfg(target_arch = "x86_64")]
        {
            if let (Self::Avx512, Some(simd)) = (self, level.as_avx512()) {
                return simd.vectorize(
                    #[inline(always)]
                    || task.run(simd),
                );
            }
            if let (Self::Avx2 | Self::Avx512, Some(simd)) = (self, level.as_avx2()) {
                return simd.vectorize(
                    #[inline(always)]
                    || task.run(simd),
                );
            }
            let Some(simd) = level.as_sse2() else { unreachable!("every x86-64 machine has SSE2") };
            simd.vectorize(
                #[inline(always)]
                || task.run(simd),
            )
        }
        #[cfg(target_arch = "aarch64")]
        {
            let Some(simd) = level.as_neon() else { unreachable!("every 64-bit ARM has NEON") };
            simd.vectorize(
                #[inline(always)]
                || task.run(simd),
            )
        }
        #[cfg(not(any(target_arch = "x86_64", target_arch = "aarch64")))]
        {
            let _ = level;
            task.run(fearless_simd::Fallback::new())
        }
    }
}

/// Runs plain loops compiled for [`InstructionSet::chosen`], but for no more than 256 bits: of loops over arrays the compiler
/// makes 512-bit code that was measured two times slower than its 256-bit code.
///
/// The closure must be marked `#[inline(always)]`, and so must every function of a loop in it that is worth vectors.
#[inline]
pub fn vectorize<R>(loops: impl FnOnce() -> R) -> R {
    struct Loops<F>(F);
    impl<R, F: FnOnce() -> R> Task for Loops<F> {
        type Output = R;
        #[inline(always)]
        fn run<S: Simd>(self, _: S) -> R {
            (self.0)()
        }
    }
    InstructionSet::chosen().min(InstructionSet::Avx2).run(Loops(loops))
}

impl fmt::Display for InstructionSet {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

impl FromStr for InstructionSet {
    type Err = Unavailable;

    fn from_str(name: &str) -> Result<Self, Unavailable> {
        let available = Self::available();
        available.iter().copied().find(|set| set.name() == name).ok_or_else(|| Unavailable {
            expected: available.iter().map(|set| set.name()).collect::<Vec<_>>().join(", "),
            got: name.to_string(),
        })
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use fearless_simd::prelude::*;

    /// Returns the level that runs it, and a fused product whose last bit tells rounding once from rounding twice.
    struct Probe;

    impl Task for Probe {
        type Output = (usize, f32);
        #[inline(always)]
        fn run<S: Simd>(self, simd: S) -> (usize, f32) {
            let x = S::f32s::splat(simd, 1.0 + f32::EPSILON);
            (S::f32s::LEN, x.mul_add_precise(x, S::f32s::splat(simd, -1.0)).as_slice()[0])
        }
    }

    #[test]
    fn every_instruction_set_runs_with_its_own_width_and_rounds_once() {
        let mut last = 0;
        for set in InstructionSet::available() {
            let (width, fused) = set.run(Probe);
            assert!(width > last, "{set}: {width} numbers after {last}");
            last = width;
            assert_eq!(fused, (1.0 + f32::EPSILON).mul_add(1.0 + f32::EPSILON, -1.0), "{set}");
            assert_eq!(set.name().parse::<InstructionSet>().unwrap(), set);
        }
    }

    #[test]
    fn what_the_machine_has_not_is_refused_by_name() {
        let refused = "altivec".parse::<InstructionSet>().unwrap_err().to_string();
        assert!(
            refused.starts_with("LIFELIKE_SIMD: this machine has ") && refused.ends_with("got 'altivec'"),
            "{refused}"
        );
    }
}
