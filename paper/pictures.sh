#!/usr/bin/env bash
# Makes docs/pictures/paper of what `make paper` left in DIR: three stills of each run side by side, and the plots of Fig. 7.
# usage: pictures.sh [DIR]      default: reproduced
# Needs ffmpeg, with librsvg for the plots.
set -euo pipefail
dir=$(realpath "${1:-reproduced}")
cd "$(dirname "$0")/.."
target=docs/pictures/paper
size_limit=300000 # [bytes] of a picture in the repository
command -v ffmpeg >/dev/null || { echo "pictures are put together by ffmpeg, which is not installed" >&2; exit 2; }
[ -d "$dir/stills" ] || { echo "$dir holds no stills; make paper makes them" >&2; exit 2; }
mkdir -p $target

# name, run
table() {
    cat <<'END'
example_one_low   example_one_low_friction
example_one_high  example_one_high_friction
animation_1       animation_1.patches
animation_2       animation_2.patches
animation_3       animation_3.patches
animation_4       animation_4.patches
animation_5       animation_5.patches
animation_6       animation_6.patches
rings             rings
ribbons           ribbons
END
}

check_size() { # PICTURE
    [ "$(stat -c %s "$1")" -le $size_limit ] || { echo "$1 is larger than $size_limit bytes" >&2; exit 1; }
    echo "$1"
}

make_strip() { # NAME RUN
    local stills=("$dir/stills/$2"_*.png)
    [ ${#stills[@]} = 3 ] || { echo "$dir/stills: not three of $2" >&2; exit 1; }
    local scale='scale=400:-1:flags=area'
    ffmpeg -v error -y -i "${stills[0]}" -i "${stills[1]}" -i "${stills[2]}" \
        -filter_complex "[0]$scale[a];[1]$scale[b];[2]$scale[c];[a][b][c]hstack=3" \
        -pred mixed -compression_level 9 -update 1 "$target/$1.png" </dev/null
    check_size "$target/$1.png"
}

make_plot() { # NAME
    ffmpeg -v error -y -i "$dir/$1.svg" -filter_complex 'split[a][b];[a]palettegen[p];[b][p]paletteuse=dither=none' -update 1 "$target/$1.png" </dev/null
    check_size "$target/$1.png"
}

while read -r name run; do make_strip "$name" "$run"; done < <(table)
for plot in fig7a fig7b fig7c fig7d; do make_plot $plot; done
