#!/bin/sh
# Chooses the kept corpus of targets anew: of the working corpus, the seeds and what is kept, few small inputs that reach the same
# edges. fuzz/README.md.
# usage: keep.sh TARGET...      without a target: all
set -eu
cd "$(dirname "$0")/.."
build=${TULLE_FUZZ_BUILD:-build/fuzz}
[ $# -gt 0 ] || set -- $(for source in fuzz/targets/*.c; do basename "$source" .c; done)
most_files=40 most_bytes=4096
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
TULLE_FUZZ_FOLDER=$work
export TULLE_FUZZ_FOLDER CMOCKA_TEST_ABORT=1

for target in "$@"; do
    kept=fuzz/corpus/$target
    mkdir -p "$kept" "$work/all" "$work/few"
    for folder in "$build/corpus/$target" "$build/seeds/$target" "$kept"; do
        find "$folder" -type f -size -$((most_bytes + 1))c -exec cp {} "$work/all/" \;
    done
    "$build/fuzz/fuzz_$target" -set_cover_merge=1 -use_counters=0 -close_fd_mask=3 -timeout=20 "$work/few" "$work/all" >"$work/log" 2>&1 ||
        { cat "$work/log" >&2; exit 1; }
    # Beyond so many files those that are new last, so the ones that add least, stay out.
    rm -f "$kept"/*
    find "$work/few" -type f -printf '%T@ %p\n' | sort -n | head -n $most_files | cut -d ' ' -f 2 | while read -r path; do
        cp "$path" "$kept/"
    done
    printf '%-12s %4s of %5s inputs, %6s bytes\n' "$target" "$(find "$kept" -type f | wc -l)" "$(find "$work/few" -type f | wc -l)" \
        "$(cat "$kept"/* | wc -c)"
    rm -rf "$work/all" "$work/few"
done
