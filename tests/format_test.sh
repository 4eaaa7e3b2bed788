#!/usr/bin/env bash
# Fails if a C or C++ file is not formatted according to .clang-format; prints the files.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
find engine_client server tests -name node_modules -prune -o \
  \( -name '*.h' -o -name '*.cc' -o -name '*.c' \) -print0 | xargs -0 clang-format --dry-run -Werror
