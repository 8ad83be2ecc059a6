#!/usr/bin/env bash
# The oldest compiler that Cargo.toml promises (`rust-version`).
. "$(dirname "$0")/../common.sh"
msrv="$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml)"
step "rust $msrv"
case "$(rustc --version)" in
    "rustc $msrv."*)
        echo "the compiler of all other parts is $(rustc --version)"
        exit 0
        ;;
esac
rustup toolchain install "$msrv" --profile minimal || { not_run "rust $msrv does not install here"; exit 0; }
cargo "+$msrv" check --locked --release --workspace --target-dir "$target/msrv"
