#!/usr/bin/env bash
# Damage to any file of a run: tulle info and tulle check name it with exit code 2, and tulle run --resume makes it good to the same
# bytes or refuses it by name and changes nothing. TULLE_TEST_LONG=1: every file in every way.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
faults=0
fault() { echo "fault: $*"; faults=1; }
run() {
    "$TULLE" run "$scene" --set "obstacles[1].dynamic={mass: 0.1 kg, start: 0.02 s}" --frames 4 --threads 1 --record debug \
        --write vtp --progress none --checkpoint-every 5 "$@"
}

run -o whole >whole.out || fault "the whole run: exit $?"
"$TULLE" info whole | grep -q '^  files  *as the run wrote them$' || fault "info of a whole run"
"$TULLE" check whole --json | grep -q '"intersections":0}$' || fault "check of a whole run"

# damage KIND FILE
damage() {
    local size
    size=$(stat -c %s "$2")
    case $1 in
        removed) rm "$2" ;;
        cut) truncate -s $((size / 3)) "$2" ;;
        flipped) python3 -c 'import sys
data = bytearray(open(sys.argv[1], "rb").read())
data[len(data) // 3] ^= 4
open(sys.argv[1], "wb").write(data)' "$2" ;;
        longer) printf 'v 1 2 3\n' >>"$2" ;;
        zeroed) dd if=/dev/zero of="$2" bs=1 seek=$((size / 3)) count=$((size / 3)) conv=notrunc status=none ;;
    esac
}

# try KIND FILE
try() {
    local what="$2 $1" code file
    rm -rf run
    cp -R whole run
    damage "$1" "run/$2"
    cp -R run before
    for command in info check; do
        "$TULLE" $command run >out 2>err
        [ $? = 2 ] || fault "$what: tulle $command ends otherwise than with 2"
        grep -q "$(basename "$2")" err || fault "$what: tulle $command does not name it: $(cat err)"
    done
    run -o run --resume >out 2>err
    code=$?
    if [ $code = 2 ]; then
        grep -q "$(basename "$2")" err || fault "$what: refused without its name: $(cat err)"
        diff -r before run >changes || fault "$what: refused, but changed: $(head -n 3 changes)"
    elif [ $code = 0 ]; then
        for file in sheet.obj sheet.pc2 box.obj box.pc2 ground.obj frames.csv bodies.csv debug.bin scene.yaml sheet.pvd vtp/sheet.000003.vtp; do
            cmp -s "whole/$file" "run/$file" || fault "$what: resumed, but $file is not that of the undisturbed run"
        done
        [ "$(tail -n 1 out)" = "$(tail -n 1 whole.out)" ] || fault "$what: resumed to another state"
        "$TULLE" check run >out 2>err || fault "$what: resumed, but tulle check says: $(cat err)"
    else
        fault "$what: exit $code: $(cat err)"
    fi
    rm -rf before
}

if [ "${TULLE_TEST_LONG:-}" = 1 ]; then
    for file in $(cd whole && find . -type f | sed 's,^\./,,' | sort); do
        for kind in removed cut flipped longer zeroed; do
            [ "$file $kind" = "checkpoint.previous.bin removed" ] && continue # nothing of the run is lost
            [ "$file $kind" = "checksums.csv longer" ] && continue # it ends where run.json says
            try $kind "$file"
        done
    done
else
    try removed run.json
    try removed sheet.obj
    try longer sheet.obj
    try longer scene.yaml
    try longer vtp/sheet.000003.vtp
    try longer sheet.pc2
    try flipped sheet.pc2
    try cut bodies.csv
    try zeroed report.csv
    try flipped debug.bin
    try flipped checksums.csv
    try removed vtp/box.000002.vtp
    try cut checkpoint.bin
fi

# What was made good, and what the run goes on from, is told.
rm -rf run
cp -R whole run
rm run/ground.obj
damage flipped run/vtp/sheet.000004.vtp
run -o run --resume >out 2>err || fault "damage behind the checkpoint before: exit $?: $(cat err)"
grep -q 'run/ground.obj: damaged, and made again$' err || fault "the mesh is not told of: $(cat err)"
grep -q 'sheet.000004.vtp: frame 4: damaged: .*; the run continues from the checkpoint before, after step 5$' err ||
    fault "the checkpoint is not told of: $(cat err)"

# A run of another version is refused.
rm -rf run
cp -R whole run
sed -i 's/"format_version": 3/"format_version": 2/; s/"checksum": .*/"comment": ""/' run/run.json
for command in "info run" "check run" "run $scene -o run --resume"; do
    "$TULLE" $command >out 2>err
    [ $? = 2 ] && grep -q 'run/run.json.*: format version 2, of another version of tulle' err || fault "an older run: $command: $(cat err)"
done

# So is a checkpoint of another version, or with the state of another version: its bytes are whole, but nothing reads them.
# other BYTE VALUE: the byte of checkpoint.bin gets the value, and the file its hash again
other() {
    rm -rf run
    cp -R whole run
    PYTHONPATH=$TULLE_SOURCE_DIR/test/e2e python3 -c 'import seal, sys
path, at, value = sys.argv[1], int(sys.argv[2]), ord(sys.argv[3])
data = bytearray(open(path, "rb").read())
data[at] = value
data[88:96] = seal.hash_bytes(bytes(data[:88] + data[96:]), seal.CHAIN_SEED).to_bytes(8, "little")
open(path, "wb").write(data)' run/checkpoint.bin "$1" "$2"
    rm run/checkpoint.previous.bin
    cp -R run before
    run -o run --frames 5 --resume >out 2>err
    [ $? = 2 ] || fault "a checkpoint of another version is resumed: $(cat err)"
    diff -r -x run.json before run >/dev/null || fault "a refused run is changed"
    rm -rf before
}
other 8 9
grep -q 'checkpoint.bin: byte 8: version 57; only version 2 can be read' err || fault "another checkpoint: $(cat err)"
other 103 1
grep -q 'run/checkpoint.bin: the saved state is of another version of Tulle (format 1, this one reads' err || fault "another state: $(cat err)"

[ $faults = 0 ] && echo "damage: named or made good"
exit $faults
