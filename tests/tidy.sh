#!/usr/bin/env bash
# Runs clang-tidy over all our sources with the compile commands of preset dev, which must be configured. It is slow and not
# part of the default suite.
#
#   tests/tidy.sh                 everything
#   tests/tidy.sh server/storage  one folder
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
command -v clang-tidy >/dev/null || { echo "clang-tidy is missing: apt-get install clang-tidy" >&2; exit 1; }
[ -f build/dev/compile_commands.json ] || { echo "Build preset dev first: tests/run.sh" >&2; exit 1; }
(($# > 0)) || set -- engine_client server tests
find "$@" -name '*.cc' -not -path '*/install_consumer/*' -print0 2>/dev/null |
  xargs -0 -P "$(nproc)" -n 1 clang-tidy -p build/dev --quiet
