#!/bin/sh
# Builds libtulle alone with another compiler or for another processor, links a small host statically or by its own loader,
# runs it, and compares the hash of its state with the golden one.
# usage: check_small_host.sh musl|m32|native [JOBS]     exit 77: skipped, as the compiler is missing
#   musl   musl-gcc, linked statically: there is no ifunc, and no library is loaded
#   m32    i686-linux-gnu-gcc with SSE2: 32-bit pointers
#   native -march=native: all that this processor has
set -eu
cd "$(dirname "$0")/.."
kind=$1 jobs=${2:-1}
build=build/$kind
case $kind in
musl) compiler=musl-gcc flags=-static loader="" ;;
native) compiler=cc flags=-march=native loader="" ;;
m32)
    compiler=i686-linux-gnu-gcc flags="-msse2 -mfpmath=sse"
    loader="/usr/i686-linux-gnu/lib/ld-linux.so.2 --library-path /usr/i686-linux-gnu/lib"
    ;;
*)
    echo "check_small_host.sh: \"$kind\" should be musl, m32 or native" >&2
    exit 2
    ;;
esac
command -v "$compiler" >/dev/null || { echo "skipped: $compiler is missing (make test-$kind installs it)"; exit 77; }
if [ "$kind" = m32 ] && [ "$(uname -m)" != x86_64 ]; then echo "skipped: this processor does not run x86"; exit 77; fi

cmake --preset "$kind"
cmake --build "$build" -j "$jobs"
# shellcheck disable=SC2086
"$compiler" $flags -std=c17 -O1 -Wall -Wextra -Werror -Iinclude test/host/world_host.c "$build/libtulle.a" -lm -lpthread -o "$build/world_host"
if nm "$build/libtulle.a" | awk '$2 == "i"' | grep .; then
    echo "$build/libtulle.a has functions that the loader would choose (ifunc)"
    exit 1
fi
if [ "$kind" = native ]; then
    code=0
    /usr/bin/python3 tools/check_baseline.py --fused "$build" || code=$?
    [ "$code" = 0 ] || [ "$code" = 77 ] || exit 1
fi
if [ "$kind" = m32 ] && ! $loader --version >/dev/null 2>&1; then # a kernel without 32-bit programs
    command -v qemu-i386 >/dev/null || { echo "skipped: this kernel runs no 32-bit programs, and qemu-i386 is missing (make test-m32 installs it)"; exit 77; }
    loader="qemu-i386 $loader"
fi
golden=$(sed -n 's/.*GOLDEN = UINT64_C(0x\([0-9a-f]*\)).*/\1/p' test/world/test_golden.c)
# shellcheck disable=SC2086
said=$($loader "$build/world_host")
[ "$said" = "$golden" ] || { echo "$kind: the host's hash is $said, not the golden $golden"; exit 1; }
echo "$kind: libtulle builds, a host links and runs, its hash $said is the golden one"
