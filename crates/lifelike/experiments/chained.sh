#!/usr/bin/env bash
# Long motion of a list of clips: in a shuffled order, each joined smoothly with those that follow until 1000 frames (20 s at 50 Hz) are reached.
#   chained.sh LIST OUT [lifelike [OPTIONS]]   LIST: a file with the path of a *.motion.safetensors in each line; OPTIONS: as --robot FILE
set -euo pipefail
list=$1 out=$2 lifelike=${3:-lifelike} options=("${@:4}")
mapfile -t clips < <(grep -v '^#' "$list")
# The order is shuffled by a fixed seed, so that the set is the same everywhere.
mapfile -t order < <(seq 0 $((${#clips[@]} - 1)) | shuf --random-source=<(yes 7))
chain=() total=0 made=0
for i in "${order[@]}"; do
    frames=$("$lifelike" --json inspect "${clips[$i]}" | sed -n 's/^  "frames": \([0-9]*\).*/\1/p')
    chain+=("${clips[$i]}") total=$((total + frames))
    if [ "$total" -ge 1000 ]; then
        "$lifelike" -q motion sequence "${chain[@]}" "${options[@]}" --fade 0.3 --name "chain-$made" -o "$out"
        chain=() total=0 made=$((made + 1))
    fi
done
