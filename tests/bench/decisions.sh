#!/usr/bin/env bash
# Prints the table of goals of the policy of AI Decides: see README.md beside this file, or --help.
set -euo pipefail

here=$(cd "$(dirname "${BASH_SOURCE[0]}")" && pwd)
root=$(cd "$here/../.." && pwd)

usage() {
  cat <<END
Usage: tests/bench/decisions.sh [--program PATH] [--traces FOLDER] [--ablation] [tuning|held-out] [-- OPTION…]

Traces the scenes of tuning_scenes.txt or held_out_scenes.txt (the default: the final figures) into FOLDER where they are not
there yet, lets the policies play them in virtual time and prints every goal with what was reached, the cells behind it and
how each policy did. What follows -- goes to \`sweepstake replay\`, as --seeds 200, --json or --no-shadow.
  --ablation        every policy that there is, not only AI Decides and the paper's
  --program PATH    the program \`sweepstake\` (default: build/release/bin/sweepstake)
  --traces FOLDER   (default: build/traces/LIST)
Ends with 1 when a goal was missed. Tracing takes some 5 minutes and wants the machine for itself; the rest takes some ten
seconds on two cores, a minute with --ablation.
END
}

program=$root/build/release/bin/sweepstake
list=held-out
traces=
policies=default,paper
while (($# > 0)); do
  case $1 in
    --program) program=$2; shift ;;
    --traces) traces=$2; shift ;;
    --ablation) policies=default,all ;;
    -h | --help) usage; exit 0 ;;
    --) shift; break ;;
    tuning | held-out) list=$1 ;;
    *) usage >&2; exit 2 ;;
  esac
  shift
done
scenes=$here/${list//-/_}_scenes.txt
traces=${traces:-$root/build/traces/$list}

"$here/traces.sh" --program "$program" "$scenes" "$traces" >&2
exec "$program" replay --goals "$scenes" --traces "$traces" --policy "$policies" "$@"
