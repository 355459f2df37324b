#!/bin/sh
# Builds the program without Embree and without the viewer, and checks that `tulle render` and `tulle view` say so, exit with 2 and
# write nothing.
# usage: test_without_embree.sh SOURCE_DIR
set -eu
source_dir=$1
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
cmake -S "$source_dir" -B "$work/build" -DCMAKE_BUILD_TYPE=Debug -DTULLE_EMBREE=off -DTULLE_VIEW=off -DTULLE_BUILD_TESTS=OFF >"$work/log" 2>&1 &&
    cmake --build "$work/build" --target tulle_program -j 2 >>"$work/log" 2>&1 || { tail -30 "$work/log"; exit 1; }
cd "$work"
cat >scene.yaml <<END
time: {step: 1/90 s, frames: 1}
cloth: [{name: cloth, mesh: {shape: rectangle, size: [1, 1], resolution: [4, 4]}, material: {preset: cotton}}]
END
program=$work/build/tulle
"$program" run scene.yaml -o run --progress none >run.log 2>&1 || { cat run.log; exit 1; }
code=0
said=$("$program" render run -o picture.png 2>&1) || code=$?
echo "$said"
case $said in *"built without Embree"*"libembree-dev"*) ;; *) echo "the message does not say what to do"; exit 1 ;; esac
[ $code = 2 ] || { echo "exit $code, not 2"; exit 1; }
[ ! -e picture.png ] || { echo "a picture was left behind"; exit 1; }
code=0
said=$("$program" view scene.yaml 2>&1) || code=$?
echo "$said"
case $said in *"built without the viewer"*"libwebsockets-dev"*"make view"*) ;; *) echo "the message does not say what to do"; exit 1 ;; esac
[ $code = 2 ] || { echo "exit $code, not 2"; exit 1; }
