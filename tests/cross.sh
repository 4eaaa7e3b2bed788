#!/usr/bin/env bash
# Builds the portable parts for other platforms, runs their tests there, and checks that one seed gives the same boxes and
# pairs on all of them. Exit status: 0 all tests passed, 1 a test failed or results differ, 2 bad usage.
#
#   tests/cross.sh                  Linux aarch64 (run by qemu) and Windows x86-64 (run by wine)
#   tests/cross.sh windows          only Windows; `aarch64` selects only Linux aarch64
#   tests/cross.sh --quick          without the exhaustive tests of the broad phases; only the first shard of programs that are
#                                   slow under qemu; sources are compiled together, which hides missing includes
#   tests/cross.sh --jobs 4         number of parallel compilers and tests (default: one per processor)
#
# Installs missing packages (Debian 12, root or sudo) and keeps everything else under build/cross-*. The libraries of the
# other platforms are unpacked there, without the package manager of this machine. CCACHE_PROGRAM selects another ccache.
# tests/cross/README.md lists what is tested and what cannot be. If a platform passes with a committed tree, the tree's hash
# is written to build/cross-PLATFORM/passed.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."
# shellcheck source=tests/passed.sh
source tests/passed.sh
# shellcheck source=deploy/private_apt.sh
source deploy/private_apt.sh
readonly root=$PWD packages=$PWD/build/cross-packages
# The packages that are downloaded from the archive, again if this list has changed since the last run.
readonly libraries="libeigen3-dev nlohmann-json3-dev libprotozero-dev googletest"

platforms=()
jobs=$(nproc)
quick=
while (($# > 0)); do
  case $1 in
    aarch64 | windows) platforms+=("$1") ;;
    --quick) quick=yes ;;
    --jobs)
      [[ ${2:-} =~ ^[1-9][0-9]*$ ]] || { echo "--jobs needs a number." >&2; exit 2; }
      jobs=$2
      shift
      ;;
    --help)
      sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *)
      echo "Unknown platform '$1'. Platforms: aarch64 windows. Options: --quick, --jobs N, --help." >&2
      exit 2
      ;;
  esac
  shift
done
((${#platforms[@]} > 0)) || platforms=(aarch64 windows)

# Use a separate wine folder, and no graphical output.
export WINEPREFIX=$root/build/cross-wine WINEARCH=win64 WINEDEBUG=-all
unset DISPLAY
trap 'if [[ -d $WINEPREFIX ]]; then wineserver -k || true; fi' EXIT

launcher=()
[[ -z ${CCACHE_PROGRAM:-} ]] || launcher=("-DCCACHE_PROGRAM=$CCACHE_PROGRAM")
configuration=(-G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo
  "-DCMAKE_C_FLAGS_RELWITHDEBINFO=-O2 -UNDEBUG" "-DCMAKE_CXX_FLAGS_RELWITHDEBINFO=-O2 -UNDEBUG")

say() { printf '== %s\n' "$*"; }

# quietly LOG COMMAND...: writes the output to LOG and shows its end if the command fails.
quietly() {
  local log=$1
  shift
  mkdir -p "$(dirname "$log")"
  "$@" >"$log" 2>&1 && return
  tail -n 40 "$log" >&2
  echo "Failed: $* (complete output: $log)" >&2
  return 1
}

install_tools() {
  local tools=()
  local platform
  for platform in "${platforms[@]}"; do
    case $platform in
      aarch64) tools+=(g++-aarch64-linux-gnu qemu-user-static) ;;
      windows) tools+=(clang-19 lld-19 g++-mingw-w64-x86-64-posix wine wine64) ;;
    esac
  done
  deploy/install_packages.sh dpkg-dev "${tools[@]}"
}

download_libraries() {
  local state=$packages/apt
  rm -rf "$packages"
  mkdir -p "$packages/downloads"
  cd "$packages/downloads"
  start_private_apt "$state" deb deb-src &&
    # shellcheck disable=SC2086
    private_apt "$state" download $libraries &&
    private_apt "$state" source --download-only highway &&
    dpkg-source -x highway_*.dsc "$packages/highway" || return
  rm -rf "$state"
  echo "$libraries" >"$packages/complete"
}

# build_library PLATFORM NAME SOURCE CMAKE_ARGUMENTS...: builds and installs into the platform's tree of libraries.
build_library() {
  local tree=$packages/$1 name=$2 source=$3
  local build=$tree/build-$name
  cmake "${configuration[@]}" -S "$source" -B "$build" -DCMAKE_TOOLCHAIN_FILE="$root/tests/cross/$1.cmake" \
    -DCROSS_ROOT="$tree" -DCMAKE_INSTALL_PREFIX="$tree/usr" "${@:4}" &&
    cmake --build "$build" -j "$jobs" && cmake --install "$build"
}

build_libraries() {
  local platform=$1 tree=$packages/$1 deb
  [[ ! -f $tree/complete ]] || return 0
  say "$platform: GoogleTest and Highway"
  rm -rf "$tree"
  mkdir -p "$tree"
  for deb in "$packages"/downloads/*.deb; do dpkg -x "$deb" "$tree" || return; done
  quietly "$packages/$platform-googletest.log" build_library "$platform" googletest "$tree/usr/src/googletest" || return
  quietly "$packages/$platform-highway.log" build_library "$platform" highway "$packages/highway" \
    -DBUILD_SHARED_LIBS=OFF -DCMAKE_POSITION_INDEPENDENT_CODE=ON -DBUILD_TESTING=OFF -DHWY_ENABLE_CONTRIB=OFF \
    -DHWY_ENABLE_EXAMPLES=OFF || return
  touch "$tree/complete"
}

# configure_and_build NAME TARGETS CMAKE_ARGUMENTS...: builds in build/cross-NAME.
configure_and_build() {
  local build=build/cross-$1 targets
  read -ra targets <<<"$2"
  quietly "$build/configure.log" cmake "${configuration[@]}" "${launcher[@]}" -DSWEEPSTAKE_WERROR=ON -S . -B "$build" \
    "${@:3}" || return
  grep '^-- Left out' "$build/configure.log" || true
  say "$1: compiles"
  # Show all errors in one run.
  quietly "$build/build.log" cmake --build "$build" -j "$jobs" --target "${targets[@]}" -- -k 0
}

run_tests() {
  say "$1: tests"
  local selection=() left_out='^(broad_phase_conformance|instruction_sets)[.]'
  [[ $1 != aarch64 ]] || left_out+='|[.][1-9][0-9]*$'
  [[ -z $quick ]] || selection=(-E "$left_out")
  # wine has once ended a program before it started (0.03 s, no output). The log contains the output of a failed first attempt.
  [[ $1 != windows ]] || selection+=(--repeat until-pass:2)
  ctest --test-dir "build/cross-$1" -j "$jobs" --output-on-failure --no-tests=error "${selection[@]}"
}

# on_platform PLATFORM PROGRAM...: runs the program, in an emulator if needed.
on_platform() {
  case $1 in
    native) "${@:2}" ;;
    aarch64) qemu-aarch64-static -L /usr/aarch64-linux-gnu "${@:2}" ;;
    windows) "$(command -v /usr/lib/wine/wine64 wine | head -n 1)" "${@:2}" ;;
  esac
}

# same_fingerprint PLATFORM KIND: checks that this kind of processor gives the same boxes and pairs as this machine.
same_fingerprint() {
  local build=build/cross-$1 program=fingerprint
  [[ $1 != windows ]] || program=fingerprint.exe
  on_platform "$1" "$build/bin/$program" "$build/fingerprint-$2.txt" || return
  cmp "build/cross-native/fingerprint.txt" "$build/fingerprint-$2.txt" || {
    diff "build/cross-native/fingerprint.txt" "$build/fingerprint-$2.txt" | head -n 10
    return 1
  }
  say "$1, $2: the same boxes and pairs, $(wc -l <"$build/fingerprint-$2.txt") lines"
}

# Compares a processor with NEON only, then processors with SVE2 registers of 128, 256 and 512 bits (with --quick only 512).
compare_aarch64() {
  local failed=0 bytes widths=(16 32 64)
  [[ -z $quick ]] || widths=(64)
  QEMU_CPU=neoverse-n1 same_fingerprint aarch64 neon || failed=1
  for bytes in "${widths[@]}"; do
    QEMU_CPU=max,sve-default-vector-length=$bytes same_fingerprint aarch64 "sve2-$((bytes * 8))" || failed=1
  done
  return "$failed"
}

compare_windows() {
  same_fingerprint windows x86-64
}

check_platform() {
  local platform=$1
  say "$platform"
  build_libraries "$platform" || return
  [[ $platform != windows ]] || quietly build/cross-wine.log wineboot -i || return
  local compiled=(-DSWEEPSTAKE_PCH=ON -UCMAKE_UNITY_BUILD)
  # Here missing includes are errors.
  [[ $platform != aarch64 || -n $quick ]] || compiled=(-DSWEEPSTAKE_PCH=OFF -DCMAKE_UNITY_BUILD=OFF)
  configure_and_build "$platform" all -DCMAKE_TOOLCHAIN_FILE="$root/tests/cross/$platform.cmake" \
    -DCROSS_ROOT="$packages/$platform" "${compiled[@]}" || return
  local failed=0
  run_tests "$platform" || failed=1
  "compare_$platform" || failed=1
  return "$failed"
}

tree=$(tree_to_test)
for platform in "${platforms[@]}"; do forget_passed "cross-$platform"; done
say "packages"
install_tools
if [[ $(cat "$packages/complete" 2>/dev/null) != "$libraries" ]]; then
  say "libraries of the other platforms"
  (quietly "$root/build/cross-download.log" download_libraries)
fi

say "this machine"
configure_and_build native "fingerprint frames"
build/cross-native/bin/fingerprint build/cross-native/fingerprint.txt

failed=0
summary=()
for platform in "${platforms[@]}"; do
  start=$SECONDS
  if check_platform "$platform"; then
    leave_passed "cross-$platform" "$tree"
    summary+=("$platform: passed, $((SECONDS - start)) s")
  else
    summary+=("$platform: FAILED, $((SECONDS - start)) s")
    failed=1
  fi
done
say "result"
printf '%s\n' "${summary[@]}"
exit "$failed"
