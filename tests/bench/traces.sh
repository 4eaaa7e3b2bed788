#!/usr/bin/env bash
# Makes the cost traces of a list of scenes: see README.md beside this file, or --help.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
program=$here/../../build/release/bin/sweepstake-lab

usage() {
  cat <<END
Usage: tests/bench/traces.sh [--again] [--quick] [--repeats N] [--program PATH] LIST FOLDER

Traces every scene of LIST (data/tuning_scenes.txt, data/held_out_scenes.txt or one of your own) into FOLDER/SCENE-OBJECTS-SEED.costs.
A trace that is there already is kept, so that what was interrupted can go on.
  --again         make it anew
  --repeats N     runs of each scene; with 1 the traces hold every disturbed frame (default: that of \`sweepstake-lab trace\`)
  --quick         120 frames of 300 objects at most, to see that everything works
  --program PATH  the program \`sweepstake-lab\` (default: build/release/bin/sweepstake-lab)
Takes 5 to 20 minutes a list on two cores; nothing else should run meanwhile.
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
[[ -f $list ]] || { echo "There is no list $list" >&2; exit 2; }
[[ -x $program ]] || { echo "No program at $program: build it (cmake --workflow --preset release), or give --program" >&2; exit 2; }
mkdir -p "$folder"
declare -A made

while read -r scene objects frames seed pass category rest; do
  [[ -n $scene && $scene != \#* ]] || continue
  [[ $category =~ ^(stationary|changing|resonant)$ && -z $rest && -n $pass ]] ||
    { echo "$list: '$scene $objects …' is no line of scene objects frames seed pass category" >&2; exit 2; }
  file=$folder/$scene-$objects-$seed.costs
  # Lines may share a trace and go through it at another pace.
  [[ -z ${made[$file]:-} ]] || continue
  made[$file]=1
  ((again)) || [[ ! -f $file ]] || continue
  size=(--objects "$objects" --frames "$frames" "${repeats[@]}")
  ((quick == 0)) || size=(--objects $((objects < 300 ? objects : 300)) --frames 120 --repeats 1)
  "$program" trace --scene "$scene" --seed "$seed" "${size[@]}" --out "$file" </dev/null
done <"$list"
