#!/usr/bin/env bash
# paper/reproduce that is interrupted or killed goes on where it was: what was measured is kept, what was measured under
# other conditions or of another run is not used.
set -uo pipefail
PYTHONPATH=$TULLE_PYTHON sh "$TULLE_SOURCE_DIR/paper/find_python.sh" 'matplotlib, tulle' >/dev/null ||
    { echo "skipped: no python3 with numpy, cffi and matplotlib"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0
fail() { echo "$*"; faults=1; }
begin() { exec sh "$TULLE_SOURCE_DIR/paper/reproduce.sh" --tulle "$TULLE" --measure "$TULLE_PAPER_MEASURE" "$@" --scenes scenes -o out.d; }

# write_scene NAME FRAMES RESOLUTION: a sheet falls on a spike.
write_scene() {
    cat >"scenes/$1.yaml" <<END_OF_SCENE
title: $1
time: {step: 0.02 s, frames: $2}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [$3, $3]}
    translate: [0.02, 0.01, 0.12]
obstacles:
  - name: ground
    mesh: {shape: plane, size: [2, 2]}
  - name: spike
    mesh: {shape: tetrahedron, radius: 0.05, height: 0.11}
    translate: [-0.1, 0, 0.001]
END_OF_SCENE
}
mkdir scenes
for name in rings ribbons animation_1 animation_2 animation_3 animation_4 animation_5 animation_6; do write_scene $name 6 9; done
write_scene example_one 40 25

# make CODE PATTERN ARGUMENTS...: runs it in out.d; exit code, and a line of either output. Where Embree is not there, 2
# stands for 0.
make() {
    local code=$1 pattern=$2
    shift 2
    (begin "$@") >log 2>&1
    local found=$?
    [ "$code" = 0 ] && grep -q 'no stills are made' log && code=2
    [ $found = "$code" ] || { fail "reproduce $*: exit $found, expected $code"; tail -20 log; }
    [ -z "$pattern" ] || grep -Eq -- "$pattern" log || { fail "reproduce $*: no \"$pattern\" in:"; tail -20 log; }
}
# cut_off SIGNAL TEST ARGUMENTS...: begins it, sends the signal once the words of `test` hold; its exit code is in $cut.
cut_off() {
    local signal=$1 condition=$2
    shift 2
    begin "$@" >log 2>&1 &
    local process=$!
    until eval "[ $condition ]" 2>/dev/null || ! kill -0 $process 2>/dev/null; do sleep 0.002; done
    kill -s "$signal" $process 2>/dev/null
    wait $process 2>/dev/null
    cut=$?
    [ "$signal" = KILL ] && sleep 0.5 # what it had started ends with it, soon
    ls -R out.d | grep -q tmp && [ "$signal" = INT ] && fail "an interrupted command leaves temporary files"
    find out.d -name '*tmp*' -delete # a kill may leave one
}
# rows FILE FROM TO: lines of a table.
rows() { sed -n "$2,$3p" "$1"; }

# Killed while a scene runs: the run goes on to the same bytes under the same conditions.
cp scenes/rings.yaml rings.yaml
sed -i 's/frames: 6/frames: 80/; s/\[9, 9\]/[21, 21]/' scenes/rings.yaml
make 0 '' fig9 --size 16x10
mv out.d whole.d
cut_off KILL "-e out.d/runs/rings/report.csv -a -s out.d/made/rings.csv" fig9 --size 16x10
[ $cut = 137 ] || fail "fig9 was not killed: exit $cut"
make 0 '"run":"rings","what":"runs"' fig9 --size 16x10
for file in frames.csv sheet.pc2 scene.yaml; do
    cmp -s "whole.d/runs/rings/$file" "out.d/runs/rings/$file" || fail "a run that was killed: $file differs"
done
[ "$(wc -l <out.d/made/rings.csv)" = 2 ] || { fail "conditions of a run that went on:"; cat out.d/made/rings.csv; }
cmp -s whole.d/judged/rings.csv out.d/judged/rings.csv || fail "verdicts differ"
rm -rf out.d whole.d
cp rings.yaml scenes/rings.yaml

# Fig. 7, interrupted, then killed: no row is measured twice. The last angle's file is there after the first frame.
whole_lines=162 # two of its head, forty frames by four rules
cut_off INT "-e out.d/measured/fig7_89.csv" fig7
[ $cut = 130 ] || fail "fig7 interrupted: exit $cut, expected 130"
lines=$(wc -l <out.d/measured/fig7_89.csv)
[ "$lines" -lt $whole_lines ] || fail "fig7 was not cut off"
[ -e out.d/fig7_angles.csv ] || [ -e out.d/fig7_frames.csv ] && fail "a table of some of the frames"
[ $(($(wc -l <out.d/measured/fig7_30.csv) - lines)) -le 4 ] || fail "angles do not take turns on each frame"
cp -R out.d/measured first
cut_off KILL "\$(wc -l <out.d/measured/fig7_89.csv) -gt $lines" fig7
[ $cut = 137 ] || fail "fig7 was not killed: exit $cut"
[ "$(wc -l <out.d/measured/fig7_89.csv)" -lt $whole_lines ] || fail "fig7 was not cut off again"
cp -R out.d/measured second
make 0 'report' fig7
for kept in first second; do
    for file in $kept/*.csv; do
        lines=$(wc -l <$file)
        rows out.d/measured/${file#*/} 1 "$lines" | cmp -s - $file || fail "$file was measured again"
    done
done
[ "$(wc -l <out.d/measured/fig7_45.csv)" = $whole_lines ] || fail "fig7: not forty frames by four rules"
[ "$(wc -l <out.d/fig7_angles.csv)" = 53 ] && [ "$(wc -l <out.d/fig7_frames.csv)" = 481 ] || fail "fig7: tables are not whole"
# The sums are those of the rows.
awk -F, 'FNR == NR { if ($2 == "proven") sum += $7; next } $1 == "proven" && $2 == 45 { d = $3 - 1000 * sum / 40; exit !(d < 1e-3 && d > -1e-3) }' \
    out.d/measured/fig7_45.csv out.d/fig7_angles.csv || fail "fig7: 45 degrees is not the mean of its frames"
cp -R out.d/measured whole
cp out.d/fig7_angles.csv whole.csv
make 0 '' fig7
diff -r whole out.d/measured >/dev/null && cmp -s whole.csv out.d/fig7_angles.csv || fail "fig7: what is whole was measured again"

# Within an angle too; rows of another build, another run or another number of threads are not used.
rows whole/fig7_45.csv 1 14 >out.d/measured/fig7_45.csv
sed -i '1s/build [0-9a-f]*/build 0123456789abcdef/' out.d/measured/fig7_50.csv
sed -i '1s/last [0-9a-f]*/last 0123456789abcdef/' out.d/measured/fig7_55.csv
truncate -s -20 out.d/measured/fig7_65.csv # nobody's file: it does not end with a line
sed -i '10s/$/7x/' out.d/measured/fig7_75.csv # a row that ends with more than its numbers
sed -i '10s/,[0-9]*$/,/' out.d/measured/fig7_80.csv # and one that lacks its last
make 0 '' fig7
rows out.d/measured/fig7_45.csv 1 14 | cmp -s - <(rows whole/fig7_45.csv 1 14) || fail "kept rows within an angle were measured again"
rows out.d/measured/fig7_45.csv 15 $whole_lines | cmp -s - <(rows whole/fig7_45.csv 15 $whole_lines) && fail "missing rows were not measured"
for angle in 75 80; do
    [ "$(wc -l <out.d/measured/fig7_$angle.csv)" = $((whole_lines + 4)) ] || fail "fig7_$angle.csv: a damaged row was used"
done
for angle in 50 55 65; do
    cmp -s <(head -n 1 out.d/measured/fig7_$angle.csv) <(head -n 1 whole/fig7_$angle.csv) || fail "fig7_$angle.csv keeps another head"
    cmp -s out.d/measured/fig7_$angle.csv whole/fig7_$angle.csv && fail "fig7_$angle.csv was not measured again"
    [ "$(wc -l <out.d/measured/fig7_$angle.csv)" = $whole_lines ] || fail "fig7_$angle.csv is not whole"
done
cmp -s out.d/measured/fig7_70.csv whole/fig7_70.csv || fail "fig7_70.csv was measured again"
make 0 '' fig7 --threads 3
cmp -s <(rows out.d/measured/fig7_70.csv 3 3) <(rows whole/fig7_70.csv 3 3) && fail "rows of another number of threads were used"
[ "$(wc -l <out.d/conditions.csv)" = 3 ] || { fail "conditions:"; cat out.d/conditions.csv; }

# Counterexamples: the counts of a frame are kept.
make 0 '' counterexamples
cp out.d/counterexamples_scenes.csv whole.csv
rows out.d/measured/counterexamples_rings.csv 1 5 | sed '3s/^1,0,/1,777,/' >rings.csv
cp rings.csv out.d/measured/counterexamples_rings.csv
make 0 '"run":"rings","what":"is there"' counterexamples
grep -q '^rings,6,5,777,' out.d/counterexamples_scenes.csv || { fail "counterexamples: a kept frame was looked at again"; cat out.d/counterexamples_scenes.csv; }
sed -i '1s/build [0-9a-f]*/build 0123456789abcdef/' out.d/measured/counterexamples_rings.csv
make 0 '' counterexamples
cmp -s whole.csv out.d/counterexamples_scenes.csv || fail "counterexamples: rows of another build were used"

# Interrupted, the table stays as it was.
rm out.d/measured/counterexamples_*.csv
cut_off INT "-e out.d/measured/counterexamples_example_one_low_friction.csv" counterexamples
[ $cut = 130 ] || fail "counterexamples interrupted: exit $cut, expected 130"
cmp -s whole.csv out.d/counterexamples_scenes.csv || { fail "counterexamples: a table of some of the runs"; cat out.d/counterexamples_scenes.csv; }
make 0 '' counterexamples

# Verdicts: of each frame, by its state.
cp out.d/judged/rings.csv whole.csv
sed '4s/,0$/,55/; 6s/,[0-9a-f]*,0$/,0123456789abcdef,66/; 7,$d' whole.csv >out.d/judged/rings.csv
make 0 '"run":"rings","what":"is judged"' counterexamples
cmp -s <(sed '4s/,55$/,0/' out.d/judged/rings.csv) whole.csv || { fail "verdicts:"; cat out.d/judged/rings.csv; }
grep -q '^rings,.*,1,55,0.02,' out.d/runs.csv || fail "a kept verdict was judged again"
# A verdict that is not a number to the end of its line is none.
for damage in '5s/,0$/,/; 6s/,0$/,0rubbish/' '5s/,0$/, 0/' '$s/,0$/,/'; do
    sed "$damage" whole.csv >out.d/judged/rings.csv
    make 0 '"run":"rings","what":"is judged"' counterexamples
    cmp -s out.d/judged/rings.csv whole.csv || { fail "damaged verdicts were used:"; cat out.d/judged/rings.csv; }
done
printf %s "$(cat whole.csv)" >out.d/judged/rings.csv # without its last line feed
make 0 '"run":"rings","what":"is judged"' counterexamples
cmp -s out.d/judged/rings.csv whole.csv || { fail "a verdict that was cut off was used:"; cat out.d/judged/rings.csv; }
sed -i '1s/scene [0-9a-f]*/scene 0123456789abcdef/' out.d/judged/rings.csv
make 0 '"run":"rings","what":"is judged"' counterexamples
cmp -s out.d/judged/rings.csv whole.csv || fail "verdicts of another scene were used"

# A program that is built anew while the driver works is not taken for the one before.
cp "$TULLE" tulle
cp "$TULLE_PAPER_MEASURE" paper_measure
rm -f out.d/measured/fig7_*.csv
(exec sh "$TULLE_SOURCE_DIR/paper/reproduce.sh" --tulle tulle --measure paper_measure fig7 --scenes scenes -o out.d >log 2>&1) &
process=$!
until [ -e out.d/measured/fig7_89.csv ] || ! kill -0 $process 2>/dev/null; do sleep 0.002; done
cp tulle other && mv other tulle
wait $process
found=$?
[ $found = 3 ] && grep -q 'the program was built anew meanwhile' log || { fail "built anew: exit $found, expected 3"; tail -5 log; }

# Table 1: times of several builds are shown, not compared.
make 0 '' table1
awk -F, 'NR > 1 && $4 !~ /^((not )?confirmed|within the noise)$/ { exit 1 }' out.d/table1_ranking.csv || { fail "ranking:"; cat out.d/table1_ranking.csv; }
sed -i '2s/.*/01234567/' out.d/made/animation_3.bvox.csv
echo 01234567 >>out.d/made/animation_4.patches.csv
rm out.d/made/animation_5.paper.csv
make 0 'animation 3: its times are not compared' table1
[ "$(cut -d, -f1,4 out.d/table1_ranking.csv | grep 'not compared' | tr '\n' ' ')" = '3,not compared 4,not compared 5,not compared ' ] ||
    { fail "times of several builds are compared:"; cat out.d/table1_ranking.csv; }
[ "$(grep -cE '^(3,bvox,.*,01234567|4,patches,.*,mixed|5,paper,.*,unknown)$' out.d/table1.csv)" = 3 ] || { fail "conditions:"; cat out.d/table1.csv; }
rm -r out.d/runs/animation_3.* out.d/runs/animation_4.* out.d/runs/animation_5.*
make 0 '' table1
grep -q 'not compared' out.d/table1_ranking.csv && { fail "runs that were made again are not compared:"; cat out.d/table1_ranking.csv; }

[ $faults = 0 ] && echo "paper: goes on as expected"
exit $faults
