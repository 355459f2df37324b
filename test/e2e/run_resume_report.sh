#!/usr/bin/env bash
# A run that goes on from a checkpoint reports what the unbroken run reports, step by step, in every column but the times: pairs,
# searches and patches too, though trees and patches are made anew. A fast sheet falls on a ball that stands
# still and has most of the vertices: what is fitted once must not count later, as for whether paths are long; runs of each method, cut at several steps where trees are kept.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >fast.yaml <<'END_OF_SCENE'
title: fast
time: {step: 0.01 s, frames: 10}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.6, 0.6], resolution: [19, 19]}
    translate: [0.02, 0.01, 0.28]
    velocity: [0, 0, -1.5]
obstacles:
  - name: ball
    mesh: {shape: sphere, radius: 0.2, resolution: [48]}
END_OF_SCENE
# largest DIR COLUMN: of the column, over all steps.
largest() {
    awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) column = i }
        NR > 1 && $column > most { most = $column } END { print most + 0 }' "$1/report.csv"
}
# run DIR OPTION...
run() {
    local directory=$1
    shift
    "$TULLE" run fast.yaml -o "$directory" --progress none --checkpoint-every 1 "$@" >"$directory.out" 2>"$directory.err" ||
        fault "$directory: exit $?: $(cat "$directory.err")"
}
reduce() { awk -f "$TULLE_SOURCE_DIR/test/e2e/without_times.awk" "$1/report.csv"; }

for method in patches refit bvox paper; do
    run $method --set contact.method=$method --threads 1
    reduce $method >$method.csv
    [ "$(wc -l <$method.csv)" = 11 ] || fault "$method: $(wc -l <$method.csv) lines of report"
    [ "$(largest $method contacts)" -gt 100 ] || fault "$method: the sheet does not land"
    [ "$(largest $method box_pairs)" -gt 1000 ] || fault "$method: no pairs"
    cuts=(1 3 6)
    case $method in bvox | paper) cuts=(6) ;; esac
    for cut in "${cuts[@]}"; do
        run cut --set contact.method=$method --frames $cut --threads 2
        run cut --set contact.method=$method --frames 10 --threads 1 --resume
        reduce cut >cut.csv
        if ! cmp -s $method.csv cut.csv; then
            fault "$method: resumed after frame $cut it reports otherwise"
            diff $method.csv cut.csv | head -n 6
        fi
        [ "$(tail -n 1 cut.out)" = "$(tail -n 1 $method.out)" ] || fault "$method: another end after frame $cut"
        rm -rf cut
    done
done
[ "$(largest patches patch_triangles)" -gt 500 ] || fault "no patches are in use"
[ "$(head -n 1 patches.csv | tr , '\n' | grep -c seconds)" = 0 ] || fault "times are compared"
[ "$(head -n 1 patches.csv | tr , '\n' | wc -l)" -gt 25 ] || fault "too few columns are compared"
exit $faults
