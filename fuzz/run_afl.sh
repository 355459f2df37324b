#!/bin/sh
# Fuzzes one target with AFL++: fuzz/README.md.
# usage: run_afl.sh SECONDS TARGET
#
# AFL++ begins with the seeds and with what is kept in fuzz/corpus; a later call goes on. Exit code 1 if there are findings.
set -eu
cd "$(dirname "$0")/.."
build=build/fuzz-afl
seconds=$1 target=$2
replay=$build/fuzz/replay_$target
[ -x "$replay" ] || { echo "there is no target $target; see fuzz/targets" >&2; exit 2; }
TULLE_FUZZ_FOLDER=$(mktemp -d "$([ -w /dev/shm ] && echo /dev/shm || echo /tmp)/tulle-fuzz-run-XXXXXX")
trap 'rm -rf "$TULLE_FUZZ_FOLDER"' EXIT
trap 'exit 130' INT TERM
export TULLE_FUZZ_FOLDER CMOCKA_TEST_ABORT=1
export AFL_SKIP_CPUFREQ=1 AFL_I_DONT_CARE_ABOUT_MISSING_CRASHES=1 AFL_NO_UI=1 AFL_AUTORESUME=1 AFL_CRASH_EXITCODE=1

rm -rf "$build/inputs/$target"
mkdir -p "$build/inputs/$target" "$build/out"
"$replay" --seeds "$build/inputs/$target"
for folder in "fuzz/corpus/$target" "test/regress/$target"; do
    [ ! -d "$folder" ] || cp "$folder"/* "$build/inputs/$target/"
done
dictionary=
[ ! -e "fuzz/dictionaries/$target.dict" ] || dictionary="-x fuzz/dictionaries/$target.dict"
# shellcheck disable=SC2086
afl-fuzz -V "$seconds" -t 20000 $dictionary -i "$build/inputs/$target" -o "$build/out/$target" -- "$replay" >"$build/out/$target.log" 2>&1 ||
    { tail -n 20 "$build/out/$target.log" >&2; exit 2; }
grep -E '^(execs_done|edges_found|corpus_count|saved_crashes|saved_hangs) ' "$build/out/$target/default/fuzzer_stats"
found=$(find "$build/out/$target/default/crashes" "$build/out/$target/default/hangs" -name 'id*' | wc -l)
[ "$found" -eq 0 ] && exit 0
echo "findings are in $build/out/$target/default; $replay <FILE shows one again" >&2
exit 1
