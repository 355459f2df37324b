#!/usr/bin/env bash
# tulle render: stills, series, films, resumption, colors, subdivision, threads, and a table of bad input.
set -uo pipefail
scenes=$TULLE_SOURCE_DIR/test/e2e/scenes
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cd "$work" || exit 1
faults=0
fail() { echo "$1"; faults=1; }

"$TULLE" run "$scenes/small.yaml" -o small.run --record debug --progress none >/dev/null || { echo "the run fails"; exit 1; }
if [[ $("$TULLE" render small.run --size 8x8 --samples 1 2>&1) = *libembree-dev* ]]; then
    echo "skipped: built without Embree"
    exit 77
fi
rm -f small.png
quick=(--size 64x36 --samples 2 --progress none)

# expect CODE PATTERN ARGUMENTS...: exit code of `tulle render ARGUMENTS`, and a line of its output.
expect() {
    local code=$1 pattern=$2
    shift 2
    "$TULLE" render "$@" >out 2>err </dev/null
    local found=$?
    [ $found = "$code" ] || { fail "render $*: exit $found, expected $code"; cat out err; }
    grep -q -e "$pattern" out err || { fail "render $*: no \"$pattern\" in:"; cat out err; }
}

# ---- stills ----
expect 0 '^picture: small.png$' small.run "${quick[@]}"
grep -q '^frame: 24 of 0 to 24; 64x36 pixels, 2 samples each$' out || fail "the still's facts: $(cat out)"
[ "$(head -c 8 small.png | od -An -tx1 | tr -d ' \n')" = 89504e470d0a1a0a ] || fail "no PNG file"
expect 0 '^frame: 3 of' small.run "${quick[@]}" --frame 3 -o three.png --threads 1
expect 0 '^frame: 3 of' small.run/ "${quick[@]}" --frames 3 -o again.png --threads 2
cmp three.png again.png || fail "threads change the picture"
cmp -s three.png small.png && fail "frames 3 and 24 look the same"
expect 0 'frame: 24' small.run "${quick[@]}" --camera orbit=120deg,30deg,2m -o turned.png
cmp -s turned.png small.png && fail "--camera changes nothing"
expect 0 'frame: 24' small.run "${quick[@]}" --wire -o wire.png
cmp -s wire.png small.png && fail "--wire changes nothing"

expect 0 '^hidden: box$' small.run "${quick[@]}" --hide box -o hidden.png
cmp -s hidden.png small.png && fail "--hide changes nothing"
expect 0 '^hidden: sheet$' small.run "${quick[@]}" --hide sheet -o hidden.png
expect 0 '^hidden: sheet, ground, box, spike$' small.run "${quick[@]}" --hide sheet --hide box --hide ground --hide spike -o hidden.png
# Keys of the scene, and no scene.
cp -r small.run keyed.run
printf 'render: {camera: {orbit: [120 deg, 30 deg], distance: 2}}\n' >>keyed.run/scene.yaml
expect 0 'frame: 24' keyed.run "${quick[@]}" -o keyed.png
cmp turned.png keyed.png || fail "the scene's camera and the option's differ"
sed -i 's/elevation\|orbit/orbti/' keyed.run/scene.yaml
expect 2 "scene.yaml:[0-9]*:[0-9]*: render.camera.orbti: unknown key; did you mean 'orbit'" keyed.run "${quick[@]}" -o no.png
rm keyed.run/scene.yaml
expect 0 'frame: 24' keyed.run "${quick[@]}" -o keyed.png
cmp small.png keyed.png || fail "without a scene file the defaults do not hold"

# ---- colors ----
for color in patches contacts gap velocity strain; do
    expect 0 '^picture' small.run "${quick[@]}" --size 160x90 --color $color -o $color.png
done
"$TULLE" run "$scenes/small.yaml" -o plain.run -n 2 --progress none >/dev/null
for color in patches contacts velocity; do
    expect 2 "run it again with .tulle run .*small.yaml --record debug" plain.run "${quick[@]}" --color $color -o no.png
done
expect 0 '^picture' plain.run "${quick[@]}" --size 160x90 --color strain -o plain.png

# ---- subdivision ----
# While the sheet hangs over the spike the smoothed one goes through; both streams say so.
expect 0 '^subdivided: the subdivided surface intersects in [0-9]* of 25 frames' small.run --size 8x8 --samples 1 --subdivide 1 --frames all -o 'step_%d.png'
bad=$(sed -n 's/^subdivided: .*; frame \([0-9]*\): .*/\1/p' out)
expect 0 "^subdivided: frame $bad: the subdivided surface intersects" small.run "${quick[@]}" --subdivide 1 --frame "$bad" -o smooth.png
grep -q "^tulle render: frame $bad: the subdivided surface intersects" err || fail "no warning: $(cat err)"
expect 0 '^subdivided: .*does not intersect' small.run "${quick[@]}" --subdivide 1 --frame 0 -o smooth.png
[ -s err ] && fail "a warning without reason: $(cat err)"
rm step_*
expect 0 '^subdivided: ' small.run "${quick[@]}" --subdivide 1 -o smooth.png
cmp -s smooth.png small.png && fail "--subdivide changes nothing"
expect 0 '^subdivided: ' small.run "${quick[@]}" --subdivide 2 --color gap -o smooth_gap.png

# ---- series ----
expect 0 '^frames: 3, from 2 to 10, every 4' small.run "${quick[@]}" --frames 2:10:4 -o 'name_%04d.png'
[ "$(echo name_*)" = "name_0002.png name_0006.png name_0010.png" ] || fail "series: $(echo name_*)"
rm name_0006.png
echo garbage >name_0002.png
expect 0 '^reused: 1 from before$' small.run "${quick[@]}" --frames 2:10:4 -o 'name_%04d.png'
expect 0 '^traced: 3 ' small.run "${quick[@]}" --frames 2:10:4 -o 'name_%04d.png' --samples 3
rm name_*

# ---- films ----
if command -v ffmpeg >/dev/null && command -v ffprobe >/dev/null; then
    probe() { ffprobe -v error -count_frames -select_streams v:0 -show_entries stream=nb_read_frames,width,height,r_frame_rate -of csv=p=0 "$1"; }
    expect 0 '^speed: 12.5 frames a second, real time$' small.run "${quick[@]}" --size 65x37 --frames ::4 -o film.mp4
    [ "$(probe film.mp4)" = 66,38,25/2,7 ] || fail "film: $(probe film.mp4)"
    [ -e film.frames ] && fail "the film's frames stay"
    expect 0 '2 times as fast as real' small.run "${quick[@]}" --frames ::4 --fps 25 -o film.gif
    [ "$(probe film.gif | cut -d, -f1,2,4)" = 64,36,7 ] || fail "gif: $(probe film.gif)"
    # Interrupted, then gone on with.
    "$TULLE" render small.run --size 128x72 --samples 24 --progress json -o cut.mp4 >out 2>err </dev/null &
    process=$!
    for _ in $(seq 300); do
        [ "$(grep -c '"event":"frame"' err)" -ge 2 ] && break
        sleep 0.05
    done
    kill -INT $process
    wait $process
    code=$?
    [ $code = 130 ] || { fail "interrupted film: exit $code"; cat err; }
    [ -e cut.mp4 ] && fail "half a film is there"
    kept=$(find cut.frames -name '*.png' | wc -l)
    [ "$kept" -ge 2 ] || fail "$kept frames are kept"
    grep -q "interrupted; $kept of 25 pictures are kept in cut.frames" err || fail "message: $(tail -n 1 err)"
    expect 0 "^reused: $kept from before" small.run --size 128x72 --samples 24 -o cut.mp4
    [ "$(probe cut.mp4)" = 128,72,50/1,25 ] || fail "film gone on with: $(probe cut.mp4)"
    # An encoder that is missing, and one that dies.
    mkdir bin
    printf '#!/bin/sh\necho " V....D h263 x"\n' >bin/ffmpeg && chmod +x bin/ffmpeg
    PATH=$PWD/bin:$PATH expect 2 'no encoder libx264' small.run "${quick[@]}" -o no.mp4
    printf '#!/bin/sh\n[ "$3" = -encoders ] && { echo " V....D libx264 x"; exit; }\necho broken pipes here >&2\nexit 7\n' >bin/ffmpeg
    PATH=$PWD/bin:$PATH expect 3 'ended with 7): broken pipes here' small.run "${quick[@]}" --frames :3 -o dies.mp4
    [ "$(find . -name 'dies*' -o -path './dies*' | wc -l)" = 5 ] || fail "after a failure: $(find . -path './dies*')"
    rm -r bin dies.frames
fi
mkdir empty
(
    PATH=$PWD/empty
    "$TULLE" render small.run -o no.mp4 2>err
    [ $? = 2 ]
) || fail "without ffmpeg: $(cat err)"
grep -q "Debian's package is ffmpeg" err || fail "without ffmpeg: $(cat err)"

# ---- bad input: exit 2, a clear message, nothing left behind ----
cp -r small.run none.run
head -n 1 small.run/frames.csv >none.run/frames.csv
rm none.run/checkpoint*.bin
python3 "$TULLE_SOURCE_DIR/test/e2e/seal.py" none.run/run.json frames.csv
mkdir folder.png
touch file.frames
list_files() { find . ! -name out ! -name err | sort; }
before=$(list_files)
expect 2 'holds no whole frame' none.run
expect 2 'no_such' no_such.run
expect 2 'run.json' empty
expect 2 'does not exist; there are frames 0 to 24' small.run --frame 25
expect 2 'should be the number of one frame' small.run --frame -1
expect 2 'should be N, A:B' small.run --frames 1:2:0
expect 2 'ends before it begins' small.run --frames 5:3
expect 2 'give one of them' small.run --frame 1 --frames 2:3
for size in 0x0 640 1e9x5 -5x5 640x 99999x5 16384x16384 nanxnan; do
    expect 2 --size small.run --size=$size
done
for samples in 0 -1 nan 99999999; do
    expect 2 --samples small.run --samples=$samples
done
expect 2 'should end in .png' small.run -o picture.jpg
expect 2 'should end in .png' small.run -o picture
expect 2 'cannot be written: No such file' small.run -o missing/picture.png
expect 2 'cannot be written: No such file' small.run -o missing/film.mp4
expect 2 'exists and is not a file' small.run -o folder.png
expect 2 'is one picture, and there are 3 frames' small.run --frames 1:3 -o one.png
expect 2 'name_%d%d' small.run --frames 1:3 -o 'name_%d%d.png'
expect 2 '%s' small.run --frames 1:3 -o 'name_%s.png'
if command -v ffmpeg >/dev/null; then
    expect 2 'exists and is not a folder' small.run --frames 1:3 -o file.mp4
fi
expect 2 --camera small.run --camera 'position=1,2'
expect 2 --camera small.run --camera 'orbit=30,20'
expect 2 'in its target' small.run --camera 'position=1,2,3,target=1,2,3'
expect 2 --camera small.run --camera 'position=nan,0,0'
expect 2 --subdivide small.run --subdivide 99
expect 2 --color small.run --color red
expect 2 'no body is called "bo"' small.run --hide bo
expect 2 --fps small.run --fps 0 -o no.mp4
expect 2 'RUN'
[ "$(list_files)" = "$before" ] || fail "bad input leaves something behind: $(diff <(echo "$before") <(list_files))"
if ! { command -v ffmpeg && command -v ffprobe; } >/dev/null; then
    [ $faults = 0 ] || exit 1
    echo "skipped: ffmpeg is not installed, so no film is made"
    exit 77
fi
exit $faults
