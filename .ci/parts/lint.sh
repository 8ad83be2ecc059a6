#!/usr/bin/env bash
# Clippy, and rustdoc's own lints: broken links are errors.
. "$(dirname "$0")/../common.sh"
cargo clippy --version >/dev/null 2>&1 || rustup component add clippy

step "lints"
cargo clippy --locked --release --workspace --all-targets -- -D warnings

# Pages of modules name their private parts: they are read in the source, too.
step "documentation of the API"
RUSTDOCFLAGS="-D warnings -A rustdoc::private_intra_doc_links" cargo doc --locked --release --workspace --no-deps
