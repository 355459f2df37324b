#!/bin/sh
# Compiles library, program and some tests for arm64 with Debian's cross compiler, warnings are errors; then runs the
# tests, with the golden hash among them, by qemu-aarch64. All of it goes into build/arm64. The libraries of the program
# (as arm64 packages) are fetched by apt-get into build/arm64/root; nothing of the system is changed.
# usage: check_arm64.sh [JOBS]     exit 77: skipped, as the cross compiler is missing
set -eu
cd "$(dirname "$0")/.."
jobs=${1:-1}
made=$PWD/build/arm64
packages="libyaml-dev libpng-dev libexpat1-dev zlib1g-dev libgmp-dev libcmocka-dev libcmocka0"
tests="base.base base.parallel contact.project_impulses dynamics.forces math.linear_algebra math.single_solve
    math.nested_aggregates world.golden world.memory"

for program in aarch64-linux-gnu-gcc pkg-config apt-get dpkg-deb; do
    command -v "$program" >/dev/null || { echo "skipped: $program is missing (make check-arm64 installs what it can)"; exit 77; }
done

# apt-get with lists of its own, of arm64 packages only.
fetch_packages() {
    mkdir -p "$made/apt/lists/partial" "$made/apt/cache/archives/partial" "$made/packages"
    own="-q -o APT::Architecture=arm64 -o Dir::State=$made/apt -o Dir::State::status=/dev/null -o Dir::Cache=$made/apt/cache"
    # shellcheck disable=SC2086
    apt-get $own update && (cd "$made/packages" && apt-get $own download $packages)
}
if [ ! -e "$made/root/whole" ]; then
    rm -rf "$made/packages" "$made/root"
    mkdir -p "$made"
    fetch_packages >"$made/packages.log" 2>&1 || { cat "$made/packages.log"; echo "skipped: the arm64 packages cannot be fetched"; exit 77; }
    mkdir -p "$made/root"
    for package in "$made/packages"/*.deb; do dpkg-deb -x "$package" "$made/root"; done
    touch "$made/root/whole"
fi

cmake -S . -B "$made/build" -DCMAKE_TOOLCHAIN_FILE="$PWD/cmake/arm64.cmake" -DCMAKE_BUILD_TYPE=Release \
    -DTULLE_BUILD_TESTS=ON -DTULLE_WARNINGS_AS_ERRORS=ON -DTULLE_EMBREE=off -DTULLE_VIEW=off
targets="tulle_program tulle_shared tulle_static tulle_io_shared tulle_io_static"
pattern=""
for test in $tests; do
    targets="$targets ${test%%.*}_test_${test#*.}"
    pattern="$pattern|$test"
done
# shellcheck disable=SC2086
cmake --build "$made/build" -j "$jobs" --target $targets
if ! command -v qemu-aarch64 >/dev/null; then
    echo "compiled for arm64; nothing was run: qemu-aarch64 is missing (apt-get install qemu-user)"
    exit 0
fi
(cd "$made/build" && ctest --output-on-failure -j "$jobs" -R "^(${pattern#|})\$")
echo "compiled for arm64; the tests pass there, with the same golden hash"
