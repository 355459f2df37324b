#!/usr/bin/env bash
# tulle convert to Alembic and back, value for value; a build without it says so, and leaves nothing behind.
set -uo pipefail
command -v python3 >/dev/null || { echo "skipped: there is no python3"; exit 77; }
work=$(mktemp -d)
trap 'umount "$work/disk" 2>/dev/null; rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fault() { echo "fault: $*"; faults=1; }
convert() { "$TULLE" convert "$@" >out 2>err || { fault "convert $*: exit $?"; cat err; }; }

cat >scene.yaml <<'END'
time: {step: 0.01 s, frames: 8}
cloth:
  - name: sheet
    mesh: {shape: rectangle, size: [0.4, 0.4], resolution: [6, 6]}
    translate: [0, 0, 0.2]
obstacles:
  - name: floor
    mesh: {shape: plane, size: [2, 2]}
  - name: box
    mesh: {shape: box, size: [0.1, 0.1, 0.1]}
    translate: [0, 0, 0.3]
    dynamic: {density: 100 kg/m^3}
END
"$TULLE" run scene.yaml -o run --progress none >out 2>err || { cat err; exit 1; }

"$TULLE" convert run run.abc >out 2>err
if grep -q "has no Alembic" err; then
    ls | grep -q abc && fault "a file was left"
    : >in.abc
    "$TULLE" convert in.abc out.npz >out 2>err
    [ $? = 2 ] || fault "reading: not exit 2"
    grep -q "in.abc: this build of Tulle has no Alembic; configure it with -DTULLE_ALEMBIC=ON" err || fault "reading: $(cat err)"
    echo "built without Alembic: its refusal alone was tested"
    exit $faults
fi

# In Alembic y points up; of glTF the numbers are known to be true.
convert run.abc from_abc.npz --up z
convert run run.glb
convert run.glb from_glb.npz --up z
python3 - <<'END' || fault "the numbers differ"
import struct, zipfile
def read(name, entry):
    raw = zipfile.ZipFile(name).read(entry + ".npy")
    length = struct.unpack("<H", raw[8:10])[0]
    return raw[10:10 + length], raw[10 + length:]
assert read("from_abc.npz", "triangles") == read("from_glb.npz", "triangles")
times = struct.unpack("<9d", read("from_abc.npz", "times")[1])
assert max(abs(t - 0.01 * i) for i, t in enumerate(times)) < 1e-15
(head, a), (other, b) = read("from_abc.npz", "positions"), read("from_glb.npz", "positions")
assert head == other and b"<f4" in head and len(a) == len(b) > 0
numbers = [struct.unpack("<%df" % (len(x) // 4), x) for x in (a, b)]
assert max(abs(x - y) for x, y in zip(*numbers)) < 1e-6 # rigid bodies: float poses of glTF
END
convert run --body sheet sheet.abc
convert sheet.abc back.npz --up z
convert run --body sheet sheet.npz
python3 - <<'END' || fault "cloth is not the same to the bit"
import zipfile
a, b = (zipfile.ZipFile(n).read("positions.npy") for n in ("back.npz", "sheet.npz"))
assert a.replace(b"\x00\x00\x00\x80", b"\x00\x00\x00\x00") == b.replace(b"\x00\x00\x00\x80", b"\x00\x00\x00\x00")
END

# What is no Alembic, or a part of it.
printf 'nothing' >bad.abc
head -c 3000 run.abc >cut.abc
for name in bad cut; do
    "$TULLE" convert $name.abc out2.npz >out 2>err
    [ $? = 2 ] || fault "$name.abc: not exit 2"
    grep -q "$name.abc: " err || fault "$name.abc is not named: $(cat err)"
    [ -e out2.npz ] && fault "$name.abc left a file"
done
mkdir disk
if mount -t tmpfs -o size=8k tmpfs disk 2>/dev/null; then
    "$TULLE" convert run disk/full.abc >out 2>err
    [ $? != 0 ] || fault "a full disk: exit 0"
    ls disk | grep -q . && fault "a full disk: $(ls disk) is left"
    grep -qi "space\|full" err || fault "a full disk: $(cat err)"
fi
exit $faults
