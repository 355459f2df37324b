#!/bin/sh
# Installs a build into a temporary folder, moves it, then builds and runs small programs against both libraries through
# pkg-config and through CMake's find_package, shared and static, and as C++.
# usage: test_install.sh BUILD_DIRECTORY
set -eu
build=$1
source=$(cd "$(dirname "$0")/.." && pwd)
for program in cmake pkg-config cc; do
    command -v $program >/dev/null || { echo "skipped: $program is not installed"; exit 77; }
done
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

cmake --install "$build" --prefix "$work/first" >"$work/install.log"
mv "$work/first" "$work/prefix"
prefix=$work/prefix
library=$(dirname "$(find "$prefix" -name libtulle.so)")
version=$("$prefix/bin/tulle" --version | cut -d' ' -f2)
for file in include/tulle/tulle.h include/tulle_io/tulle_io.h share/man/man1/tulle.1 share/tulle/scenes/paper/rings.yaml share/tulle/scenes/sphere.yaml; do
    [ -s "$prefix/$file" ] || { echo "$file is not installed"; exit 1; }
done
for name in libtulle libtulle_io; do
    [ -e "$library/$name.so.$version" ] || { echo "$name.so.$version is not installed"; exit 1; }
    readelf -d "$library/$name.so" | grep -q "SONAME.*\[$name\.so\.${version%.*}\]" || { echo "$name.so has another soname"; exit 1; }
done

"$prefix/bin/tulle" run "$prefix/share/tulle/scenes/boxes.yaml" --set 'cloth[0].mesh.resolution=[20, 20]' --frames 2 -o "$work/run" \
    >"$work/run.log" 2>&1 || { echo "the installed program runs no installed scene:"; cat "$work/run.log"; exit 1; }

cat >"$work/consumer.c" <<'END'
#include <stdio.h>
#include <tulle/tulle.h>
int main(void) {
    puts(tulle_status_text(TULLE_ERROR_DISK_FULL));
    return 0;
}
END
cp "$source/test/host/files_host.c" "$source/test/e2e/scenes/small.yaml" "$work"
cat >"$work/CMakeLists.txt" <<'END'
cmake_minimum_required(VERSION 3.25)
project(consumer LANGUAGES C)
find_package(tulle 0.1 REQUIRED)
if(TARGET tulle::tulle_io)
    message(FATAL_ERROR "libtulle_io was not asked for")
endif()
add_executable(shared consumer.c)
target_link_libraries(shared PRIVATE tulle::tulle)
add_executable(static consumer.c)
target_link_libraries(static PRIVATE tulle::tulle_static)
if(BY_COMPONENT)
    find_package(tulle 0.1 REQUIRED COMPONENTS io)
else()
    find_package(tulle_io 0.1 REQUIRED)
endif()
add_executable(files_shared files_host.c)
target_link_libraries(files_shared PRIVATE tulle::tulle_io)
add_executable(files_static files_host.c)
target_link_libraries(files_static PRIVATE tulle::tulle_io_static)
END
expect() {
    said=$(LD_LIBRARY_PATH=$library "$1")
    [ "$said" = "disk full" ] || { echo "$1 said \"$said\""; exit 1; }
    echo "install: $2 works"
}

expect_files() {
    LD_LIBRARY_PATH=$library "$1" "$work/small.yaml" "$work/cloth.obj" >"$work/hash" || { echo "$1 failed"; exit 1; }
    grep -q '^[0-9a-f]\{16\}$' "$work/hash" || { echo "$1 printed no hash"; exit 1; }
    echo "install: $2 works"
}

export PKG_CONFIG_PATH="$library/pkgconfig"
[ "$(pkg-config --modversion tulle)" = "$version" ] || { echo "tulle.pc names another version than $version"; exit 1; }
# shellcheck disable=SC2046
cc -Wall -Werror "$work/consumer.c" -o "$work/with_pc" $(pkg-config --cflags --libs tulle)
expect "$work/with_pc" "pkg-config, shared"
# shellcheck disable=SC2046
cc -Wall -Werror "$work/consumer.c" -o "$work/with_a" $(pkg-config --cflags tulle) "$library/libtulle.a" \
    $(pkg-config --libs-only-l --static tulle | sed 's/-ltulle //')
expect "$work/with_a" "pkg-config, static"

# shellcheck disable=SC2046
cc -Wall -Werror "$work/files_host.c" -o "$work/files_with_pc" $(pkg-config --cflags --libs tulle_io)
expect_files "$work/files_with_pc" "tulle_io, pkg-config, shared"
# shellcheck disable=SC2046
cc -Wall -Werror "$work/files_host.c" -o "$work/files_with_a" $(pkg-config --cflags tulle_io) "$library/libtulle_io.a" "$library/libtulle.a" \
    $(pkg-config --libs-only-l --static tulle_io | sed 's/-ltulle_io //; s/-ltulle //')
expect_files "$work/files_with_a" "tulle_io, pkg-config, static"

for by_component in OFF ON; do
    cmake -S "$work" -B "$work/build" -DCMAKE_PREFIX_PATH="$prefix" -DBY_COMPONENT=$by_component >"$work/cmake.log" || { cat "$work/cmake.log"; exit 1; }
    cmake --build "$work/build" >"$work/cmake.log" || { cat "$work/cmake.log"; exit 1; }
    expect "$work/build/shared" "find_package, shared"
    expect "$work/build/static" "find_package, static"
    expect_files "$work/build/files_shared" "tulle_io, find_package, shared"
    expect_files "$work/build/files_static" "tulle_io, find_package, static"
    rm -rf "$work/build"
done

# shellcheck disable=SC2046
cc -Wall -Werror "$source/examples/detect_two_frames.c" -o "$work/detect_two_frames" $(pkg-config --cflags --libs tulle) -lm
LD_LIBRARY_PATH=$library "$work/detect_two_frames" | grep -q '^[1-9][0-9]* events$' || { echo "detect_two_frames found no events"; exit 1; }
echo "install: the detector's example works"

if command -v c++ >/dev/null; then
    cp "$work/consumer.c" "$work/consumer.cpp"
    # shellcheck disable=SC2046
    c++ -Wall -Wextra -Wpedantic -Werror "$work/consumer.cpp" -o "$work/with_cxx" $(pkg-config --cflags --libs tulle)
    expect "$work/with_cxx" "C++"
fi
# Each public header stands alone.
for header in "$prefix"/include/tulle/*.h "$prefix"/include/tulle_io/*.h; do
    echo "#include <${header#"$prefix"/include/}>" | cc -Wall -Wextra -Wpedantic -Werror -std=c17 -I"$prefix/include" -fsyntax-only -x c -
done
echo "install: every public header stands alone"
