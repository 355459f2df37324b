#!/bin/sh
# Checks that a library exports every function of its public headers, and nothing else.
# usage: check_symbols.sh HEADER_DIRECTORY LIBRARY...     LIBRARY: shared (.so) or static (.a)
set -eu
headers=$1
shift
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
# Names behind TULLE_API and before the first bracket; a declaration may take two lines.
cat "$headers"/*.h | tr '\n' ' ' | grep -o 'TULLE_API [^;(]*(' | grep -o 'tulle_[a-z0-9_]*(' | tr -d '(' | sort -u >"$work/declared"
[ -s "$work/declared" ] || { echo "no functions are declared in $headers"; exit 1; }
for library in "$@"; do
    case $library in *.a) kind=-g ;; *) kind=-D ;; esac
    nm "$kind" --defined-only "$library" | awk 'NF == 3 { print $3 }' | sed 's/@.*//' | sort -u >"$work/exported"
    if ! cmp -s "$work/declared" "$work/exported"; then
        echo "$library: names that it exports and that are declared in $headers differ (> exported, < declared):"
        diff "$work/declared" "$work/exported" | grep '^[<>]'
        exit 1
    fi
    echo "symbols: $(basename "$library") exports $(wc -l <"$work/exported") names, those of $headers"
done
