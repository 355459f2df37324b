#!/bin/sh
# Opens what tulle convert writes with other programs: Khronos' validator of glTF, three.js and tinyusdz in Node, and
# Blender. What is missing is left out, and said; exit code 77 when all is.
# usage: run.sh FOLDER      FOLDER: for npm's packages and the files; TULLE: the program
set -eu
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
cd "$1"
rm -rf files
mkdir files
sh "$here/make_scene.sh" files
opened=0
if command -v node >/dev/null && command -v npm >/dev/null; then
    cp "$here"/*.json "$here"/*.mjs .
    npm install --no-package-lock --no-audit --no-fund --ignore-scripts --loglevel=error
    node check.mjs files
    opened=1
else
    echo "skipped: glTF validator, three.js and tinyusdz; there is no node with npm"
fi
if command -v blender >/dev/null; then
    blender --background --factory-startup --python-exit-code 1 --python "$here/blender.py" -- files >blender.log 2>&1 || {
        cat blender.log
        exit 1
    }
    grep -e ' off$' -e floats -e '^Blender reads' blender.log
    opened=1
else
    echo "skipped: Blender is not there"
fi
[ $opened = 1 ] || exit 77
