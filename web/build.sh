#!/bin/sh
# Bundles the page of `tulle view` into OUT_DIR: index.html, app.js, app.css and icon.svg, which ask nobody for anything.
# The packages are fetched from npm once, into build/web of this checkout.
# usage: build.sh OUT_DIR [--dev]      --dev: also fetches what only tests need
set -eu
here=$(cd "$(dirname "$0")" && pwd)
place=$here/../build/web
fail() {
    echo "web: $1" >&2
    exit 1
}
[ $# -ge 1 ] || fail "usage: build.sh OUT_DIR [--dev]"
for program in node npm; do
    command -v $program >/dev/null || fail "$program is missing, so the page of tulle view is not built"
done
mkdir -p "$place" "$1"
place=$(cd "$place" && pwd)
# What was fetched for tests is enough for the page, too.
kept=$place/node_modules/.fetched
if ! cmp -s "$here/package-lock.json" "$kept" && ! { [ "${2:-}" != --dev ] && cmp -s "$here/package-lock.json" "$kept-page"; }; then
    [ "${TULLE_NO_INSTALL:-0}" != 1 ] || fail "build/web/node_modules is missing, and TULLE_NO_INSTALL forbids to fetch it"
    cp "$here/package.json" "$here/package-lock.json" "$here/.npmrc" "$place"
    omit=--omit=dev
    [ "${2:-}" != --dev ] || omit=--include=dev
    (cd "$place" && npm ci $omit --ignore-scripts --no-audit --no-fund --loglevel=error) >&2 || fail "npm could not fetch the packages"
    if [ "${2:-}" = --dev ]; then cp "$here/package-lock.json" "$kept"; else cp "$here/package-lock.json" "$kept-page"; fi
fi
NODE_PATH=$place/node_modules node "$here/bundle.mjs" "$1" || fail "esbuild could not bundle it"
