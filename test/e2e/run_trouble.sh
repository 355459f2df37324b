#!/usr/bin/env bash
# The end of a run says in words what did not go well, or that nothing was wrong: on the terminal, in run.json, by `tulle info`, and
# the same after a run that was resumed.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >hung.yaml <<'END'
title: hung
time: {step: 0.01 s, frames: 20}
cloth:
  - name: flag
    mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [9, 9]}
    pins: [{vertices: [0, 8]}]
END
run() { "$TULLE" run hung.yaml --progress none "$@" >stdout 2>stderr || fault "$*: exit $?: $(cat stderr)"; }
# value DIR KEY: of "outcome" in run.json.
value() { python3 -c 'import json,sys; print(json.load(open(sys.argv[1] + "/run.json"))["outcome"][sys.argv[2]])' "$1" "$2"; }
# column DIR NAME: of all steps, a line each.
column() { awk -F, -v name="$2" 'NR == 1 { for (i = 1; i <= NF; i++) if ($i == name) k = i } NR > 1 { print $k }' "$1/report.csv"; }

run -o well
grep -q '^trouble: none: every solve converged, no step was cut, nothing was rescued or pinched; cloth was stretched by at most .* %' stdout ||
    fault "a healthy run: $(cat stdout)"
[ "$(grep -c '^trouble: ' stdout)" = 1 ] || fault "more than a line: $(cat stdout)"
"$TULLE" info well | grep -q '^  trouble  *none: every solve converged' || fault "info of a healthy run"
[ "$(value well unconverged_steps)" = 0 ] || fault "run.json of a healthy run"

bad=(--set cloth[0].material.stretch=3 --set cloth[0].material.shear.stiffness=1 --set solver.cg_iterations=1)
run -o bad "${bad[@]}"
grep -q '^trouble: a solve did not converge in [1-9][0-9]* of 20 steps; the largest residual was [0-9.e-]* at [0-9.]* s$' stdout ||
    fault "solves: $(cat stdout)"
grep -Eq "^trouble: cloth was stretched by [0-9.]+ % at [0-9.]+ s, between vertices [0-9]+ and [0-9]+ of 'flag', at \([^,]*, [^,]*, [^,]*\)$" stdout ||
    fault "stretch: $(cat stdout)"
grep '^trouble: ' stdout | sed 's/^trouble: //' >told
"$TULLE" info bad | sed -n '/^  trouble/,/^  detection/p' | sed 's/^  trouble */ /; s/^ *//; /^detection/d' >info
diff told info || fault "info tells it otherwise"
value bad trouble | diff told - || fault "run.json tells it otherwise"
[ "$(value bad steps)" = 20 ] || fault "steps: $(value bad steps)"
[ "$(column bad cg_converged | grep -c '^0$')" = "$(value bad unconverged_steps)" ] || fault "steps that did not converge"
awk -v most="$(column bad max_stretch | sort -g | tail -1)" -v told="$(value bad largest_stretch)" \
    'BEGIN { exit !(told == most && told > 1.15) }' || fault "stretch: $(value bad largest_stretch)"

# The same after a pause; where run.json has lost it, it is counted anew, but for the place.
run -o cut "${bad[@]}" --frames 12
run -o cut "${bad[@]}" --frames 20 --resume
value cut trouble | diff told - || fault "after a pause"
grep '^trouble: ' stdout | sed 's/^trouble: //' | diff told - || fault "after a pause, on the terminal"
python3 -c 'import json
record = json.load(open("cut/run.json"))
del record["outcome"]
json.dump(record, open("cut/run.json", "w"))'
python3 "$TULLE_SOURCE_DIR/test/e2e/seal.py" cut/run.json
"$TULLE" info cut | grep -q '^  trouble  *a solve did not converge in' || fault "info does not count the steps"
run -o cut "${bad[@]}" --resume
[ "$(value cut unconverged_steps)" = "$(value bad unconverged_steps)" ] || fault "counted anew: $(value cut unconverged_steps)"

[ $faults = 0 ] && echo "trouble: told as it should"
exit $faults
