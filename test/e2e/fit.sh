#!/usr/bin/env bash
# tulle fit: what is refused, and with what words; the file that it writes, in a scene; the report; an interrupt.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0

# expect CODE PATTERN ARGUMENTS...: exit code, and a line of either output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" fit "$@" >out 2>&1 </dev/null
    local found=$?
    [ $found = "$code" ] || { echo "tulle fit $*: exit $found, expected $code"; cat out; faults=1; }
    grep -q -- "$pattern" out || { echo "tulle fit $*: no \"$pattern\" in:"; cat out; faults=1; }
}

expect 2 'nothing was measured' a.yaml
expect 2 'nothing was measured' a.yaml --preset silk --area-density 70gsm
expect 2 'drape: "165" should be from 2 to 99.5, in percent' a.yaml --drape 165
expect 2 'drape: "0.65" should be' a.yaml --drape 0.65
expect 2 'drape: "x" should be' a.yaml --drape x
expect 2 'drape-error: "31" should be' a.yaml --drape 65 --drape-error 31
expect 2 'bending-warp: "19" should be a length from 2mm to 100mm, with its unit' a.yaml --bending-warp 19
expect 2 'bending-weft: "19gsm" should be' a.yaml --bending-weft 19gsm
expect 2 'bending-error: "-1mm" should be' a.yaml --bending-warp 19mm --bending-error -1mm
expect 2 'area-density: "150" should be from 5gsm' a.yaml --bending-warp 19mm --area-density 150
expect 2 'shear: "nan" should be' a.yaml --bending-warp 19mm --shear nan
expect 2 'stiffer yarns' a.yaml --bending-warp 19mm --shear 1e5
expect 2 'no fabric "cottn"; did you mean "cotton"' a.yaml --bending-warp 19mm --preset cottn
expect 2 'give one of them' a.yaml --bending-warp 19mm --preset silk --from b.yaml
expect 2 'b.yaml.* cannot be opened' a.yaml --bending-warp 19mm --from b.yaml
expect 2 'samples: "0" should be' a.yaml --drape 65 --samples 0
expect 2 'cell: "1m" should be' a.yaml --drape 65 --cell 1m
expect 2 'no file can be made in none/' none/a.yaml --bending-warp 19mm
expect 2 'is there and no file' . --bending-warp 19mm
echo 'bend: 0' >limp.yaml
expect 2 'limp.yaml has no bending rigidity' a.yaml --bending-warp 19mm --from limp.yaml
echo 'warp: {stifness: 1}' >wrong.yaml
expect 2 '^wrong.yaml:1:8: .*did you mean .stiffness' a.yaml --bending-warp 19mm --from wrong.yaml
[ -e a.yaml ] && { echo "a.yaml was written though all was refused"; faults=1; }

# A file, which is not replaced unasked, and starts another one.
expect 0 '^wrote a.yaml' a.yaml --bending-warp 20mm --bending-weft 15mm --area-density 200gsm --preset wool
expect 2 'a.yaml is there; --force replaces it' a.yaml --bending-warp 19mm
expect 0 '^wrote a.yaml' a.yaml --bending-warp 20mm --bending-weft 15mm --area-density 200gsm --preset wool --force
expect 0 '^shear 56.2 N/m: measured' 'odd name, 2.yaml' --from a.yaml --bending-weft 15mm --shear 1gf/cm/deg
# w g c^3 = 0.2 kg/m^2 * 9.81 m/s^2 * (20 mm)^3
grep -q '^bend_warp: 1.57e-05$' a.yaml || { echo "a.yaml has another bending:"; cat a.yaml; faults=1; }
printf 'time: {frames: 1}\ncloth: [{mesh: {shape: rectangle}, material: {file: "%s"}}]\n' 'odd name, 2.yaml' >scene.yaml
"$TULLE" info scene.yaml >out 2>&1 || { echo "the scene with the file:"; cat out; faults=1; }
for number in 0.2 1.57e-05 6.622e-06 56.19; do
    grep -q -- "$number" 'odd name, 2.yaml' || { echo "no $number in:"; cat 'odd name, 2.yaml'; faults=1; }
done

# A search on coarse meshes: progress, report, the same file for any number of threads.
coarse='--samples 1 --cell 20mm --force'
expect 0 'drape tests: bending length' b.yaml --drape 80 $coarse
expect 0 'bending lengths of .* fit' b.yaml --drape 80 $coarse
cp b.yaml c.yaml
expect 0 'found by the drape coefficient' b.yaml --drape '80 %' --threads 1 $coarse
cmp b.yaml c.yaml || { echo "another number of threads writes another file"; faults=1; }
"$TULLE" fit b.yaml --drape 80 $coarse --json 2>/dev/null >out
python3 - out <<'END' || faults=1
import json, sys
found = json.load(open(sys.argv[1], encoding="utf-8"))
search = found["search"]
assert found["file"] == "b.yaml" and found["searched"] == "bending", found
assert search["low"] < search["value"] < search["high"] and search["verdict"] == "found", found
assert found["tests"] == len(search["points"]), found
END

# What cannot be is refused, told, and leaves no file.
expect 2 'bending length of .* would fit' d.yaml --drape 60 --bending-warp 30mm --shear 50 $coarse
expect 2 'contradict each other; no file was written' d.yaml --drape 60 --bending-warp 30mm --shear 50 $coarse
[ -e d.yaml ] && { echo "d.yaml was written though the measures contradict each other"; faults=1; }

# An interrupt ends the search within a step.
"$TULLE" fit d.yaml --drape 40 >out 2>&1 &
search=$!
until grep -q 'will be simulated' out; do sleep 0.1; done
sleep 0.5
kill -INT $search
wait $search
found=$?
[ $found = 130 ] || { echo "interrupted: exit $found"; cat out; faults=1; }
grep -q 'interrupted; nothing was written' out || { echo "interrupted:"; cat out; faults=1; }
[ -e d.yaml ] && { echo "d.yaml was written though the search was interrupted"; faults=1; }
exit $faults
