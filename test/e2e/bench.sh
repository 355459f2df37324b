#!/usr/bin/env bash
# tulle bench: a scene end to end, the state that is kept, CSV and comparison, what is refused, Ctrl-C. bench_series.sh tests the
# scenes and sizes of bench/bench.py, which stands on it.
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
bench() { "$TULLE" bench drop.yaml --steps 3 --repeat 2 "$@"; }
# refuse CODE PATTERN ARGUMENTS...: of the program itself.
refuse() {
    local code=$1 pattern=$2 found
    shift 2
    "$TULLE" bench "$@" >out 2>err
    found=$?
    [ $found = "$code" ] || fault "tulle bench $*: exit $found, not $code"
    grep -q -- "$pattern" err || { fault "tulle bench $*: no \"$pattern\" in:"; cat err; }
}

bench --skip 12 --threads 1 --state kept.state --csv first.csv >first.out 2>first.err || fault "exit $?: $(cat first.err)"
[ -s kept.state ] || fault "no state is kept"
[ "$(sed -n 1p first.csv)" = scene,size,threads,kind,name,value,minimum,spread ] || fault "the head of the CSV"
[ "$(grep -c '^| drop  *| 169 ' first.out)" = 2 ] || fault "the scene is not in both tables: $(cat first.out)"
for row in time,step, time,processor, time,solve_motion, count,contacts, memory,most_bytes, hash,start, hash,end,; do
    grep -q "^drop,169,1,$row" first.csv || fault "no row $row"
done
awk -F, '$5 == "contacts" && $6 <= 0 { exit 1 }' first.csv || fault "no contact"

# From the state that is kept, the same work again, on other threads too; without it, too; with other names.
before=$(stat -c '%Y %i' kept.state)
bench --skip 12 --threads 1,2 --state kept.state --csv second.csv >/dev/null 2>&1 || fault "the second bench: exit $?"
[ "$(stat -c '%Y %i' kept.state)" = "$before" ] || fault "the state was made again"
bench --skip 12 --threads 1 --name fall --size small --csv third.csv >/dev/null 2>&1 || fault "the third bench: exit $?"
for threads in 1 2; do
    cmp -s <(grep ',\(count\|hash\),' first.csv) <(grep ",169,$threads,\(count\|hash\)" second.csv | sed "s/,169,$threads,/,169,1,/") ||
        fault "counts or states of $threads threads differ"
done
cmp -s <(grep '^drop,.*,\(count\|hash\),' first.csv | sed 's/^drop,169/fall,small/') <(grep '^fall,.*,\(count\|hash\),' third.csv) ||
    fault "another name gives other counts"

# Compared: with itself, with a slower one, without measuring.
"$TULLE" bench --from first.csv --compare first.csv >same.out 2>&1 || fault "a file against itself: exit $?"
grep -q '^compared [1-9][0-9]* measures: 0 slower, 0 changed, 0 more' same.out || fault "a file against itself: $(tail -n 1 same.out)"
awk -F, -v OFS=, '$4 == "time" { $6 *= 2; $7 *= 2 } { print }' first.csv >slow.csv
"$TULLE" bench --from slow.csv --compare first.csv >slow.out 2>&1
[ $? = 1 ] || fault "a slower file: no exit 1"
grep -q '^slower:  drop 169, 1 thread, processor: .* 2.000 times' slow.out || fault "a slower file: $(tail -n 3 slow.out)"
bench --skip 12 --threads 1 --set contact.friction=0.5 --set obstacles[0].friction=0.9 --csv other.csv >other.out 2>&1 || fault "--set: exit $?"
cmp -s <(grep ',hash,' first.csv) <(grep ',hash,' other.csv) && fault "--set changes nothing"

refuse 2 'SCENE.yaml is missing; usage: tulle bench'
refuse 2 'give a scene to measure, or --from' drop.yaml --from first.csv
refuse 2 'missing.yaml: ' missing.yaml
refuse 2 'whole numbers from 1 to 256' drop.yaml --threads 1,0
refuse 2 'whole numbers from 1 to 256' drop.yaml --threads 1,two
refuse 2 '--repeat: "0" should be a whole number from 1' drop.yaml --repeat 0
refuse 2 '--size: "" should have' drop.yaml --size ''
refuse 2 '--name: "a,b" should have' drop.yaml --name a,b
refuse 2 'missing.csv: cannot be opened' drop.yaml --compare missing.csv
printf 'scene,size\n' >foreign.csv
refuse 2 'foreign.csv:1: is no table' drop.yaml --compare foreign.csv
head -c 300 first.csv >cut.csv
refuse 2 'cut.csv:[0-9]*: ' drop.yaml --compare cut.csv
refuse 2 'no/where.csv: cannot be written' drop.yaml --csv no/where.csv
head -c 5000 kept.state >damaged.state
refuse 2 'damaged or cut off.*delete it' drop.yaml --state damaged.state

"$TULLE" bench drop.yaml --skip 1000000 --state cut.state >cut.out 2>cut.err &
process=$!
sleep 0.5
kill -INT $process
wait $process
code=$?
[ $code = 130 ] || fault "interrupted: exit $code, not 130: $(cat cut.err)"
grep -q '^tulle bench: interrupted' cut.err || fault "interrupted, not said: $(cat cut.err)"
[ -e cut.state ] && fault "interrupted: left a state"

[ $faults = 0 ] && echo "bench: as it should"
exit $faults
