#!/bin/sh
# Lays out every C and C++ file as .clang-format says; with --check only names the files that are laid out otherwise.
set -eu
cd "$(dirname "$0")/.."
command -v clang-format >/dev/null || { echo "clang-format is missing; tools/install_packages.sh test installs it" >&2; exit 2; }
list() { find src include test fuzz examples bench paper tools -name '*.[ch]' -print0 -o -name '*.cpp' -print0 2>/dev/null; }
if [ "${1:-}" = --check ]; then
    list | xargs -0 clang-format --dry-run -Werror --ferror-limit=1 || { echo "run \`make format\`"; exit 1; }
    echo "format: all files are laid out as .clang-format says"
else
    list | xargs -0 clang-format -i
fi
