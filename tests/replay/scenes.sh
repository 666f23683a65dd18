#!/bin/sh
# Simulated scans of every scene, as they are and smoothed: golden digests, the same with 1, 2, 3 and 8
# threads.
set -eu
B=${B:-build}
run=$(mktemp -d)
trap 'rm -rf "$run"' EXIT

for golden in scenes smooth; do
  option=$([ $golden = scenes ] || echo --smooth)
  while read -r want scene; do
    "$B/bin/dexel" sim "$scene" -o "$run/scan.pcd" --size 300x200 --noise 0.005 --dropouts 0.02 \
      --mixed 0.5 --seed 7
    for threads in 1 2 3 8; do
      # shellcheck disable=SC2086 # a word or none
      got=$("$B/bin/dexel" mesh "$run/scan.pcd" --threads $threads $option --stats |
        sed -n 's/.*"digest": "\([0-9a-f]*\)".*/\1/p')
      [ "$got" = "$want" ] || { echo "$golden: $scene, $threads threads: digest $got, expected $want"; exit 1; }
    done
  done <tests/replay/$golden.golden
done
