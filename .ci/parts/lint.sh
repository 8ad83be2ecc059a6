#!/usr/bin/env bash
# Clippy with and without MuJoCo, and rustdoc's own lints: broken links are errors.
. "$(dirname "$0")/../common.sh"
cargo clippy --version >/dev/null 2>&1 || rustup component add clippy

step "lints with MuJoCo"
mujoco
cargo clippy --locked --release --workspace --all-targets --features lifelike/mujoco -- -D warnings

step "lints without MuJoCo"
cargo clippy --locked --release --workspace --all-targets -- -D warnings

step "documentation of the API"
RUSTDOCFLAGS="-D warnings" cargo doc --locked --release --workspace --no-deps
