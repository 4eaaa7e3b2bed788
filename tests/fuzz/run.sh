#!/usr/bin/env bash
# Builds the fuzz targets with clang and runs each of them: first the inputs in corpus/, then mutations of them.
#
#   tests/fuzz/run.sh                      30 seconds each, two at a time
#   tests/fuzz/run.sh --seconds 3600       an hour each
#   tests/fuzz/run.sh --seconds 60 http    only these targets: config database http import link messages
#
# New inputs are kept in build/fuzz/corpus and used the next time. An input that makes a target fail is in
# build/fuzz/failures; copy it to corpus/, fix the error, and check that `build/fuzz/bin/NAME_fuzz FILE` passes.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/../.."

seconds=30
targets=()
while (($# > 0)); do
  case $1 in
    --seconds)
      seconds=${2:?"--seconds needs a number"}
      shift
      ;;
    config | database | http | import | link | messages) targets+=("$1") ;;
    --help)
      sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}"
      exit 0
      ;;
    *)
      echo "Unknown argument '$1'. Known are --seconds N, --help, config, database, http, import, link and messages." >&2
      exit 2
      ;;
  esac
  shift
done
((${#targets[@]} > 0)) || targets=(messages import database config link http)

# libFuzzer needs clang; gcc does not have it.
deploy/install_packages.sh clang libclang-rt-dev llvm
cmake --preset fuzz >/dev/null
cmake --build --preset fuzz -j "$(nproc)"

# Use memory instead of a disk if possible.
work=$(mktemp -d -p "$([[ -w /dev/shm ]] && echo /dev/shm || echo "${TMPDIR:-/tmp}")")
trap 'rm -rf "$work"' EXIT
mkdir -p build/fuzz/failures

fuzz() {
  local name=$1 found=build/fuzz/corpus/$1
  mkdir -p "$found" "$work/$name"
  TMPDIR=$work/$name ASAN_OPTIONS=quarantine_size_mb=64:detect_leaks=1 build/fuzz/bin/"${name}_fuzz" \
    -seed=1 -max_total_time="$seconds" -timeout=60 -rss_limit_mb=2048 -print_final_stats=1 \
    -artifact_prefix="build/fuzz/failures/$name-" "$found" "tests/fuzz/corpus/$name" >"$work/$name.log" 2>&1 || {
    tail -n 40 "$work/$name.log"
    echo "$name: failed; the input is in build/fuzz/failures."
    return 1
  }
  echo "$name: $(grep -o 'stat::number_of_executed_units: .*' "$work/$name.log" | grep -o '[0-9]*$') inputs, no failure"
}
export -f fuzz
export work seconds
printf '%s\n' "${targets[@]}" | xargs -n 1 -P 2 bash -c 'fuzz "$1"' fuzz
