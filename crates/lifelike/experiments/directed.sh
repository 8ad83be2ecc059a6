#!/usr/bin/env bash
# Motion made from a robot's clips by the direction tools: a faster pace, larger movements, sequences with smooth and with abrupt
# switches, arms of one clip on the legs of another.
#   directed.sh LIST OUT [lifelike]         LIST: a file with the path of a *.motion.safetensors in each line
set -euo pipefail
list=$1 out=$2 lifelike=${3:-lifelike}
mapfile -t clips < <(grep -v '^#' "$list")
n=${#clips[@]}
"$lifelike" -q motion warp "${clips[@]}" --speed 1.2 -o "$out/fast"
"$lifelike" -q motion stylize "${clips[@]}" --gain 1.2 -o "$out/large"
# The order is shuffled by a fixed seed, so that the set is the same everywhere.
mapfile -t order < <(seq 0 $((n - 1)) | shuf --random-source=<(yes 7))
for i in $(seq 0 $((n - 2))); do
    a=${clips[${order[$i]}]} b=${clips[${order[$((i + 1))]}]}
    case $((i % 3)) in
        0) "$lifelike" -q motion sequence "$a" "$b" --fade 0.3 --name "smooth-$i" -o "$out/smooth" ;;
        1) "$lifelike" -q motion sequence "$a" "$b" --fade 0.06 --name "abrupt-$i" -o "$out/abrupt" ;;
        2) "$lifelike" -q motion compose "$a" "$b" --joints arms --name "arms-$i" -o "$out/arms" ;;
    esac
done
