#!/usr/bin/env bash
# bench/bench.py with a scene file: end to end, CSV and comparison, what is refused; bench_scene below it: the state that is kept,
# Ctrl-C. bench_series.sh tests the scenes and sizes of bench.py.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >drop.yaml <<'END'
title: drop
time: {step: 1/90 s, frames: 10}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [13, 13]}
    translate: [0, 0, 0.11]
obstacles:
  - name: ball
    mesh: {shape: sphere, radius: 0.1}
END
program=$(dirname "$TULLE")/bench/bench_scene
[ -x "$program" ] || { echo "skipped: $program is not built"; exit 77; }
bench() { "${PYTHON3:-python3}" "$TULLE_SOURCE_DIR/bench/bench.py" --tulle "$TULLE" --inputs inputs "$@"; }
measure() { bench drop.yaml --skip 12 --steps 3 --repeat 2 "$@"; }
# refuse COMMAND CODE PATTERN ARGUMENTS...
refuse() {
    local command=$1 code=$2 pattern=$3 found
    shift 3
    "$command" "$@" >out 2>err
    found=$?
    [ $found = "$code" ] || fault "$command $*: exit $found, not $code"
    grep -q -- "$pattern" err || { fault "$command $*: no \"$pattern\" in:"; cat err; }
}

measure --threads 1 --csv first.csv >first.out 2>first.err || fault "exit $?: $(cat first.err)"
[ "$(sed -n 1p first.csv)" = scene,size,threads,kind,name,value,minimum,spread ] || fault "the head of the CSV"
[ "$(grep -c '^| drop  *| 169 ' first.out)" = 2 ] || fault "the scene is not in both tables: $(cat first.out)"
for row in time,step, time,processor, time,solve_motion, count,contacts, memory,most_bytes, hash,start, hash,end,; do
    grep -q "^drop,169,1,$row" first.csv || fault "no row $row"
done
awk -F, '$5 == "contacts" && $6 <= 0 { exit 1 }' first.csv || fault "no contact"

# The same work again, on other threads too, and from a state that is kept.
measure --threads 1,2 --csv second.csv >/dev/null 2>&1 || fault "the second bench: exit $?"
for threads in 1 2; do
    cmp -s <(grep ',\(count\|hash\),' first.csv) <(grep ",169,$threads,\(count\|hash\)" second.csv | sed "s/,169,$threads,/,169,1,/") ||
        fault "counts or states of $threads threads differ"
done
keep() { "$program" drop.yaml --skip 12 --steps 3 --repeat 2 --threads 1 --state kept.state; }
keep >kept.out || fault "a state to keep: exit $?"
[ -s kept.state ] || fault "no state is kept"
before=$(stat -c '%Y %i' kept.state)
keep >again.out || fault "from a state that is kept: exit $?"
[ "$(stat -c '%Y %i' kept.state)" = "$before" ] || fault "the state was made again"
cmp -s <(grep ',\(count\|hash\),' kept.out) <(grep ',\(count\|hash\),' again.out) || fault "counts or states from a kept state differ"
cmp -s <(grep '^drop,.*,\(count\|hash\),' first.csv | cut -d, -f3-6) <(grep ',\(count\|hash\),' kept.out) || fault "a kept state gives other counts"

# Compared: with itself, with a slower one, without measuring.
bench drop.yaml --from first.csv --compare first.csv >same.out 2>&1 || fault "a file against itself: exit $?"
grep -q '^compared [1-9][0-9]* measures: 0 slower, 0 changed, 0 more' same.out || fault "a file against itself: $(tail -n 1 same.out)"
awk -F, -v OFS=, '$4 == "time" { $6 *= 2; $7 *= 2 } { print }' first.csv >slow.csv
bench drop.yaml --from slow.csv --compare first.csv >slow.out 2>&1
[ $? = 1 ] || fault "a slower file: no exit 1"
grep -q '^slower:  drop 169, 1 thread, processor: .* 2.000 times' slow.out || fault "a slower file: $(tail -n 3 slow.out)"
measure --threads 1 --set contact.friction=0.5 --set obstacles[0].friction=0.9 --csv other.csv >other.out 2>&1 || fault "--set: exit $?"
cmp -s <(grep ',hash,' first.csv) <(grep ',hash,' other.csv) && fault "--set changes nothing"

refuse bench 2 'missing.yaml: ' missing.yaml
refuse bench 2 '--steps should be whole numbers from 1' drop.yaml --steps 0
refuse bench 2 'cloth\[0\].mesh.resolutoin' drop.yaml --set cloth[0].mesh.resolutoin=[3,3]
refuse bench 2 'missing.csv: cannot be read' drop.yaml --compare missing.csv
refuse bench 2 'no/where.csv: cannot be written' drop.yaml --csv no/where.csv
refuse "$program" 2 'usage: bench_scene SCENE.yaml'
refuse "$program" 2 '"--threads 1,two" is not understood' drop.yaml --threads 1,two
refuse "$program" 2 '"--threads 0" is not understood' drop.yaml --threads 0
refuse "$program" 2 '"--repeat" is not understood' drop.yaml --repeat
refuse "$program" 2 '"--name a" is not understood' drop.yaml --name a
refuse "$program" 3 'no/where.state: ' drop.yaml --skip 1 --state no/where.state
head -c 5000 kept.state >damaged.state
refuse "$program" 2 'damaged.state: .*damaged or cut off.*delete it' drop.yaml --state damaged.state
if [ -w /dev/full ]; then
    "$program" drop.yaml --skip 1 --steps 1 --repeat 1 --threads 1 >/dev/full 2>err
    [ $? = 3 ] || fault "a full disk: no exit 3: $(cat err)"
fi

"$program" drop.yaml --skip 1000000 --state cut.state >cut.out 2>cut.err &
process=$!
sleep 0.5
kill -INT $process
wait $process
code=$?
[ $code = 130 ] || fault "interrupted: exit $code, not 130: $(cat cut.err)"
[ -e cut.state ] && fault "interrupted: left a state"

[ $faults = 0 ] && echo "bench: as it should"
exit $faults
