#!/usr/bin/env bash
# tulle_validate: what was interrupted goes on to the same rows; rows of other options and files that
# are no table are refused.
set -uo pipefail
validate=$(dirname "$TULLE")/test/tulle_validate
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
export TULLE_SOURCE_DIR=${TULLE_SOURCE_DIR:-}

# expect CODE ARGUMENTS...: exit code of `tulle_validate --quick ARGUMENTS`.
expect() {
    local code=$1
    shift
    "$validate" --quick "$@" >out 2>err </dev/null
    local found=$?
    [ $found = "$code" ] || { echo "$*: exit $found, expected $code"; cat err; faults=1; }
}

# Nothing touches anything in laws.falls.
names=laws.falls,incline.slides,incline.goes,layers.fall_together
expect 0 --only $names --csv whole.csv
[ "$(cut -d, -f1 whole.csv | sort -u | wc -l)" = 6 ] || { echo "whole.csv:"; cat whole.csv; faults=1; }

# In two parts, and from two files one after the other.
expect 0 --only incline.slides --csv parts.csv
expect 0 --only $names --csv parts.csv --resume
expect 0 --only incline.goes --csv second.csv
expect 0 --only incline.slides --csv third.csv
expect 0 --only laws.falls --csv fourth.csv
cat fourth.csv second.csv third.csv >joined.csv
expect 0 --only $names --csv joined.csv --resume
grep -q incline err && { echo "experiments that have rows are run again:"; cat err; faults=1; }
for file in parts joined; do
    diff whole.csv $file.csv || { echo "$file.csv differs"; faults=1; }
done

# An interrupt: nothing of the experiment that runs is kept, all of those before it.
"$validate" --only incline.slides,layers.stack_sticks --csv stopped.csv >out 2>err </dev/null &
process=$!
for _ in $(seq 600); do
    [ -s stopped.csv ] && break
    sleep 0.1
done
kill -INT $process
wait $process
found=$?
[ $found = 130 ] || { echo "interrupted: exit $found"; faults=1; }
grep -q 'resume goes on' err || { echo "interrupted:"; cat err; faults=1; }
grep -q incline.slides stopped.csv || { echo "no rows are kept"; faults=1; }
grep -q layers stopped.csv && { echo "rows of what was interrupted are kept"; faults=1; }

# stopped.csv is of whole runs, not quick ones.
expect 2 --only carried --csv stopped.csv --resume
grep -q 'other options' err || { echo "no reason:"; cat err; faults=1; }
printf 'a,b\n1,2\n' >other.csv
expect 2 --only carried --csv other.csv --resume
expect 2 --only carried --resume
expect 2 --only nothing
exit $faults
