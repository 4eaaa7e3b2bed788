#!/usr/bin/env bash
# Installs missing packages, builds, runs the tests and prints ctest's summary last.
#
#   tests/run.sh                    the default suite (preset dev)
#   tests/run.sh --long             also the long tests: benchmarks, PostgreSQL, C# of the Unity package, browsers
#   tests/run.sh asan tsan          the same tests under AddressSanitizer + UBSan, then under ThreadSanitizer
#   tests/run.sh release --quick    builds the shipped parts, and runs only basic tests of programs and package
#   tests/run.sh dev -R proxies        the first other option and all after it are passed to ctest
#
# Warnings are errors in all presets. If a complete run of a committed tree passes, the tree's hash is written to
# build/PRESET/passed; runs with options of ctest or --quick do not write it.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tests/passed.sh
source tests/passed.sh

readonly quick_tests='^(install_consumer|subproject|check_mixtures|c_api(_static)?[.].*|plugin[.].*|readme_program_c|decider[.].*)$'
# The targets that the quick tests need.
readonly quick_targets=(proto/all server/all engine_client/all tests/engine_client/c_api/all tests/laboratory/all decider_test readme_program_c)

presets=()
quick=
long=()
while (($# > 0)); do
  case $1 in
    dev | release | asan | tsan) presets+=("$1") ;;
    --quick) quick=yes ;;
    --long) long=(-C long) ;;
    --help)
      sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    -*) break ;;
    *)
      echo "Unknown preset '$1'. Presets: dev release asan tsan. Options: --quick, --long, --help, and those of ctest." >&2
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

# Includes the libraries for `sweepstake-lab bench --peers`, a browser for the tests of reports, Prometheus for the daemon's
# metrics, HAProxy as its proxy, PostgreSQL as the store of several daemons, and gRPC for the client in Python.
deploy/install_packages.sh libbullet-dev libfcl-dev libode-dev libbox2d-dev libembree-dev libcgal-dev chromium prometheus haproxy postgresql clang libclang-rt-dev llvm python3-grpcio python3-protobuf
# Needed in the archive and the plug-in of the C ABI. Without apt, CMake uses the system's Highway or prints what it leaves out.
if command -v apt-get >/dev/null; then deploy/static_highway.sh; fi
for folder in tests/proto server/dashboard tests/laboratory/report; do
  (cd "$folder" && npm ci --no-audit --no-fund --silent) || {
    echo "npm could not install the packages in $folder/package-lock.json." >&2
    exit 1
  }
done
# A program without the report's page fails here, instead of skipping its tests. (The name does not begin with SWEEPSTAKE_, because
# the daemon reads such variables as settings.)
export REQUIRE_REPORT_PAGE=1

jobs=$(nproc)
for preset in "${presets[@]}"; do
  echo "== preset $preset =="
  cmake --preset "$preset" -DSWEEPSTAKE_WERROR=ON
  cmake --build --preset "$preset" -j "$jobs" "${targets[@]}"
done
if ! command -v dotnet >/dev/null; then
  echo "******** LEFT OUT: the C# tests of the Unity package, because the .NET SDK 10 is missing (tests/unity_client/dotnet_test.sh prints how to install it) ********"
fi
# Build all presets first, so that ctest's summary is the last output.
for preset in "${presets[@]}"; do
  ctest --preset "$preset" -j "$jobs" "${long[@]}" "$@"
  [[ -n $narrowed || -n $quick ]] || leave_passed "$preset" "$tree"
done
