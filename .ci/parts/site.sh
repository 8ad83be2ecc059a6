#!/usr/bin/env bash
# The documentation as a site, with the command reference of this build's program.
. "$(dirname "$0")/../common.sh"
step "the documentation as a site"
[ -x "$target/release/lifelike" ] || cargo build --locked --release --package lifelike
cargo xtask docs "$(realpath "$target/release/lifelike")"
