#!/usr/bin/env bash
# A full disk stops a run with exit 3 and a message; everything up to the last frame is usable, and with
# more room the run goes on to the same end. Needs root, to mount a small disk.
set -uo pipefail
[ "$(id -u)" = 0 ] || { echo "skipped: mounting a small disk needs root"; exit 77; }
work=$(mktemp -d)
disk=$work/disk
trap 'umount "$disk" 2>/dev/null; rm -rf "$work"' EXIT
mkdir "$disk"
mount -t tmpfs -o size=512k tmpfs "$disk" 2>/dev/null ||
    { echo "skipped: a small disk cannot be mounted here"; exit 77; }
cd "$work" || exit 1
scene=$TULLE_SOURCE_DIR/test/e2e/scenes/small.yaml
faults=0
fault() { echo "fault: $*"; faults=1; }

"$TULLE" run "$scene" -o whole --record debug --progress none >whole.out || fault "the whole run: exit $?"
used=$(du -sk whole | cut -f 1)
head -c $(((512 - used * 2 / 3) * 1024)) /dev/zero >"$disk/ballast"
"$TULLE" run "$scene" -o disk/run --record debug --progress none --checkpoint-every 4 >out 2>err
code=$?
[ $code = 3 ] || fault "exit $code on a full disk, not 3"
grep -q 'No space left' err || { fault "no message of the full disk:"; cat err; }
"$TULLE" info disk/run >info.out || fault "info: exit $?"
frames=$(sed -n 's/^  frames  *\([0-9]*\) of.*/\1/p' info.out)
[ "${frames:-0}" -gt 0 ] || { fault "no frames are left:"; cat info.out; }
"$TULLE" check disk/run >check.out || fault "check: exit $?"
tail -n 1 check.out | grep -q "^0 intersections in $frames frames$" || fault "check: $(tail -n 1 check.out)"

rm "$disk/ballast"
mount -o remount,size=4m "$disk" || fault "the disk cannot be made larger"
"$TULLE" run "$scene" -o disk/run --resume --record debug --progress none >out || fault "resuming: exit $?"
[ "$(tail -n 1 out)" = "$(tail -n 1 whole.out)" ] || fault "another state after resuming"
cmp whole/sheet.pc2 disk/run/sheet.pc2 || fault "other frames after resuming"
cmp whole/debug.bin disk/run/debug.bin || fault "other debug records after resuming"

# A disk that is full from the start.
"$TULLE" run "$scene" -o /dev/full --progress none >out 2>err
[ $? = 2 ] || fault "a device was taken as output directory"
echo "$frames frames before the disk was full"
exit $faults
