//! MuJoCo's shared library: found, opened once per process, its version checked.

use std::ffi::{CStr, c_char, c_int, c_void};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use super::ENGINE;
use super::fields::{LOG_ERROR, LOG_WARNING, LOGMESSAGE_LEVEL, LOGMESSAGE_SUBJECT, VERSION_HEADER};
use crate::error::SimError;

/// Environment variable that names the library, or a folder with it.
pub const VARIABLE: &str = "LIFELIKE_MUJOCO";

/// The version whose structs are known.
pub const VERSION: &str = "3.17.0";

/// Names of the library's file.
const NAMES: &[&str] = if cfg!(windows) {
    &["mujoco.dll"]
} else if cfg!(target_os = "macos") {
    &["libmujoco.3.17.0.dylib", "libmujoco.dylib"]
} else {
    &["libmujoco.so.3.17.0", "libmujoco.so"]
};

/// Folder of the library in a checkout.
const CHECKOUT: &str = "third_party/mujoco/lib";

type Pointer = *mut c_void;
type Constant = *const c_void;
type Text = *const c_char;
type LogHandler = Option<unsafe extern "C" fn(*const u8)>;

macro_rules! functions {
    ($($name:ident($($argument:ty),*) $(-> $output:ty)?;)+) => {
        /// The functions of an open library, by MuJoCo's names.
        #[allow(non_snake_case)]
        #[derive(Debug)]
        pub struct Library {
            $(pub(super) $name: unsafe extern "C" fn($($argument),*) $(-> $output)?,)+
            /// Keeps them in memory.
            _library: libloading::Library,
        }

        impl Library {
            fn of(library: libloading::Library) -> Result<Self, libloading::Error> {
                Ok(Self {
                    // SAFETY: these are the declarations of the header of this version, which is checked before any use.
                    $($name: unsafe { *library.get(concat!(stringify!($name), "\0").as_bytes())? },)+
                    _library: library,
                })
            }
        }
    };
}

functions! {
    mju_setLogHandler(LogHandler) -> LogHandler;
    mj_parseXMLString(Text, Constant, *mut c_char, c_int) -> Pointer;
    mj_deleteSpec(Pointer);
    mj_compile(Pointer, Constant) -> Pointer;
    mjs_getError(Pointer) -> Text;
    mjs_findBody(Constant, Text) -> Pointer;
    mjs_findElement(Constant, c_int, Text) -> Pointer;
    mjs_asJoint(Pointer) -> Pointer;
    mjs_addGeom(Pointer, Constant) -> Pointer;
    mjs_addHField(Pointer) -> Pointer;
    mjs_setName(Pointer, Text) -> c_int;
    mjs_setString(Pointer, Text);
    mjs_setFloat(Pointer, *const f32, c_int);
    mj_copyModel(Pointer, Constant) -> Pointer;
    mj_deleteModel(Pointer);
    mj_id2name(Constant, c_int, c_int) -> Text;
    mj_isSparse(Constant) -> c_int;
    mj_makeData(Constant) -> Pointer;
    mj_deleteData(Pointer);
    mj_resetData(Constant, Pointer);
    mj_setConst(Pointer, Pointer);
    mj_step(Constant, Pointer);
    mj_forward(Constant, Pointer);
    mj_kinematics(Constant, Pointer);
    mj_comPos(Constant, Pointer);
    mj_subtreeVel(Constant, Pointer);
    mj_rnePostConstraint(Constant, Pointer);
    mj_contactForce(Constant, Constant, c_int, *mut f64);
    mj_jac(Constant, Constant, *mut f64, *mut f64, *const f64, c_int);
    mj_fullM(Constant, Constant, *mut f64);
}

/// Returns the library. The first call of a process finds and opens it.
///
/// # Errors
/// [`SimError::EngineUnavailable`] where it is missing, does not open or has another version.
pub fn library() -> Result<&'static Library, SimError> {
    static OPENED: OnceLock<Result<Library, String>> = OnceLock::new();
    let opened = OPENED.get_or_init(|| find().and_then(|path| open(&path)));
    opened.as_ref().map_err(|hint| SimError::EngineUnavailable { name: ENGINE, hint: hint.clone() })
}

/// Returns the library's file: what `LIFELIKE_MUJOCO` names, else in the user's data folder, else in the checkout around the
/// program. The working folder is not looked at: a library is code.
///
/// # Errors
/// A message that says where it was expected and which command fetches it.
pub fn find() -> Result<PathBuf, String> {
    let fetched = lifelike_robot::load::data_folder().join("mujoco/lib");
    let missing = |folder: &Path| format!("expected {} in {}; {}", NAMES[0], folder.display(), remedy());
    if let Some(named) = named() {
        return if named.is_file() { Ok(named) } else { inside(&named).ok_or_else(|| missing(&named)) };
    }
    let program = std::env::current_exe().ok();
    let checkouts = program.iter().flat_map(|program| program.ancestors()).map(|folder| folder.join(CHECKOUT));
    let mut folders = [fetched.clone()].into_iter().chain(checkouts);
    folders.find_map(|folder| inside(&folder)).ok_or_else(|| missing(&fetched))
}

fn inside(folder: &Path) -> Option<PathBuf> {
    NAMES.iter().map(|name| folder.join(name)).find(|path| path.is_file())
}

/// The path that the variable names.
fn named() -> Option<PathBuf> {
    std::env::var_os(VARIABLE).filter(|value| !value.is_empty()).map(PathBuf::from)
}

/// Command that gets the library.
fn remedy() -> String {
    let first = named().map_or_else(String::new, |_| format!("correct or unset {VARIABLE}, then "));
    format!("{first}run once: lifelike fetch mujoco")
}

fn open(path: &Path) -> Result<Library, String> {
    let fail = |got: String| format!("expected MuJoCo {VERSION} in {}, got {got}; {}", path.display(), remedy());
    // SAFETY: MuJoCo's library may be loaded by any thread at any time.
    let library = unsafe { libloading::Library::new(path) }.map_err(|e| fail(e.to_string()))?;
    let (number, text) = version(&library).map_err(|e| fail(e.to_string()))?;
    if number != VERSION_HEADER || text != VERSION {
        return Err(fail(format!("{text} ({number})")));
    }
    let library = Library::of(library).map_err(|e| fail(e.to_string()))?;
    // SAFETY: nothing else of this library is in use yet. A handler that is there already belongs to another user of
    // the same library in this process, and stays.
    unsafe {
        let before = (library.mju_setLogHandler)(Some(handle));
        if before.is_some() {
            (library.mju_setLogHandler)(before);
        }
    }
    Ok(library)
}

/// The version as a number and as text, which every version of MuJoCo has.
fn version(library: &libloading::Library) -> Result<(c_int, String), libloading::Error> {
    // SAFETY: both functions are constant and without arguments; the text has a terminating zero.
    unsafe {
        let number = library.get::<unsafe extern "C" fn() -> c_int>(b"mj_version\0")?;
        let text = library.get::<unsafe extern "C" fn() -> Text>(b"mj_versionString\0")?;
        Ok((number(), CStr::from_ptr(text()).to_string_lossy().into_owned()))
    }
}

/// MuJoCo's messages: to standard error, not into a log file in the current folder.
///
/// # Safety
/// For MuJoCo only, with a message of its own.
unsafe extern "C" fn handle(message: *const u8) {
    // SAFETY: MuJoCo's message is whole for the time of the call, and its subject has a terminating zero.
    let (level, subject) = unsafe {
        let level = message.add(LOGMESSAGE_LEVEL).cast::<c_int>().read();
        (level, CStr::from_ptr(message.add(LOGMESSAGE_SUBJECT).cast()).to_string_lossy())
    };
    // Divergence is reported per environment (`BatchState::diverged`); information is not of interest.
    let known = subject.starts_with("Nan, Inf or huge value");
    if level == LOG_ERROR || (level == LOG_WARNING && !known) {
        // A closed standard error is no reason to end in C code.
        let _ = writeln!(std::io::stderr(), "MuJoCo: {subject}");
    }
    if level == LOG_ERROR {
        // MuJoCo cannot go on after an error.
        std::process::exit(1);
    }
}
