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
# Files are written in tests, and few random cases are enough at this speed.
MIRIFLAGS="-Zmiri-disable-isolation" PROPTEST_CASES=2 LIFELIKE_SIMD=portable cargo "+$nightly" miri test --locked \
    --package lifelike-dense --package lifelike-checkpoint --lib --target-dir "$target/miri"
