#!/usr/bin/env bash
# Formatting of all Rust files.
. "$(dirname "$0")/../common.sh"
step "formatting"
cargo fmt --version >/dev/null 2>&1 || rustup component add rustfmt
cargo fmt --all -- --check
