#!/usr/bin/env bash
# Thesis Tables 5.2 and 5.3: MDM, RobotMDM, best of N, PhysDiff and retrained policies, for several seeds.
#
#   thesis/experiments/study-generation.sh SET OUT        SET: lima-captures | g1-captures | lima-grammar | g1-grammar
#
# Every step has a mark in OUT/done and a log in OUT/log. Started again, it goes on where it was stopped, in the middle of a training
# too. It runs at the lowest priority on one core. Results are JSON: OUT/seed-N/table-5.2.json, OUT/seed-N/table-5.3/*/evaluation.json,
# OUT/seed-N/cotrain/cotrain.json (every round, on validation sentences).
#
# Environment: LIFELIKE (the program), SEEDS ("1 2 3"), CORE (0), MUJOCO (1: Table 5.3 in MuJoCo too, needs a build with it), and for
# captures MOCAP (a folder with cmu_amc, cmu_bvh_daz, deepmimic, bandai; or CLIPS, one of such folders made for the robot) and CAPTIONS (a folder with cmu_clips.tsv, bandai_clips.tsv).
# G1: cargo xtask fetch unitree_g1.
#
# Time of each step on one core that nobody else uses, captures: motion 20 to 40 min once, evaluator 15 min once; for each seed generator
# 50 min, cotrain 1.5 to 2 h (a round: motion 5 min, 2 x 10^7 control steps 5 min, critic 3 to 10 min, alignment 2 min, measured 1 min),
# Table 5.2 60 min, retrained policies 15 min, Table 5.3 30 min (MuJoCo 60 min more). Three seeds: some 15 h. Control steps (70,000 a second)
# and critic (46,000 windows a second for one network) were measured, the rest is an estimate.
set -euo pipefail

set_name=${1:?SET} out=${2:?OUT}
lifelike=${LIFELIKE:-target/release/lifelike} tables=${LIFELIKE_THESIS:-target/release/lifelike-thesis}
seeds=${SEEDS:-1 2 3} core=${CORE:-0} mujoco=${MUJOCO:-0}
robot_name=${set_name%-*} kind=${set_name#*-}
case $robot_name in
  lima) robot=lima policy=assets/lima-path environment=track-long hours=${HOURS:-8} ;;
  g1) robot=third_party/robots/unitree_g1/g1.xml policy=assets/g1-long environment=track-g1-long hours=${HOURS:-1.5} ;;
  *) echo "expected lima-... or g1-..., got '$set_name'" >&2; exit 3 ;;
esac
case $kind in
  captures) entries=70 generator_keys="space.knot_seconds=0.1 batch=24 iterations=${ITERATIONS:-5000}" ;;
  grammar) entries=120 generator_keys="batch=32 iterations=${ITERATIONS:-5000}" ;;
  *) echo "expected ...-captures or ...-grammar, got '$set_name'" >&2; exit 3 ;;
esac
data=$out/data
mkdir -p "$out/done" "$out/log"

# One at a time: what it starts holds the lock too.
exec 9>"$out/lock"
flock -n 9 || { echo "$out: another study runs there" >&2; exit 1; }

# Stopped, it stops what it runs, which saves first.
child=
trap '[ -z "$child" ] || { kill -TERM "$child" 2>/dev/null; wait "$child"; }; exit 130' INT TERM
low() {
  nice -n 19 taskset -c "$core" "$@" &
  child=$!
  wait "$child"
}

# step NAME COMMAND...: once.
step() {
  local name=$1; shift
  [ -e "$out/done/$name" ] && return
  echo "$(date '+%F %T') $name"
  if "$@" >>"$out/log/$name.log" 2>&1; then touch "$out/done/$name"; return; fi
  echo "$name failed; the last lines of $out/log/$name.log:" >&2
  tail -n 5 "$out/log/$name.log" >&2
  exit 1
}

# training FOLDER COMMAND...: begun, or gone on with. A plan is written first of all, so no plan is no run.
training() {
  local folder=$1; shift
  local words=()
  for word in "$@"; do [ "$word" = -- ] && break; words+=("$word"); done
  if [ -e "$folder/plan.toml" ]; then low "$lifelike" "${words[@]}" --resume -o "$folder"; return; fi
  shift $((${#words[@]} + 1))
  low "$lifelike" "${words[@]}" "$@" -o "$folder"
}

captured() {
  local source=()
  for part in cmu_amc cmu_bvh_daz deepmimic bandai; do
    if [ -n "${CLIPS:-}" ]; then source+=("$CLIPS/$part"); continue; fi
    low "$lifelike" motion retarget "${MOCAP:?a folder of captured motion}/$part" --robot "$robot" -o "$out/clips/$part"
    source+=("$out/clips/$part")
  done
  low "$lifelike" dataset captures "${source[@]}" --robot "$robot" --captions "${CAPTIONS:?a folder of captions}/cmu_clips.tsv" \
    --captions "$CAPTIONS/bandai_clips.tsv" --non-commercial -o "$data"
}

if [ "$kind" = captures ]; then step motion captured; else
  step motion low "$lifelike" dataset grammar --robot "$robot" --hours "$hours" -o "$data"
fi
step evaluator training "$out/evaluator" train evaluator -- --plan evaluator "robot=$robot" "dataset=$data" \
  evaluator.iterations="${EVALUATOR:-1500}"
evaluator=$out/evaluator/motion.evaluator.safetensors

# retrained SEED NAME GENERATOR: the policy, after motion of a thousand training sentences by this generator.
retrained() {
  local at=$out/seed-$1 name=$2
  if [ ! -d "$at/motion/$name" ]; then
    low "$tables" generation --robot "$robot" --data "$data" --split train --limit 1000 --repetitions 1 --seed "$1" \
      --generator "$name=$3" --keep "$at/motion.part" -o "$at/motion.part.json"
    mkdir -p "$at/motion"; mv "$at/motion.part/$name" "$at/motion/$name"
  fi
  training "$at/policy-$name" train tracker -- --plan "$environment" "robot=$robot" "init=$policy.controller.safetensors" "seed=$1" \
    "clips=[\"$data/train\", \"$at/motion/$name\"]" mirror=false "budget.steps=${RETRAIN:-5000000}" \
    'network.actor='"$(layers actor)" 'network.critic='"$(layers critic)"
}

# The hidden layers of the policy that is gone on with.
layers() { if [ "$robot_name" = g1 ]; then echo '[256,256,128]'; else echo '[512,256,128]'; fi; }

# played SEED POLICY MOTIONS NAME ENGINE EPISODES: a row of Table 5.3.
played() {
  low "$lifelike" eval --policy "$2" --robot "$robot" --motions "$3" --engine "$5" --protocol thesis --episodes "$6" --seconds 30 --seed "$1" \
    -o "$out/seed-$1/table-5.3/$4-$5"
}

for seed in $seeds; do
  at=$out/seed-$seed
  mkdir -p "$at"
  mdm=$at/generator/motion.generator.safetensors
  # shellcheck disable=SC2086 # the keys are words
  step "$seed-generator" training "$at/generator" train generator -- --plan generator "robot=$robot" "clips=[\"$data\"]" "seed=$seed" \
    $generator_keys
  step "$seed-cotrain" training "$at/cotrain" cotrain -- --plan cotrain "robot=$robot" "generator=$mdm" "dataset=$data" \
    "init=$policy.controller.safetensors" "clips=[\"$data/train\"]" "seed=$seed" "rounds=${ROUNDS:-6}" "prompts=${PROMPTS:-1000}" \
    "critic.keys=[\"environment=$environment\", \"critic.epochs=6\", \"critic.gamma=0.97\", \"critic.window=0.5\", \"rollouts.steps=${STEPS:-20000}\"]"
  aligned=$at/cotrain/best.generator.safetensors
  once=$at/cotrain/round-1/aligned/motion.generator.safetensors
  critic=$at/cotrain/round-${ROUNDS:-6}/critic/motion.critic.safetensors
  step "$seed-table-5.2" low "$tables" generation --robot "$robot" --data "$data" --split test --limit "$entries" \
    --repetitions "${REPETITIONS:-4}" --seed "$seed" --evaluator "$evaluator" --critic "$critic" --policy "$policy.controller.safetensors" \
    --best-of "${BEST_OF:-8}" --generator "MDM=$mdm" --generator "RobotMDM=$aligned" --guided "guided=$mdm@0.005" \
    --guided "RobotMDM one round=$once@0" --projected "PhysDiff=$mdm" --keep "$at/kept" -o "$at/table-5.2.json"
  step "$seed-policy-MDM" retrained "$seed" MDM "$mdm"
  step "$seed-policy-RobotMDM" retrained "$seed" RobotMDM "$aligned"
  for engine in lifelike mujoco; do
    [ "$engine" = mujoco ] && [ "$mujoco" != 1 ] && continue
    episodes=${EPISODES:-2048}
    [ "$engine" = mujoco ] && episodes=$((episodes / 4))
    step "$seed-$engine-dataset" played "$seed" "$policy.controller.safetensors" "$data/test" dataset "$engine" "$episodes"
    for folder in "$at"/kept/*/; do
      row=$(basename "$folder")
      step "$seed-$engine-${row// /-}" played "$seed" "$policy.controller.safetensors" "$folder" "${row// /-}" "$engine" "$episodes"
    done
    for name in MDM RobotMDM; do
      step "$seed-$engine-retrained-$name" played "$seed" "$at/policy-$name/tracker.controller.safetensors" "$at/kept/$name" "retrained-$name" \
        "$engine" "$episodes"
    done
  done
done
echo "$(date '+%F %T') complete: $out"
