# Sourced by every part: strict shell, the checkout as working directory, Rust, and words for the log.
# shellcheck shell=bash
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

if ! command -v cargo >/dev/null; then
    curl --proto '=https' --tlsv1.2 -sSf https://sh.rustup.rs | sh -s -- -y --profile minimal --component rustfmt,clippy
    # shellcheck disable=SC1091
    . "$HOME/.cargo/env"
fi
command -v cc >/dev/null || { echo "a C compiler is needed to link: apt install build-essential" >&2; exit 1; }

# The lock file is a part of the change.
export CARGO_NET_GIT_FETCH_WITH_CLI=true
target="${CARGO_TARGET_DIR:-$PWD/target}"

step() { echo; echo "== $* ($(date +%H:%M:%S))"; }

# A check that this machine cannot do. The log says so, and the part goes on.
not_run() { echo "NOT RUN: $*"; }

# Installs Debian packages where that is possible.
debian() {
    [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null || return 1
    apt-get install -y -q "$@" || { apt-get update -q && apt-get install -y -q "$@"; }
}

# A Python environment of the build's own.
python_tools() {
    local tools="$target/ci-tools"
    [ -x "$tools/bin/pip" ] || python3 -m venv "$tools" || { debian python3-venv && python3 -m venv "$tools"; }
    "$tools/bin/pip" install -q "$@" && PATH="$tools/bin:$PATH"
}

# MuJoCo and the robots that gates measure.
mujoco() {
    cargo xtask mujoco
    cargo xtask fetch unitree_g1 --without-meshes
    cargo xtask fetch dm_control
    export LIFELIKE_MUJOCO="$PWD/third_party/mujoco/lib"
}
