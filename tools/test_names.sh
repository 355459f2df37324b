#!/bin/sh
# Links hosts that have functions with all inner names of the libraries (arena_allocate, parallel_for, hash_bytes and
# hundreds more) against the static libraries, and runs them: no name of ours is in a host's way.
# usage: test_names.sh BUILD_DIRECTORY     the C compiler is $CC or cc
set -eu
build=$(cd "$1" && pwd)
source=$(cd "$(dirname "$0")/.." && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

nm -g --defined-only "$build/libtulle_inside.a" "$build/libtulle_io_inside.a" | awk 'NF == 3 { print $3 }' |
    grep '^[a-z][a-z0-9_]*$' | grep -v '^tulle_' | sort -u >"$work/names"
for name in arena_allocate parallel_for hash_bytes json_read; do
    grep -q "^$name" "$work/names" || { echo "$name is no inner name; is the list empty?"; exit 1; }
done
{
    echo '#include <stdlib.h>'
    sed 's/.*/void &(void);\nvoid &(void) { abort(); }/' "$work/names"
} >"$work/names.c"

flags="-std=c17 -O1 -fno-builtin -Wall -Werror -I$source/include"
# shellcheck disable=SC2086
${CC:-cc} $flags -c "$work/names.c" -o "$work/names.o"
# shellcheck disable=SC2086
${CC:-cc} $flags "$source/test/host/world_host.c" "$work/names.o" "$build/libtulle.a" -lm -lpthread -o "$work/world_host"
# shellcheck disable=SC2086
${CC:-cc} $flags "$source/test/host/files_host.c" "$work/names.o" "$build/libtulle_io.a" "$build/libtulle.a" \
    -lyaml -lexpat -lz -lm -lpthread -o "$work/files_host"

golden=$(sed -n 's/.*GOLDEN = UINT64_C(0x\([0-9a-f]*\)).*/\1/p' "$source/test/world/test_golden.c")
said=$("$work/world_host")
[ "$said" = "$golden" ] || { echo "the host's hash is $said, not $golden"; exit 1; }
"$work/files_host" "$source/test/e2e/scenes/small.yaml" "$work/cloth.obj" >/dev/null
echo "names: hosts with $(wc -l <"$work/names") functions of our inner names link and run, with the golden hash"
