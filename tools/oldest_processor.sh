#!/bin/sh
# Runs test programs on an emulated x86-64 processor without any extension: SSE2 is the widest that it has, and any newer
# instruction ends the program. So what is chosen at run time is chosen right, and gives the same bits.
# usage: oldest_processor.sh PROGRAM...      exit 77: skipped
set -eu
[ "$(uname -m)" = x86_64 ] || { echo "skipped: this is no x86-64 machine"; exit 77; }
command -v qemu-x86_64 >/dev/null || { echo "skipped: qemu-x86_64 is missing (apt-get install qemu-user)"; exit 77; }
export TULLE_TEST_EMULATED=1
for program in "$@"; do
    echo "$(basename "$program"):"
    qemu-x86_64 -cpu qemu64,-sse3,-cx16 "$program"
done
