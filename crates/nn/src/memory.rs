//! Allocator settings that keep freed memory.
//!
//! Memory returned to the system after every layer must be faulted in again for the next one. For networks that costs
//! up to half of the time.

/// Tells the C library to keep freed memory instead of returning it to the system. Call once, first thing in `main`,
/// before other threads run. Returns whether the allocator took the setting; elsewhere than on Linux with glibc there is
/// nothing to set and the answer is `false`. Numerical results do not change.
pub fn tune_allocator() -> bool {
    imp::tune()
}

#[cfg(all(target_os = "linux", target_env = "gnu"))]
mod imp {
    /// glibc doubles a heap's spare room only on request.
    const TOP_PAD: libc::c_int = 64 << 20;

    pub fn tune() -> bool {
        // SAFETY: `mallopt` takes two integers, keeps no pointer and is safe to call at any time under glibc's own lock.
        unsafe {
            libc::mallopt(libc::M_MMAP_MAX, 0) == 1
                && libc::mallopt(libc::M_TRIM_THRESHOLD, libc::c_int::MAX) == 1
                && libc::mallopt(libc::M_TOP_PAD, TOP_PAD) == 1
        }
    }
}

#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
mod imp {
    pub fn tune() -> bool {
        false
    }
}
