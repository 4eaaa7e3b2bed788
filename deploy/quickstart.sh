#!/usr/bin/env bash
# Tries Sweepstake from a fresh clone: installs missing packages, builds, and starts the daemon with its dashboard. Then it plays a
# scene in which 3,000 objects rest and move in turns, so that the cheapest algorithm changes. It prints each switch with its reason,
# and at the end what was learnt and saved. Then it stops everything it started. A second run starts from the priors of the first.
#
#   deploy/quickstart.sh              takes half a minute after the build
#   deploy/quickstart.sh --fresh      first deletes the priors of earlier runs
#   deploy/quickstart.sh --stay       a demo for the dashboard: plays seven scenes, one of them in two builds and on two classes of
#                                     machines, until Ctrl-C; prints the page's address
#   deploy/quickstart.sh --bin DIR    uses sweepstaked and sweepstake of this folder and builds nothing
#   deploy/quickstart.sh --data DIR   keeps priors, logs and the file of ports there; default: build/quickstart/data
set -euo pipefail
root=$(cd "$(dirname "${BASH_SOURCE[0]}")/.." && pwd)

data=$root/build/quickstart/data
bin=
fresh=
stay=
while [ $# -gt 0 ]; do
  case $1 in
    --fresh) fresh=1 ;;
    --stay) stay=1 ;;
    --bin | --data)
      [ $# -gt 1 ] || { echo "$1 needs a folder." >&2; exit 2; }
      declare "${1#--}=$(realpath -m "$2")"
      shift
      ;;
    --help)
      sed -n '2,11s/^# \{0,1\}//p' "$root/deploy/quickstart.sh"
      exit 0
      ;;
    *)
      echo "Unknown option '$1'. Options: --fresh --stay --bin DIR --data DIR --help." >&2
      exit 2
      ;;
  esac
  shift
done

cd "$root"
if [ -z "$bin" ]; then
  deploy/install_packages.sh --programs
  echo "== building the daemon and the command line (the first time takes a few minutes) =="
  cmake --preset quickstart >/dev/null
  cmake --build --preset quickstart -j "$(nproc)"
  bin=build/quickstart/bin
fi

[ -z "$fresh" ] || rm -rf "$data"
mkdir -p "$(dirname "$data")"
mkdir -p -m 700 "$data"
port_file=$data/port
rm -f "$port_file"
daemon=
games=()

# Stops the games first, so that each sends its goodbye to the daemon.
stop_all() {
  local status=0
  ((${#games[@]} == 0)) || kill -TERM "${games[@]}" 2>/dev/null || true
  ((${#games[@]} == 0)) || wait "${games[@]}" || true
  games=()
  [ -n "$daemon" ] || return 0
  kill -TERM "$daemon" 2>/dev/null || true
  wait "$daemon" || status=$?
  daemon=
  return "$status"
}
trap 'stop_all || true' EXIT

echo "== starting the daemon (data in $data, log in $data/daemon.log) =="
"$bin/sweepstaked" --listen 127.0.0.1:0 --http 127.0.0.1:0 --data "$data" --port-file "$port_file" --max-time-scale 8 \
  2>>"$data/daemon.log" &
daemon=$!
until [ -s "$port_file" ]; do
  kill -0 "$daemon" 2>/dev/null || {
    daemon=
    echo "The daemon did not start. The end of its log:" >&2
    tail -n 5 "$data/daemon.log" >&2
    exit 1
  }
  sleep 0.05
done
address=127.0.0.1:$(sed -n 1p "$port_file")
echo "== the dashboard: http://127.0.0.1:$(sed -n 2p "$port_file")/ =="

# A time scale of 8 divides the paper's intervals (exploration 42 s, cooldown 40 s), so that 30 s show the complete process.
play() {
  exec "$bin/sweepstake" run --daemon "$address" --project "$1" --scene "$2" --objects "$3" --seed 1 --mode ai --time-scale 8 "${@:4}"
}

if [ -z "$stay" ]; then
  (play quickstart rest-and-motion 3000 --fps 60 --duration 30s)
  stop_all
  echo "== done: the daemon has stopped; run this again to start from what it learnt, or with --stay to see the dashboard =="
  exit
fi

trap 'exit 0' INT TERM
while read -r project scene objects build machines; do
  play "$project" "$scene" "$objects" --scene-name "$scene" --build "$build" --machine-class "$machines" --fps 60 --duration 720h --allow-orders --allow-box-view >>"$data/games.log" 2>&1 &
  games+=($!)
done <<'SCENES'
arena storms 1200 1.4 demo
arena storms 1100 1.5 demo
arena storms 900 1.5 demo-2
arena waves 900 1.5 demo
arena hurricane 1000 1.5 demo
city day-and-night 1500 1.4 demo
city arrivals 800 1.5 demo
physics gather-and-scatter 1000 1.5 demo
physics rest-and-motion 600 1.5 demo
SCENES
echo "== ${#games[@]} games are running (log in $data/games.log); Ctrl-C ends them =="
wait "$daemon" || true
daemon=
echo "The daemon has ended. The end of its log:" >&2
tail -n 5 "$data/daemon.log" >&2
exit 1
