#!/usr/bin/env bash
# Measures the backends: see README.md in this folder, or --help.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)
parts=(suite large million slow shapes coincident counts threads frame-path)

usage() {
  cat <<END
Usage: tests/bench/run.sh [--quick] [--simd LIST] [--cold] [--program PATH] [--out FOLDER] [--json] [PART…]

Runs the parts (all of them by default): ${parts[*]}.
Each part's tables, with the goals of data/goals.toml, are written to stdout and to FOLDER/PART.txt; with --json its document is
written to FOLDER/PART.json instead. The page with charts of all its documents is FOLDER/PART.html.
  --quick         a few frames of small scenes, as a smoke test
  --simd LIST     instruction sets of the backends, in turns: \`avx512,avx2,sse4\`, or \`all\` for all that the
                  machine has (default: the best one)
  --cold          evict the caches before each frame
  --program PATH  the program \`sweepstake-lab\` (default: build/release/bin/sweepstake-lab)
  --out FOLDER    folder of the results (default: build/bench)
Exit code 1: a backend or a peer found wrong pairs, or the frame path allocated or blocked.
Takes about 10 minutes on two cores, one minute with --quick; the machine should be otherwise idle.
END
}

quick=0
json=0
program=$root/build/release/bin/sweepstake-lab
out=$root/build/bench
passed=()  # options for `sweepstake-lab bench`
chosen=()
while (($# > 0)); do
  case $1 in
    --quick) quick=1 ;;
    --json) json=1 ;;
    --simd) passed+=(--simd "${2:?--simd needs a list, for example avx512,avx2}"); shift ;;
    --cold) passed+=(--cold) ;;
    --program) program=$2; shift ;;
    --out) out=$2; shift ;;
    -h | --help) usage; exit 0 ;;
    -*) usage >&2; exit 2 ;;
    *)
      [[ " ${parts[*]} " == *" $1 "* ]] || { echo "Unknown part '$1'; the parts are ${parts[*]}" >&2; exit 2; }
      chosen+=("$1")
      ;;
  esac
  shift
done
((${#chosen[@]} > 0)) || chosen=("${parts[@]}")
[[ -x $program ]] || { echo "No program at $program: build it (cmake --workflow --preset release), or give --program" >&2; exit 2; }
mkdir -p "$out"

# bench SCENES COUNTS FRAMES WARMUP CAP_S ARGUMENT…: runs a measurement of the current part and appends it to its file.
bench() {
  local sized=(--scene "$1" --objects "$2" --frames "$3" --warmup "$4" --peer-cap "$5")
  ((quick == 0)) || sized=(--scene "$1" --objects 200,400 --frames 4 --warmup 1 --peer-cap 0.2)
  shift 5
  local measured=0
  "$program" bench --json "${sized[@]}" "${passed[@]}" "$@" >"$documents/measured.json" || measured=$?
  ((measured <= 1)) || return "$measured"
  judge || return
  return "$measured"
}

# Compares the measurements with the goals. A missed goal is shown in the table but is not an error, because ratios depend on the machine and on other programs.
judge() {
  local judged=0 document=$documents/$part-${#pages[@]}.json
  "$here/judge.py" bench --json "$documents/measured.json" >"$document" || judged=$?
  ((judged <= 1)) || return "$judged"
  pages+=("$document")
  if ((json)); then
    cat "$document" >>"$file"
  else
    { "$here/judge.py" bench "$documents/measured.json" || true; } | tee -a "$file"
  fi
}

# Writes one page for all documents of the part. Without the page in the program, `report` prints the reason and exits with 3, which is not
# an error here.
page() {
  ((${#pages[@]} == 0)) || "$program" report "${pages[@]}" --out "$out/$part.html" || (($? == 3))
}

# The arms for more than 10,000 objects. Brute force is left out, because its cost is quadratic.
fast=Grid,SAP,AxisSweep,DBVT,Tracy,KDTree
suite=suite-b,suite-g,suite-h
shapes=sizes-1-to-1000,beams,clusters,planar,teleporting,one-huge

measure() {
  case $1 in
    suite) bench $suite 1000,3000,10000 120 20 2 --peers ;;
    large) bench $suite 100000 20 20 5 --peers --arms $fast ;;
    million) bench suite-b 10000,100000,1000000 8 8 5 --peers --arms Grid,DBVT,Tracy,KDTree ;;
    slow) bench nearly-resting,few-moving 1000,10000 120 20 2 --peers ;;
    shapes)
      local status=0
      bench $shapes 1000,10000 60 20 1 --peers || status=$?
      bench long-thin 3000 60 20 1 --peers || status=$?
      return "$status"
      ;;
    coincident) bench all-coincident 500,1000 40 5 1 --peers ;;
    counts) bench spawning 1000,10000 128 20 2 --peers ;;
    threads) bench $suite 10000,100000 40 20 1 --arms $fast --threads 1,2 ;;
    frame-path) frame_path ;;
  esac
}

frame_path() {
  local path_bench
  path_bench=$(dirname "$program")/frame_path_bench
  if [[ ! -x $path_bench ]]; then
    echo "frame-path left out: $path_bench was not built. Install Google Benchmark (libbenchmark-dev) and build again" | tee -a "$file"
    return
  fi
  local options=()
  ((quick == 0)) || options+=(--benchmark_min_time=0.01)
  ((json == 0)) || options+=(--benchmark_format=json)
  "$path_bench" "${options[@]}" | tee -a "$file"
}

documents=$(mktemp -d)
trap 'rm -r "$documents"' EXIT
failed=()
for part in "${chosen[@]}"; do
  file=$out/$part.$( ((json)) && echo json || echo txt)
  pages=()
  : >"$file"
  echo "== $part" >&2
  measure "$part" || failed+=("$part")
  page || failed+=("$part")
done
((${#failed[@]} == 0)) || { echo "Failed: ${failed[*]}" >&2; exit 1; }
