#!/usr/bin/env bash
# A run says once, on standard error and in run.json, that a pinch begins and ends and by whom, and
# that cloth is caught in an obstacle that appears in it. No message holds a control character.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >press.yaml <<'SCENE'
time: {step: 1/90 s, frames: 45}
contact: {on_pinch: slow}
cloth:
  - mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [9, 9]}
obstacles:
  - name: lower
    mesh: {shape: box, size: [0.5, 0.5, 0.1]}
    translate: [0, 0, -0.06]
  - name: upper
    mesh: {shape: box, size: [0.5, 0.5, 0.1]}
    translate: [0, 0, 0.06]
    motion: {keyframes: [{time: 0}, {time: 0.2, translate: [0, 0, -0.021]}, {time: 0.4}]}
SCENE
for progress in none json auto; do
    "$TULLE" run press.yaml -o "out_$progress" --progress $progress >stdout 2>stderr || fault "run: $(cat stderr)"
    [ "$(grep -c "'cloth0' is pinched near (.*) m at .* s, between 'lower', 'upper'; scripted" stderr)" = 1 ] ||
        fault "$progress: begin: $(cat stderr)"
    [ "$(grep -c "'lower', 'upper' follow their script again at\|'upper' follows its script again at" stderr)" = 1 ] ||
        fault "$progress: end: $(cat stderr)"
    grep -q "is pinched near" "out_$progress/run.json" || fault "run.json"
    grep -q "^trouble: cloth was pinched between obstacles in [1-9][0-9]* of 45 steps" stdout || fault "summary: $(cat stdout)"
done
"$TULLE" run press.yaml -o out_json --force --progress json 2>&1 >stdout |
    grep -q '^{"event":"message","step":[0-9]*,"time":[0-9.]*,"message":".*pinched.*"}$' || fault "JSON"

cat >caught.yaml <<'SCENE'
time: {step: 1/90 s, frames: 20}
contact: {start_intersections: ignore}
cloth:
  - mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [9, 9]}
obstacles:
  - name: late
    mesh: {shape: box, size: [0.1, 0.1, 0.3]}
    appears: 0.1
SCENE
"$TULLE" run caught.yaml -o caught --progress none >stdout 2>stderr || fault "caught: $(cat stderr)"
[ "$(grep -c "'cloth0' is caught at 0.1 s in 'late', which appears there: [0-9]* pairs" stderr)" = 1 ] || fault "caught: $(cat stderr)"

# A start that leaves less than the least contact distance is told by info, run and its summary.
cat >near.yaml <<'SCENE'
time: {step: 1/90 s, frames: 1}
cloth:
  - {name: sheet, mesh: {shape: rectangle, size: [1, 1], resolution: [11, 11]}, translate: [0, 0, 0.2 mm]}
obstacles:
  - {name: table, mesh: {shape: plane, size: [2, 2]}}
SCENE
told="'sheet' lies 0.2 mm from 'table' at the start.*give the cloth a thickness of 0.2 mm"
"$TULLE" info near.yaml 2>stderr >stdout && grep -q "$told" stderr || fault "info of a narrow start: $(cat stderr)"
"$TULLE" run near.yaml -o near --progress json >stdout 2>stderr || fault "near: $(cat stderr)"
grep -q "^{\"event\":\"message\".*$told" stderr || fault "a narrow start in JSON: $(cat stderr)"
grep -q "^first message: $told" stdout || fault "the summary of a narrow start: $(cat stdout)"
"$TULLE" info near | grep -q "^  first message  *$told" || fault "info of its run: $("$TULLE" info near)"
"$TULLE" run near.yaml -o wide --set 'cloth[0].thickness=0.2 mm' >stdout 2>&1 || fault "wide: $(cat stdout)"
grep -q 'lies\|first message' stdout && fault "a narrow start with a thickness is told: $(cat stdout)"

# A stranger's run.json: its words move no cursor.
cp -r caught strange
sed -i 's/"name": "cloth0"/"name": "cl\\u001b[2J\\u009both"/; s/"scene_path": "caught/"scene_path": "\\u0007\\ncaught/' strange/run.json
python3 "$TULLE_SOURCE_DIR/test/e2e/seal.py" strange/run.json
for command in 'info strange' 'check strange' 'convert strange/ x.ply --frame 1' 'convert strange x.ply --body nope --frame 1'; do
    "$TULLE" $command >shown 2>&1
    grep -q 'cl?\[2J??oth\|"nope"\|strange/' shown || fault "$command: no name in: $(cat -v shown)"
    LC_ALL=C grep -q $'\x1b\|\xc2\x9b\|\x07' shown && fault "$command: a control character: $(cat -v shown)"
done
"$TULLE" info strange | grep -q 'scene  *??caught.yaml' || fault "info: $("$TULLE" info strange | cat -v)"

# So do those of a scene, of a table of measures, and of the command line.
printf 'time: {frames: 1}\n"k\\u009b31mey": 1\ncloth: [{mesh: {file: "\\e[31mq.obj"}, nmae: "a\\u009bb"}]\n' >strange.yaml
cp strange.yaml $'\e[31m.yaml'
printf 'scene,size,threads,kind,name,value,minimum,spread\n\e[31mX,1k,1,time,step,1,1,0\n' >strange.csv
show() {
    "$TULLE" "$@" >shown 2>&1
    [ -s shown ] || fault "$*: nothing is shown"
    LC_ALL=C grep -q $'\x1b\|\xc2\x9b' shown && fault "$*: a control character: $(cat -v shown)"
}
show run strange.yaml -o none
show info strange.yaml
grep -q 'k??31mey: unknown key' shown || fault "no key: $(cat -v shown)"
show info $'\e[31m.yaml'
show bench strange.yaml
show bench --from strange.csv
show $'\e[31m'
[ $faults = 0 ] && echo "pinches and what is caught are told"
exit $faults
