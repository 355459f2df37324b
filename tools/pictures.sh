#!/usr/bin/env bash
# Makes the pictures of README.md and docs/: runs each scene that is missing below out/pictures, then renders one frame of it.
# usage: pictures.sh PROGRAM [SCENE ...]      all scenes of the table below without names
# A run that was cut short goes on. Scenes whose meshes are not there are passed over, and said so. `napkin` is the scene that
# docs/start/first_scene.md shows.
set -euo pipefail
cd "$(dirname "$0")/.."
program=$1
shift

# scene, frame
table() {
    cat <<'END'
needles      54
sphere       58
spikes       90
layers       15
ribbon       210
net          60
pinch        40
pinch_zero   104
body         75
table        45
spot         90
rings        36
hammock      150
chain        20
napkin       135
END
}

size_limit=300000 # [bytes] of a picture in the repository
mkdir -p out/pictures docs/pictures

make_picture() { # SCENE FRAME
    local scene=$1 run=out/pictures/$1 code=0 file=scenes/$1.yaml
    if [ "$scene" = napkin ]; then
        file=out/pictures/napkin.yaml
        sed -n '/^```yaml$/,/^```$/p' docs/start/first_scene.md | sed '1d; /^```$/,$d' >"$file"
    fi
    "$program" run "$file" -o "$run" --record debug --resume || code=$?
    case $code in
    0) ;;
    2) echo "$scene: passed over, see above"; return ;;
    3) echo "$scene: the run stopped before its end; its frames are used" ;;
    *) exit "$code" ;;
    esac
    render_frame "$run" "$2" 480x270 "$scene"
    [ "$scene" = needles ] && render_frame "$run" 14 720x405 hero
    return 0
}

render_frame() { # RUN FRAME SIZE NAME
    local target=docs/pictures/$4.png
    "$program" render "$1" --frame "$2" --size "$3" --samples 256 -o "$target"
    [ "$(stat -c %s "$target")" -le $size_limit ] || { echo "$target is larger than $size_limit bytes" >&2; exit 1; }
}

while read -r scene frame; do
    [ $# = 0 ] || [[ " $* " == *" $scene "* ]] || continue
    make_picture "$scene" "$frame" </dev/null
done < <(table)
