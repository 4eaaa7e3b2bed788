#!/usr/bin/env python3
"""Compares measurements of `sweepstake-lab bench`, `sweepstake-lab replay`, `live.py` and `daemon_load.py` with the goals.

Reads documents that these commands print with --json, the goals in data/goals.toml, and published times and times measured elsewhere in
data/published_figures.csv. Needs only Python 3.11. Exit code: 0 every goal is met, 1 a goal is missed or has too few rounds or
scenes, 2 the input is wrong or incomplete. A cell without rows never meets its goal. A document of `live.py` may contain a part of
the conditions; `live` lists the goals that it does not cover.
"""

import argparse
import json
import pathlib
import sys
import tomllib

from judging import backends, choosing, daemon, decisions, live, proxies
from judging.common import InputError, read_goals, read_json

DATA = pathlib.Path(__file__).resolve().parent / "data"


def judge_bench(options):
    document = read_json(options.document)
    ratios = backends.judge(document, read_goals(options.goals), backends.read_published(options.published))
    write = backends.bench_json if options.json else backends.bench_text
    print_result(write(document, ratios))
    return all(ratio["met"] is not False for ratio in ratios)


def judge_decisions(options):
    cells = decisions.read_cells(options.cells)
    replays = decisions.Replays([read_json(path) for path in options.documents])
    policy = options.policy or replays.policies[0]
    goals = [decisions.judge_goal(goal, cells, policy, replays) for goal in read_goals(options.goals)["decisions"]]
    write = decisions.decisions_json if options.json else decisions.decisions_text
    print_result(write(goals, cells, policy, replays))
    return all(goal["met"] or goal["reached"] is None for goal in goals)


def judge_daemon(options):
    document, goals = read_json(options.document), read_goals(options.goals)["daemon"]
    rows = daemon.judge(document, goals)
    daemon.require_all(document, goals)
    print_result((daemon.daemon_json if options.json else daemon.daemon_text)(document, rows))
    return all(row["met"] is not False for row in rows)


def judge_proxies(options):
    rows = proxies.judge(read_json(options.document), read_goals(options.goals)["proxies"])
    print_result({"figures": rows} if options.json else proxies.proxies_text(rows))
    return all(row["met"] is not False for row in rows)


def judge_live(options):
    rows = live.judge(read_json(options.document), read_goals(options.goals)["live"])
    print_result({"figures": rows} if options.json else live.live_text(rows))
    return all(row["met"] is not False for row in rows)


def judge_choosing(options):
    return choosing.conclude(read_json(options.document), options.json, options.goals) == 0


def print_result(result):
    print(result if isinstance(result, str) else json.dumps(result, indent=2, ensure_ascii=False) + "\n", end="")


def parse(words):
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter,
        epilog="examples:\n"
        "  sweepstake-lab bench --scene suite-b --objects 1000,10000 --peers --json | tests/bench/judge.py bench\n"
        "  tests/bench/judge.py bench --json build/bench/suite.json\n"
        "  tests/bench/judge.py decisions --cells tests/bench/data/held_out_scenes.txt none.json right.json wrong.json time.json\n"
        "  tests/bench/daemon_load.py --json | tests/bench/judge.py daemon\n"
        "  build/release/bin/proxy_ratios_bench | tests/bench/judge.py proxies\n"
        "  tests/bench/live.py --json | tests/bench/judge.py live\n"
        "tests/bench/run.sh and tests/bench/decisions.sh measure and call it.")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    bench = commands.add_parser("bench", help="backends against peers: the document of `sweepstake-lab bench --peers --json`")
    bench.add_argument("document", nargs="?", default="-", help="a file, or - for stdin (the default)")
    bench.add_argument("--published", default=DATA / "published_figures.csv", metavar="FILE.csv",
                       help="times measured elsewhere (default: %(default)s)")
    bench.set_defaults(judge=judge_bench)
    replays = commands.add_parser("decisions", help="the policy of AI Decides on replayed traces")
    replays.add_argument("documents", nargs="+", metavar="document",
                           help="documents of `sweepstake-lab replay --json` with --priors none, right and wrong, and of "
                           "`decision_tick_bench --json`")
    replays.add_argument("--cells", required=True, metavar="LIST.txt", help="the scenes, one per line")
    replays.add_argument("--policy", help="the judged policy (default: the first of the first document)")
    replays.set_defaults(judge=judge_decisions)
    load = commands.add_parser("daemon", help="the capacity of a daemon: the document of `daemon_load.py --json`")
    load.add_argument("document", nargs="?", default="-", help="a file, or - for stdin (the default)")
    load.set_defaults(judge=judge_daemon)
    ratios = commands.add_parser("proxies", help="the cost of proxies: the document of `proxy_ratios_bench` or `proxy_steps_bench`")
    ratios.add_argument("document", nargs="?", default="-", help="a file, or - for stdin (the default)")
    ratios.set_defaults(judge=judge_proxies)
    games = commands.add_parser("live", help="AI Decides in live games: the document of `live.py --json`")
    games.add_argument("document", nargs="?", default="-", help="a file, or - for stdin (the default)")
    games.set_defaults(judge=judge_live)
    choice = commands.add_parser("choosing", help="judges a document of conditions.py, sealed.py, stored_priors.py or worth.py again")
    choice.add_argument("document", nargs="?", default="-", help="a file, or - for stdin (the default)")
    choice.set_defaults(judge=judge_choosing)
    for command in (bench, replays, load, ratios, games, choice):
        command.add_argument("--goals", default=DATA / "goals.toml", metavar="FILE.toml", help="(default: %(default)s)")
        command.add_argument("--json", action="store_true", help="one JSON document on stdout")
    return parser.parse_args(words)


def main(words):
    options = parse(words)
    try:
        return 0 if options.judge(options) else 1
    except (InputError, OSError, tomllib.TOMLDecodeError) as error:
        print(f"judge.py: {error}", file=sys.stderr)
    except (KeyError, TypeError) as error:
        print(f"judge.py: a document does not contain {error}; make it with the programs of this version", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
