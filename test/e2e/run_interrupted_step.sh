#!/usr/bin/env bash
# Ctrl-C during a step that takes long: the run ends within a moment with exit 130, keeps what was written, and resumes to the same
# bytes as a run that was left alone. A step that takes seconds is told of meanwhile.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }

# Two sheets beat together on a comb, faster than a step can follow: the second step takes many seconds.
cat >fast.yaml <<'END'
title: fast
time: {step: 1/24 s, frames: 2}
wind: {drag: 0}
cloth:
  - name: left
    mesh: {shape: rectangle, size: [0.5, 0.5], resolution: [8, 8]}
    rotate: [0, 90 deg, 0]
    translate: [-3, 0, 0.5]
    velocity: [60, 0, 0]
    material: {preset: wool}
  - name: right
    mesh: {shape: rectangle, size: [0.5, 0.5], resolution: [9, 9], irregular: true}
    rotate: [0, 80 deg, 10 deg]
    translate: [3, 0, 0.5]
    velocity: [-60, 0, 0]
    material: {preset: silk}
obstacles:
  - name: comb
    mesh: {shape: cylinder, radius: 3 mm, height: 1}
    copies: {grid: {count: [1, 6], spacing: [1, 0.08]}}
END
now() { date +%s%N; }

"$TULLE" run fast.yaml -o whole --threads 1 --progress json >whole.out 2>whole.json || fault "the whole run: exit $?"
seconds=$(sed -n 's/.*"step":2,.*"seconds":\([0-9.]*\),"rest.*/\1/p' whole.json)
echo "the long step: $seconds s"
if awk -v s="$seconds" 'BEGIN { exit !(s > 5) }'; then
    grep -q '^{"event":"substep","step":2,"seconds":[0-9.]*,"substep":[0-9]*,"share":[0-9.]*}$' whole.json || fault "the step is not told of"
fi

for signal in INT TERM; do
    rm -rf cut
    "$TULLE" run fast.yaml -o cut --threads 2 --progress json >cut.out 2>cut.json &
    process=$!
    until grep -q '"step":1,' cut.json 2>/dev/null || ! kill -0 $process 2>/dev/null; do sleep 0.01; done
    sleep "$(awk -v s="$seconds" 'BEGIN { print s / 4 }')"
    kill -0 $process 2>/dev/null || fault "the run ended by itself"
    begin=$(now)
    kill -s $signal $process
    wait $process
    code=$?
    taken=$((($(now) - begin) / 1000000))
    [ $code = 130 ] || fault "SIG$signal: exit $code, not 130"
    # a step left alone would go on for three quarters of its time
    awk -v taken=$taken -v s="$seconds" 'BEGIN { exit !(taken < 500 || taken < 250 * s) }' || fault "SIG$signal: took $taken ms"
    grep -q '^tulle run: interrupted after step 1; the same command with --resume continues from there$' cut.json || fault "SIG$signal: $(tail -n 2 cut.json)"
    grep -q '"event":"end","state":"interrupted","frames":2,' cut.json || fault "SIG$signal: no end event"
    [ "$(wc -l <cut/report.csv)" = 2 ] || fault "SIG$signal: report.csv has not the line of one step"
    "$TULLE" info cut | grep -q '^cut: run, interrupted$' || fault "info does not say interrupted"
done
"$TULLE" run fast.yaml -o cut --resume --threads 2 --progress none >cut.out || fault "resuming: exit $?"
[ "$(tail -n 1 cut.out)" = "$(tail -n 1 whole.out)" ] || fault "the resumed run ends with $(tail -n 1 cut.out)"
for file in left.pc2 right.pc2 frames.csv; do
    cmp -s "whole/$file" "cut/$file" || fault "$file differs from that of the undisturbed run"
done

[ $faults = 0 ] && echo "interrupted steps: as they should"
exit $faults
