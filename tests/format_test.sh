#!/usr/bin/env bash
# Fails when a C or C++ file is not formatted as .clang-format says; prints the files.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
find engine_client server tests -name node_modules -prune -o \
  \( -name '*.h' -o -name '*.cc' -o -name '*.c' \) -print0 | xargs -0 clang-format --dry-run -Werror
