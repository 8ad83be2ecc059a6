//! Timing of the examples.

use std::time::Instant;

use lifelike_checkpoint::rng;
use lifelike_nn::init;

/// Random numbers.
pub fn random(count: usize) -> Vec<f32> {
    init::normal(&mut rng::stream(1, "bench", 0, 0), count, 1.0)
}

/// Does the job once and then `runs` times more; prints median and best of those. `--only TEXT` leaves out what has another name.
pub fn time(name: &str, runs: usize, mut job: impl FnMut()) {
    if std::env::args().skip_while(|a| a != "--only").nth(1).is_some_and(|only| !name.contains(&only)) {
        return;
    }
    job();
    let mut times: Vec<f64> = (0..runs)
        .map(|_| {
            let start = Instant::now();
            job();
            start.elapsed().as_secs_f64() * 1e3
        })
        .collect();
    times.sort_by(f64::total_cmp);
    println!("{name}: median {:.2} ms, best {:.2} ms", times[times.len() / 2], times[0]);
}
