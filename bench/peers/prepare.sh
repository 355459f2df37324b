#!/bin/sh
# Puts what bench-peers runs beside installed programs into DIR: MuJoCo's npm package, the driver of Bullet. What can not be
# had is told and left out; run.py then says so in its table.
# usage: prepare.sh DIR        TULLE_NO_INSTALL=1: fetches nothing
set -eu
here=$(cd "$(dirname "$0")" && pwd)
mkdir -p "$1"
if [ ! -e "$1/node_modules/@mujoco/mujoco" ] && [ "${TULLE_NO_INSTALL:-0}" != 1 ]; then
    cp "$here/package.json" "$here/package-lock.json" "$1"
    if command -v npm >/dev/null; then
        npm ci --prefix "$1" --no-audit --no-fund || echo "prepare.sh: npm could not fetch @mujoco/mujoco" >&2
    else
        echo "prepare.sh: npm is missing, so MuJoCo is left out" >&2
    fi
fi
rm -f "$1/bullet_driver"
if pkg-config --exists bullet 2>/dev/null && command -v c++ >/dev/null; then
    # -isystem: no warnings of the headers.
    # shellcheck disable=SC2046
    c++ -std=c++17 -O2 -o "$1/bullet_driver" "$here/bullet_driver.cpp" \
        $(pkg-config --cflags bullet | sed 's/-I */-isystem /g') $(pkg-config --libs bullet) ||
        echo "prepare.sh: the driver of Bullet does not compile" >&2
else
    echo "prepare.sh: libbullet-dev or a C++ compiler is missing, so Bullet is left out" >&2
fi
