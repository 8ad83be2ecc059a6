#!/usr/bin/env bash
# Every test, oracles included, then the physics' gates with each instruction set of this machine.
. "$(dirname "$0")/../common.sh"

# The engine's gates against MuJoCo and its promises, with the instruction set of LIFELIKE_SIMD.
gates() {
    cargo test --locked --release --workspace --test all -- \
        oracle_contact:: oracle_engine:: oracle_constraint_wrenches:: oracle_closure:: oracle_coupling:: \
        contract_engines:: contract_augmented:: contract_robots::
}

step "MuJoCo, and the robots that gates measure"
mujoco

step "a browser for the tests of pages"
command -v chromium >/dev/null || debian chromium || not_run "no Chromium here, and it may not be installed"

step "tests: the README's second command, oracles included"
log="$(mktemp)"
trap 'rm -f "$log"' EXIT
status=0
cargo xtask test --locked 2>&1 | tee "$log" || status=$?

step "summary"
grep -E '^test result:|^error|FAILED|panicked' "$log" || true
awk '/^test result:/ { passed += $4; failed += $6; ignored += $8 }
     END { printf "total: %d passed, %d failed, %d ignored\n", passed, failed, ignored }' "$log"
[ "$status" -eq 0 ] || exit "$status"

step "other people's robots"
cargo test --locked --release --workspace --test all -- --ignored fetched_robots

# The tests above built the program.
lifelike="$target/release/lifelike"
step "this machine"
"$lifelike" inspect --machine

# The run above was with the best set. `lifelike` refuses a set that the machine has not.
best="$("$lifelike" --json inspect --machine | sed -n 's/.*"instruction_set": "\(.*\)".*/\1/p')"
for set in portable neon avx2 avx512; do
    [ "$set" != "$best" ] || continue
    LIFELIKE_SIMD="$set" "$lifelike" plans >/dev/null 2>&1 || continue
    step "gates with $set"
    LIFELIKE_SIMD="$set" gates
done
