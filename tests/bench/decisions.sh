#!/usr/bin/env bash
# Prints the table of goals of the policy of AI Decides: see README.md in this folder, or --help.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

usage() {
  cat <<END
Usage: tests/bench/decisions.sh [--program PATH] [--traces FOLDER] [tuning|held-out|LIST.txt] [-- OPTION…]

Creates the missing traces of the scenes in data/tuning_scenes.txt, data/held_out_scenes.txt (the default, for final figures)
or LIST.txt in FOLDER. Replays the policies in virtual time: without priors, with the priors of a store after a game of the
same scene, with these reversed, with those of another class of machines, and for a new scene with those of the other traces.
Measures the time of a decision, and prints every goal with the reached value, its cells and the results of each policy.
Options after -- are passed to \`sweepstake-lab replay\`, for example --seeds 200 or --no-shadow; --json prints one JSON document.
  --program PATH    the program \`sweepstake-lab\` (default: build/release/bin/sweepstake-lab)
  --traces FOLDER   folder of the traces (default: build/traces/tuning, held-out or LIST)
Exit code: 0 every goal is met, 1 a goal is missed, 2 a program or a trace is missing. Tracing takes 5 to 20 minutes on an otherwise idle
machine; the rest takes about one minute on two cores.
END
}

program=$root/build/release/bin/sweepstake-lab
list=held-out
scenes=$here/data/held_out_scenes.txt
traces=
judged=default
while (($# > 0)); do
  case $1 in
    --program) program=$2; shift ;;
    --traces) traces=$2; shift ;;
    -h | --help) usage; exit 0 ;;
    --) shift; break ;;
    tuning | held-out) scenes=$here/data/${1/-/_}_scenes.txt list=$1 ;;
    *.txt) scenes=$1 list=$(basename "$1" .txt) ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done
traces=${traces:-$root/build/traces/$list}
options=()
json=()
for option; do
  if [[ $option == --json ]]; then json=(--json); else options+=("$option"); fi
done

tick_bench=$(dirname "$program")/decision_tick_bench
[[ -x $tick_bench ]] || { echo "No program at $tick_bench, which measures the time of a decision: build the tests, too" >&2; exit 2; }
"$here/traces.sh" --program "$program" "$scenes" "$traces" >&2

costs=
passes=
while read -r scene objects _ seed pass _; do
  [[ -n $scene && $scene != \#* ]] || continue
  costs+=,$traces/$scene-$objects-$seed.costs
  passes+=,$pass
done <"$scenes"

documents=$(mktemp -d)
trap 'rm -r "$documents"' EXIT
replay() {
  "$program" replay --costs "${costs#,}" --pass "${passes#,}" --priors "$1" --policy "$2" --json "${options[@]}" >"$documents/$1.json"
}
replay none "$judged,paper"
replay right "$judged"
replay wrong "$judged"
replay class "$judged"
replay scenes "$judged"
"$tick_bench" --json "$judged" >"$documents/time.json"
"$here/judge.py" decisions --cells "$scenes" "${json[@]}" "$documents"/{none,right,wrong,class,scenes,time}.json
