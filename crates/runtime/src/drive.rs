//! The loop.

use crate::bus::{Bus, Measurement};
use crate::clock::Clock;
use crate::gate::Trip;
use crate::packets::Counts;
use crate::phase::{Phase, Request};
use crate::record::Recorder;
use crate::supervisor::Supervisor;
use crate::timing::{Histogram, Quantiles};

/// Most packets that one tick looks at: a flood does not delay the command.
const MOST_PACKETS: usize = 64;

/// Account of a run.
#[derive(Debug, Clone, serde::Serialize)]
pub struct Summary {
    /// Ticks.
    pub ticks: u64,
    /// Ticks that were left out because one before them took too long.
    pub missed: u64,
    /// Policy steps.
    pub steps: u64,
    /// Packets.
    pub packets: Counts,
    /// Commands that the bus did not take.
    pub unsent: u64,
    /// Ticks that the record lacks.
    pub unrecorded: u64,
    /// Time from a deadline to the wake-up.
    pub latency: Quantiles,
    /// Time between two wake-ups.
    pub period: Quantiles,
    /// Time that a tick took: packets, state machine, gate, bus, record.
    pub tick: Quantiles,
    /// Time that a tick with a policy step took.
    pub step: Quantiles,
    /// Modelled heat of the hottest motor at the end; 1 is its continuous rating.
    pub hottest: f32,
    /// Falls after which the robot tried to get up.
    pub falls: u32,
    /// Reason for which the gate braked.
    pub trip: Option<Trip>,
}

/// Runs a supervisor on a bus until its motion is over, it was stopped, or `ask` returns none. `ask` is called in every tick
/// with the time (ns) and the phase.
///
/// Neither allocates nor locks after the first policy step.
pub fn drive(
    supervisor: &mut Supervisor,
    bus: &mut dyn Bus,
    clock: &mut dyn Clock,
    mut recorder: Option<&mut Recorder>,
    mut ask: impl FnMut(u64, Phase) -> Option<Request>,
) -> Summary {
    let period = (1e9 / supervisor.config().command_hz).round() as u64;
    let mut packet = Measurement::new(supervisor.controller().robot().joints());
    let [mut latency, mut between, mut tick, mut step] = [(); 4].map(|()| Histogram::default());
    let (mut ticks, mut missed, mut unsent, mut last) = (0u64, 0u64, 0u64, None);
    let mut deadline = clock.now().next_multiple_of(period.max(1));
    let mut has_begun = false;
    loop {
        let now = clock.wait_until(deadline);
        let Some(request) = ask(now, supervisor.phase()) else { break };
        for _ in 0..MOST_PACKETS {
            // A broken connection is silence, which the gate judges.
            if !bus.receive(&mut packet).unwrap_or(false) {
                break;
            }
            supervisor.receive(now, &packet);
            if let Some(recorder) = recorder.as_deref_mut() {
                recorder.packet(now, &packet);
            }
        }
        let command = supervisor.tick(now, request);
        if bus.send(command).is_err() {
            unsent += 1;
        }
        if let Some(recorder) = recorder.as_deref_mut() {
            recorder.tick(now, request, supervisor);
        }
        latency.add(now.saturating_sub(deadline));
        if let Some(last) = last.replace(now) {
            between.add(now.saturating_sub(last));
        }
        ticks += 1;
        let end = clock.now();
        let took = end.saturating_sub(now);
        if supervisor.has_stepped() { &mut step } else { &mut tick }.add(took);
        deadline += period;
        while deadline + period <= end {
            (deadline, missed) = (deadline + period, missed + 1);
        }
        let is_idle = supervisor.phase() == Phase::Idle;
        if has_begun && is_idle {
            break;
        }
        has_begun |= !is_idle;
    }
    Summary {
        ticks,
        missed,
        steps: supervisor.steps(),
        packets: supervisor.gate().counts(),
        unsent,
        unrecorded: recorder.map_or(0, |recorder| recorder.dropped()),
        latency: latency.quantiles(),
        period: between.quantiles(),
        tick: tick.quantiles(),
        step: step.quantiles(),
        hottest: supervisor.gate().heat().fold(0.0, f32::max),
        falls: supervisor.falls(),
        trip: supervisor.trip(),
    }
}
