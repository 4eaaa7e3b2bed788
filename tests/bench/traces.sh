#!/usr/bin/env bash
# Creates the cost traces of a list of scenes: see README.md in this folder, or --help.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$here/../../build/release/bin/sweepstake-lab

usage() {
  cat <<END
Usage: tests/bench/traces.sh [--again] [--quick] [--repeats N] [--program PATH] LIST FOLDER

Traces every scene of LIST (data/tuning_scenes.txt, data/held_out_scenes.txt or your own) into FOLDER/SCENE-OBJECTS-SEED.costs.
Existing traces are kept, so that an interrupted run can be continued.
  --again         replace existing traces
  --repeats N     runs of each scene; with 1 the traces contain every disturbed frame (default: that of \`sweepstake-lab trace\`)
  --quick         at most 120 frames of 300 objects, as a smoke test
  --program PATH  the program \`sweepstake-lab\` (default: build/release/bin/sweepstake-lab)
Takes 5 to 20 minutes per list on one core; the machine should be otherwise idle.
END
}

again=0
quick=0
repeats=()
places=()
while (($# > 0)); do
  case $1 in
    --again) again=1 ;;
    --quick) quick=1 ;;
    --repeats) repeats=(--repeats "$2"); shift ;;
    --program) program=$2; shift ;;
    -h | --help) usage; exit 0 ;;
    -*) usage >&2; exit 2 ;;
    *) places+=("$1") ;;
  esac
  shift
done
((${#places[@]} == 2)) || { usage >&2; exit 2; }
list=${places[0]}
folder=${places[1]}
[[ -f $list ]] || { echo "The list $list does not exist" >&2; exit 2; }
[[ -x $program ]] || { echo "No program at $program: build it (cmake --workflow --preset release), or give --program" >&2; exit 2; }
mkdir -p "$folder"
declare -A made

while read -r scene objects frames seed pass category rest; do
  [[ -n $scene && $scene != \#* ]] || continue
  [[ $category =~ ^(stationary|changing|resonant)$ && -z $rest && -n $pass ]] ||
    { echo "$list: '$scene $objects …' must be a line of: scene objects frames seed pass category" >&2; exit 2; }
  file=$folder/$scene-$objects-$seed.costs
  # Lines may share a trace and replay it at different speeds.
  [[ -z ${made[$file]:-} ]] || continue
  made[$file]=1
  ((again)) || [[ ! -f $file ]] || continue
  size=(--objects "$objects" --frames "$frames" "${repeats[@]}")
  ((quick == 0)) || size=(--objects $((objects < 300 ? objects : 300)) --frames 120 --repeats 1)
  "$program" trace --scene "$scene" --seed "$seed" "${size[@]}" --out "$file" </dev/null
done <"$list"
