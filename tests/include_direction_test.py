#!/usr/bin/env python3
"""Fails if an #include violates the direction of dependencies.

    include, text, math <- broad_phase <- scene <- adaptive <- decider <- telemetry <- c_api, cli      adaptive <- bullet, ode, box2d
    decider <- server/sessions <- server/storage, events, alerts <- rpc; events <- web; rpc, web <- server/host <- daemon <- main
    storage <- auth, history <- rpc, daemon
    proto <- telemetry, cli, server/rpc, server/web      telemetry/tls <- rpc, web      net, auth <- rpc, web <- daemon

`a <- b`: b may include a. engine_client never includes server; headers of tests/laboratory may be included only from that
folder. Within the decider: the decision core (decider, policy, session) and pooling <- audit, embedded.

In addition, the decision core, pooling and the audit log include only the standard library, Eigen and themselves (math and text also
without Eigen). They use no clock, thread, file, distribution or libm function whose last bit differs between platforms. Headers
of one operating system may be included in telemetry, the server and the command line only.

    include_direction_test.py ROOT          checks the tree at ROOT
    include_direction_test.py --self-test   shows that each rule can fail
"""

import pathlib
import re
import sys
import tempfile

DECISION = {"engine_client/decider", "engine_client/decider/policy", "engine_client/decider/session"}
DECIDER = DECISION | {"engine_client/decider/pooling", "engine_client/decider/audit"}
ENGINE = {"engine_client/broad_phase", "engine_client/scene", "engine_client/adaptive"}

# For each folder: the folders that it may include in addition to itself.
ALLOWED = {
    "engine_client/text": set(),
    "engine_client/math": set(),
    "engine_client/include": set(),
    "engine_client/broad_phase": set(),
    "engine_client/scene": {"engine_client/broad_phase"},
    "engine_client/adaptive": {"engine_client/broad_phase", "engine_client/scene"},
    "engine_client/bullet": {"engine_client/broad_phase", "engine_client/adaptive"},
    "engine_client/ode": {"engine_client/broad_phase", "engine_client/adaptive"},
    "engine_client/box2d": {"engine_client/broad_phase", "engine_client/adaptive"},
    "engine_client/decider": set(),
    "engine_client/decider/policy": {"engine_client/decider"},
    "engine_client/decider/session": DECISION,
    "engine_client/decider/pooling": DECISION,
    "engine_client/decider/audit": DECISION,
    "engine_client/decider/embedded": DECIDER | ENGINE,
    "engine_client/telemetry": DECIDER | ENGINE | {
        "engine_client/decider/embedded", "engine_client/telemetry/conversion", "engine_client/telemetry/tls", "proto"},
    "engine_client/telemetry/conversion": DECIDER | {"engine_client/decider/embedded", "proto"},
    "engine_client/telemetry/tls": set(),
    "engine_client/c_api": ENGINE | {"engine_client/decider/embedded", "engine_client/telemetry"},
    "engine_client/c_api/flavours": set(),
    "engine_client/c_api/grpc": ENGINE | {"engine_client/c_api", "engine_client/telemetry"},
    "engine_client/cli": DECIDER | ENGINE | {
        "engine_client/decider/embedded", "engine_client/telemetry", "engine_client/telemetry/conversion", "proto"},
    "server/dashboard": set(),
    "server/sessions": DECIDER,
    "server/storage": DECIDER | {"server/sessions"},
    "server/tls": {"engine_client/telemetry/tls"},
    "server/auth": {"server/storage"},
    "server/events": DECIDER | {"server/sessions"},
    "server/alerts": DECIDER | {"server/sessions"},
    "server/net": set(),
    "server/web": {"engine_client/telemetry/conversion", "engine_client/telemetry/tls", "server/auth", "server/dashboard", "server/events", "server/net", "server/sessions", "server/tls", "proto"},
    "server/history": {"server/sessions", "server/storage", "proto"},
    "server/rpc": DECIDER | {
        "server/alerts", "server/auth", "server/events", "server/history", "server/net", "server/sessions", "server/tls", "engine_client/telemetry/conversion",
        "engine_client/telemetry/tls",
        "proto"},
    "server/host": {"engine_client/decider/policy", "server/alerts", "server/sessions", "server/rpc", "server/storage", "server/web", "proto"},
    "server": DECIDER | {
        "server/alerts", "server/auth", "server/events", "server/history", "server/host", "server/sessions", "server/storage", "engine_client/telemetry/tls",
        "server/tls", "server/rpc",
        "server/web", "server/dashboard", "proto"},
}

# Every folder may include these: pure functions, and the definitions of frames, commands and verdicts. They need the standard
# library only.
FOR_ALL = {"engine_client/text", "engine_client/math", "engine_client/include"}

# Each public header belongs to the layer that implements it.
PUBLIC_HEADERS = {
    "aabb.h": "engine_client/broad_phase",
    "broad_phase.h": "engine_client/broad_phase",
    "executor.h": "engine_client/broad_phase",
    "hooks.h": "engine_client/broad_phase",
    "names/begin.h": "engine_client/broad_phase",
    "names/end.h": "engine_client/broad_phase",
    "pair_buffer.h": "engine_client/broad_phase",
    "machine_class.h": "engine_client/broad_phase",
    "simd.h": "engine_client/broad_phase",
    "pair_sorter.h": "engine_client/broad_phase",
    "proxy_set.h": "engine_client/broad_phase",
    "status.h": "engine_client/broad_phase",
    "scene.h": "engine_client/scene",
    "frame_sample.h": "engine_client/include",
    "adaptive_broad_phase.h": "engine_client/adaptive",
    "shadow.h": "engine_client/adaptive",
    "bullet.h": "engine_client/bullet",
    "ode.h": "engine_client/ode",
    "box2d.h": "engine_client/box2d",
    "embedded_decider.h": "engine_client/decider/embedded",
    "adaptive_session.h": "engine_client/telemetry",
    "session.h": "engine_client/telemetry",
    "c_api.h": "engine_client/c_api",
    "c_worlds.h": "engine_client/c_api",
    "c_sessions.h": "engine_client/c_api",
    "c_deciders.h": "engine_client/c_api",
    "c_proxies.h": "engine_client/c_api",
    "c_link.h": "engine_client/c_api",
    "c_daemon.h": "engine_client/c_api",
    "c_scenes.h": "engine_client/c_api",
    "c_hooks.h": "engine_client/c_api",
}
PUBLIC_FOLDER = "engine_client/include/sweepstake"

# The order of the subfolders ("rooms") of a folder. A room may include itself and the rooms before it. "" is the folder itself.
ROOM_ORDER = {
    "engine_client/broad_phase": ("host", "common", "grid", "kd", "sweep", "dbvt", "tracy", "proxies", ""),
    "engine_client/cli": ("io", "game", "daemon", "priors", ""),
    "engine_client/telemetry": ("tls", "common", "protocol", "conversion", ""),
    "server/rpc": ("common", "services", ""),
    "server/sessions": ("common", ""),
    "server/web": ("", "csv", "api"),
}

# Only these folders may use headers of one operating system, gRPC or protobuf.
PLATFORM_FOLDERS = {
    "engine_client/c_api/flavours", "engine_client/telemetry", "engine_client/telemetry/conversion", "engine_client/telemetry/tls", "engine_client/cli", "server",
    "server/alerts", "server/auth", "server/events", "server/history", "server/host", "server/net", "server/sessions", "server/storage", "server/tls",
    "server/rpc", "server/web"}
# These files ask the system for names of threads, cores, processor and memory. If a system does not provide them, they do nothing.
PLATFORM_FILES = {
    "engine_client/broad_phase/host/" + name
    for name in ("core_speed.cc", "machine_class.cc", "processor_name.cc", "threads.cc", "usable_cores.cc")}
PLATFORM_HEADER = re.compile(
    r"^(sys/|netinet/|arpa/|linux/|net/if|(unistd|fcntl|poll|pthread|dirent|dlfcn|termios|netdb|sched|ifaddrs|syslog|"
    r"pwd|grp|signal|spawn|windows|winsock2|ws2tcpip|io|direct)\.h$)")
RPC_HEADER = re.compile(r"^(grpc|google/protobuf|absl)")

# These platform folders must not include gRPC and protobuf.
WITHOUT_RPC = {"server/alerts", "server/events", "server/sessions", "server/storage"}
RPC_LIBRARY = re.compile(r"^(grpc|google/protobuf)")

# These folders may use only the standard library and Eigen.
PURE_FOLDERS = DECIDER | FOR_ALL
DECISION_HEADERS = re.compile(
    r"^(Eigen/.*|algorithm|array|bit|cassert|charconv|cmath|compare|concepts|cstddef|cstdint|cstring|deque|functional|"
    r"initializer_list|iterator|limits|map|memory|numbers|numeric|optional|ranges|set|span|string|string_view|tuple|"
    r"type_traits|unordered_map|utility|variant|vector)$")
# The results of these functions differ between standard libraries. (sqrt, fabs, floor, ceil, trunc, ldexp, frexp and fmin/fmax are exact
# everywhere.)
INEXACT = r"(?:exp2?|expm1|log(?:2|10|1p)?|pow|sin|cos|tan|asin|acos|atan2?|sinh|cosh|tanh|cbrt|hypot|[lt]gamma|erfc?)f?"
INEXACT_CALL = re.compile(r"(?:\bstd::%s\b|(?<![\w:.>])%s\s*\(|\.%s\(\))" % (INEXACT, INEXACT, INEXACT))
# The results of these classes differ, too, because standard libraries use different algorithms for them.
DISTRIBUTION = re.compile(r"\bstd::\w+_distribution\b|\b(?:mt19937\w*|random_device|random_shuffle)\b")

INCLUDE = re.compile(r'^[ \t]*#[ \t]*include[ \t]*(?:"([^"]+)"|<([^>]+)>)', re.MULTILINE)
COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/", re.DOTALL)
SOURCE_SUFFIXES = {".h", ".cc", ".c", ".inc"}


def folder_of(path):
    """Returns the row of ALLOWED for a source file, or None."""
    if path.startswith(PUBLIC_FOLDER + "/"):
        return PUBLIC_HEADERS.get(path[len(PUBLIC_FOLDER) + 1:])
    parent = path.rpartition("/")[0]
    while parent and parent not in ALLOWED:
        parent = parent.rpartition("/")[0]
    if parent == "server" and path.count("/") > 1:
        return None
    return parent or None


def target_of(name):
    """Returns the folder of an included header; None for headers of other projects."""
    if name.startswith("sweepstake/v1/"):
        return "proto"
    if name.startswith("sweepstake/"):
        return PUBLIC_HEADERS.get(name[len("sweepstake/"):], "an unknown public header")
    if name.startswith(("engine_client/", "server/")):
        return folder_of(name) or "an unknown folder"
    if name.startswith("tests/"):
        return "tests"
    return None


def is_core(folder):
    return folder in PURE_FOLDERS


def include_errors(path, folder, name):
    target = target_of(name)
    if target is not None:
        if target not in {folder, *FOR_ALL, *ALLOWED[folder]}:
            yield f'"{name}" ({target}) must not be included from {folder}'
        return
    if is_core(folder) and not DECISION_HEADERS.match(name):
        yield f"<{name}> must not be included from the decision core"
    if folder in FOR_ALL and name.startswith("Eigen/"):
        yield f"<{name}> must not be included from {folder}, which needs the standard library only"
    if folder in WITHOUT_RPC and RPC_LIBRARY.match(name):
        yield f"<{name}> must not be included from {folder}, which may use plain values only"
    if folder not in PLATFORM_FOLDERS:
        if PLATFORM_HEADER.match(name) and path not in PLATFORM_FILES:
            yield f"<{name}> is not portable and must not be included from {folder}"
        if RPC_HEADER.match(name):
            yield f"<{name}> must not be included from {folder}, which builds without gRPC"


def room_errors(path, name):
    for folder, order in ROOM_ORDER.items():
        if path.startswith(folder + "/") and name.startswith(folder + "/"):
            room, target = (file[len(folder) + 1:].rpartition("/")[0] for file in (path, name))
            if room not in order:
                yield f"the room '{room}' of {folder} is missing in ROOM_ORDER of tests/include_direction_test.py"
            elif target not in order[:order.index(room) + 1]:
                yield f'"{name}" must not be included from the room \'{room or folder}\''


def file_errors(path, text):
    folder = folder_of(path)
    if folder is None:
        yield f"{path}: its folder is missing in the table ALLOWED of tests/include_direction_test.py"
        return
    # Remove comments but keep their line breaks, so that line numbers stay correct.
    code = COMMENT.sub(lambda match: "\n" * match.group().count("\n"), text)
    for match in INCLUDE.finditer(code):
        line = code.count("\n", 0, match.start(match.lastindex)) + 1
        name = match.group(1) or match.group(2)
        for error in [*include_errors(path, folder, name), *room_errors(path, name)]:
            yield f"{path}:{line}: {error}"
    if is_core(folder):
        for pattern in (INEXACT_CALL, DISTRIBUTION):
            for match in pattern.finditer(code):
                line = code.count("\n", 0, match.start()) + 1
                yield f"{path}:{line}: '{match.group().strip()}' differs between platforms"


def check(root):
    errors, count = [], 0
    for top in ("engine_client", "server"):
        for file in sorted((root / top).rglob("*")):
            if file.suffix in SOURCE_SUFFIXES and "node_modules" not in file.parts:
                count += 1
                errors += file_errors(file.relative_to(root).as_posix(), file.read_text(encoding="utf-8"))
    return errors, count


GOOD = {
    "engine_client/broad_phase/grid/grid.cc": '#include "sweepstake/broad_phase.h"\n#include <hwy/highway.h>\n',
    "engine_client/broad_phase/dbvt/dbvt.cc": '#include "engine_client/broad_phase/kd/leaf_tree.h"\n',
    "engine_client/broad_phase/registry.cc": '#include "engine_client/broad_phase/grid/grid.h"\n',
    "engine_client/telemetry/embedded.cc": '#include "engine_client/decider/types.h"\n#include <unistd.h>\n',
    "engine_client/cli/watch.cc": '#include "sweepstake/v1/posteriors.pb.h"\n#include <grpcpp/grpcpp.h>\n',
    "engine_client/decider/policy/reward.cc": "#include <cmath>\n// std::exp differs\ndouble F(double x) { return std::sqrt(x) + Log(x); }\n",
    "engine_client/decider/session/decision_session.cc": '#include "engine_client/decider/policy/policy.h"\n',
    "engine_client/decider/audit/audit_log.cc": '#include "engine_client/decider/session/decision_session.h"\n',
    "server/rpc/telemetry_service.cc": '#include "engine_client/decider/audit/audit_log.h"\n#include "sweepstake/v1/telemetry.pb.h"\n',
    "engine_client/broad_phase/simd.cc": '#include "engine_client/text/names.h"\n',
    "engine_client/scene/suite.cc": '#include "engine_client/math/hash.h"\n',
    "engine_client/math/beta.cc": '#include "engine_client/math/portable_math.h"\n#include <cmath>\n',
    "server/program.cc": '#include "server/daemon.h"\n#include "server/storage/sqlite_prior_store.h"\n',
    "engine_client/include/sweepstake/scene.h": '#include "sweepstake/aabb.h"\n',
}
BAD = {
    "engine_client/adaptive/z.cc": '#include "engine_client/decider/types.h"\n',
    "engine_client/decider/embedded/z.cc": '#include "engine_client/telemetry/common/sample_queue.h"\n',
    "engine_client/broad_phase/a.cc": '#include "engine_client/scene/world.h"\n',
    "engine_client/broad_phase/common/b.cc": '#include "engine_client/broad_phase/grid/grid.h"\n',
    "engine_client/broad_phase/grid/b.cc": '#include "engine_client/broad_phase/brute_force.h"\n',
    "engine_client/cli/game/b.cc": '#include "engine_client/cli/daemon/daemon_client.h"\n',
    "engine_client/cli/attic/b.cc": '#include "engine_client/cli/io/text_table.h"\n',
    "engine_client/broad_phase/b.cc": '#  include "sweepstake/adaptive_broad_phase.h"\n',
    "engine_client/scene/c.cc": '#include "sweepstake/adaptive_broad_phase.h"\n',
    "engine_client/scene/d.cc": "#include <sys/mman.h>\n",
    "engine_client/adaptive/e.cc": '#include "engine_client/telemetry/common/sample_queue.h"\n',
    "engine_client/adaptive/f.cc": "#include <unistd.h>\n",
    "engine_client/c_api/g.cc": '#include "sweepstake/v1/telemetry.pb.h"\n',
    "engine_client/c_api/h.cc": "#include <grpcpp/grpcpp.h>\n",
    "engine_client/cli/i.cc": '#include "server/rpc/telemetry_service.h"\n',
    "engine_client/include/sweepstake/aabb.h": '#include "sweepstake/scene.h"\n',
    "engine_client/include/sweepstake/new.h": "\n",
    "engine_client/telemetry/j.cc": '#include "server/storage/prior_store.h"\n',
    "server/rpc/k.cc": '#include "server/storage/prior_store.h"\n',
    "server/storage/l.cc": '#include "server/rpc/rpc_server.h"\n',
    "engine_client/decider/pooling/m.cc": '#include "server/sessions/prior_store.h"\n',
    "server/rpc/n.cc": '#include "sweepstake/shadow.h"\n',
    "server/program.cc": '#include "engine_client/scene/world.h"\n',
    "server/rpc/o.cc": '#include "server/daemon.h"\n',
    "engine_client/decider/p.cc": "#include <chrono>\n",
    "engine_client/decider/q.cc": '#include "sweepstake/v1/telemetry.pb.h"\n',
    "engine_client/decider/r.cc": "double F(double x) { return std::exp(x); }\n",
    "engine_client/decider/s.cc": "double F(double x) { return 1 + pow(x, 2); }\n",
    "engine_client/decider/t.cc": "std::gamma_distribution<double> d;\n",
    "engine_client/decider/u.cc": "auto F(const Eigen::ArrayXd& x) { return x.log(); }\n",
    "server/elsewhere/v.cc": "\n",
    "server/sessions/a.cc": '#include "server/events/event_bus.h"\n',
    "server/sessions/b.cc": '#include "sweepstake/v1/telemetry.pb.h"\n',
    "server/sessions/c.cc": "#include <grpcpp/support/byte_buffer.h>\n",
    "server/sessions/common/d.cc": '#include "server/sessions/prior_store.h"\n',
    "engine_client/scene/w.cc": '#include "engine_client/decider/types.h"\n',
    "engine_client/math/x.cc": '#include "engine_client/decider/types.h"\n',
    "engine_client/text/x.cc": '#include "engine_client/decider/types.h"\n',
    "engine_client/math/y.cc": "#include <Eigen/Core>\n",
    "engine_client/math/z.cc": "double F(double x) { return std::exp(x); }\n",
    "engine_client/decider/session/w.cc": '#include "engine_client/decider/audit/audit_log.h"\n',
    "engine_client/decider/session/x.cc": '#include "server/sessions/session_start.h"\n',
    "engine_client/decider/policy/x.cc": '#include "engine_client/decider/session/decision_session.h"\n',
    "engine_client/decider/y.cc": '#include "engine_client/decider/policy/policy.h"\n',
    "server/rpc/z.cc": '#include "tests/laboratory/policies/study_policies.h"\n',
    "engine_client/telemetry/common/z.cc": '#include "engine_client/telemetry/conversion/proto_conversion.h"\n',
    "engine_client/telemetry/aa.cc": '#include "tests/laboratory/policies/study_policies.h"\n',
    "engine_client/decider/audit/ab.cc": '#include "server/sessions/prior_store.h"\n',
    "engine_client/decider/audit/ac.cc": "#include <fstream>\n",
    "server/tls/af.cc": '#include "server/rpc/common/options.h"\n',
    "server/events/ad.cc": '#include "server/rpc/common/options.h"\n',
    "server/auth/ag.cc": '#include "server/rpc/common/options.h"\n',
    "server/web/af.cc": '#include "server/rpc/common/options.h"\n',
    "server/events/ae.cc": '#include "server/storage/store_thread.h"\n',
}


def self_test():
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for path, text in GOOD.items():
            (root / path).parent.mkdir(parents=True, exist_ok=True)
            (root / path).write_text(text, encoding="utf-8")
        errors, _ = check(root)
        if errors:
            return ["a good tree was refused: " + error for error in errors]
        missed = []
        for path, text in BAD.items():
            file = root / path
            before = file.read_text(encoding="utf-8") if file.exists() else None
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
            errors, _ = check(root)
            if len(errors) != 1 or not errors[0].startswith(path):
                missed.append(f"{path} {text!r} gave {errors} instead of one error")
            file.unlink() if before is None else file.write_text(before, encoding="utf-8")
        return missed


def main(arguments):
    if arguments == ["--self-test"]:
        errors = self_test()
        print("\n".join(errors) or f"{len(BAD)} bad includes were each found")
        return 1 if errors else 0
    if len(arguments) != 1:
        print(__doc__, file=sys.stderr)
        return 2
    errors, count = check(pathlib.Path(arguments[0]))
    if count == 0:
        errors.append(f"no source file under {arguments[0]}")
    print("\n".join(errors) or f"{count} files follow the direction")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
