//! MuJoCo 3.17.0 (Apache-2.0, Google DeepMind), the library behind the engine `mujoco`: from its own Python wheel.

use std::fs;
use std::path::{Path, PathBuf};

use crate::at;
use crate::wheel::{Wheel, digest, unpack, verify};

/// Its name.
pub const NAME: &str = "mujoco";

/// Facts about one platform.
struct Platform {
    wheel: Wheel,
    /// The library's name in the wheel.
    library: &'static str,
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
            sha256: "23496b023ee80fb61ab71167e94bc649f9941710fde96b18bb8204fb332523ad",
        }),
        ("linux", "aarch64") => Ok(Platform {
            wheel: Wheel {
                requirement: VERSION,
                selection: &const { selection("manylinux_2_28_aarch64") },
                sha256: "91a70ed9979c383ff1f5c03f25cc2e1280a8254c1a8e558d5dd7f4184f01efc9",
            },
            library: "libmujoco.so.3.17.0",
            sha256: "e2edd0204fb9229f75f332a4fcd1a32345bb9f90651dc0fddfa20ec0670db789",
        }),
        ("macos", "aarch64") => Ok(Platform {
            wheel: Wheel {
                requirement: VERSION,
                selection: &const { selection("macosx_11_0_arm64") },
                sha256: "6c324addca24a24a7b0beff2ec49300e9d4481fd8ccd611514ba7ea8e4a5e870",
            },
            library: "libmujoco.3.17.0.dylib",
            sha256: "454d51fa639100018579716bd68e61285e9b53c9241b029680d82dec95bc8d53",
        }),
        (os, arch) => Err(format!(
            "no digest of MuJoCo is known for {os} on {arch}; get MuJoCo 3.17.0 yourself and let LIFELIKE_MUJOCO name its \
             library"
        )),
    }
}

/// pip's options for the wheel of CPython 3.11, so that the same file comes whichever Python runs pip: only the library
/// in it is of interest, and that is the same for all.
const fn selection(platform: &'static str) -> [&'static str; 8] {
    ["--platform", platform, "--python-version", "3.11", "--implementation", "cp", "--abi", "cp311"]
}

/// Fetches the library into `folder/mujoco/lib`, with headers and licences beside it, where it is not there already.
/// Returns its file.
///
/// # Errors
/// For an unknown platform, and what [`Wheel::download`] and [`unpack`] fail with.
pub fn ensure(folder: &Path) -> Result<PathBuf, String> {
    let (platform, folder) = (platform()?, folder.join(NAME));
    let library = folder.join("lib").join(platform.library);
    if fs::read(&library).is_ok_and(|bytes| digest(&bytes) == platform.sha256) {
        eprintln!("{} is there already", library.display());
        return Ok(library);
    }
    let wheel = platform.wheel.download()?;
    let count = unpack(&wheel, &folder, |name| {
        let inside = name.strip_prefix("mujoco/");
        let header =
            inside.filter(|n| n.starts_with("include/mujoco/mj") || *n == "include/mujoco/mujoco.h").map(PathBuf::from);
        let library = inside.filter(|n| *n == platform.library).map(|n| Path::new("lib").join(n));
        let licence = name.contains(".dist-info/licenses/").then(|| name.rsplit('/').next()).flatten();
        header.or(library).or(licence.map(|n| Path::new("licences").join(n)))
    })?;
    verify(platform.library, &fs::read(&library).map_err(at(&library))?, platform.sha256)?;
    eprintln!("{count} files are in {}", folder.display());
    Ok(library)
}
