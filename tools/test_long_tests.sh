#!/bin/sh
# long_tests.sh with a CTest that is made up: what passed is not run again, what failed is, and a changed file starts anew.
set -eu

tool=$(cd "$(dirname "$0")" && pwd)/long_tests.sh
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
cd "$folder"
mkdir -p build src
echo settings >build/CMakeCache.txt
echo code >src/file.c

# Tells its options, then as CTest does how three tests ended. Fails while there is a file `broken`.
cat >fake_ctest.sh <<'END'
#!/bin/sh
echo "options: $*"
echo '1/3 Test  #1: made.up ...................   Passed    3.18 sec'
echo '2/3 Test #12: made.skipped ...................***Skipped   1.37 sec'
[ -f "$(dirname "$0")/build/hangs" ] && exec sleep 20
[ -f "$(dirname "$0")/build/broken" ] || exit 0
echo '3/3 Test #13: made.wrong .................***Failed    0.20 sec'
exit 8
END
chmod +x fake_ctest.sh

# check WHAT EXPECTED-CODE OPTIONS: runs the tool.
check() {
    code=0
    sh "$tool" build ../fake_ctest.sh -j 2 >build/out.txt 2>&1 || code=$?
    if [ "$code" != "$2" ] || ! grep -qxF "options: $3" build/out.txt; then
        echo "$1: exit code $code instead of $2, or other options than '$3':"
        cat build/out.txt
        exit 1
    fi
    rm build/out.txt
}

# What has passed is noted at once: the machine may go off.
touch build/hangs
sh "$tool" build ../fake_ctest.sh -j 2 >build/out.txt 2>&1 &
for _ in $(seq 100); do
    grep -q made.skipped build/long_passed.txt 2>/dev/null && break
    sleep 0.1
done
pkill -P "$(pgrep -d , -P $!)" 2>/dev/null || true
pkill -P $! 2>/dev/null || true
wait $! 2>/dev/null || true
grep -q made.skipped build/long_passed.txt || { echo "nothing is noted while tests run"; exit 1; }
rm build/hangs build/long_passed.txt

touch build/broken
check "first run" 8 "-j 2"
check "what passed is left out" 8 "-j 2 --no-tests=ignore -E ^(made\\.up|made\\.skipped)\$"
echo "other code" >src/file.c
check "a changed file" 8 "-j 2"
echo "other settings" >build/CMakeCache.txt
check "other settings of the build" 8 "-j 2"
rm build/broken
check "the rest passes" 0 "-j 2 --no-tests=ignore -E ^(made\\.up|made\\.skipped)\$"
check "all passed, so all are run" 0 "-j 2"
echo "long_tests.sh: ok"
