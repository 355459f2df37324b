#!/bin/sh
# Runs all tests in their long forms, which takes hours. What was interrupted goes on: a test that has passed is noted in
# BUILD/long_passed.txt and not run again, unless a file of the project or the build's settings have changed since.
# usage, from the project's root: long_tests.sh BUILD CTEST [OPTION...]
set -eu

build=$1
shift
notes=long_passed.txt
state=$({
    find . \( -name .git -o -name __pycache__ -o -path ./build -o -path ./out -o -path './reproduced*' \) -prune \
        -o -type f -print | LC_ALL=C sort | xargs -d '\n' cksum
    cksum "$build/CMakeCache.txt"
} | cksum)

cd "$build"
if [ ! -f $notes ] || [ "$(head -n 1 $notes)" != "$state" ]; then
    echo "$state" >$notes
fi
passed=$(tail -n +2 $notes | sed 's/\./\\./g' | paste -sd '|' -)
if [ -n "$passed" ]; then
    echo "$(tail -n +2 $notes | wc -l) tests have passed before: $build/$notes"
    set -- "$@" --no-tests=ignore -E "^($passed)\$"
fi

# A shell notes each line as it comes; awk may wait for more. The exit code of a pipe's first part is
# lost in sh, so it goes through a file.
{
    code=0
    TULLE_TEST_LONG=1 "$@" || code=$?
    echo "$code" >long_code.txt
} | while IFS= read -r line; do
    printf '%s\n' "$line"
    case $line in
    *' Test '*'#'*': '*' Passed '* | *' Test '*'#'*': '*'***Skipped'*)
        case ${line%%/*} in *[!\ 0-9]*) continue ;; esac # what a test has printed
        line=${line#*: }
        echo "${line%% *}" >>$notes
        ;;
    esac
done
code=$(cat long_code.txt)
rm long_code.txt
[ "$code" != 0 ] || rm $notes
exit "$code"
