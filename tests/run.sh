#!/usr/bin/env bash
# Installs what is missing, builds, runs every test and prints ctest's summary last.
#
#   tests/run.sh                    the default suite (preset dev)
#   tests/run.sh asan tsan          the same tests under AddressSanitizer + UBSan, then under ThreadSanitizer
#   tests/run.sh release --quick    builds what is shipped, runs only what shows that programs and package work
#   tests/run.sh dev -R Grid        arguments from the first other option on go to ctest
#
# Warnings are errors in all of them. A run that passed, of a tree that is committed, leaves the tree's hash in
# build/PRESET/passed; one that ctest's options narrowed does not, nor does a quick one.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tests/passed.sh
source tests/passed.sh

readonly quick_tests='^(install_consumer|subproject|check_mixtures|c_api(_static)?[.].*|plugin[.].*|readme_program|GoldenLog.*)$'
# What these run.
readonly quick_targets=(proto/all server/all engine_client/all tests/engine_client/c_api/all tests/laboratory/all decider_test)

presets=()
quick=
while (($# > 0)); do
  case $1 in
    dev | release | asan | tsan) presets+=("$1") ;;
    --quick) quick=yes ;;
    --help)
      sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -*) break ;;
    *)
      echo "Unknown preset '$1'. Presets: dev release asan tsan. Options: --quick, --help, and those of ctest." >&2
      exit 2
      ;;
  esac
  shift
done
((${#presets[@]} > 0)) || presets=(dev)
narrowed=$*
targets=()
if [[ -n $quick ]]; then
  set -- -R "$quick_tests" "$@"
  targets=(--target "${quick_targets[@]}")
fi

tree=$(tree_to_test)
for preset in "${presets[@]}"; do forget_passed "$preset"; done

# With the libraries that `sweepstake-lab bench --peers` compares with, the browser that the reports are tested in, the
# Prometheus that reads the daemon's metrics, the HAProxy that stands before it, and the PostgreSQL that several share.
deploy/install_packages.sh libbullet-dev libfcl-dev libode-dev libembree-dev libcgal-dev chromium prometheus haproxy postgresql clang libclang-rt-dev llvm
# What the archive and the plug-in of the C ABI bring along. Without apt CMake takes the system's, or says what it leaves out.
if command -v apt-get >/dev/null; then deploy/static_highway.sh; fi
for folder in tests/proto server/dashboard tests/laboratory/report; do
  (cd "$folder" && npm ci --no-audit --no-fund --silent) || {
    echo "npm could not install what $folder/package-lock.json lists." >&2
    exit 1
  }
done
# A program without the report's page is a failure here, not a reason to skip its tests. (The daemon takes each
# SWEEPSTAKE_… of the environment for a setting.)
export REQUIRE_REPORT_PAGE=1

jobs=$(nproc)
for preset in "${presets[@]}"; do
  echo "== preset $preset =="
  cmake --preset "$preset" -DSWEEPSTAKE_WERROR=ON
  cmake --build --preset "$preset" -j "$jobs" "${targets[@]}"
done
if ! command -v dotnet >/dev/null; then
  echo "******** LEFT OUT: the C# tests of the Unity package, for want of the .NET SDK 10 (tests/unity_client/dotnet_test.sh says how to get it) ********"
fi
# All builds come first, so that what a reader sees last is ctest's summary.
for preset in "${presets[@]}"; do
  ctest --preset "$preset" -j "$jobs" "$@"
  [[ -n $narrowed || -n $quick ]] || leave_passed "$preset" "$tree"
done
