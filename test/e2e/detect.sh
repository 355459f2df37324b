#!/usr/bin/env bash
# tulle detect: known events, all options, every kind of mesh file, text against JSON, threads, bad input, output that
# cannot be written. Needs python3, to write the meshes and to read JSON.
set -uo pipefail
command -v python3 >/dev/null || { echo "skipped: python3 is not installed"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
tests=$TULLE_SOURCE_DIR/test/e2e
faults=0
fault() { echo "fault: $*"; faults=1; }

# detect ARGUMENTS...: must work.
detect() { "$TULLE" detect "$@" >out 2>err </dev/null || { fault "detect $*: exit $?"; cat err; }; }
# said PATTERN: the last output has such a line.
said() { grep -Eq -e "$1" out || { fault "no \"$1\" in:"; cat out; }; }
# Comparisons are noted down with what they are about, and made at the end.
job_count=0
note() { local IFS=$'\t'; echo "$*" >>jobs; }
# keep FILE: makes a copy, and sets `kept` to its name.
keep() { kept=$((job_count++)).json; cp "$1" $kept; }
# values KEY=VALUE...: of the JSON document in out.
values() { keep out; note values $kept "$@"; }
# refuse PATTERN ARGUMENTS...: exit 2, nothing on standard output, and such a message.
refuse() {
    local pattern=$1
    shift
    "$TULLE" detect "$@" >out 2>err </dev/null
    local found=$?
    [ $found = 2 ] || fault "detect $*: exit $found, not 2"
    [ -s out ] && fault "detect $*: refused, but prints to standard output"
    grep -Eq -e "$pattern" err || { fault "detect $*: no \"$pattern\" in:"; cat err; }
}
listed() { grep -E '^(vertex_face|edge_edge) ' "$1"; }

python3 "$tests/detect_meshes.py" || exit 1
methods="patches refit bvox paper"

# ---- small meshes with known events, by every method
for method in $methods; do
    detect drop_0.obj drop_1.obj --list --method $method
    [ "$(listed out | wc -l)" = 1 ] || { fault "$method: not one event in:"; cat out; }
    said '^vertex_face 3 0 0\.(5|49[0-9]*) hit$'
    detect edges_0.obj edges_1.obj --list --method=$method
    [ "$(listed out | wc -l)" = 1 ] || { fault "$method: not one event in:"; cat out; }
    said '^edge_edge 0-1 3-4 0\.(25|24[0-9]*) hit$'
    detect touching_0.obj touching_1.obj --list -m $method
    [ "$(listed out)" = 'vertex_face 3 0 0 touching_at_start' ] || { fault "$method: touching:"; cat out; }
    detect touching_0.obj touching_1.obj --json -m $method
    values events.touching_at_start=1 events.vertex_face=1 events.earliest_time=0 events.earliest_hit_time=null
    detect crossing_0.obj crossing_1.obj --json --method $method
    values events.crossing_at_start=1 events.earliest_time=null events.all=0
    detect apart_0.obj apart_1.obj --json --method $method
    values events.crossing_at_start=0 events.complete=true events.all=0
    # 0.5 m remain between them: more than 0.3 m + 0.1 m, less than 0.3 m + 0.3 m.
    detect apart_0.obj apart_1.obj --json --method $method --thickness 300mm --minimum-separation 0.1
    values events.all=0 settings.thickness=0.3 settings.minimum_separation=0.1
    detect apart_0.obj apart_1.obj --method $method --thickness 30cm --minimum-separation 300mm --list
    said '^vertex_face 3 0 0\.(8|7[89][0-9]*) hit$'
    detect strange_0.obj strange_1.obj --list --method $method
    [ "$(listed out | wc -l)" = 1 ] || { fault "$method: not one event in the strange mesh:"; cat out; }
    said '^vertex_face 3 0 0\.(5|49[0-9]*) hit$'
done
detect drop_0.obj drop_1.obj --json
# What --help, the manual and docs/guide/detect.md say of the defaults.
values settings.method='"patches"' settings.cone='"bernstein"' settings.alpha_max_degrees=60 settings.certificate=true \
    settings.patches='"keep"' settings.thickness=0 settings.minimum_separation=0 settings.repeat=0 settings.earliest=false
detect crossing_0.obj crossing_1.obj
said '^  start crosses +itself in 1 pairs of triangles$'
said '^  earliest time +none$'

# ---- two sheets through each other: all options, text against JSON
detect sheets_0.obj sheets_1.obj --json --list --method refit
cp out refit.json
values settings.method='"refit"' patches.used=false mesh.vertices=1152 mesh.triangles=2116 "events.all=>100"
# both OPTIONS...: text and JSON, which are to say the same; the document stays in out and in $kept.
both() {
    "$TULLE" detect sheets_0.obj sheets_1.obj --list "$@" >text 2>err || { fault "detect $*: exit $?"; cat err; }
    detect sheets_0.obj sheets_1.obj --list --json "$@"
    keep out
    cp text $kept.text
    note sound $kept.text $kept
}
both_within_refit() { both "$@"; note within $kept refit.json; }
for method in $methods; do both_within_refit --method $method --repeat 2; done
both --method bvox
note within refit.json $kept
for options in "--cone paper" "--alpha-max 30deg" "--alpha-max 1.2rad" "--patches grow --repeat 3" "--patches keep" \
    "--certificate on" "--cone bernstein --method paper --alpha-max=45deg --repeat=3"; do
    both_within_refit $options
done
both_within_refit --alpha-max 89
values settings.alpha_max_degrees=89
both --thickness 2mm
note within refit.json $kept

both_within_refit --earliest
values events.all=1 events.complete=false events.earliest_time==refit.json

both --certificate off
values settings.certificate=false events.complete=false
grep -q '^COLLISIONS MAY BE MISSED' text || { fault "nothing is said of what may be missed:"; cat text; }
both --certificate off --method refit
values events.complete=true
grep -q 'MISSED' text && fault "refit without patches warns of a missing certificate"

# ---- times
detect sheets_0.obj sheets_1.obj --repeat 5
said '^times \[ms\] +first call +median +minimum  of 5 further calls$'
said '^    time of impact( +[0-9]+\.[0-9]+){3}$'
detect sheets_0.obj sheets_1.obj
said '^times \[ms\] +one call$'
said '^  total +[0-9]+\.[0-9]+$'

# ---- the same bytes but for times and file names, for any threads, repeats and kinds of file
without_times() { grep -v '^"time_ms"\|^"start"\|^"settings"' "$1"; }
for method in $methods; do
    detect sheets_0.obj sheets_1.obj --json --list --method $method --threads 1
    without_times out >expected
    for threads in 2 3 8; do
        detect sheets_0.obj sheets_1.obj --json --list --method $method -t $threads
        without_times out | cmp -s - expected || fault "$method: $threads threads change the report"
    done
    "$TULLE" detect sheets_0.obj sheets_1.obj --list --method $method -t 1 | listed - >list_1
    "$TULLE" detect sheets_0.obj sheets_1.obj --list --method $method -t 2 | listed - | cmp -s - list_1 ||
        fault "$method: 2 threads change the list"
done
detect sheets_0.obj sheets_1.obj --json --list
without_times out >expected
for kind in float double; do
    for order in ascii binary_little_endian binary_big_endian; do
        end=_${kind}_$order.ply
        detect sheets_0"$end" sheets_1"$end" --json --list
        without_times out | cmp -s - expected || fault "$kind $order gives other events than OBJ"
    done
done
detect sheets_0_float_binary_big_endian.ply sheets_1_double_ascii.ply --json --list
without_times out | cmp -s - expected || fault "a mixture of files gives other events"
for state in 0 1; do "$TULLE" convert sheets_$state.obj sheets_$state.vtp >/dev/null || fault "convert to VTP"; done
detect sheets_0.vtp sheets_1.vtp --json --list
without_times out | cmp -s - expected || fault "VTP gives other events"
detect fine_0.obj fine_1.obj --json --list
without_times out | cmp -s - expected && fault "rounding coordinates to float changes no time"
without_times out >expected
for order in ascii binary_little_endian binary_big_endian; do
    detect fine_0_double_$order.ply fine_1_double_$order.ply --json --list
    without_times out | cmp -s - expected || fault "$order loses bits of doubles"
done
cp drop_0.obj $'a "quoted" \\ \x01 \xc3\xa4 \xff name.obj'
detect $'a "quoted" \\ \x01 \xc3\xa4 \xff name.obj' drop_1.obj --json
values start='"a \"quoted\" \\ \u0001 \u00e4 \ufffd name.obj"'

# ---- bad input
refuse 'START END is missing'
refuse 'START END is missing' drop_0.obj
refuse 'one too many' drop_0.obj drop_1.obj drop_1.obj
refuse '^tulle detect: missing.obj: ' missing.obj drop_1.obj
refuse '^tulle detect: missing.ply: ' drop_0.obj missing.ply
refuse '^tulle detect: \./?: ' . drop_1.obj
cp edges_0.obj other_0.obj
sed 's/^f 1 2 3/f 1 2 4/' edges_1.obj >other_1.obj
refuse '^tulle detect: other_1.obj: triangle 0 has vertices 0, 1, 3, but in other_0.obj 0, 1, 2 \(counted' other_0.obj other_1.obj
sed '$d' edges_1.obj >fewer_1.obj
refuse '^tulle detect: fewer_1.obj: has 1 triangles, but edges_0.obj has 2' edges_0.obj fewer_1.obj
refuse '^tulle detect: strange_1.obj: has 12 vertices, but drop_0.obj has 6' drop_0.obj strange_1.obj
grep '^v' drop_0.obj >points.obj
refuse '^tulle detect: points.obj: .*no triangles' points.obj points.obj
sed '4s/.*/v nan 0 0/' drop_1.obj >nan.obj
refuse '^tulle detect: nan.obj:4:3: ' drop_0.obj nan.obj
sed '4s/.*/v 1e999 0 0/' drop_1.obj >infinite.obj
refuse '^tulle detect: infinite.obj:4:3: ' infinite.obj drop_1.obj
header=$(sed '/^end_header/q' sheets_1_float_binary_big_endian.ply | wc -c)
{
    head -c $((header + 16)) sheets_1_float_binary_big_endian.ply
    printf '\177\300\0\0'
    tail -c +$((header + 21)) sheets_1_float_binary_big_endian.ply
} >nan.ply
refuse '^tulle detect: nan.ply: byte [0-9]+: vertex 1, y: is not a finite number' sheets_0.obj nan.ply
head -c 20000 sheets_1_double_binary_little_endian.ply >cut.ply
refuse '^tulle detect: cut.ply: byte [0-9]+: .*cut short' sheets_0.obj cut.ply
sed 's/^f 1 2 3/f 1 2 2/' drop_0.obj >repeated_0.obj
sed 's/^f 1 2 3/f 1 2 2/' drop_1.obj >repeated_1.obj
refuse '^tulle detect: repeated_0.obj: .*triangle 0' repeated_0.obj repeated_1.obj
for state in 0 1; do "$TULLE" convert drop_$state.obj drop_$state.stl >/dev/null; done
refuse '^tulle detect: drop_0.stl: STL' drop_0.stl drop_1.stl
cp drop_0.obj drop_0.txt
refuse '^tulle detect: drop_0.txt: .*should end in' drop_0.txt drop_1.obj
refuse '--method: "voxels" should be one of: patches, refit, bvox, paper' drop_0.obj drop_1.obj --method voxels
refuse '--cone: "round" should be one of' drop_0.obj drop_1.obj --cone round
refuse '--certificate: "maybe"' drop_0.obj drop_1.obj --certificate maybe
refuse '--patches: "some"' drop_0.obj drop_1.obj --patches some
for angle in 90deg 90 0 0deg -3deg 1.6rad 200 wide 60degrees nan ''; do
    refuse '--alpha-max: .*should be an angle above 0 and below 90deg' drop_0.obj drop_1.obj --alpha-max "$angle"
done
refuse '--alpha-max: "1.0" could be meant in degrees or in radians' drop_0.obj drop_1.obj --alpha-max 1.0
for length in -1mm -1 thick inf nan 1e999 2kg ''; do
    refuse '--thickness: .*should be a length of 0 or more' drop_0.obj drop_1.obj "--thickness=$length"
    refuse '--minimum-separation: .*should be a length' drop_0.obj drop_1.obj "--minimum-separation=$length"
done
for number in -1 257 two; do refuse '--threads: ' drop_0.obj drop_1.obj "--threads=$number"; done
for number in -1 100001 1.5; do refuse '--repeat: ' drop_0.obj drop_1.obj "--repeat=$number"; done
refuse 'did you mean --thickness' drop_0.obj drop_1.obj --thicknes 1

# ---- output that cannot be written, or that nobody reads
for options in "" "--json" "--list" "--json --list"; do
    "$TULLE" detect sheets_0.obj sheets_1.obj $options >/dev/full 2>err
    [ $? = 3 ] || fault "detect $options onto a full disk: no exit 3"
    grep -q 'could not be written' err || fault "detect $options onto a full disk: no message"
done
"$TULLE" detect sheets_0.obj sheets_1.obj --list --thickness 50mm 2>err | head -n 1 >first
grep -q '^sheets_0.obj to sheets_1.obj$' first || fault "the first line is lost in a pipe"
[ -s err ] && { fault "a pipe that is closed early gives a message:"; cat err; }

# ---- an interrupt ends it at once
"$TULLE" detect sheets_0.obj sheets_1.obj --repeat 100000 >out 2>err &
process=$!
sleep 0.3
kill -TERM $process 2>/dev/null
wait $process
code=$?
[ $code -gt 128 ] || fault "an interrupted search exits with $code"
[ -s out ] && { fault "an interrupted search reports:"; cat out; }

python3 "$tests/detect_compare.py" jobs || faults=1
exit $faults
