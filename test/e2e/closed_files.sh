#!/usr/bin/env bash
# With standard input, output and error closed no file that the program writes gets their descriptors: the files are
# those of a run with all three open.
set -uo pipefail
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
faults=0
fault() { echo "fault: $*"; faults=1; }
run() { "$TULLE" run "$scene" --frames 4 --threads 1 --progress json "$@"; }
reduce() { awk -f "$TULLE_SOURCE_DIR/test/e2e/without_times.awk" "$1/report.csv"; }

run -o open >open.out 2>open.err || fault "the run with all files open: exit $?"
"$TULLE" convert open open.pc2 >out 2>err || fault "converting: exit $?: $(cat err)"

# closed NAME CODE: what the run and the conversion wrote, with the exit codes.
closed() {
    local file
    [ "$2" = "0 0" ] || fault "$1: exit codes $2"
    for file in sheet.obj sheet.pc2 box.pc2 frames.csv scene.yaml; do
        cmp -s "open/$file" "closed/$file" || fault "$1: $file differs"
    done
    cmp -s <(reduce open) <(reduce closed) || fault "$1: report.csv differs in more than times"
    cmp -s open.pc2 closed.pc2 || fault "$1: the converted cache differs"
    "$TULLE" check closed >out || fault "$1: tulle check: $(tail -n 1 out)"
    rm -rf closed closed.pc2
}
run -o closed <&- >&- 2>&-
codes=$?
"$TULLE" convert closed closed.pc2 <&- >&- 2>&-
closed "all closed" "$codes $?"
run -o closed >&- 2>err
codes=$?
"$TULLE" convert closed closed.pc2 >out 2>&-
closed "one closed" "$codes $?"

# A message still goes to what is open.
"$TULLE" check missing.obj <&- >&- 2>err
[ $? = 2 ] && grep -q 'missing.obj' err || fault "no message: $(cat err)"
exit $faults
