//! The C interface: a controller and its robot, a reference, and steps.
//!
//! Every function that can fail returns null or a number below 0, and [`lifelike_error`] has the sentence. No function
//! panics into C. Units are SI and rad; quaternions are `wxyz`. A step allocates nothing from the second on.

use std::cell::RefCell;
use std::ffi::{CStr, CString, c_char};
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;
use std::sync::Arc;

use lifelike_character::{Quat, Vec3};
use lifelike_motion::MotionClip;
use lifelike_robot::{ClipPlayer, Controller, ControllerFile, ControllerState, MeasuredState, ReferenceLibrary, Robot};

thread_local! {
    static ERROR: RefCell<CString> = RefCell::new(CString::default());
}

/// A policy with its robot.
pub struct LifelikeController {
    controller: Arc<Controller>,
    joints: Vec<CString>,
}

/// Motion to follow.
pub struct LifelikeReference {
    library: Arc<ReferenceLibrary>,
}

/// One robot's run of a controller.
pub struct LifelikeRun {
    controller: Arc<Controller>,
    player: ClipPlayer<Arc<ReferenceLibrary>>,
    state: ControllerState,
}

/// A robot as its sensors tell. Null: not measured.
#[repr(C)]
pub struct LifelikeMeasured {
    /// Joint positions (rad), one for each joint.
    pub joint_position: *const f32,
    /// Joint velocities (rad/s), one for each joint.
    pub joint_velocity: *const f32,
    /// Orientation of the root (wxyz).
    pub root_orientation: [f32; 4],
    /// Angular velocity of the root (rad/s, in its own frame, as a gyroscope gives it).
    pub angular_velocity_b: [f32; 3],
    /// Position of the root (m, world), 3 numbers or null.
    pub root_position: *const f32,
    /// Linear velocity of the root (m/s, world), 3 numbers or null.
    pub linear_velocity_w: *const f32,
}

/// Runs what may fail; the sentence of a failure is kept for the thread.
fn guarded<T>(failed: T, work: impl FnOnce() -> Result<T, String>) -> T {
    let result = catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|_| Err("a defect of lifelike: a panic".into()));
    result.unwrap_or_else(|message| {
        let text = CString::new(message.replace('\0', " ")).unwrap_or_default();
        ERROR.with(|error| *error.borrow_mut() = text);
        failed
    })
}

fn text<'a>(pointer: *const c_char, what: &str) -> Result<&'a str, String> {
    if pointer.is_null() {
        return Err(format!("{what}: expected a text, got null"));
    }
    // SAFETY: the caller gives a text that ends with zero and lives for the call.
    unsafe { CStr::from_ptr(pointer) }.to_str().map_err(|error| format!("{what}: expected UTF-8: {error}"))
}

fn object<'a, T>(pointer: *const T, what: &str) -> Result<&'a T, String> {
    // SAFETY: the caller gives what a function here returned and has not freed it.
    unsafe { pointer.as_ref() }.ok_or_else(|| format!("expected a {what}, got null"))
}

fn numbers<'a>(pointer: *const f32, count: usize, what: &str) -> Result<&'a [f32], String> {
    if pointer.is_null() {
        return Err(format!("{what}: expected {count} numbers, got null"));
    }
    // SAFETY: the caller gives as many numbers as the header says.
    Ok(unsafe { std::slice::from_raw_parts(pointer, count) })
}

fn three(pointer: *const f32) -> Option<[f32; 3]> {
    numbers(pointer, 3, "").ok().map(|values| [values[0], values[1], values[2]])
}

/// Returns the sentence of this thread's last failure; valid until the next one.
#[unsafe(no_mangle)]
pub extern "C" fn lifelike_error() -> *const c_char {
    ERROR.with(|error| error.borrow().as_ptr())
}

/// Loads a controller for a robot: a name (lima, humanoid, g1), or an MJCF or URDF file. Null on failure.
///
/// # Safety
/// Both are texts that end with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_controller_load(
    path: *const c_char,
    robot: *const c_char,
) -> *mut LifelikeController {
    guarded(std::ptr::null_mut(), || {
        let (path, robot) = (text(path, "path")?, text(robot, "robot")?);
        let file = ControllerFile::read(Path::new(path)).map_err(|error| error.to_string())?;
        let robot = Robot::load(robot).map_err(|error| error.to_string())?;
        let robot = robot.in_joint_order(&file.header().observation.joints).map_err(|error| error.to_string())?;
        let controller = Controller::new(file, Arc::new(robot)).map_err(|error| error.to_string())?;
        let names = &controller.robot().layout.joints;
        let joints = names.iter().map(|name| CString::new(name.as_str()).unwrap_or_default()).collect();
        Ok(Box::into_raw(Box::new(LifelikeController { controller: Arc::new(controller), joints })))
    })
}

/// Frees a controller. Runs of it go on.
///
/// # Safety
/// `controller` came from `lifelike_controller_load` and was not freed, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_controller_free(controller: *mut LifelikeController) {
    if !controller.is_null() {
        // SAFETY: as above.
        drop(unsafe { Box::from_raw(controller) });
    }
}

/// Returns the number of joints; 0 for null.
///
/// # Safety
/// `controller` is alive, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_joints(controller: *const LifelikeController) -> usize {
    guarded(0, || Ok(object(controller, "controller")?.joints.len()))
}

/// Returns the name of a joint, valid as long as the controller; null where there is no such joint.
///
/// # Safety
/// `controller` is alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_joint_name(controller: *const LifelikeController, joint: usize) -> *const c_char {
    guarded(std::ptr::null(), || {
        let names = &object(controller, "controller")?.joints;
        let missing = || format!("joint: expected a number below {}, got {joint}", names.len());
        names.get(joint).map(|name| name.as_ptr()).ok_or_else(missing)
    })
}

/// Returns the steps per second; below 0 on failure.
///
/// # Safety
/// `controller` is alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_rate(controller: *const LifelikeController) -> f64 {
    guarded(-1.0, || Ok(object(controller, "controller")?.controller.robot().control_hz))
}

/// Writes default pose (rad), stiffness (N m/rad) and damping (N m s/rad) of every joint; null: not wanted. 0, or below on failure.
///
/// # Safety
/// `controller` is alive; each array has one number for each joint.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_gains(
    controller: *const LifelikeController,
    default_pose: *mut f32,
    kp: *mut f32,
    kd: *mut f32,
) -> i32 {
    guarded(-1, || {
        let robot = object(controller, "controller")?.controller.robot();
        let write = |into: *mut f32, of: &dyn Fn(usize) -> f64| {
            for joint in (0..robot.joints()).filter(|_| !into.is_null()) {
                // SAFETY: the caller gives one number for each joint.
                unsafe { into.add(joint).write(of(joint) as f32) };
            }
        };
        write(default_pose, &|joint| robot.default_pose[joint]);
        write(kp, &|joint| robot.actuators.parameters[joint].kp);
        write(kd, &|joint| robot.actuators.parameters[joint].kd);
        Ok(0)
    })
}

/// Loads a clip of the controller's robot. Null on failure.
///
/// # Safety
/// `controller` is alive; `path` is a text that ends with zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_reference_load(
    controller: *const LifelikeController,
    path: *const c_char,
) -> *mut LifelikeReference {
    guarded(std::ptr::null_mut(), || {
        let (controller, path) = (object(controller, "controller")?, text(path, "path")?);
        let robot = controller.controller.robot();
        let clip = lifelike_robot::clips::load_one(Path::new(path), robot).map_err(|error| error.to_string())?;
        reference(controller, &clip)
    })
}

/// Makes a reference of frames: root positions (m, 3 each), root orientations (wxyz, 4 each), joints (rad, one for each
/// joint in the controller's order). Null on failure.
///
/// # Safety
/// `controller` is alive; the arrays have as many numbers as said.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_reference_from_frames(
    controller: *const LifelikeController,
    frames_per_second: f64,
    frames: usize,
    root_position: *const f32,
    root_orientation: *const f32,
    joints: *const f32,
) -> *mut LifelikeReference {
    guarded(std::ptr::null_mut(), || {
        let controller = object(controller, "controller")?;
        let robot = controller.controller.robot();
        let places = numbers(root_position, 3 * frames, "root_position")?.as_chunks::<3>().0;
        let turns = numbers(root_orientation, 4 * frames, "root_orientation")?.as_chunks::<4>().0;
        let mut clip = lifelike_robot::reference::standing_clip(robot, 1.0);
        clip.name = "frames".into();
        clip.fps = frames_per_second;
        clip.contacts = None;
        clip.root_position = places.iter().map(|place| Vec3::from(place.map(f64::from))).collect();
        let turn = |q: &[f32; 4]| {
            let turn = lifelike_character::rotation::from_wxyz(q.map(f64::from));
            turn.ok_or_else(|| format!("root_orientation: expected a quaternion, got {q:?}"))
        };
        clip.root_orientation = turns.iter().map(turn).collect::<Result<Vec<Quat>, String>>()?;
        let joints = numbers(joints, frames * robot.joints(), "joints")?;
        clip.joints = joints.iter().map(|q| f64::from(*q)).collect();
        clip.check().map_err(|error| error.to_string())?;
        reference(controller, &clip)
    })
}

fn reference(controller: &LifelikeController, clip: &MotionClip) -> Result<*mut LifelikeReference, String> {
    let clips = std::slice::from_ref(clip);
    let library =
        ReferenceLibrary::new(controller.controller.robot(), clips, None).map_err(|error| error.to_string())?;
    Ok(Box::into_raw(Box::new(LifelikeReference { library: Arc::new(library) })))
}

/// Returns the frames of a reference at the controller's rate; 0 for null.
///
/// # Safety
/// `reference` is alive, or null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_frames(reference: *const LifelikeReference) -> usize {
    guarded(0, || Ok(object(reference, "reference")?.library.len()))
}

/// Frees a reference. Runs of it go on.
///
/// # Safety
/// `reference` came from a function here and was not freed, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_reference_free(reference: *mut LifelikeReference) {
    if !reference.is_null() {
        // SAFETY: as above.
        drop(unsafe { Box::from_raw(reference) });
    }
}

/// Begins a run at the reference's first frame. Null on failure.
///
/// # Safety
/// Both are alive.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_run_new(
    controller: *const LifelikeController,
    reference: *const LifelikeReference,
) -> *mut LifelikeRun {
    guarded(std::ptr::null_mut(), || {
        let controller = object(controller, "controller")?.controller.clone();
        let library = object(reference, "reference")?.library.clone();
        if library.layout != controller.robot().layout {
            return Err("reference: expected one of the controller's robot, got another's".into());
        }
        let state = ControllerState::new(&controller);
        Ok(Box::into_raw(Box::new(LifelikeRun { controller, player: ClipPlayer::new(library, 0), state })))
    })
}

/// One step: writes a joint target (rad) for each joint, and the reference goes on by a frame. 0, or below on failure.
///
/// # Safety
/// `run` and `measured` are alive; `targets` has room for `count` numbers.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_step(
    run: *mut LifelikeRun,
    measured: *const LifelikeMeasured,
    targets: *mut f32,
    count: usize,
) -> i32 {
    guarded(-1, || {
        // SAFETY: the caller gives a run that is used by no other thread.
        let Some(run) = (unsafe { run.as_mut() }) else { return Err("expected a run, got null".into()) };
        let measured = object(measured, "measured state")?;
        let joints = run.controller.robot().joints();
        if count != joints || targets.is_null() {
            return Err(format!("targets: expected room for {joints} numbers, got {count}"));
        }
        // SAFETY: as the header says.
        let targets = unsafe { std::slice::from_raw_parts_mut(targets, count) };
        let state = MeasuredState {
            joint_position: numbers(measured.joint_position, joints, "joint_position")?,
            joint_velocity: numbers(measured.joint_velocity, joints, "joint_velocity")?,
            root_orientation: measured.root_orientation,
            root_position: three(measured.root_position),
            linear_velocity_w: three(measured.linear_velocity_w),
            ..MeasuredState::default()
        };
        let state = state.with_gyroscope(measured.angular_velocity_b);
        run.controller.step(&mut run.state, &state, &mut run.player, targets).map_err(|error| error.to_string())?;
        match targets.iter().position(|target| !target.is_finite()) {
            None => Ok(0),
            Some(joint) => Err(format!("target of joint {joint}: expected a number, got {}", targets[joint])),
        }
    })
}

/// Frees a run.
///
/// # Safety
/// `run` came from `lifelike_run_new` and was not freed, or is null.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn lifelike_run_free(run: *mut LifelikeRun) {
    if !run.is_null() {
        // SAFETY: as above.
        drop(unsafe { Box::from_raw(run) });
    }
}
