#!/bin/sh
# Makes the experiments of the paper again: starts the package `reproduce` with a Python 3 that has what it needs, and with the
# package `tulle` that lies beside the program.
# usage: reproduce.sh FIGURE ... [options]      --help tells more
# Without matplotlib all but the plots is made.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
program=$here/../build/release/tulle
before=
for word in "$@"; do
    case $before in --tulle) program=$word ;; esac
    case $word in --tulle=*) program=${word#--tulle=} ;; esac
    before=$word
done
python=$(sh "$here/find_python.sh" 'numpy, cffi, matplotlib') || python=$(sh "$here/find_python.sh" 'numpy, cffi') ||
    { echo "reproduce: there is no python3 with numpy and cffi: sh tools/install_packages.sh paper installs them" >&2; exit 2; }
export PYTHONPATH="$here:$(dirname "$program")/python:$here/../build/release/python${PYTHONPATH:+:$PYTHONPATH}" PYTHONDONTWRITEBYTECODE=1
"$python" -c 'import tulle' 2>/dev/null || { echo "reproduce: the Python package is not built: make python" >&2; exit 2; }
exec "$python" -m reproduce "$@"
