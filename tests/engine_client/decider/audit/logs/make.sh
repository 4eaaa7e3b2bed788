#!/usr/bin/env bash
# Makes new logs in this folder, each from a real game with a real daemon, and checks that they replay. Run it after a
# change that is meant to change decisions or the log. Games begin with an arm that they should leave.
#
#   tests/engine_client/decider/audit/logs/make.sh build/release/bin [POLICY...]     (default: paper adaptive)
set -euo pipefail
(($# > 0)) || { sed -n '2,/^set /{/^set /d;s/^# \{0,1\}//p}' "${BASH_SOURCE[0]}" >&2; exit 2; }
bin=$(cd "$1" && pwd)
shift
(($# > 0)) || set -- paper adaptive
cd "$(dirname "${BASH_SOURCE[0]}")"
work=$(mktemp -d)
"$bin/sweepstaked" --listen 127.0.0.1:0 --http 127.0.0.1:0 --port-file "$work/port" --data "$work/data" --max-time-scale 100 \
  --log-level error &
daemon=$!
trap 'kill "$daemon" 2>/dev/null; wait "$daemon" || true; rm -rf "$work"' EXIT
until [[ -s $work/port ]]; do sleep 0.1; done
address=127.0.0.1:$(head -n 1 "$work/port")
for policy in "$@"; do
  "$bin/sweepstake" run --daemon "$address" --policy "$policy" --project logs --scene-name "$policy" --scene hurricane \
    --objects 300 --arm AxisSweep --shadow on --time-scale 100 --duration 1200ms >/dev/null
  "$bin/sweepstake" audit export --daemon "$address" --scene "$policy" --out "$policy.csv"
  "$bin/sweepstake-lab" replay --log "$policy.csv"
done
# The tests of the dashboard read the second log as the daemon sends it to a browser.
curl -fsS -H 'X-Sweepstake: 1' -d '{"filter":{"scene":"adaptive"}}' \
  "http://127.0.0.1:$(tail -n 1 "$work/port")/api/sweepstake.v1.AuditService/ExportDecisions" >adaptive.jsonl
