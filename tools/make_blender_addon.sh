#!/bin/sh
# Makes build/tulle_addon.zip: the add-on for Blender with the program inside, linked statically and without pictures, so that it
# runs where none of our libraries is installed.
# usage: make_blender_addon.sh [JOBS]
set -eu
cd "$(dirname "$0")/.."
find_archive() { # NAME
    path=$(${CC:-cc} -print-file-name="lib$1.a")
    [ -f "$path" ] || { echo "lib$1.a is not there: install the package with the static library" >&2; exit 1; }
    echo "$path"
}
png=$(find_archive png) zlib=$(find_archive z) expat=$(find_archive expat) yaml=$(find_archive yaml)
cmake -B build/addon -DCMAKE_BUILD_TYPE=Release -DTULLE_BUILD_TESTS=OFF -DTULLE_INSTALL=OFF -DTULLE_EMBREE=off -DTULLE_VIEW=off \
    -DCMAKE_EXE_LINKER_FLAGS=-static -DPNG_LIBRARY_RELEASE="$png" -DPNG_LIBRARY="$png" -DZLIB_LIBRARY_RELEASE="$zlib" \
    -DZLIB_LIBRARY="$zlib" -DEXPAT_LIBRARY="$expat" -Dpkgcfg_lib_YAML_yaml="$yaml" >build/addon.log 2>&1 || { cat build/addon.log >&2; exit 1; }
cmake --build build/addon -j "${1:-2}" --target tulle_program
python3 blender/package.py build/addon/tulle build/tulle_addon.zip
echo "the add-on is build/tulle_addon.zip: Blender > Edit > Preferences > Add-ons > Install"
