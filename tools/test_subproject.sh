#!/bin/sh
# Projects that take Tulle in by add_subdirectory, and by FetchContent: `all` builds nothing of Tulle that the host does not
# link, there are no tests, no rules for installing and no settings of ours in the host.
# usage: test_subproject.sh SOURCE_DIRECTORY
set -eu
source=$(cd "$1" && pwd)
work=$(mktemp -d)
trap 'rm -rf "$work"' EXIT
golden=$(sed -n 's/.*GOLDEN = UINT64_C(0x\([0-9a-f]*\)).*/\1/p' "$source/test/world/test_golden.c")

mkdir "$work/plain" "$work/fetched"
cat >"$work/plain/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(host LANGUAGES C)
add_subdirectory("$source" tulle)
if(CMAKE_C_STANDARD OR CMAKE_BUILD_TYPE)
    message(FATAL_ERROR "Tulle changed settings of the host")
endif()
get_property(flags DIRECTORY PROPERTY COMPILE_OPTIONS)
if(flags)
    message(FATAL_ERROR "Tulle added options to the host: \${flags}")
endif()
file(WRITE \${CMAKE_BINARY_DIR}/main.c "int main(void) { return 0; }\n")
add_executable(nothing \${CMAKE_BINARY_DIR}/main.c)
add_executable(host EXCLUDE_FROM_ALL "$source/test/host/world_host.c")
target_link_libraries(host PRIVATE tulle::tulle_static)
install(TARGETS nothing)
END
cat >"$work/fetched/CMakeLists.txt" <<END
cmake_minimum_required(VERSION 3.25)
project(host LANGUAGES C)
include(FetchContent)
set(TULLE_IO ON)
set(TULLE_PROGRAM OFF)
FetchContent_Declare(tulle SOURCE_DIR "$source")
FetchContent_MakeAvailable(tulle)
add_executable(files EXCLUDE_FROM_ALL "$source/test/host/files_host.c")
target_link_libraries(files PRIVATE tulle::tulle_io)
END
quietly() { "$@" >"$work/log" 2>&1 || { echo "$*:"; tail -30 "$work/log"; exit 1; }; }

quietly cmake -S "$work/plain" -B "$work/plain/build"
quietly cmake --build "$work/plain/build" -j 2
made=$(find "$work/plain/build" -name '*.o' -path '*tulle*')
[ -z "$made" ] || { echo "all builds parts of Tulle that nobody asked for:"; echo "$made" | head; exit 1; }
quietly cmake --install "$work/plain/build" --prefix "$work/prefix"
extra=$(find "$work/prefix" -type f ! -name nothing)
[ -z "$extra" ] || { echo "Tulle installed $extra"; exit 1; }
if (cd "$work/plain/build" && ctest -N) | grep -q 'Test *#'; then echo "Tulle added tests"; exit 1; fi
quietly cmake --build "$work/plain/build" -j 2 --target host
said=$("$work/plain/build/host")
[ "$said" = "$golden" ] || { echo "the host's hash is $said, not $golden"; exit 1; }

if command -v pkg-config >/dev/null; then
    quietly cmake -S "$work/fetched" -B "$work/fetched/build"
    quietly cmake --build "$work/fetched/build" -j 2 --target files
    "$work/fetched/build/files" "$source/test/e2e/scenes/small.yaml" "$work/cloth.obj" >/dev/null
fi
echo "subproject: a host gets what it links, and nothing more"
