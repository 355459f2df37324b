#!/bin/sh
# Fuzzes with libFuzzer and tells what came of it: fuzz/README.md.
# usage: run.sh SECONDS TARGET...     so many seconds, shared evenly; without a target: all
#
# The working corpus is build/fuzz/corpus/TARGET; it begins with the seeds and with what is kept in fuzz/corpus, and a later
# call goes on with it. Inputs that fail are in build/fuzz/findings/TARGET. Exit code 1 if this call found any.
#   TULLE_FUZZ_BUILD    the build folder (default build/fuzz)
#   TULLE_FUZZ_LENGTH   the longest input in bytes (default 16384); shorter ones are quicker
set -eu
cd "$(dirname "$0")/.."
build=${TULLE_FUZZ_BUILD:-build/fuzz}
seconds=$1
shift
[ $# -gt 0 ] || set -- $(for source in fuzz/targets/*.c; do basename "$source" .c; done)
share=$((seconds / $#))
[ $share -gt 0 ] || share=1

# An input that takes this long, or memory of this size, is a finding.
limits="-timeout=20 -report_slow_units=20 -rss_limit_mb=2048 -malloc_limit_mb=1024"
TULLE_FUZZ_FOLDER=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)/tulle-fuzz-run-XXXXXX")
export TULLE_FUZZ_FOLDER CMOCKA_TEST_ABORT=1
export ASAN_OPTIONS=detect_leaks=1:allocator_may_return_null=1 UBSAN_OPTIONS=print_stacktrace=1
trap 'rm -rf "$TULLE_FUZZ_FOLDER"' EXIT
trap 'exit 130' INT TERM

make_dictionary() { # TARGET: the words of its format, where there are any
    case $1 in
    scene) # every key and choice of the page that the program prints
        grep -o '`[a-z][a-z0-9_-]*`' docs/guide/scene.md | sort -u | sed 's/`\(.*\)`/"\1"/'
        printf '"%s"\n' ': ' '- ' '[0, 0, 1]' '{' '}' ' mm' ' deg' '1/90 s' '\x0a  ' 'mesh.obj' 'named.obj' 'frame_%%d.obj' 'never'
        ;;
    run | json) cat fuzz/dictionaries/run.dict ;;
    *) [ ! -e "fuzz/dictionaries/$1.dict" ] || cat "fuzz/dictionaries/$1.dict" ;;
    esac
}

prepare() { # TARGET: its folders, seeds and dictionary
    mkdir -p "$build/corpus/$1" "$build/seeds/$1" "$build/findings/$1" "$build/logs"
    "$build/fuzz/replay_$1" --seeds "$build/seeds/$1"
    [ "$1" != scene ] || cp scenes/*.yaml "$build/seeds/$1"
    { echo "# words of $1" && make_dictionary "$1"; } >"$build/seeds/$1.dict"
}

say_row() { printf '%-12s %12s %10s %10s %10s\n' "$@"; }

fuzz() { # TARGET
    prepare "$1"
    before=$(find "$build/findings/$1" -type f | wc -l)
    kept=fuzz/corpus/$1
    [ -d "$kept" ] || kept=
    regress=test/regress/$1
    [ -d "$regress" ] || regress=
    # What the target itself prints would fill the log.
    mask=0
    [ "$1" != arguments ] || mask=3
    code=0
    # libFuzzer ends at a finding. What is left of the share goes to the inputs beside it.
    end=$(($(date +%s) + share))
    : >"$build/logs/$1.log"
    while left=$((end - $(date +%s))) && [ $left -gt 0 ] && [ $code -lt 10 ]; do
        # shellcheck disable=SC2086
        "$build/fuzz/fuzz_$1" $limits -max_total_time=$left -print_final_stats=1 -close_fd_mask=$mask -max_len="${TULLE_FUZZ_LENGTH:-16384}" \
            -dict="$build/seeds/$1.dict" -artifact_prefix="$build/findings/$1/" "$build/corpus/$1" "$build/seeds/$1" $kept $regress \
            >>"$build/logs/$1.log" 2>&1 && break || code=$((code + 1))
    done
    found=$(($(find "$build/findings/$1" -type f | wc -l) - before))
    executions=$(awk '/stat::number_of_executed_units/ { sum += $2 } END { print sum + 0 }' "$build/logs/$1.log")
    edges=$(awk '{ for (i = 1; i < NF; i++) if ($i == "cov:") edges = $(i + 1) } END { print edges + 0 }' "$build/logs/$1.log")
    say_row "$1" "$executions" "$edges" "$(find "$build/corpus/$1" -type f | wc -l)" "$found"
    all_found=$((all_found + found))
    # An end without a finding is a fault of its own.
    if [ $code -gt 0 ] && [ $found -eq 0 ]; then
        echo "fuzz_$1 ended otherwise than by its time: $build/logs/$1.log" >&2
        all_found=$((all_found + 1))
    fi
}

all_found=0
say_row target executions edges inputs findings
for target in "$@"; do
    [ -x "$build/fuzz/fuzz_$target" ] || { echo "there is no target $target; see fuzz/targets" >&2; exit 2; }
    fuzz "$target"
done
[ $all_found -eq 0 ] && exit 0
echo "findings are in $build/findings; $build/fuzz/replay_TARGET FILE shows one again" >&2
exit 1
