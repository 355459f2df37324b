#!/bin/sh
# Tests the page of `tulle view`: its types, its messages, and the page in Debian's Chromium over the real program. Pictures stay in
# build/web/pictures.
# usage: test.sh TULLE [PATTERN]      PATTERN: only checks whose names match
set -eu
here=$(cd "$(dirname "$0")" && pwd)
root=$here/..
tulle=$(realpath "$1")
place=$root/build/web
sh "$here/build.sh" "$place/page" --dev
place=$(cd "$place" && pwd)
# The compiler looks for packages beside what it compiles.
rm -rf "$place/types"
mkdir -p "$place/types"
ln -s "$here/src" "$here/test" "$place/node_modules" "$place/types"
cp "$here/tsconfig.json" "$place/types"
"$place/node_modules/.bin/tsc" -p "$place/types"
echo "the types are right"
NODE_PATH=$place/node_modules "$place/node_modules/.bin/esbuild" "$here/test/protocol.ts" --bundle --platform=node --format=esm \
    --outfile="$place/test/protocol.mjs" --log-level=warning
node --test "$place/test/protocol.mjs" >"$place/test/protocol.txt" || { cat "$place/test/protocol.txt"; exit 1; }
sed -n 's/^# \(pass .*\)/unit tests: \1/p' "$place/test/protocol.txt"
for file in index.html app.css app.js; do
    printf '%s: %d bytes, %d compressed\n' $file "$(wc -c <"$place/page/$file")" "$(gzip -9 <"$place/page/$file" | wc -c)"
done
node "$here/test/check_page.mjs" "$place" "$tulle" "$(command -v chromium)" "${2:-}"
