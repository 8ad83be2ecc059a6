//! Processes that MPI started (`mpirun -n 4 lifelike train tracker ...`), on one machine or on many.
//!
//! MPI wants to be called from the thread that woke it, and learning happens on several: one thread of its own talks to it.

use std::sync::Mutex;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::thread::JoinHandle;

use mpi::collective::SystemOperation;
use mpi::topology::SimpleCommunicator;
use mpi::traits::{Communicator, CommunicatorCollectives};

use lifelike_checkpoint::FromInput;
use lifelike_train::TrainError;
use lifelike_train::collective::Collective;

enum Request {
    Abort,
    Narrow(Vec<f32>),
    Wide(Vec<f64>),
}

/// A member of MPI's world.
pub struct Mpi {
    size: usize,
    rank: usize,
    /// A request and its answer belong together, so nobody else may ask between them.
    line: Mutex<Option<(Sender<Request>, Receiver<Request>)>>,
    thread: Option<JoinHandle<()>>,
}

impl Mpi {
    /// Wakes MPI. Once in the life of a process.
    ///
    /// # Errors
    /// There is no MPI to wake, or it was awake already.
    pub fn start() -> Result<Self, TrainError> {
        let (ask, asked) = channel();
        let (answer, answers) = channel();
        let (tell, told) = channel();
        let thread = std::thread::Builder::new()
            .name("mpi".into())
            .spawn(move || {
                // Learning has many threads, of which only this one talks to MPI.
                let Some((universe, _)) = mpi::initialize_with_threading(mpi::Threading::Funneled) else { return };
                let world = universe.world();
                if tell.send((world.size() as usize, world.rank() as usize)).is_ok() {
                    serve(&world, &asked, &answer);
                }
            })
            .map_err(|e| TrainError::mismatch("MPI", "a thread of its own", e))?;
        let (size, rank) = told
            .recv()
            .map_err(|_| TrainError::mismatch("MPI", "one that starts", "one that is awake already, or none"))?;
        Ok(Self { size, rank, line: Mutex::new(Some((ask, answers))), thread: Some(thread) })
    }

    /// The answer to a request. Without MPI's thread there is none, and the other processes wait for ever: better to end.
    fn asked(&self, request: Request) -> Request {
        let answer = self.line.lock().ok().and_then(|line| {
            let (ask, answers) = line.as_ref()?;
            ask.send(request).ok()?;
            answers.recv().ok()
        });
        answer.unwrap_or_else(|| {
            tracing::error!("MPI does not answer any more; this process ends");
            std::process::exit(1)
        })
    }
}

/// Every process must put MPI to sleep before it ends.
impl Drop for Mpi {
    fn drop(&mut self) {
        if let Ok(mut line) = self.line.lock() {
            line.take();
        }
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has nothing left to put to sleep.
            let _ = thread.join();
        }
    }
}

/// Answers until nobody asks any more; then MPI is put to sleep by whoever owns it.
fn serve(world: &SimpleCommunicator, asked: &Receiver<Request>, answer: &Sender<Request>) {
    while let Ok(request) = asked.recv() {
        let sum = SystemOperation::sum();
        let done = match request {
            Request::Abort => world.abort(1),
            Request::Narrow(values) => {
                let mut out = vec![0.0; values.len()];
                world.all_reduce_into(&values[..], &mut out[..], sum);
                Request::Narrow(out)
            }
            Request::Wide(values) => {
                let mut out = vec![0.0; values.len()];
                world.all_reduce_into(&values[..], &mut out[..], sum);
                Request::Wide(out)
            }
        };
        if answer.send(done).is_err() {
            return;
        }
    }
}

impl Collective for Mpi {
    fn size(&self) -> usize {
        self.size
    }
    fn rank(&self) -> usize {
        self.rank
    }
    fn abort(&self) {
        self.asked(Request::Abort);
    }
    fn sum(&self, values: &mut [f32]) {
        if let Request::Narrow(sums) = self.asked(Request::Narrow(values.to_vec())) {
            values.copy_from_slice(&sums);
        }
    }
    fn sum_wide(&self, values: &mut [f64]) {
        if let Request::Wide(sums) = self.asked(Request::Wide(values.to_vec())) {
            values.copy_from_slice(&sums);
        }
    }
}
