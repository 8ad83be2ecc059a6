#!/usr/bin/env bash
# The queue of long runs behind docs/results: what is still missing in the thesis' tables, in the order in which it is wanted.
# Every run goes on where it was stopped, and one that is done is skipped. Hours to days of one core.
#   thesis/experiments/queue.sh CAPTURES [FOLDER]     CAPTURES has bandai, cmu_amc, cmu_bvh_daz and deepmimic below it
# Run it at the lowest priority, in a session of its own:
#   setsid nice -n 19 thesis/experiments/queue.sh CAPTURES > queue.log 2>&1 &
set -euo pipefail
captures="$(realpath "$1")"
folder="${2:-runs/science}"
here="$(cd "$(dirname "$0")" && pwd)"
mkdir -p "$folder"
cd "$folder"
[ -e experiments ] || ln -s "$here/../../experiments" experiments
lifelike="${LIFELIKE:-lifelike}" tables="${LIFELIKE_THESIS:-lifelike-thesis}"

for robot in humanoid lima; do
    [ -d "data/$robot/keys" ] || "$lifelike" motion retarget "$here/../../motions" --robot "$robot" -o "data/$robot/keys"
    for set in deepmimic cmu_amc cmu_bvh_daz bandai; do
        [ -d "data/$robot/$set" ] || "$lifelike" motion retarget "$captures/$set" --robot "$robot" -o "data/$robot/$set"
    done
done

# train KIND NAME ARGUMENTS...: begins a run, or goes on with it.
train() {
    local kind="$1" run="runs/$2"
    shift 2
    [ ! -e "$run/done" ] || return 0
    if [ -e "$run/plan.toml" ]; then
        "$lifelike" train "$kind" -o "$run" --resume
    else
        "$lifelike" train "$kind" "$@" -o "$run"
    fi
    touch "$run/done"
}

for robot in humanoid lima; do train prior "prior-pca-$robot" --plan "$here/prior-pca-$robot.toml"; done
train tracker M-sum-1 --plan "$here/track-thesis-humanoid.toml"                                # 20 minutes of two cores
train tracker M-mean-1 --plan "$here/track-thesis-humanoid.toml" reward.norm=mean
train prior prior-thesis-humanoid --plan "$here/prior-thesis-humanoid.toml"                    # 10 hours of one core
"$tables" tracking --study "$here/study-humanoid.toml" -o runs/humanoid --only M,L,LM --seeds 1
train prior prior-thesis-lima --plan "$here/prior-thesis-lima.toml"                            # 10 hours of one core
"$tables" tracking --study "$here/study-humanoid.toml" -o runs/humanoid                # days
for set in lima-captures g1-grammar lima-grammar g1-captures; do
    MOCAP="$captures" LIFELIKE="$lifelike" LIFELIKE_THESIS="$tables" "$here/study-generation.sh" "$set" "runs/generation-$set"    # 15 hours each
done
# Thesis chapter 2 in the thesis' form: docs/results/augmentation.md has the command (in a checkout, `--example twin_tables`).
# Thesis chapter 3's long rows: docs/results/spline-transformers.md has the commands and their times.
