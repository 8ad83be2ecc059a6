#!/usr/bin/env bash
# Packages as crates.io would have them: nothing outside of a package is needed to build it.
. "$(dirname "$0")/../common.sh"
step "packages: nothing outside of a package is needed to build it"
cargo package --locked --workspace --exclude xtask --exclude lifelike-thesis --no-verify --allow-dirty --quiet \
    --target-dir target
unpacked="$PWD/target/unpacked"
rm -rf "$unpacked" && mkdir -p "$unpacked"
for package in target/package/*.crate; do tar xzf "$package" -C "$unpacked"; done
{
    printf '[workspace]\nresolver = "3"\nmembers = ["*"]\n[patch.crates-io]\n'
    for folder in "$unpacked"/*/; do
        name="$(basename "$folder")"
        printf '%s = { path = "%s" }\n' "${name%-*}" "$name"
    done
} >"$unpacked/Cargo.toml"
cp Cargo.lock "$unpacked/"
# Not --locked: the workspace has fewer members than the lock file.
cargo check --release --workspace --target-dir target --manifest-path "$unpacked/Cargo.toml"
