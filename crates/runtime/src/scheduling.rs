//! Real-time scheduling and locked memory, where the system permits them.

use thread_priority::unix::{
    RealtimeThreadSchedulePolicy, ThreadSchedulePolicy, set_thread_priority_and_policy, thread_native_id,
};
use thread_priority::{ThreadPriority, ThreadPriorityValue};

/// Priority of the loop among real-time threads: above most drivers' threads, below the kernel's watchdogs.
const PRIORITY: u8 = 80;

/// Makes the calling thread a real-time one and locks the process in memory. Returns a line for each that was not permitted.
pub fn real_time() -> Vec<String> {
    let mut refused = Vec::new();
    let policy = ThreadSchedulePolicy::Realtime(RealtimeThreadSchedulePolicy::Fifo);
    let priority = ThreadPriorityValue::try_from(PRIORITY).map(ThreadPriority::Crossplatform);
    let set = priority.map_err(|error| error.to_string()).and_then(|priority| {
        set_thread_priority_and_policy(thread_native_id(), priority, policy).map_err(|error| format!("{error:?}"))
    });
    if let Err(error) = set {
        let remedy = "the loop has ordinary priority; allow it: sudo setcap cap_sys_nice,cap_ipc_lock+ep lifelike";
        refused.push(format!("SCHED_FIFO: not permitted ({error}): {remedy}"));
    }
    #[cfg(target_os = "linux")]
    if let Err(error) = rustix::mm::mlockall(rustix::mm::MlockAllFlags::CURRENT) {
        refused.push(format!("mlockall: not permitted ({error}): a page that is swapped out delays a tick; ulimit -l"));
    }
    refused
}
