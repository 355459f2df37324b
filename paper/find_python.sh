#!/bin/sh
# Prints the first python3 that has the modules: the first one on the PATH need not be Debian's, whose packages these are.
# usage: find_python.sh 'MODULE, ...'      exit 1 where none has them
for python in python3 /usr/bin/python3; do
    "$python" -c "import $1" 2>/dev/null || continue
    echo "$python"
    exit 0
done
exit 1
