#!/bin/sh
# Looks at views of worlds, runs and meshes in Debian's Chromium: test/check_pages.mjs says at what. Pictures stay in build/viewer/pages.
# usage: test.sh      PYTHONPATH leads to the package
set -eu
here=$(cd "$(dirname "$0")" && pwd)
place=$here/../../build/viewer
python=$(sh "$here/../../paper/find_python.sh" 'cffi, numpy')
rm -rf "$place/pages"
mkdir -p "$place/pages"
"$python" "$here/test/make_pages.py" "$place/pages"
node "$here/test/check_pages.mjs" "$place" "$(command -v chromium)"
