#!/usr/bin/env bash
# One training by several processes (MPI).
. "$(dirname "$0")/../common.sh"
step "several processes"
packages=(libopenmpi-dev openmpi-bin libclang-dev)
if command -v mpicc >/dev/null || debian "${packages[@]}"; then
    cargo test --locked --release --workspace --features lifelike/mpi --test processes
else
    not_run "no MPI here, and it may not be installed (Debian: ${packages[*]})"
fi
