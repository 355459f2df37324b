#!/usr/bin/env bash
# tulle detect on meshes that are not part of this repository: every method finds the collisions of the cloth funnel, of the
# ramp that passes through itself between two clean states, and of the C-ring. Skips without TULLE_DATA_DIR.
set -uo pipefail
command -v python3 >/dev/null || { echo "skipped: python3 is not installed"; exit 77; }
data=${TULLE_DATA_DIR:-}
[ -d "$data/cloth-funnel/frames" ] && [ -d "$data/synthetic" ] ||
    { echo "skipped: TULLE_DATA_DIR names no folder with cloth-funnel and synthetic"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
compare=$TULLE_SOURCE_DIR/test/e2e/detect_compare.py
faults=0
fault() { echo "fault: $*"; faults=1; }

job_count=0
note() { local IFS=$'\t'; echo "$*" >>jobs; }
# find_events START END OPTIONS...: the JSON document is in the file $kept.
find_events() {
    kept=$((job_count++)).json
    "$TULLE" detect "$@" --json --list >$kept 2>err || { fault "detect $*: exit $?"; cat err; }
}
find_by_all() {
    local start=$1 end=$2 refit
    find_events "$start" "$end" --method refit
    refit=$kept
    sed -n 's/^"events"://p' $refit
    for options in "--method patches" "--method patches --alpha-max 89deg --cone paper" "--method bvox" "--method paper" \
        "--method paper --alpha-max 85" "--method patches --repeat 2"; do
        find_events "$start" "$end" $options
        note values $kept "events.hit=>0"
        note within $kept $refit
    done
}

funnel=$data/cloth-funnel/frames
find_by_all "$funnel"/227.ply "$funnel"/228.ply
# Cloth as crumpled as this is where patches that are kept do not pay and may be switched off; the paper's never are.
find_events "$funnel"/227.ply "$funnel"/228.ply --method paper
note values $kept events.crossing_at_start=309 patches.used=true "patches.certified_share=>0.5" "events.without_patches=>0"
for name in ramp cring; do
    start=$data/synthetic/${name}_t0.obj end=$data/synthetic/${name}_t1.obj
    find_by_all "$start" "$end"
    note values $kept events.crossing_at_start=0
    # Cones alone take the whole surface for one that cannot touch itself.
    for method in patches paper; do
        find_events "$start" "$end" --method $method --certificate off --alpha-max 89
        note values $kept patches.used=true patches.certified_share=0 events.all=0 "events.without_patches=>0"
    done
done
python3 "$TULLE_SOURCE_DIR"/test/e2e/detect_compare.py jobs || faults=1
exit $faults
