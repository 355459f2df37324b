#!/usr/bin/env bash
# Bodies that pass through themselves with cloth between (scenes/characters): the runs go to their ends, no frame has a crossing with what
# the cloth met, next to nothing is rescued or thrown, and crossings with the drawn body are listed apart. The sleeve alone, of coarser
# cloth than the scene has, unless TULLE_TEST_LONG is set.
set -uo pipefail
python3 -c '' 2>/dev/null || { echo "skipped: the bodies are made by python3, which is not there"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cp "$TULLE_SOURCE_DIR"/scenes/characters/*.yaml . || exit 1
python3 "$TULLE_SOURCE_DIR/scenes/characters/make_bodies.py" . >made || fault "bodies: $(cat made)"

cat >judge.py <<'JUDGE'
"""What a run must have kept: judge.py RUN CLOTH LEAST_LAG MOST_LAG"""
import array, csv, math, struct, sys

run, cloth, least, most = sys.argv[1], sys.argv[2], float(sys.argv[3]), float(sys.argv[4])

def read_cache(name):
    data = open(f"{run}/{name}.pc2", "rb").read()
    count = struct.unpack("<i", data[16:20])[0]
    numbers = array.array("f")
    numbers.frombytes(data[32:])
    return [numbers[i:i + 3 * count] for i in range(0, len(numbers), 3 * count)]

def fastest(before, after):
    return math.sqrt(max(sum((after[i + k] - before[i + k])**2 for k in range(3)) for i in range(0, len(after), 3)))

reports = list(csv.DictReader(open(f"{run}/report.csv")))
frames = list(csv.DictReader(open(f"{run}/frames.csv")))
lags = [float(r["largest_lag"]) for r in reports]
assert least < max(lags) < most, f"the largest lag is {max(lags)} m"
assert lags[-1] == 0.0, f"a lag of {lags[-1]} m is left"
contacts = sum(int(r["contacts"]) for r in reports)
rescues = sum(int(r[f"rescue_{kind}"]) for r in reports
              for kind in ("impact_zones", "component_scalings", "global_scalings"))
assert contacts > 10000 and 1000 * rescues < contacts, f"{rescues} rescues in {contacts} contacts"
assert any(int(f["lags"].split(":")[3]) > 20 for f in frames if f["lags"]), "as drawn nothing crosses"
assert sum(r["pinched"] == "1" for r in reports) < len(reports) * 0.7
body, sheet = read_cache("body"), read_cache(cloth)
speed = max(fastest(body[i - 1], body[i]) for i in range(1, len(body)))
for i in range(1, len(sheet)):
    if frames[i]["lags"]:
        way = fastest(sheet[i - 1], sheet[i])
        assert way < 3 * speed, f"frame {i}: cloth goes {way} m, the lagging surface {speed} m at most"
JUDGE

run() { # SCENE CLOTH COARSE_RESOLUTION LEAST_LAG MOST_LAG
    local set=(--set "cloth[0].mesh.resolution=$3")
    [ -n "${TULLE_TEST_LONG:-}" ] && set=()
    "$TULLE" run "$1.yaml" -o "$1" --progress none "${set[@]}" >stdout 2>stderr || fault "$1: $(cat stderr)"
    grep -q "'body' leaves cloth no room near (.*) m at .* s; there it lags behind its frames (on_pinch: lag)" stderr ||
        fault "$1 does not say where it lags: $(cat stderr)"
    grep -q "^trouble: cloth was pinched .*; obstacles lagged behind their path there, by .* mm at most at " stdout ||
        fault "$1 does not say at its end that it lagged: $(cat stdout)"
    "$TULLE" check "$1" >judged || fault "$1: $(grep -v '0 intersections' judged)"
    grep -q "^  apart: body lags behind its frames by .* mm at vertex [0-9]*; as drawn it crosses cloth in [0-9]* pairs$" judged ||
        fault "$1: nothing is listed apart"
    "$TULLE" check --json "$1" >lines
    grep -q '"lags":\[{"body":"body","vertex":[0-9]*,"lag":[0-9.e-]*,"drawn_crossings":[0-9]*}\]' lines ||
        fault "$1: nothing is listed apart in JSON"
    python3 judge.py "$1" "$2" "$4" "$5" || fault "$1: see above"
}

run sleeve sleeve '[32, 34]' 0.025 0.045
if [ -n "${TULLE_TEST_LONG:-}" ]; then
    run skirt skirt '[64, 36]' 0.01 0.03
    run trousers trousers '[44, 54]' 0.05 0.13
fi
"$TULLE" run sleeve.yaml -o stopped --progress none --set contact.on_pinch=stop --set 'cloth[0].mesh.resolution=[32, 34]' >stdout 2>stderr
[ $? = 3 ] || fault "on_pinch: stop does not stop the sleeve"
exit $faults
