#!/bin/sh
# Makes the experiments of the paper again: finds a Python 3 with numpy and matplotlib, and starts the package `reproduce` with it.
# usage: reproduce.sh FIGURE ... [options]      --help tells more
# The first python3 on the PATH need not be Debian's, whose packages these are. One without matplotlib makes all but the plots.
set -eu
here=$(cd "$(dirname "$0")" && pwd)
find_python() { # MODULES
    for python in python3 /usr/bin/python3; do
        "$python" -c "import $1" 2>/dev/null || continue
        echo "$python"
        return 0
    done
    return 1
}
python=$(find_python 'numpy, matplotlib') || python=$(find_python numpy) ||
    { echo "reproduce: there is no python3 with numpy: sh tools/install_packages.sh paper installs it" >&2; exit 2; }
PYTHONPATH="$here${PYTHONPATH:+:$PYTHONPATH}" PYTHONDONTWRITEBYTECODE=1 exec "$python" -m reproduce "$@"
