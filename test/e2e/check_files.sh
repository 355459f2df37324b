#!/usr/bin/env bash
# tulle check on mesh files: verdicts, lists, JSON, several files, obstacles, bad input, exit codes.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0

# expect CODE PATTERN ARGUMENTS...: exit code of `tulle check ARGUMENTS`, and a line of its output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" check "$@" >out 2>err </dev/null
    local found=$?
    [ $found = "$code" ] || { echo "check $*: exit $found, expected $code"; cat out err; faults=1; }
    grep -q -e "$pattern" out err || { echo "check $*: no \"$pattern\" in:"; cat out err; faults=1; }
}
# last TEXT: the last line of the last output is exactly this.
last() {
    [ "$(tail -n 1 out)" = "$1" ] || { echo "last line is \"$(tail -n 1 out)\", not \"$1\""; faults=1; }
}

# Two triangles in a square; the same with the second folded flat onto the first; a spike.
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 4\n' >square.obj
printf 'v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0.75 0.5 0\nf 1 2 3\nf 1 3 4\n' >folded.obj
printf 'v 0.6 0.2 -1\nv 0.7 0.2 -1\nv 0.6 0.3 1\nf 1 2 3\n' >spike.obj
printf 'v 0.6 0.2 3\nv 0.7 0.2 3\nv 0.6 0.3 4\nf 1 2 3\n' >above.obj
# Touching counts: a corner exactly on the square.
printf 'v 0.5 0.25 0\nv 1 0 1\nv 0 0 1\nf 1 2 3\n' >touching.obj

expect 0 '^square.obj: 0 intersections$' square.obj
last '0 intersections in 1 frames'
expect 1 '^  folded.obj triangle 0 and folded.obj triangle 1 near (0.[0-9.]*, 0.[0-9.]*, 0)$' folded.obj
last '1 intersections in 1 of 1 frames'
expect 1 '^folded.obj: 1 intersection$' square.obj folded.obj square.obj
last '1 intersections in 1 of 3 frames'
expect 0 '^spike.obj: 0 intersections$' square.obj spike.obj
last '0 intersections in 2 frames'
expect 1 '^  square.obj triangle 0 and spike.obj triangle 0 near' --together square.obj spike.obj
last '1 intersections in 1 of 1 frames'
expect 1 '^  square.obj triangle 0 and spike.obj triangle 0 near' square.obj --obstacle spike.obj
expect 0 '^square.obj: 0 intersections$' square.obj --obstacle above.obj --obstacle above.obj
last '0 intersections in 1 frames'
# Obstacles may intersect themselves and one another.
expect 0 '^above.obj: 0' above.obj --obstacle square.obj --obstacle spike.obj --obstacle folded.obj
expect 1 'touching.obj triangle 0' --together square.obj touching.obj
expect 1 'touching.obj triangle 0' --together square.obj touching.obj --threads 2

# A hundred copies of one triangle: 4,950 pairs, listed or not.
{
    for i in $(seq 100); do printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n'; done
    for i in $(seq 0 99); do echo "f $((3 * i + 1)) $((3 * i + 2)) $((3 * i + 3))"; done
} >copies.obj
expect 1 'and 3950 more' copies.obj
[ "$(grep -c triangle out)" = 1000 ] || { echo "another number of pairs is listed than by default"; faults=1; }
expect 1 '^copies.obj: 4950 intersections$' copies.obj --list 4950
[ "$(grep -c triangle out)" = 4950 ] || { echo "not every pair is listed"; faults=1; }
cp out all
expect 1 'and 4947 more' copies.obj --list 3
[ "$(grep -c triangle out)" = 3 ] || { echo "--list 3 lists another number"; faults=1; }
expect 1 '^copies.obj: 4950' copies.obj --list 0
last '4950 intersections in 1 of 1 frames'
[ "$(wc -l <out)" = 2 ] || { echo "--list 0 lists something"; faults=1; }
for threads in 1 2 7; do
    "$TULLE" check copies.obj --list 4950 --threads $threads >out
    cmp -s out all || { echo "threads change the output"; faults=1; }
done

expect 1 '"intersections":1,"pairs":\[{"a":"folded.obj","triangle_a":0,"b":"folded.obj","triangle_b":1,"near":\[' --json folded.obj
last '{"frames":1,"frames_with_intersections":1,"intersections":1}'
cp square.obj 'a "quoted" \ name.obj'
expect 0 '^{"source":"a \\"quoted\\" \\\\ name.obj","intersections":0,"pairs":\[\]}$' --json 'a "quoted" \ name.obj'

expect 2 'missing.obj' missing.obj
expect 2 'missing.obj' square.obj --obstacle missing.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\n' >points.obj
expect 2 'points.obj' points.obj
printf 'v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 4\n' >range.obj
expect 2 'range.obj' range.obj
printf 'v 0 nan 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n' >nan.obj
expect 2 'nan.obj' nan.obj
mkdir empty
expect 2 'empty' empty
expect 2 'threads' square.obj --threads 1000
expect 2 'did you mean --together' square.obj --togehter
[ -s out ] && { echo "a refused call prints to standard output"; faults=1; }
expect 2 'FILE|DIR ... is missing'
"$TULLE" check square.obj >/dev/full 2>err
[ $? = 3 ] || { echo "a full disk is not exit 3"; faults=1; }
exit $faults
