#!/usr/bin/env bash
# From a fresh clone to learnt posteriors: installs what is missing, builds, starts the daemon, runs the Hurricane scene
# with 3,000 objects in AI mode over the real gRPC stream, prints switches and posteriors as they happen, and stops
# everything it started. Run it again: it starts from the priors of the run before.
#
#   deploy/quickstart.sh            about a minute after the build
#   deploy/quickstart.sh --fresh    forgets the priors of earlier runs first
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

data=build/quickstart/data
case ${1:-} in
  '') ;;
  --fresh) rm -rf "$data" ;;
  --help)
    sed -n '2,7s/^# \{0,1\}//p' "${BASH_SOURCE[0]}"
    exit 0
    ;;
  *)
    echo "Unknown option '$1'. Options: --fresh --help." >&2
    exit 2
    ;;
esac

deploy/install_packages.sh --programs
echo "== building the daemon and the command line without its laboratory (the first time takes a few minutes) =="
cmake --preset quickstart >/dev/null
cmake --build --preset quickstart -j "$(nproc)"

bin=build/quickstart/bin
port_file=$data/port
mkdir -p "$data"
rm -f "$port_file"
daemon=

stop_daemon() {
  [ -n "$daemon" ] || return 0
  kill -TERM "$daemon" 2>/dev/null || true
  local status=0
  wait "$daemon" || status=$?
  daemon=
  return "$status"
}
trap 'stop_daemon || true' EXIT

echo "== starting the daemon (data in $data, log in $data/daemon.log) =="
"$bin/sweepstaked" --listen 127.0.0.1:0 --data "$data" --port-file "$port_file" --max-time-scale 8 \
  2>>"$data/daemon.log" &
daemon=$!
until [ -s "$port_file" ]; do
  kill -0 "$daemon" 2>/dev/null || {
    daemon=
    echo "The daemon did not start. Its last words:" >&2
    tail -n 5 "$data/daemon.log" >&2
    exit 1
  }
  sleep 0.05
done
address=127.0.0.1:$(head -n 1 "$port_file")

# A time scale of 8 divides the paper's intervals (exploration 42 s, cooldown 40 s), so that the whole shows in 50 s.
"$bin/sweepstake" run --daemon "$address" --project quickstart --scene hurricane --objects 3000 --seed 1 \
  --mode ai --time-scale 8 --duration 50s

stop_daemon
echo "== done: the daemon has stopped; run this again to start from what it learnt =="
