#!/usr/bin/env bash
# Meshes, scenes and animations of other projects, in the folder TULLE_WILD: each is read as another reader reads it, has a napkin
# dropped on it, and falls as cloth where it can; or it is refused by a message. wild.py has the rows. Skips where the folder is not there.
# .usda is compared where TULLE_TINYUSDZ names a folder in which `npm install tinyusdz` ran.
set -uo pipefail
here=$(cd "$(dirname "$0")" && pwd)
folder=${TULLE_WILD:-$here/../../../shared/data/wild}
[ -d "$folder" ] || { echo "skipped: no folder $folder; TULLE_WILD names one"; exit 77; }
command -v assimp >/dev/null || { echo "skipped: assimp is not there (package assimp-utils)"; exit 77; }
if ! { command -v node >/dev/null && [ -e "${TULLE_TINYUSDZ:-}/node_modules/tinyusdz/tinyusdz.js" ]; }; then
    echo "not compared: .usda; TULLE_TINYUSDZ names a folder in which npm installed tinyusdz, and node runs it"
    unset TULLE_TINYUSDZ
fi
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
exec python3 "$here/wild.py" "$folder" "$work" "${TULLE_WILD_TABLE:-$work/table.md}" "${TULLE_WILD_EVERY:-16}"
