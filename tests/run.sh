#!/usr/bin/env bash
# Installs what is missing, builds, runs every test and prints ctest's summary last.
#
#   tests/run.sh               the default suite (preset dev)
#   tests/run.sh asan tsan     the same tests under AddressSanitizer + UBSan, then under ThreadSanitizer
#   tests/run.sh dev -R Grid   arguments from the first option on go to ctest
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

presets=()
while (($# > 0)) && [[ $1 != -* ]]; do
  case $1 in
    dev | release | asan | tsan) presets+=("$1") ;;
    --help) ;;
    *)
      echo "Unknown preset '$1'. Presets: dev release asan tsan." >&2
      exit 2
      ;;
  esac
  shift
done
if [[ ${1:-} == --help ]]; then
  sed -n '2,6s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
  exit 0
fi
((${#presets[@]} > 0)) || presets=(dev)

# With the libraries that `sweepstake bench --peers` compares with.
deploy/install_packages.sh libbullet-dev libfcl-dev libode-dev libembree-dev libboost-dev libcgal-dev
(cd tests/proto && npm ci --no-audit --no-fund --silent)

jobs=$(nproc)
for preset in "${presets[@]}"; do
  echo "== preset $preset =="
  cmake --preset "$preset"
  cmake --build --preset "$preset" -j "$jobs"
done
# All builds come first, so that what a reader sees last is ctest's summary.
for preset in "${presets[@]}"; do
  ctest --preset "$preset" -j "$jobs" "$@"
done
