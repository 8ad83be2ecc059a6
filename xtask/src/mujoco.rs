//! MuJoCo 3.17.0, the library that the feature `mujoco` links: from its own Python wheel, checked.

use std::fs;
use std::path::{Path, PathBuf};

use lifelike_fetch::at;
use lifelike_fetch::wheel::{Wheel, digest, unpack, verify};

use crate::root;

/// Facts about one platform.
struct Platform {
    wheel: Wheel,
    /// The library's name in the wheel.
    library: &'static str,
    /// The name that the linker looks for.
    link: &'static str,
    /// Digest of the library.
    sha256: &'static str,
}

const VERSION: &str = "mujoco==3.17.0";

fn platform() -> Result<Platform, String> {
    match (std::env::consts::OS, std::env::consts::ARCH) {
        ("linux", "x86_64") => Ok(Platform {
            wheel: Wheel {
                requirement: VERSION,
                selection: &const { selection("manylinux_2_28_x86_64") },
                sha256: "d66928d86a2d1b601bbaa4dc11db50214d17d5301bb8afd84721313b67ff0874",
            },
            library: "libmujoco.so.3.17.0",
            link: "libmujoco.so",
            sha256: "23496b023ee80fb61ab71167e94bc649f9941710fde96b18bb8204fb332523ad",
        }),
        ("linux", "aarch64") => Ok(Platform {
            wheel: Wheel {
                requirement: VERSION,
                selection: &const { selection("manylinux_2_28_aarch64") },
                sha256: "91a70ed9979c383ff1f5c03f25cc2e1280a8254c1a8e558d5dd7f4184f01efc9",
            },
            library: "libmujoco.so.3.17.0",
            link: "libmujoco.so",
            sha256: "e2edd0204fb9229f75f332a4fcd1a32345bb9f90651dc0fddfa20ec0670db789",
        }),
        ("macos", "aarch64") => Ok(Platform {
            wheel: Wheel {
                requirement: VERSION,
                selection: &const { selection("macosx_11_0_arm64") },
                sha256: "6c324addca24a24a7b0beff2ec49300e9d4481fd8ccd611514ba7ea8e4a5e870",
            },
            library: "libmujoco.3.17.0.dylib",
            link: "libmujoco.dylib",
            sha256: "454d51fa639100018579716bd68e61285e9b53c9241b029680d82dec95bc8d53",
        }),
        (os, arch) => Err(format!(
            "no digest of MuJoCo is known for {os} on {arch}. Put MuJoCo 3.17.0 into third_party/mujoco/lib yourself and \
             build with `--features mujoco`; everything but the comparison with MuJoCo builds and runs as it is."
        )),
    }
}

/// pip's options for the wheel of CPython 3.11, so that the same file comes whichever Python runs pip: only the library
/// in it is of interest, and that is the same for all.
const fn selection(platform: &'static str) -> [&'static str; 8] {
    ["--platform", platform, "--python-version", "3.11", "--implementation", "cp", "--abi", "cp311"]
}

/// Returns the folder of the library.
pub fn library_folder() -> PathBuf {
    root().join("third_party/mujoco/lib")
}

/// Makes sure that the library lies in `third_party/mujoco/lib` and is the one we know; fetches it where it is not.
/// Returns the folder.
///
/// # Errors
/// For an unknown platform, no pip, no network, a wrong digest, or a folder that cannot be written.
pub fn ensure() -> Result<PathBuf, String> {
    let platform = platform()?;
    let folder = library_folder();
    let library = folder.join(platform.library);
    if !fs::read(&library).is_ok_and(|bytes| digest(&bytes) == platform.sha256) {
        install(&platform)?;
    }
    link(&folder, platform.library, platform.link)?;
    Ok(folder)
}

fn install(platform: &Platform) -> Result<(), String> {
    let folder = root().join("third_party/mujoco");
    let wheel = platform.wheel.download()?;
    unpack(&wheel, &folder, |name| {
        let inside = name.strip_prefix("mujoco/");
        let header = inside.filter(|n| n.starts_with("include/mujoco/") && n.ends_with(".h")).map(PathBuf::from);
        let library = inside.filter(|n| *n == platform.library).map(|n| Path::new("lib").join(n));
        let licence = name.contains(".dist-info/licenses/").then(|| name.rsplit('/').next()).flatten();
        header.or(library).or(licence.map(|n| Path::new("licences").join(n)))
    })?;
    let library = folder.join("lib").join(platform.library);
    verify(platform.library, &fs::read(&library).map_err(at(&library))?, platform.sha256)?;
    eprintln!("MuJoCo 3.17.0 (Apache-2.0, Google DeepMind) is in third_party/mujoco");
    Ok(())
}

/// The name without version that linkers ask for: a link where links exist, else a copy.
fn link(folder: &Path, library: &str, name: &str) -> Result<(), String> {
    let path = folder.join(name);
    if fs::read_link(&path).is_ok_and(|target| target == Path::new(library)) {
        return Ok(());
    }
    if path.symlink_metadata().is_ok() {
        fs::remove_file(&path).map_err(at(&path))?;
    }
    #[cfg(unix)]
    let done = std::os::unix::fs::symlink(library, &path);
    #[cfg(not(unix))]
    let done = fs::copy(folder.join(library), &path).map(|_| ());
    done.map_err(at(&path))
}
