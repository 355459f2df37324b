#!/bin/sh
# Bundles the viewer of notebooks into one file, python/tulle/viewer.js, which the package carries. Its packages are fetched from npm
# once, into build/viewer.
# usage: build.sh [--optional]      --optional: where it cannot be built, that is said and is no error
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$(cd "$here/../.." && pwd)
place=$root/build/viewer
fail() {
    echo "python/viewer: $1" >&2
    [ "${option:-}" != --optional ] || { echo "python/viewer: notebooks will show pictures that do not turn; make viewer builds the viewer" >&2; exit 0; }
    exit 1
}
option=${1:-}
for program in node npm; do
    command -v $program >/dev/null || fail "$program is missing, so the viewer is not built"
done
mkdir -p "$place"
if ! cmp -s "$here/package-lock.json" "$place/package-lock.json" || [ ! -e "$place/node_modules/.package-lock.json" ]; then
    [ "${TULLE_NO_INSTALL:-0}" != 1 ] || fail "build/viewer/node_modules is missing, and TULLE_NO_INSTALL forbids to fetch it"
    cp "$here/package.json" "$here/package-lock.json" "$here/.npmrc" "$place"
    (cd "$place" && npm ci --ignore-scripts --no-audit --no-fund --loglevel=error) >&2 || {
        rm -f "$place/package-lock.json"
        fail "npm could not fetch the packages"
    }
fi
# The licence of three.js goes with its code.
NODE_PATH=$place/node_modules "$place/node_modules/.bin/esbuild" "$here/src/main.js" --bundle --minify --format=iife \
    --global-name=tulleViewer --target=es2022 --loader:.css=text --log-level=warning --legal-comments=none \
    --banner:js="/* three.js: $(cat "$place/node_modules/three/LICENSE") */" --outfile="$place/viewer.js" ||
    fail "esbuild could not bundle it"
cp "$place/viewer.js" "$root/python/tulle/viewer.js"
