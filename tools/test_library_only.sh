#!/bin/sh
# Configures and builds libtulle alone, where nothing but a C compiler, make and CMake can be found: no pkg-config, no
# Python, no library. A small host is linked against it and gives the golden hash.
# usage: test_library_only.sh SOURCE_DIRECTORY
set -eu
source=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT

# A folder with the programs that may be used; CMake is told to look nowhere else.
mkdir "$work/bin"
for program in cmake make sh cc gcc as ld ar ranlib objcopy nm strip ${CMAKE_C_COMPILER_LAUNCHER:-}; do
    found=$(command -v "$program") || continue
    ln -s "$found" "$work/bin/$program"
done
cat >"$work/nothing.cmake" <<'END'
set(CMAKE_FIND_USE_SYSTEM_ENVIRONMENT_PATH ON)
set(CMAKE_DISABLE_FIND_PACKAGE_PkgConfig ON)
foreach(package PNG EXPAT ZLIB CGAL Python3 Threads)
    set(CMAKE_DISABLE_FIND_PACKAGE_${package} ON)
endforeach()
END
configure() { # BUILD OPTIONS...
    build=$1
    shift
    PATH=$work/bin CC= CXX= cmake -S "$source" -B "$build" -G "Unix Makefiles" -DTULLE_PROGRAM=OFF -DCMAKE_BUILD_TYPE=Debug -DTULLE_WARNINGS_AS_ERRORS=ON \
        -DCMAKE_PROJECT_TOP_LEVEL_INCLUDES="$work/nothing.cmake" "$@" >"$work/log" 2>&1
}
configure "$work/build" || { cat "$work/log"; exit 1; }
if grep -iE 'yaml|png|expat|zlib|embree|pkg-config|cmocka|CXX' "$work/build/CMakeCache.txt" | grep -v '^TULLE_'; then
    echo "the library alone looked for something that it does not need"
    exit 1
fi
PATH=$work/bin cmake --build "$work/build" -j 2 >"$work/log" 2>&1 || { tail -30 "$work/log"; exit 1; }
foreign=$(find "$work/build" -maxdepth 2 -type f \( -name '*.a' -o -name '*.so*' -o -perm -100 \) ! -name 'libtulle.*' ! -path '*/CMakeFiles/*')
[ -z "$foreign" ] || { echo "the library alone built more than itself: $foreign"; exit 1; }
if readelf -d "$work/build/libtulle.so" | grep NEEDED | grep -vE 'lib[cm]\.so|libpthread\.so|ld-linux'; then
    echo "libtulle.so needs more than libc, libm and threads"
    exit 1
fi

${CC:-cc} -std=c17 -Wall -Werror -I"$source/include" "$source/test/host/world_host.c" "$work/build/libtulle.a" -lm -lpthread -o "$work/host"
golden=$(sed -n 's/.*GOLDEN = UINT64_C(0x\([0-9a-f]*\)).*/\1/p' "$source/test/world/test_golden.c")
said=$("$work/host")
[ "$said" = "$golden" ] || { echo "the host's hash is $said, not $golden"; exit 1; }

# Installed, it is found and linked; the second library is not there.
cmake --install "$work/build" --prefix "$work/prefix" >"$work/log"
[ ! -e "$work/prefix/include/tulle_io" ] && [ ! -e "$work/prefix/bin" ] || { echo "more than libtulle was installed"; exit 1; }
# The second library is built when it is asked for, and then needs what it needs.
if configure "$work/other" -DTULLE_IO=ON; then
    echo "libtulle_io was configured where libyaml cannot be found"
    exit 1
fi
echo "library only: builds with a C compiler and nothing else; a host has the golden hash"
