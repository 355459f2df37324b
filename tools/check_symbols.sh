#!/bin/sh
# Checks that the shared library exports every function of the public headers that is built, and nothing else.
# usage: check_symbols.sh LIBRARY
set -eu
exported=$(nm -D --defined-only "$1" | awk '{print $3}' | sed 's/@.*//')
foreign=$(echo "$exported" | grep -v '^tulle_' || true)
if [ -n "$foreign" ]; then
    echo "$1 exports names of its own:"
    echo "$foreign"
    exit 1
fi
count=$(echo "$exported" | grep -c '^tulle_')
echo "symbols: $count exported, all tulle_*"
[ "$count" -gt 0 ]
