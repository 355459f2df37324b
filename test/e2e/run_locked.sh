#!/usr/bin/env bash
# Two processes run into the same directory, one a little after the other: one writes a whole run, the other is refused
# and leaves it alone. Many more offsets with TULLE_TEST_LONG=1.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
offsets=6
[ "${TULLE_TEST_LONG:-}" = 1 ] && offsets=400
faults=0
fault() { echo "fault: $*"; faults=1; }
run() { "$TULLE" run "$scene" --frames 8 --threads 1 --progress none "$@"; }

run -o whole >whole.out || fault "the whole run: exit $?"
# The same as if it had been killed before its first checkpoint.
cp -R whole begun
rm begun/checkpoint*.bin
python3 -c 'import json
record = json.load(open("begun/run.json"))
del record["checksums"]
record["state"] = "running"
json.dump(record, open("begun/run.json", "w"))'
python3 "$TULLE_SOURCE_DIR/test/e2e/seal.py" begun/run.json
# sound NAME: the directory "out" is that of an undisturbed run.
sound() {
    local file
    for file in sheet.obj sheet.pc2 box.obj box.pc2 ground.obj spike.obj frames.csv scene.yaml; do
        cmp -s "whole/$file" "out/$file" || fault "$1: $file is not that of an undisturbed run"
    done
    [ "$(ls out)" = "$(ls whole)" ] || fault "$1: other files: $(ls out 2>&1 | tr '\n' ' ')"
    [ "$(wc -l <out/report.csv)" = "$(wc -l <whole/report.csv)" ] || fault "$1: another report.csv"
    "$TULLE" check out >check.out 2>&1 || fault "$1: tulle check: $(tail -n 1 check.out)"
}

locked=0
# pair NAME SECONDS OPTION...: the second process starts so much later.
pair() {
    local name=$1 offset=$2 codes
    shift 2
    run -o out "$@" >first.out 2>first.err &
    local first=$!
    sleep "$offset"
    run -o out "$@" >second.out 2>second.err
    local second_code=$?
    wait $first
    codes="$? $second_code"
    case $codes in
        "0 2") refused=second ;;
        "2 0") refused=first ;;
        # The second began after the end of the first, which these options allow.
        "0 0") [ "$*" != "" ] || fault "$name: both wrote"; refused= ;;
        *) fault "$name: exit codes $codes: $(cat first.err second.err)"; refused= ;;
    esac
    if [ -n "$refused" ]; then
        if grep -q '^tulle run: out: is locked: another process is writing a run here' $refused.err; then
            locked=$((locked + 1))
        elif [ "$*" != "" ] || ! grep -q 'holds a run already' $refused.err; then
            fault "$name: refused with: $(cat $refused.err)"
        fi
    fi
    sound "$name"
}

for ((i = 0; i < offsets; i++)); do
    offset=$(awk -v i=$i 'BEGIN { printf "%.4f", i % 20 * 0.002 + int(i / 20) * 0.00009 }')
    rm -rf out
    pair "a new run, $offset s" "$offset"
    rm -rf out
    pair "a new run with --resume, $offset s" "$offset" --resume
    rm -rf out
    cp -R begun out
    pair "--resume without a checkpoint, $offset s" "$offset" --resume
    pair "--force, $offset s" "$offset" --force
done
[ $locked -gt 0 ] || fault "no process met the lock"

echo "$locked of $((4 * offsets)) pairs met the lock"
exit $faults
