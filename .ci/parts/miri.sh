#!/usr/bin/env bash
# Undefined behaviour in kernels and the checkpoint reader, by Miri.
. "$(dirname "$0")/../common.sh"
step "miri"
nightly="${NIGHTLY:-nightly}"
rustup toolchain install "$nightly" --profile minimal --component miri,rust-src >/dev/null 2>&1 \
    || rustup run "$nightly" cargo miri --version >/dev/null 2>&1 || {
    not_run "no nightly compiler with miri here, and it does not install"
    exit 0
}
# The queues of rayon break the stricter rules of stacked borrows. Few random cases are enough at this speed. One test draws
# texts by a regular expression, whose compilation alone takes minutes here.
export MIRIFLAGS="-Zmiri-disable-isolation -Zmiri-tree-borrows" PROPTEST_CASES=2 LIFELIKE_SIMD=portable
cargo "+$nightly" miri test --locked --package lifelike-dense --package lifelike-checkpoint --lib \
    --target-dir "$target/miri" -- --skip files_are_whole_or_refused
