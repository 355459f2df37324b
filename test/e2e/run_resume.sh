#!/usr/bin/env bash
# A run that is killed at random moments, or interrupted, and resumed ends with the same state hash and
# the same bytes as an undisturbed one, for any number of threads, with and without debug records. Fifty kills with TULLE_TEST_LONG=1.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
body=(--set "obstacles[1].dynamic={mass: 0.1 kg, start: 0.2 s}")
kills=6
[ "${TULLE_TEST_LONG:-}" = 1 ] && kills=50
RANDOM=20
faults=0
fault() { echo "fault: $*"; faults=1; }

now() { date +%s%N; }
reduce() { awk -f "$TULLE_SOURCE_DIR/test/e2e/without_times.awk" "$1/report.csv"; }
# same DIR plain|debug: its frames are those of the undisturbed run.
same() {
    local file
    for file in sheet.obj sheet.pc2 box.obj box.pc2 ground.obj spike.obj frames.csv bodies.csv scene.yaml; do
        cmp -s "whole/$file" "$1/$file" || fault "$1/$file differs from that of the undisturbed run"
    done
    if [ "$2" = debug ]; then
        cmp -s whole/debug.bin "$1/debug.bin" || fault "$1/debug.bin differs from that of the undisturbed run"
    fi
    cmp -s <(reduce whole) <(reduce "$1") || fault "$1/report.csv differs from that of the undisturbed run in more than times"
    ls "$1" | grep -q tmp && fault "$1 holds temporary files"
    [ "$(tail -n 1 "$1.out")" = "$hash" ] || fault "$1 ends with $(tail -n 1 "$1.out"), not $hash"
}

begin=$(now)
"$TULLE" run "$scene" "${body[@]}" -o whole --record debug --progress none --threads 1 >whole.out || fault "the whole run: exit $?"
duration=$((($(now) - begin) / 1000))
hash=$(tail -n 1 whole.out)
case $hash in "state hash: "*) ;; *) fault "the last line is no state hash: $hash" ;; esac
"$TULLE" check whole >check.out || fault "the undisturbed run: $(tail -n 1 check.out)"
"$TULLE" run "$scene" "${body[@]}" -o threads --record debug --progress none --threads 2 >threads.out || fault "two threads: exit $?"
same threads debug

# Killed at random moments, some of them while it resumes; a checkpoint after every third step.
done_kills=0
while [ $done_kills -lt $kills ]; do
    rm -rf killed
    for attempt in 1 2 3; do
        "$TULLE" run "$scene" "${body[@]}" -o killed --resume --record debug --progress none --checkpoint-every 3 >/dev/null 2>killed.err &
        process=$!
        sleep "$(awk -v random=$RANDOM -v duration="$duration" \
            'BEGIN { printf "%.6f", random / 32768 * duration / 1e6 * 0.8 }')"
        kill -9 $process 2>/dev/null
        wait $process 2>/dev/null
        [ $? = 137 ] && done_kills=$((done_kills + 1))
        if [ -e killed/run.json ]; then
            "$TULLE" info killed >info.out 2>&1 || fault "a killed run cannot be read: $(cat info.out)"
        fi
    done
    "$TULLE" run "$scene" "${body[@]}" -o killed --resume --record debug --progress none >killed.out || fault "resuming: exit $?"
    same killed debug
done

# Interrupted in the middle: exit 130, a checkpoint of the last step, and on from there.
for signal in INT TERM; do
    code=0
    # A run that was done before the signal came, as on a busy machine, is tried again.
    for ((tries = 0; tries < 20 && code == 0; tries++)); do
        rm -rf interrupted
        : >interrupted.json
        "$TULLE" run "$scene" "${body[@]}" -o interrupted --progress json >interrupted.out 2>interrupted.json &
        process=$!
        until grep -q '"step":3,' interrupted.json || ! kill -0 $process 2>/dev/null; do sleep 0.01; done
        kill -s $signal $process 2>/dev/null
        wait $process
        code=$?
    done
    [ $code = 130 ] || fault "SIG$signal: exit $code, not 130"
    grep -vqE '^(\{"event":"[a-z]+",.*\}|tulle run: .*)$' interrupted.json && fault "a line is neither JSON nor a message"
    grep -q '"event":"end","state":"interrupted"' interrupted.json || fault "no end event after SIG$signal"
    "$TULLE" info interrupted | grep -q '^interrupted: run, interrupted$' || fault "info does not say interrupted"
    "$TULLE" run "$scene" "${body[@]}" -o interrupted --resume --progress json >interrupted.out 2>interrupted.json ||
        fault "resuming after SIG$signal: exit $?"
    same interrupted plain
done
head -n 1 interrupted.json | grep -q '^{"event":"begin","goes_on":true,"step":' || fault "progress does not begin with its event"
sed -n 2p interrupted.json | grep -q '^{"event":"step","step":' || fault "progress is no JSON line"

# A run keeps its kind of record.
"$TULLE" run "$scene" "${body[@]}" -o killed --resume --progress none >kind.out 2>kind.err && fault "plain after debug is taken"
grep -q 'keeps debug records' kind.err || fault "plain after debug: $(cat kind.err)"
"$TULLE" run "$scene" "${body[@]}" -o interrupted --resume --record debug --progress none >kind.out 2>kind.err && fault "debug after plain is taken"
grep -q 'no debug records' kind.err || fault "debug after plain: $(cat kind.err)"
"$TULLE" info killed | grep -q 'debug.bin, .* kB a frame' || fault "info does not say what debug records take"

# A finished run may be made longer; --frames counts from the beginning.
"$TULLE" run "$scene" "${body[@]}" -o longer --frames 10 --progress none >longer.out || fault "ten frames: exit $?"
grep -q '^frames: 11, ' longer.out || fault "ten frames give $(grep '^frames' longer.out)"
"$TULLE" run "$scene" "${body[@]}" -o longer --resume --progress none >longer.out || fault "the longer run: exit $?"
sed -i 's/^  frames: .*//' longer/scene.yaml
cp whole/scene.yaml longer/scene.yaml
same longer plain
echo "$done_kills kills"
exit $faults
