#!/bin/sh
# Makes the experiments of the paper again: starts the package `reproduce` with a Python 3 that has what it needs.
# usage: reproduce.sh FIGURE ... [options]      --help tells more
# Without matplotlib all but the plots is made.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
python=$(sh "$here/find_python.sh" 'numpy, matplotlib') || python=$(sh "$here/find_python.sh" numpy) ||
    { echo "reproduce: there is no python3 with numpy: sh tools/install_packages.sh paper installs it" >&2; exit 2; }
PYTHONPATH="$here${PYTHONPATH:+:$PYTHONPATH}" PYTHONDONTWRITEBYTECODE=1 exec "$python" -m reproduce "$@"
