#!/usr/bin/env bash
# paper/reproduce over small scenes with the names of the paper's: resumes, its tables, its report, missing scenes.
set -uo pipefail
PYTHONPATH=$TULLE_PYTHON sh "$TULLE_SOURCE_DIR/paper/find_python.sh" 'matplotlib, tulle' >/dev/null ||
    { echo "skipped: no python3 with numpy, cffi and matplotlib"; exit 77; }
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work"
faults=0
modules= # where Python looks for modules first
fail() { echo "$*"; faults=1; }
reproduce() { sh "$TULLE_SOURCE_DIR/paper/reproduce.sh" --tulle "$TULLE" --measure "$TULLE_PAPER_MEASURE" "$@"; }

# write_scene NAME: a sheet falls on a spike.
write_scene() {
    cat >"scenes/$1.yaml" <<END_OF_SCENE
title: $1
time: {step: 0.02 s, frames: 6}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [9, 9]}
    translate: [0.02, 0.01, 0.12]
obstacles:
  - name: ground
    mesh: {shape: plane, size: [2, 2]}
    friction: $2
  - name: spike
    mesh: {shape: tetrahedron, radius: 0.05, height: 0.11}
    translate: [-0.1, 0, 0.001]
    friction: $2
END_OF_SCENE
}

# expect CODE PATTERN ARGUMENTS...: exit code, and a line of either output. Where Embree is not there, 2 stands for 0.
expect() {
    local code=$1 pattern=$2
    shift 2
    PYTHONPATH=$modules reproduce "$@" >out 2>&1
    local found=$?
    [ "$code" = 0 ] && grep -q 'no stills are made' out && code=2
    [ $found = "$code" ] || { fail "reproduce $*: exit $found, expected $code"; tail -20 out; }
    [ -z "$pattern" ] || grep -Eq -- "$pattern" out || { fail "reproduce $*: no \"$pattern\" in:"; tail -20 out; }
}

# columns FILE HEADER: the table's first line.
columns() { [ "$(head -n 1 "$1" 2>/dev/null)" = "$2" ] || fail "$1: its columns are $(head -n 1 "$1" 2>&1)"; }

mkdir scenes
expect 2 'no directory' all --scenes nowhere
expect 2 'did you mean "fig7"' fig77 --scenes scenes
expect 2 '-o: missing/folder cannot be made' table1 --scenes scenes -o missing/folder
touch file
expect 2 '-o: file cannot be made or written to: Not a directory' table1 --scenes scenes -o file
mkdir half
touch half/measured
expect 2 '-o: half/measured cannot be made or written to: Not a directory' table1 --scenes scenes -o half
if [ "$(id -u)" != 0 ]; then # to root every directory can be written
    mkdir locked
    chmod 500 locked
    expect 2 '-o: locked/runs cannot be made or written to: Permission denied' table1 --scenes scenes -o locked
fi
expect 2 'size' fig8 --scenes scenes --size 16
expect 2 'should be a whole number from 1 to 256' fig8 --scenes scenes --threads 0
expect 2 'nowhere/tulle cannot be read' fig8 --scenes scenes -o none.d --tulle nowhere/tulle
expect 0 'usage: reproduce' --help

# Without any scene the motions made for it are there, and what is missing is named.
expect 2 'scenes/animation_3.yaml is missing' counterexamples --scenes scenes -o bare
columns bare/counterexamples_motions.csv motion,triangles,intersections_start,intersections_end,collisions,paper_patches,paper_found,paper_missed,proven_missed
# Both are clean at both ends, collide in between, and the paper's rule misses all of it; what is proven misses nothing.
[ "$(grep -cE '^(ramp|ring),768,0,0,([0-9]+),1,0,\2,0$' bare/counterexamples_motions.csv)" = 2 ] ||
    { fail "motions:"; cat bare/counterexamples_motions.csv; }
grep -q '^r[a-z]*,768,0,0,[1-9]' bare/counterexamples_motions.csv || fail "the motions collide nowhere"

for name in rings ribbons animation_1 animation_2 animation_3 animation_4 animation_5 animation_6; do
    write_scene $name 0.02
done
write_scene example_one 0.02

# A scene that cannot be read is told before anything runs.
cp -R scenes broken
echo 'cloth: 7' >broken/animation_6.yaml
expect 2 '^broken/animation_6.yaml:1:8: cloth: ' all --scenes broken -o broken.d
[ -z "$(ls broken.d/runs)" ] || fail "scenes run although one cannot be read"

# All of it.
expect 0 'report: out.d/report.html' all --scenes scenes -o out.d --size 16x10
columns out.d/counterexamples_scenes.csv run,frames,contact_distance_mm,events,paper_patches,paper_found,paper_missed,frames_with_missed,proven_missed
[ "$(wc -l <out.d/counterexamples_scenes.csv)" = 11 ] || fail "counterexamples: a scene is missing"
[ "$(cut -d, -f9 out.d/counterexamples_scenes.csv | sort -u | tr '\n' ' ')" = '0 proven_missed ' ] || fail "something proven was missed"
columns out.d/runs.csv run,state,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,frames,simulated_seconds,step_seconds,rescues_per_1000_contacts,bad_frames,intersections,time_step,conditions
grep -q '^rings,finished,81,128,8,6,7,0.12,' out.d/runs.csv || fail "runs.csv tells wrong sizes of rings"

columns out.d/table1.csv animation,method,cloth_particles,cloth_triangles,obstacle_particles,obstacle_triangles,steps,cs_ms,dyn_ms,cgm_ms,step_ms,state,bad_frames,conditions
[ "$(wc -l <out.d/table1.csv)" = 25 ] || fail "table 1: not four methods of six animations"
columns out.d/table1_ranking.csv animation,paper_ranking,our_ranking,verdict,with_patches,same_work_ratio
columns out.d/fig6.csv run,stick_share,mean_way,centre_height
columns out.d/fig6_frames.csv run,frame,time,stick_share,mean_way,centre_height
columns out.d/fig7_angles.csv rules,angle,self_ms,self_run_seconds,partition_percent,trees_percent,traversal_percent,intrinsic_percent,patches,patch_triangles_percent,events,published_self_ms,published_self_run_seconds
[ "$(wc -l <out.d/fig7_angles.csv)" = 53 ] || fail "fig. 7: not four rules at 13 angles"
grep -qE '^paper,85,.*,230,540$' out.d/fig7_angles.csv || fail "fig. 7: the paper's numbers are not beside ours"
grep -qE '^paper,89,.*,260,$' out.d/fig7_angles.csv || fail "fig. 7: the paper's time at 89 degrees is not beside ours"
columns out.d/fig7_high.csv "$(head -n 1 out.d/fig7_angles.csv)"
[ "$(wc -l <out.d/fig7_high.csv)" = 13 ] || fail "fig. 7: not four rules at three angles with high friction"
columns out.d/fig7_frames.csv rules,angle,frame,time,self_ms,total_ms
[ "$(wc -l <out.d/fig7_frames.csv)" = 73 ] || fail "fig. 7: not six frames at three angles by four rules"
columns out.d/fig7_totals.csv rules,angle,total_ms,self_run_seconds,total_run_seconds,ratio_to_30,published_self_run_seconds,published_total_run_seconds,published_ratio_to_30
columns out.d/fig7_findings.csv finding,ours,published,verdict

# What table 1 says of the ranking follows from its numbers; the report is well-formed, holds the numbers of the tables, and
# points nowhere else.
cat >check.py <<'END_OF_PYTHON'
import base64, csv, glob, os, re, sys
import xml.etree.ElementTree as tree
from xml.sax.saxutils import unescape
faults = 0
def fail(text):
    global faults
    print(text)
    faults = 1
costs, cgm = {}, {}
for row in csv.DictReader(open("out.d/table1.csv")):
    costs.setdefault(row["animation"], {})[row["method"]] = float(row["cs_ms"])
    cgm.setdefault(row["animation"], {})[row["method"]] = float(row["cgm_ms"])
    parts = [float(row[column]) for column in ("cs_ms", "dyn_ms", "cgm_ms")]
    if min(parts) <= 0 or sum(parts) > 1.01 * float(row["step_ms"]): fail(f"parts of a step {row}")
for row in csv.DictReader(open("out.d/table1_ranking.csv")):
    noise = float(row["same_work_ratio"])
    for column, count in (("our_ranking", 3), ("with_patches", 4)):
        ranked, signs = re.split(" [<~] ", row[column]), re.findall(" ([<~]) ", row[column])
        values = [costs[row["animation"]][method] for method in ranked]
        if len(ranked) != count or values != sorted(values): fail(f"ranking {row}")
        for less, more, sign in zip(values, values[1:], signs): # the table's numbers are rounded
            if abs(more / (noise * less) - 1) > 0.01 and (more > noise * less) != (sign == "<"): fail(f"sign {row}")
    solves = [cgm[row["animation"]][method] for method in ("bvox", "refit", "patches")]
    if abs(float(row["same_work_ratio"]) / (max(solves) / min(solves)) - 1) > 0.01: fail(f"same work {row}")
    claimed = [costs[row["animation"]][method] for method in row["paper_ranking"].split(" < ")]
    pairs = [(claimed[a], claimed[b]) for a in range(3) for b in range(a + 1, 3)]
    verdict = ("not confirmed" if any(a > noise * b for a, b in pairs) else
               "confirmed" if all(b > noise * a for a, b in pairs) else "within the noise")
    is_near = any(abs(a / (noise * b) - 1) < 0.01 or abs(b / (noise * a) - 1) < 0.01 for a, b in pairs)
    if row["verdict"] != verdict and not is_near: fail(f"verdict {row}")
# So do the findings of Fig. 7.
means = {(row["rules"], row["angle"]): float(row["self_ms"]) for row in csv.DictReader(open("out.d/fig7_angles.csv"))}
found = {row["finding"]: row for row in csv.DictReader(open("out.d/fig7_findings.csv"))}
same = [value for (rules, _), value in means.items() if rules == "bvox"]
noise = float(found["same work at all angles (bvox): longest over shortest"]["ours"])
if abs(noise / (max(same) / min(same)) - 1) > 0.01: fail("fig. 7: same work")
for angle in ("85", "89"):
    row = found[f"time at 30 degrees over time at {angle}"]
    ratio = means["paper", "30"] / means["paper", angle]
    if abs(float(row["ours"]) / ratio - 1) > 0.01: fail(f"fig. 7: {row}")
    verdict = "yes" if ratio > noise else "no" if ratio * noise < 1 else "within the noise"
    if row["verdict"] != verdict and min(abs(ratio / noise - 1), abs(ratio * noise - 1)) > 0.01: fail(f"fig. 7: {row}")
page = tree.parse("out.d/report.html").getroot()
tables = {table.get("id"): [[cell.text or "" for cell in row] for row in table] for table in page.iter("table") if table.get("id")}
shown = 0
for name in ("runs", "table1", "table1_ranking", "fig6", "fig6_findings", "fig7_angles", "fig7_totals", "fig7_findings", "fig7_high",
             "counterexamples_motions", "counterexamples_scenes"):
    rows = [line.rstrip("\n").split(",") for line in open(f"out.d/{name}.csv")]
    if tables.get(name, [])[1:] != rows[1:] or len(rows) < 2: fail(f"report: table {name} differs from its file")
    shown += 1
names = []
for element in page.iter():
    for key, value in element.attrib.items():
        if key == "id": names.append(value)
        if re.search(r"(src|href)$", key) and not re.match(r"data:image/(png|svg\+xml);base64,", value): fail(f"link to {value[:60]}")
        if "url(" in value and "url(#" not in value: fail(f"link to {value[:60]}")
if len(names) != len(set(names)): fail("names of elements stand twice")
text = open("out.d/report.html").read()
if re.search(r"https?:", re.sub(r'xmlns(:xlink)?="http[^"]*"', "", text)): fail("an address stands in the report")
pictures = {base64.b64decode(e.get("src").partition(",")[2]) for e in page.iter() if e.tag == "img"}
def all_shown(pattern):
    files = glob.glob(pattern)
    for file in files:
        if open(file, "rb").read() not in pictures: fail(f"{file} is not in the report")
    return len(files)
plots, stills = all_shown("out.d/*.svg"), all_shown("out.d/stills/*.png")
if sum(e.tag == "img" for e in page.iter()) != plots + stills: fail("pictures of no file are in the report")
for file in glob.glob("out.d/*.svg"):
    if not tree.parse(file).getroot().tag.endswith("}svg"): fail(f"{file} is no plot")
    links = re.findall(r'(?:src|href)="(?!#)[^"]*"|url\((?!#)[^)]*\)', open(file).read())
    if links: fail(f"{file}: links to {links}")
print(f"report: {shown} tables, {plots} plots, {stills} stills")
sys.exit(faults)
END_OF_PYTHON
python3 check.py || fail "the report"
[ "$(ls out.d/*.svg | wc -l)" = 6 ] || fail "not six plots"

# Without matplotlib that is said, all else is there, and an old plot does not stay beside new tables.
mkdir empty bare_python bare_python/matplotlib
echo 'raise ImportError' >bare_python/matplotlib/__init__.py
cp -R out.d plain.d
modules=$work/bare_python
expect 2 "no plots are drawn: Python's matplotlib is not there" table1 --scenes scenes -o plain.d
[ -s plain.d/table1.csv ] && [ ! -e plain.d/table1.svg ] || fail "without matplotlib something is wrong"
mkdir bare_python/numpy
echo 'raise ImportError' >bare_python/numpy/__init__.py
expect 2 'there is no python3 with numpy' table1 --scenes scenes -o plain.d
modules=

# What is not whole does not get into the report: a plot is left out, a still made again.
if [ -e out.d/fig6.svg ]; then
    cp -R out.d cut.d
    truncate -s -20 cut.d/fig6.svg
    expect 2 'fig6.svg is not whole' table1 --scenes scenes -o cut.d
    python3 -c 'import xml.etree.ElementTree as tree; tree.parse("cut.d/report.html")' || fail "a cut plot breaks the report"
    grep -q '(fig6.svg)' cut.d/report.html && fail "a cut plot is in the report"
fi
if [ -e out.d/stills/rings_0006.png ]; then
    cp -R out.d cut_still.d
    truncate -s 60 cut_still.d/stills/rings_0006.png
    expect 0 '' fig9 --scenes scenes -o cut_still.d --size 16x10
    cmp -s {out,cut_still}.d/stills/rings_0006.png || fail "a cut still was kept"
fi

# Notes of whoever made the results stand in the report.
cp -R out.d notes.d
echo 'one < two & three' >notes.d/notes.txt
expect 0 '' counterexamples --scenes scenes -o notes.d
grep -q '<p>one &lt; two &amp; three</p>' notes.d/report.html || fail "notes are not in the report"

# Stills of another size are made again.
if [ -e out.d/stills/rings_0006.png ]; then
    cp -R out.d larger.d
    expect 0 '' fig9 --scenes scenes -o larger.d --size 24x16
    python3 -c 'import sys; sys.exit(open("larger.d/stills/rings_0006.png", "rb").read()[16:24] != bytes([0, 0, 0, 24, 0, 0, 0, 16]))' || fail "a still of another size was kept"
    cmp -s {out,larger}.d/stills/animation_1.patches_0006.png || fail "a still that nobody asked for was made again"
fi

# A film of each scene by one command; without ffmpeg that is said.
if ! "$TULLE" render out.d/runs/rings --size 16x10 --samples 1 2>&1 | grep -q 'without Embree'; then
    for name in example_one_{low,high}_friction animation_{1..6}.patches rings ribbons; do
        command -v ffmpeg >/dev/null || break
        "$TULLE" render out.d/runs/$name -o $name.mp4 --size 16x10 --samples 1 --subdivide 1 >film.out 2>&1 && [ -s $name.mp4 ] ||
            { fail "no film of $name:"; cat film.out; }
    done
    PATH=$work/empty "$TULLE" render out.d/runs/rings -o none.mp4 --size 16x10 >film.out 2>&1
    code=$?
    [ $code = 2 ] && [ ! -e none.mp4 ] && grep -q 'films need the program ffmpeg' film.out || { fail "without ffmpeg: exit $code"; cat film.out; }
fi

# What is whole is not run or judged again; what was cut short goes on to the same state.
cp -R out.d/runs/rings whole
sed -i 's/"state": *"finished"/"state": "interrupted"/' out.d/runs/rings/run.json
python3 "$TULLE_SOURCE_DIR/test/e2e/seal.py" out.d/runs/rings/run.json
expect 0 '"run":"ribbons","what":"is there"' counterexamples --scenes scenes -o out.d
grep -q '"run":"rings","what":"runs"' out || fail "a run that was cut short did not go on"
grep -q 'is judged' out && fail "a judged run was judged again"
cmp -s whole/sheet.pc2 out.d/runs/rings/sheet.pc2 || fail "the resumed run differs"

# Another scene than the one that a run was made of is refused, not mixed in; nor are its conditions.
sed -i 's/translate: \[0.02/translate: [0.03/' scenes/rings.yaml
cp out.d/made/rings.csv made.csv
expect 2 'scene' fig9 --scenes scenes -o out.d --size 16x10 --threads 3
cmp -s made.csv out.d/made/rings.csv || { fail "a refused command is noted as one that made the run:"; cat out.d/made/rings.csv; }
sed -i 's/translate: \[0.03/translate: [0.02/' scenes/rings.yaml

# Ctrl-C ends a long run with 130 and keeps its frames.
mkdir long
sed 's/frames: 6/frames: 1000000/' scenes/rings.yaml >long/rings.yaml
cp scenes/ribbons.yaml long
sh "$TULLE_SOURCE_DIR/paper/reproduce.sh" --tulle "$TULLE" --measure "$TULLE_PAPER_MEASURE" fig9 --scenes long -o long.d >long.out 2>&1 &
process=$!
for _ in $(seq 600); do
    [ "$(cat long.d/runs/rings/frames.csv 2>/dev/null | wc -l)" -gt 4 ] && break
    sleep 0.1
done
kill -INT $process
wait $process
found=$?
[ $found = 130 ] || { fail "interrupted: exit $found, expected 130"; tail -5 long.out; }
grep -q '"state":"interrupted"' long.out || fail "the run does not say that it was interrupted"
"$TULLE" check long.d/runs/rings >/dev/null || fail "the frames of an interrupted run are not whole"

# Without the reports of all steps nothing is said of times: no ranking, no share of contacts that stick.
cp -R out.d untold.d
rm untold.d/runs/animation_1.bvox/report.csv
sed -i 4q untold.d/runs/animation_2.paper/report.csv
echo rubbish >untold.d/runs/animation_3.refit/report.csv
head -n 1 out.d/runs/example_one_high_friction/report.csv >untold.d/runs/example_one_high_friction/report.csv
expect 2 'runs/animation_1.bvox: .*its times are not known' table1 fig6 --scenes scenes -o untold.d --size 16x10
for run in animation_2.paper animation_3.refit example_one_high_friction; do
    grep -q "runs/$run: .*its times are not known" out || fail "nothing is said of the report of $run"
done
[ "$(cut -d, -f1,3,4 untold.d/table1_ranking.csv | grep ',,' | tr '\n' ' ')" = '1,,not compared 2,,not compared 3,,not compared ' ] ||
    { fail "ranked without times:"; cat untold.d/table1_ranking.csv; }
[ "$(cut -d, -f1-2,7-11 untold.d/table1.csv | grep -c ',0,,,,$')" = 3 ] || { fail "times that nothing tells:"; cat untold.d/table1.csv; }
[ "$(wc -l <untold.d/table1.csv)" = 25 ] || fail "table 1 lacks runs"
grep -qE '^animation_1.bvox,finished,.*,7,,,,0,0,' untold.d/runs.csv || { fail "runs.csv:"; cat untold.d/runs.csv; }
grep -qE '^more contacts stick with high friction,,,not known$' untold.d/fig6_findings.csv || { fail "fig. 6:"; cat untold.d/fig6_findings.csv; }
grep -qE '^example_one_high_friction,,0' untold.d/fig6.csv || { fail "fig. 6:"; cat untold.d/fig6.csv; }
[ "$(wc -l <untold.d/fig6_frames.csv)" = 13 ] || fail "fig. 6 lacks frames"

# A figure that fails leaves its tables as they were.
cp -R out.d failed.d
python3 - failed.d/runs/example_one_high_friction/sheet.pc2 <<'END_OF_PYTHON'
import struct, sys
data = bytearray(open(sys.argv[1], "rb").read())
struct.pack_into("<3f", data, 32 + 12 * 81 * 4, *3 * [float("nan")])
open(sys.argv[1], "wb").write(data)
END_OF_PYTHON
expect 2 'is not finite' fig6 --scenes scenes -o failed.d --size 16x10
cmp -s {out,failed}.d/fig6_frames.csv || { fail "a table of half of the frames:"; wc -l failed.d/fig6_frames.csv; }

# A frame that intersects is seen.
cp -R out.d bad.d
rm bad.d/judged/rings.csv
python3 - bad.d/runs/rings/sheet.pc2 <<'END_OF_PYTHON'
import struct, sys
data = bytearray(open(sys.argv[1], "rb").read())
vertices = struct.unpack_from("<i", data, 16)[0]
offset = 32 + 12 * vertices * 6
struct.pack_into("<3f", data, offset, -0.1, 0.0, -0.5)
open(sys.argv[1], "wb").write(data)
END_OF_PYTHON
python3 "$TULLE_SOURCE_DIR/test/e2e/seal.py" bad.d/runs/rings/run.json sheet.pc2
expect 0 '' counterexamples --scenes scenes -o bad.d
grep -qE '^rings,.*,1,[1-9][0-9]*,0.02,[0-9a-f]{8}$' bad.d/runs.csv || { fail "an intersecting frame was not seen"; grep rings bad.d/runs.csv; }

[ $faults = 0 ] && echo "paper: all as expected"
exit $faults
