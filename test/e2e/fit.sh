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
expect 2 'shear: "0.9" should be .* with its unit' a.yaml --bending-warp 19mm --shear 0.9
expect 2 'bending-error: 15 mm is more than a quarter' a.yaml --bending-warp 19mm --bending-error 15mm
expect 2 '"" cannot be the name of a file' '' --bending-warp 19mm
expect 2 'stiffer yarns' a.yaml --bending-warp 19mm --shear 1e5N/m
expect 2 'no fabric "cottn"; did you mean "cotton"' a.yaml --bending-warp 19mm --preset cottn
expect 2 'give one of them' a.yaml --bending-warp 19mm --preset silk --from b.yaml
expect 2 'b.yaml.* cannot be opened' a.yaml --bending-warp 19mm --from b.yaml
expect 2 'drape-error has no effect without --drape' a.yaml --bending-warp 19mm --drape-error 3
expect 2 'bending-error has no effect without a bending length' a.yaml --drape 65 --bending-error 1mm
expect 2 'samples has no effect without --drape' a.yaml --bending-warp 19mm --samples 1
expect 2 'cell has no effect without --drape' a.yaml --bending-warp 19mm --cell 10mm
expect 2 'samples: "0" should be' a.yaml --drape 65 --samples 0
expect 2 'cell: "1m" should be' a.yaml --drape 65 --cell 1m
expect 2 'no file can be made in none/' none/a.yaml --bending-warp 19mm
expect 2 'exists and is not a file' . --bending-warp 19mm
echo 'bend: 0' >limp.yaml
expect 2 'limp.yaml has no bending rigidity' a.yaml --bending-warp 19mm --from limp.yaml
echo 'stretch: 3' >soft.yaml
expect 2 'soft.yaml cannot be started from: .*shear.stiffness is 50 N/m; it must be at most 3' a.yaml --bending-warp 19mm --from soft.yaml
echo '{area_density: 1e-9, bend: 1e-300}' >tiny.yaml
expect 2 'bend_twist is inf N m' a.yaml --bending-warp 19mm --from tiny.yaml
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
for line in 'area_density: 0.2' 'bend_warp: 1.57e-05' 'bend_weft: 6.622e-06' 'shear: {stiffness: 56.19,.*'; do
    grep -qx -- "$line" 'odd name, 2.yaml' || { echo "no $line in:"; cat 'odd name, 2.yaml'; faults=1; }
done

# What is written loads: with as much shear as the yarns allow, and whatever the start's name is.
cp a.yaml $'\xff\xe2\x80\xa8q"\'.yaml'
for from in "--preset cotton" $'--from \xff\xe2\x80\xa8q"\'.yaml'; do
    # shellcheck disable=SC2086 # options and values
    "$TULLE" fit loads.yaml --force --bending-warp 19mm --area-density 190gsm ${from%% *} "${from#* }" >out 2>&1 || { cat out; faults=1; }
    "$TULLE" fit most.yaml --force --bending-warp 19mm --shear 3549.64N/m >out 2>&1 || { cat out; faults=1; }
    for file in loads most; do
        sed "s/odd name, 2/$file/" scene.yaml >loads_scene.yaml
        "$TULLE" info loads_scene.yaml >out 2>&1 || { echo "$from: $file.yaml in a scene:"; cat out; faults=1; }
    done
done

# A search on coarse meshes: progress, report, the same file for any number of threads.
coarse='--samples 1 --cell 20mm --force'
expect 0 'drape tests: bending length' b.yaml --drape 80 $coarse
expect 0 'bending lengths of .* fit' b.yaml --drape 80 $coarse
cp b.yaml c.yaml
expect 0 'found by the drape coefficient' b.yaml --drape '80 %' --threads 1 $coarse
cmp b.yaml c.yaml || { echo "one thread writes another file"; faults=1; }
expect 0 'on 3 threads' b.yaml --drape '80 %' --threads 3 $coarse
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
"$TULLE" fit b.yaml --drape 65 --bending-warp 19mm --shear 50N/m $coarse --json 2>/dev/null >out
python3 - out <<'END' || faults=1
import json, sys
found = json.load(open(sys.argv[1], encoding="utf-8"))
assert found["searched"] == "drape" and found["search"]["value"] is None and found["bend_error_weft"] == 0, found
END
# More than can be told is not told.
expect 0 ' and more, which were not tried' b.yaml --drape 99.5 $coarse

# What cannot be is refused, told, and leaves no file.
expect 2 'bending length of .* would fit' d.yaml --drape 60 --bending-warp 30mm --shear 50N/m $coarse
expect 2 'contradict each other; no file was written' d.yaml --drape 60 --bending-warp 30mm --shear 50N/m $coarse
[ -e d.yaml ] && { echo "d.yaml was written though the measures contradict each other"; faults=1; }

# An interrupt ends the search within a step, not with its test.
"$TULLE" fit d.yaml --drape 40 >out 2>&1 &
search=$!
until grep -q 'will be simulated' out || ! kill -0 $search 2>/dev/null; do sleep 0.1; done
sleep 0.5
begin=$(date +%s)
kill -INT $search
wait $search
found=$?
[ $(($(date +%s) - begin)) -le 5 ] || { echo "interrupted: it ended $(($(date +%s) - begin)) s later"; faults=1; }
[ $found = 130 ] || { echo "interrupted: exit $found"; cat out; faults=1; }
grep -q 'interrupted; nothing was written' out || { echo "interrupted:"; cat out; faults=1; }
[ -e d.yaml ] && { echo "d.yaml was written though the search was interrupted"; faults=1; }
exit $faults
