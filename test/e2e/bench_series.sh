#!/usr/bin/env bash
# bench/bench.py: the smallest cases end to end, inputs that are kept, CSV and comparison, what is refused, Ctrl-C.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }
driver=("${PYTHON3:-python3}" "$TULLE_SOURCE_DIR/bench/bench.py" --tulle "$TULLE")
bench() { "${driver[@]}" "$@"; }

# refuse CODE PATTERN ARGUMENTS...
refuse() {
    local code=$1 pattern=$2 found
    shift 2
    bench "$@" >out 2>err
    found=$?
    [ $found = "$code" ] || fault "bench $*: exit $found, not $code"
    grep -q -- "$pattern" err || { fault "bench $*: no \"$pattern\" in:"; cat err; }
}

# ---- measured ----
bench spikes boxes --quick --csv first.csv >first.out 2>first.err || fault "the first bench: exit $?: $(cat first.err)"
[ "$(ls bench-inputs | sed 's/-[0-9a-f]*\.state$//' | paste -sd' ')" = "boxes-0.4k-45 spikes-0.4k-54" ] || fault "inputs: $(ls bench-inputs)"
[ "$(sed -n 1p first.csv)" = scene,size,threads,kind,name,value,minimum,spread ] || fault "the head of the CSV"
awk -F, 'NF != 8 { exit 1 }' first.csv || fault "a row has not 8 fields"
for row in about,processor, about,compiler, about,fingerprint,; do grep -q "^,,,$row" first.csv || fault "no row $row"; done
for row in time,step, time,processor, time,solve_motion, time,commit_safely, count,contacts, count,box_pairs, count,tested_pairs, \
    count,solve_count, count,cg_iterations, count,substeps, count,rescue_global_scalings, memory,most_bytes, hash,start, hash,end,; do
    for scene in spikes boxes; do grep -q "^$scene,0.4k,1,$row" first.csv || fault "no row $row of $scene"; done
done
awk -F, '$4 == "time" && $5 == "step" && !($7 > 0 && $7 <= $6) { exit 1 }' first.csv || fault "a least time is over its median"
[ "$(grep -c '^| spikes ' first.out)" = 2 ] || fault "spikes is not in both tables"
awk -F, '$5 == "contacts" && $6 <= 0 { exit 1 }' first.csv || fault "an input without contact"

# ---- again: the same inputs, the same counts and states, on two threads as well ----
before=$(cd bench-inputs && stat -c '%n %Y %i' ./*)
bench boxes spikes --quick --threads 1,2 --csv second.csv >second.out 2>second.err || fault "the second bench: exit $?"
[ "$(cd bench-inputs && stat -c '%n %Y %i' ./*)" = "$before" ] || fault "inputs were made again"
grep 'to where it is timed' second.err && fault "inputs were made again, it says"
for threads in 1 2; do
    cmp -s <(grep ',0.4k,1,\(count\|hash\)' first.csv) <(grep ",0.4k,$threads,\(count\|hash\)" second.csv | sed "s/,0.4k,$threads,/,0.4k,1,/") ||
        fault "counts or states of $threads threads differ"
done

# ---- compared ----
bench all --quick --from first.csv --compare first.csv >same.out 2>same.err || fault "a file against itself: exit $?"
grep -q '^compared [1-9][0-9]* measures: 0 slower, 0 changed, 0 more' same.out || fault "a file against itself: $(tail -n 1 same.out)"
awk -F, -v OFS=, '$4 == "time" && $1 == "spikes" { $6 *= 2; $7 *= 2 } { print }' first.csv >slow.csv
bench all --quick --from slow.csv --compare first.csv >slow.out 2>&1
[ $? = 1 ] || fault "a slower file: no exit 1"
grep -q '^slower:  spikes 0.4k, 1 thread, processor: .* 2.000 times' slow.out || fault "a slower file: $(tail -n 3 slow.out)"
grep -q '^slower:  boxes' slow.out && fault "boxes is called slower"
sed 's/^boxes,0.4k,1,count,cg_iterations,/&1/' first.csv >changed.csv
bench boxes --quick --from changed.csv --compare first.csv >changed.out 2>&1
[ $? = 1 ] || fault "a changed count: no exit 1"
grep -q '^changed: boxes 0.4k, 1 thread, cg_iterations: 1[0-9]*, was ' changed.out || fault "a changed count: $(tail -n 3 changed.out)"
bench spikes --quick --from changed.csv --compare first.csv >/dev/null 2>&1 || fault "the change of boxes is told of spikes"
bench spikes --quick --from first.csv --csv part.csv >/dev/null || fault "a part: exit $?"
cmp -s <(grep -v '^boxes' first.csv) part.csv || fault "a part is not what was asked for"
refuse 2 'nothing to compare with' boxes --quick --from part.csv --compare part.csv

# ---- instructions: skipped and said where valgrind is missing ----
mkdir others && cp -s /usr/bin/* others/ 2>/dev/null
rm -f others/valgrind*
PATH=$PWD/others "$(command -v "${driver[0]}")" "${driver[@]:1}" boxes --quick --instructions --csv counted.csv >/dev/null 2>err || fault "without valgrind: exit $?"
grep -q '^bench: skipped: instructions are counted by valgrind' err || fault "without valgrind: $(cat err)"
grep -q ',instructions,' counted.csv && fault "without valgrind: a count"
if command -v valgrind >/dev/null && ! grep -q '__[at]san_init' "$TULLE"; then # sanitizers and valgrind do not mix
    bench boxes --quick --instructions --csv counted.csv >/dev/null 2>err || fault "with valgrind: exit $?: $(cat err)"
    awk -F, '$4 == "instructions" && $5 == "steps" && $3 == 1 && $6 > 1e6 { found = 1 } END { exit !found }' counted.csv || fault "with valgrind: no count"
fi

# ---- every scene comes to every size ----
python3 - "$TULLE_SOURCE_DIR" "$TULLE" "${TULLE_TEST_LONG:-}" <<'END' || fault "sizes"
import json, subprocess, sys
sys.path.insert(0, sys.argv[1] + "/bench")
import bench
faults = 0
for scene, (file, _, sizes) in bench.SCENES.items():
    if len(sizes) != {"landing": 6, "small": 2, "garment": 2}.get(scene, 5):
        print(f"{scene}: {len(sizes)} sizes")
        faults += 1
    if not file:
        continue  # the garment, below
    for size, changes in sizes.items():
        if bench.PARTICLES[size] > 10000 and not sys.argv[3]:
            continue
        command = [sys.argv[2], "info", "--json", f"{sys.argv[1]}/scenes/{file}.yaml"]
        for change in changes:
            command += ["--set", change]
        cloths = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)["cloths"]
        count, bound = cloths[0]["vertices"], 0.09 if scene == "net" else 0.03
        if len(cloths) != 1 or abs(count / bench.PARTICLES[size] - 1.0) > bound:
            print(f"{scene} {size}: {count} particles")
            faults += 1
sys.exit(faults > 0)
END

# ---- the garment: coarse here, made twice, one mesh without rows with four rims; it starts, and rests on the body ----
python3 - "$TULLE_SOURCE_DIR" <<'END' || fault "the garment's meshes"
import collections, filecmp, math, sys
sys.path.insert(0, sys.argv[1] + "/bench")
import garment
faults = []
for folder in ("garment", "again"):
    garment.write_files(folder, {"2.5k": 0.05}, 0.04, 31)
for name in ("garment.yaml", "dress_2.5k.obj", "body.obj", "body.pc2"):
    if not filecmp.cmp(f"garment/{name}", f"again/{name}", False):
        faults.append(f"{name} is not the same when made again")


def read(name):
    lines = [line.split() for line in open(f"garment/{name}.obj", encoding="ascii")]
    return ([tuple(map(float, words[1:])) for words in lines if words[0] == "v"],
            [tuple(int(word) - 1 for word in words[1:]) for words in lines if words[0] == "f"])


for name, euler in (("dress_2.5k", -2), ("body", 2)):  # of a sphere with four holes; of a sphere
    points, triangles = read(name)
    directed = [(t[k], t[(k + 1) % 3]) for t in triangles for k in range(3)]
    edges = {(min(edge), max(edge)) for edge in directed}
    if len(set(directed)) != len(directed) or len(points) - len(edges) + len(triangles) != euler:
        faults.append(f"{name} is not the surface that it should be")
    valences = collections.Counter(corner for edge in edges for corner in edge)
    lengths = sorted(math.dist(points[a], points[b]) for a, b in edges)
    mean = sum(lengths) / len(lengths)
    if lengths[len(lengths) // 50] < 0.4 * mean or lengths[-len(lengths) // 50] > 1.7 * mean:
        faults.append(f"{name}: triangles are not of even size")
    if name == "body":
        continue
    if sum(n == 6 for n in valences.values()) > 0.5 * len(points):
        faults.append(f"{name} is too regular")
    if sum(abs(a - b) for a, b in edges) < 0.25 * len(points) * len(edges):
        faults.append(f"{name} is not numbered at random")
print(*faults, sep="\n", end="")
sys.exit(len(faults) > 0)
END
"$TULLE" run garment/garment.yaml -o garment/run --frames 45 --threads 1 --progress none >run.out 2>&1 || fault "the garment: $(cat run.out)"
"$TULLE" check garment/run >run.out 2>&1 || fault "the garment crosses something: $(tail -n 3 run.out)"
awk -F, 'NR == 1 { for (k = 1; k <= NF; k++) column[$k] = k } NR > 30 && $column["contacts"] < 60 { exit 1 }' garment/run/report.csv ||
    fault "the garment has few contacts: $(cut -d, -f20 garment/run/report.csv | paste -sd' ')"

# ---- a scene is made in the sizes that it has ----
bench small --particles 0.1k,0.4k --threads 1 --repeat 1 --csv small.csv >/dev/null 2>small.err || fault "small: exit $?: $(cat small.err)"
[ "$(grep -v '^,' small.csv | cut -d, -f1,2 | sort -u | tail -n +2)" = small,0.1k ] || fault "small: $(cut -d, -f1,2 small.csv | sort -u)"
awk -F, '$5 == "contacts" && $6 <= 0 { exit 1 }' small.csv || fault "small: an input without contact"
bench small --particles 2k --threads 1 >/dev/null 2>small.err
grep -q '^bench: small is made in none of these sizes, but in 0.1k, 1k' small.err || fault "small in 2k: $(cat small.err)"

# ---- refused ----
refuse 2 'there is no scene "spheer"; did you mean "sphere"' spheer
refuse 2 'there is no size "3k"' sphere --particles 3k
refuse 2 'there is no size ""' sphere --particles ''
refuse 2 'whole numbers from 1 to 256' sphere --threads 1,0
refuse 2 'whole numbers from 1 to 256' sphere --threads 1,two
refuse 2 '--repeat, --seconds and --steps should be whole numbers from 1' sphere --repeat 0
refuse 2 'missing.csv: cannot be read' sphere --compare missing.csv
printf 'scene,size\n' >foreign.csv
refuse 2 'foreign.csv:1: is no table' sphere --compare foreign.csv
head -c 300 first.csv >cut.csv
refuse 2 'cut.csv:[0-9]*: ' sphere --compare cut.csv
refuse 2 'is no directory' sphere --scenes nowhere
refuse 2 'no/where.csv: cannot be written' sphere --csv no/where.csv
refuse 2 'first.csv cannot be made' sphere --inputs first.csv
if [ "$(id -u)" != 0 ]; then
    mkdir closed && chmod 555 closed
    refuse 3 'cannot be written: Permission denied' spikes --quick --inputs closed
fi
mkdir damaged && for file in bench-inputs/boxes*; do head -c 5000 "$file" >"damaged/${file#*/}"; done
refuse 2 'damaged or cut off.*delete it' boxes --quick --inputs damaged
bench boxes --quick --inputs damaged --renew >/dev/null 2>&1 || fault "--renew: exit $?"

# ---- Ctrl-C: while an input is made, and later; whole cases stay, nothing is half written ----
interrupt() { # WHOLE_CASES WAITED_FOR ARGUMENTS...
    local cases=$1 waited=$2 process code
    shift 2
    rm -rf cut.csv cut-inputs
    "${driver[@]}" "$@" --inputs cut-inputs --csv cut.csv >cut.out 2>cut.err &
    process=$!
    until eval "$waited" || ! kill -0 $process 2>/dev/null; do sleep 0.02; done # a first case may take minutes under a sanitizer
    kill -INT $process
    wait $process
    code=$?
    [ $code = 130 ] || fault "interrupted: exit $code, not 130: $(cat cut.err)"
    grep -q "^bench: interrupted after $cases whole cases" cut.err || fault "interrupted, not said: $(cat cut.err)"
    [ -z "$(find . -name '*.tmp')" ] || fault "interrupted: left $(find . -name '*.tmp')"
}
interrupt 0 '[ -d cut-inputs ]' sphere --particles 9.8k --threads 1
[ -e cut.csv ] && fault "interrupted before the first case: there is a CSV"
[ -z "$(ls cut-inputs)" ] || fault "interrupted: left $(ls cut-inputs)"
interrupt 1 '[ -e cut.csv ]' spikes example_one --particles 0.4k,40k --threads 1 --repeat 2
[ "$(cut -d, -f1,2 cut.csv | sort -u | tail -n +2 | grep -v scene)" = spikes,0.4k ] || fault "interrupted: the CSV has $(cut -d, -f1,2 cut.csv | sort -u)"
bench all --particles all,0.4k --from cut.csv --compare cut.csv >/dev/null 2>&1 || fault "the CSV of an interrupted bench is not read"

[ $faults = 0 ] && echo "bench: as it should"
exit $faults
