#!/usr/bin/env bash
# tulle run --from: the frames of another run to the byte, then on from there with other values; it is resumed, judged, and its source
# is left alone.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

cat >scene.yaml <<'END'
time: {step: 1/90 s, steps_per_frame: 2, frames: 24}
cloth:
  - {name: sheet, mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [13, 13]}, translate: [0, 0, 0.2], thickness: 4 mm}
  - {name: upper, mesh: {shape: rectangle, size: [0.3, 0.3], resolution: [9, 9]}, translate: [0, 0, 0.3], thickness: 4 mm}
obstacles:
  - {name: ball, mesh: {shape: sphere, radius: 0.1, resolution: [12]}}
  - {name: bar, mesh: {shape: box, size: [0.1, 0.1, 0.1]}, translate: [0.4, 0, 0.1], motion: {keyframes: [{time: 0}, {time: 1, translate: [-0.1, 0, 0]}]}}
END
sed 's/name: sheet,/name: sheet, material: {preset: silk},/; s/translate: \[-0.1, 0, 0\]/translate: [0.3, 0, 0]/' scene.yaml >changed.yaml
cat >>changed.yaml <<'END'
  - {name: late, mesh: {shape: box, size: [0.05, 0.05, 0.05]}, translate: [-0.5, 0, 0.1], motion: {keyframes: [{time: 0}, {time: 2, translate: [0.1, 0, 0]}]}}
END
run() { "$TULLE" run "$@" --progress none --threads 1; }
# head FILE: the bytes of the first eleven frames of a cache of so many vertices
frames() { tail -c +33 "$1" | head -c $((11 * 12 * $2)); }

run scene.yaml -o first --record velocities >first.out || fault "the first run: exit $?"
cp -r first kept
run changed.yaml --from first:10 -o second --record velocities >second.out || fault "the second run: exit $?"
diff -r first kept || fault "the source was changed"
for cloth in "sheet 169" "upper 81"; do
    read -r name count <<<"$cloth"
    cmp -s <(frames "first/$name.pc2" "$count") <(frames "second/$name.pc2" "$count") || fault "$name: the first frames differ"
    cmp -s "first/$name.pc2" "second/$name.pc2" && fault "$name: no later frame differs"
done
cmp -s <(frames first/bar.pc2 8) <(frames second/bar.pc2 8) || fault "bar: the first frames differ"
cmp -s <(head -12 first/frames.csv | cut -d, -f1-4) <(head -12 second/frames.csv | cut -d, -f1-4) || fault "frames.csv differs at its beginning"
cmp -s <(head -21 first/report.csv) <(head -21 second/report.csv) || fault "report.csv differs at its beginning"
[ "$(wc -l <second/report.csv)" = 49 ] || fault "report.csv has $(wc -l <second/report.csv) lines"
[ "$(sed -n 12p second/frames.csv | cut -d, -f5)" = 4 ] || fault "what is new is there in frame 10"
[ -z "$(sed -n 13p second/frames.csv | cut -d, -f5)" ] || fault "what is new is absent in frame 11"
grep -q '"message": "frames 0 to 10 come from the run first, of the scene with the hash [0-9a-f]\{16\}"' second/run.json ||
    fault "run.json says nothing of it"
"$TULLE" check second >check.out || fault "it is not clean: $(tail -1 check.out)"
"$TULLE" info second | grep -q 'files  *as the run wrote them' || fault "its files are not sound"

# Interrupted and resumed it comes to the same; --from is not looked at any more.
run changed.yaml --from first:10 -o third --record velocities -n 15 >/dev/null || fault "a shorter run: exit $?"
rm -r first
run changed.yaml --from first:10 -o third --record velocities --resume >third.out || fault "resumed: exit $?"
cmp -s second/sheet.pc2 third/sheet.pc2 || fault "what is resumed differs"
[ "$(tail -1 second.out)" = "$(tail -1 third.out)" ] || fault "it ends in another state"

# Debug records go along where the bodies are the same; without a frame the last one counts.
mv kept first
run scene.yaml -o debug --record debug -n 6 >/dev/null || fault "a run with debug records: exit $?"
run scene.yaml --from debug -o on --record debug >/dev/null || fault "from debug records: exit $?"
head -c 4000 debug/debug.bin | cmp -s - <(head -c 4000 on/debug.bin) || fault "debug records are not copied"
"$TULLE" check on >check.out || fault "it is not clean: $(tail -1 check.out)"
"$TULLE" render on --frame 3 --color contacts --size 64x48 --samples 1 -o on.png >/dev/null 2>render.err || grep -q 'png' render.err || fault "contacts of a copied frame: $(cat render.err)"

# Rigid bodies go on with their places and velocities.
sed 's/  - {name: bar.*/  - {name: crate, mesh: {shape: box, size: [0.08, 0.08, 0.08]}, translate: [0.05, 0, 0.5], dynamic: {mass: 50 g, spin: [2, 1, 0]}}\n  - {name: slab, mesh: {shape: box, size: [0.1, 0.1, 0.05]}, translate: [-0.7, 0, 0.5], dynamic: {mass: 100 g}}/' scene.yaml >bodies.yaml
run bodies.yaml -o thrown --record velocities >/dev/null || fault "a run with bodies: exit $?"
run bodies.yaml --from thrown:10 -o caught --record velocities --set 'cloth[0].material.preset=silk' >/dev/null || fault "from bodies: exit $?"
# rows FILE: bodies.csv up to the frame, of places and motions
cmp -s <(awk -F, 'NR == 1 || $1 <= 10' thrown/bodies.csv) <(awk -F, 'NR == 1 || $1 <= 10' caught/bodies.csv) || fault "the first frames of the bodies differ"
cmp -s thrown/bodies.csv caught/bodies.csv && fault "no later frame of the bodies differs"
[ "$(wc -l <thrown/bodies.csv)" = "$(wc -l <caught/bodies.csv)" ] || fault "bodies.csv has another number of lines"
cmp -s <(frames thrown/crate.pc2 8) <(frames caught/crate.pc2 8) || fault "crate: the first frames differ"
awk -F, 'FNR > 1 && $2 == 4 { if (FNR == NR) fall[$1] = $5; else { n++; if (($5 - fall[$1]) ^ 2 > 1e-8) bad = 1 } } END { exit bad || n != 25 }' \
    thrown/bodies.csv caught/bodies.csv || fault "what meets nothing falls otherwise"
"$TULLE" check caught >check.out || fault "it is not clean: $(tail -1 check.out)"
run bodies.yaml --from thrown:10 -o short --record velocities --set 'cloth[0].material.preset=silk' -n 15 >/dev/null || fault "a shorter run with bodies: exit $?"
run bodies.yaml --from thrown:10 -o short --record velocities --set 'cloth[0].material.preset=silk' --resume >/dev/null || fault "resumed with bodies: exit $?"
cmp -s caught/bodies.csv short/bodies.csv || fault "resumed bodies differ"

# Other steps, as many frames a second: frames are taken over, steps counted anew; on from there it is resumed.
finer=(--set time.step=1/225 --set time.steps_per_frame=5 --set 'cloth[0].material.preset=silk')
run bodies.yaml --from thrown:10 -o finer --record velocities "${finer[@]}" >finer.out || fault "finer steps: exit $?"
cmp -s <(frames thrown/sheet.pc2 169) <(frames finer/sheet.pc2 169) || fault "finer steps: the first frames differ"
cmp -s <(head -12 thrown/frames.csv | cut -d, -f2,4) <(head -12 finer/frames.csv | cut -d, -f2,4) || fault "finer steps: other times or hashes"
[ "$(tail -n +2 finer/frames.csv | cut -d, -f3 | tr '\n' ' ')" = "$(seq -s ' ' 0 5 120) " ] || fault "finer steps: they are counted $(cut -d, -f3 finer/frames.csv | tr '\n' ' ')"
[ "$(sed -n '2p;$p' finer/report.csv | cut -d, -f1 | tr '\n' ' ')" = "50 119 " ] || fault "finer steps: reports of others"
[ "$(wc -l <finer/frames.csv)" = 26 ] || fault "finer steps: $(wc -l <finer/frames.csv) lines"
awk -F, 'NR > 1 && ($2 - ($1 * 2 / 90)) ^ 2 > 1e-24 { bad = 1 } END { exit bad }' finer/frames.csv || fault "finer steps: frames at other times"
"$TULLE" check finer >check.out || fault "finer steps: not clean: $(tail -1 check.out)"
run bodies.yaml --from thrown:10 -o again --record velocities "${finer[@]}" -n 15 >/dev/null || fault "finer steps, shorter: exit $?"
run bodies.yaml --from thrown:10 -o again --record velocities "${finer[@]}" --resume >again.out || fault "finer steps, resumed: exit $?"
cmp -s finer/sheet.pc2 again/sheet.pc2 || fault "finer steps: what is resumed differs"
[ "$(tail -1 finer.out)" = "$(tail -1 again.out)" ] || fault "finer steps: it ends in another state"
"$TULLE" info again | grep -q 'files  *as the run wrote them' || fault "finer steps: its files are not sound"
"$TULLE" convert finer finer.glb >/dev/null || fault "finer steps: cannot be converted"

# What stands still now, where cloth was in frames before, or is another size: absent in those.
run scene.yaml --from first:12 -o below --record velocities --set 'obstacles[0].translate=[0, 0, -0.02]' >/dev/null || fault "a ball that stands elsewhere: exit $?"
[ "$(sed -n 14p below/frames.csv | cut -d, -f5)" = 2 ] || fault "what stands elsewhere is there: $(sed -n 14p below/frames.csv)"
[ -z "$(sed -n 15p below/frames.csv | cut -d, -f5)" ] || fault "it is absent later"
sed '/name: upper/d; s/translate: \[0, 0, 0.2\]/translate: [0, 0, 0.6]/' scene.yaml >fall.yaml
for motion in 'obstacles[0].translate=[0, 0, 0]' 'obstacles[0].motion={keyframes: [{time: 0, translate: [0, 0, -1]}, {time: 2, translate: [0.1, 0, -1]}]}'; do
    run fall.yaml -o falls --force --record velocities -n 14 --set "$motion" >/dev/null || fault "cloth that falls: exit $?"
    run fall.yaml --from falls:12 -o met --force --record velocities --set 'obstacles[0].translate=[0, 0, 0.56]' >/dev/null || fault "a ball behind it: exit $?"
    "$TULLE" check met >check.out || fault "a ball stands where the cloth was: $(tail -1 check.out)"
done

refuse() { # WORDS ARGUMENTS...
    local words=$1
    shift
    rm -rf bad
    run "$@" -o bad >/dev/null 2>stderr
    local code=$?
    [ $code = 2 ] || fault "$*: exit $code, not 2"
    grep -q "$words" stderr || fault "$*: $(cat stderr)"
    [ -e bad ] && fault "$*: the directory was made"
}
run scene.yaml -o plain -n 3 >/dev/null
refuse 'keeps no velocities' scene.yaml --from plain
refuse 'has 25 frames' scene.yaml --from first:99
refuse 'the scene has no frame after it' scene.yaml --from first
refuse 'frames are 0.0222222222 s apart, but in the scene they are 0.0333333333 s apart' scene.yaml --from first:3 --set time.steps_per_frame=3
refuse "no cloth 'other'" scene.yaml --from first:3 --set 'cloth[0].name=other'
refuse "no cloth 'sheet'" scene.yaml --from first:3 --set 'cloth[0].mesh.resolution=[12, 13]'
refuse "no rigid body 'bar' of the same mesh" scene.yaml --from first:3 --set 'obstacles[1].dynamic={mass: 1 kg, start: 1 s}'
refuse "no rigid body 'crate' of the same mesh in the same place" bodies.yaml --from thrown:3 --set 'obstacles[1].translate=[0.05, 0, 0.6]'
refuse "no rigid body 'slab'" bodies.yaml --from thrown:3 --set 'obstacles[2].mesh.size=[0.1, 0.1, 0.06]'
refuse 'missing' scene.yaml --from missing
refuse 'intersect' scene.yaml --from first:12 --set 'obstacles[0].mesh.radius=0.2'
"$TULLE" run scene.yaml --from first:3 -o first --force >/dev/null 2>stderr && fault "it replaced its own source"
grep -q 'the directory of the new run' stderr || fault "its own source: $(cat stderr)"
diff -rq first/frames.csv second/frames.csv >/dev/null; [ -s first/sheet.pc2 ] || fault "the source is gone"

[ $faults = 0 ] && echo "runs from frames of others: as they should"
exit $faults
