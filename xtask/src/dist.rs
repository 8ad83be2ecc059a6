//! `cargo xtask dist`: a stripped program with completions and manual pages, as a tarball and, where dpkg is there, a Debian package.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

use lifelike_fetch::at;

use crate::root;

const COMPLETIONS: [(&str, &str); 3] = [
    ("bash", "share/bash-completion/completions/lifelike"),
    ("zsh", "share/zsh/site-functions/_lifelike"),
    ("fish", "share/fish/vendor_completions.d/lifelike.fish"),
];

/// Builds everything into `target/dist-package`.
///
/// # Errors
/// When the build, git, tar or dpkg-deb fails, or a file cannot be written.
pub fn dist() -> Result<(), String> {
    let commit = text_of(Command::new("git").args(["rev-parse", "--short", "HEAD"]).current_dir(root()))?;
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from);
    let mut cargo = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    cargo.args(["build", "--profile", "dist", "--package", "lifelike"]).env("LIFELIKE_COMMIT", commit.trim());
    run(cargo.current_dir(root()))?;
    let program = target.join("dist/lifelike");
    // Cargo leaves the symbols in packages whose profile is overridden; without the tool they stay, 7 MB of them.
    let _ = Command::new("strip").arg(&program).status();
    let (version, machine) = (env!("CARGO_PKG_VERSION"), std::env::consts::ARCH);
    let name = format!("lifelike-{version}-{}-{machine}", std::env::consts::OS);
    let folder = target.join("dist-package");
    let prefix = folder.join(&name);
    let _ = fs::remove_dir_all(&folder);
    install(&program, &prefix)?;
    let tarball = folder.join(format!("{name}.tar.gz"));
    run(Command::new("tar").arg("czf").arg(&tarball).arg("-C").arg(&folder).arg(&name))?;
    told(&program)?;
    told(&tarball)?;
    if Command::new("dpkg-deb").arg("--version").output().is_ok_and(|o| o.status.success()) {
        told(&debian(&folder, &prefix, version)?)?;
    }
    Ok(())
}

/// Lays out program, licences, completions and manual pages below a prefix such as `/usr`.
fn install(program: &Path, prefix: &Path) -> Result<(), String> {
    let put = |bytes: &[u8], to: &str| {
        let to = prefix.join(to);
        to.parent().map_or(Ok(()), fs::create_dir_all).map_err(at(&to))?;
        fs::write(&to, bytes).map_err(at(&to))
    };
    for (from, to) in [("LICENSE-MIT", "LICENSE-MIT"), ("LICENSE-APACHE", "LICENSE-APACHE"), ("README.md", "README.md")]
    {
        let from = root().join(from);
        put(&fs::read(&from).map_err(at(&from))?, &format!("share/doc/lifelike/{to}"))?;
    }
    let bin = prefix.join("bin");
    fs::create_dir_all(&bin).map_err(at(&bin))?;
    fs::copy(program, bin.join("lifelike")).map_err(at(&bin))?;
    for (shell, to) in COMPLETIONS {
        put(text_of(Command::new(program).args(["completions", shell]))?.as_bytes(), to)?;
    }
    run(Command::new(program).args(["man", "-o"]).arg(prefix.join("share/man/man1")))
}

/// Makes a Debian package of what is below `prefix`.
fn debian(folder: &Path, prefix: &Path, version: &str) -> Result<PathBuf, String> {
    let architecture = text_of(Command::new("dpkg").arg("--print-architecture"))?;
    let (tree, usr) = (folder.join("deb"), folder.join("deb/usr"));
    let control = tree.join("DEBIAN/control");
    fs::create_dir_all(tree.join("DEBIAN")).map_err(at(&tree))?;
    run(Command::new("cp").arg("-r").arg(prefix).arg(&usr))?;
    let text = format!(
        "Package: lifelike\nVersion: {version}\nArchitecture: {}\nMaintainer: the lifelike developers <noreply@lifelike.invalid>\n\
         Depends: libc6, libgcc-s1\nSection: science\nPriority: optional\n\
         Description: lifelike motion for robots and physics-based characters\n \
         Retargets human motion to any robot, learns policies that follow it in physics,\n \
         makes motion from sentences, and measures all of it.\n",
        architecture.trim()
    );
    fs::write(&control, text).map_err(at(&control))?;
    let package = folder.join(format!("lifelike_{version}_{}.deb", architecture.trim()));
    run(Command::new("dpkg-deb").args(["--root-owner-group", "--build"]).arg(&tree).arg(&package))?;
    Ok(package)
}

fn run(command: &mut Command) -> Result<(), String> {
    let status = command.status().map_err(|e| format!("{command:?}: {e}"))?;
    if status.success() { Ok(()) } else { Err(format!("{command:?} failed ({status})")) }
}

fn text_of(command: &mut Command) -> Result<String, String> {
    let output = command.output().map_err(|e| format!("{command:?}: {e}"))?;
    if !output.status.success() {
        return Err(format!("{command:?} failed: {}", String::from_utf8_lossy(&output.stderr)));
    }
    String::from_utf8(output.stdout).map_err(|e| format!("{command:?}: {e}"))
}

/// Prints a file with its size.
fn told(file: &Path) -> Result<(), String> {
    let bytes = fs::metadata(file).map_err(at(file))?.len();
    println!("{:>6.1} MB  {}", bytes as f64 / 1e6, file.display());
    Ok(())
}
