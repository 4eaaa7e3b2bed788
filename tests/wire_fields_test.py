#!/usr/bin/env python3
"""Fails on a field of proto/ that no program of this tree writes, or that none reads: nothing that is never read travels.

    wire_fields_test.py ROOT BUILD    checks the objects of engine_client/ and server/ in a build with debug information
    wire_fields_test.py --self-test   shows that a field that is not written, or not read, is found

A field is written or read where the accessor that protoc generates for it is called. The compiler inlines the calls, but the debug
information keeps the names of what was inlined, which are as exact as types: Goodbye.reason is not SwitchOutcome.reason. That a
column has the right length (NAME_size) is no reading. The session of a game works without protobuf: what encode.cc and decode.cc of
engine_client/telemetry/protocol/ name by its tag, as HelloTag::kProject, is written or read there.
"""

import pathlib
import re
import sys

# Fields that other programs read or write, and why.
OTHERS = {
    "StatusDetails.code": "google.rpc.Status: clients in other languages read it",
    "StatusDetails.message": "google.rpc.Status: clients in other languages read it",
    "ListPosteriorsRequest.page_size": "the size of a page is the caller's choice; ours take the daemon's",
    "ListSessionsRequest.page_size": "the size of a page is the caller's choice; ours take the daemon's",
    "BoxView.frame_index": "the dashboard shows boxes",
    "BoxView.object_count": "the dashboard shows boxes",
    "BoxView.stride": "the dashboard shows boxes",
    "WatchBoxesRequest.session_id": "the dashboard watches boxes",
    "WatchBoxesResponse.view": "the dashboard watches boxes",
    "ArmPosterior.is_outdated": "the dashboard marks old versions",
    "PriorRecord.is_imported": "the dashboard tells imports from sessions",
    "PriorRecord.weight": "the dashboard shows what a source weighs",
    "ExportDecisionsRequest.after_segment": "the dashboard reads what is new of a log",
    "ExportDecisionsRequest.after_row": "the dashboard reads what is new of a log",
    "ExportPriorsRequest.with_weights": "the dashboard asks for weights; ours export to files",
    "GetPosteriorRequest.": "the call of programs that want one scene; ours list",
    "GetPosteriorResponse.": "the call of programs that want one scene; ours list",
}

COMMENT = re.compile(r"//[^\n]*")
MESSAGE = re.compile(r"^message (\w+) \{\n(.*?)^\}", re.DOTALL | re.MULTILINE)
FIELD = re.compile(r"^\s*(?:optional |repeated )?[\w.]+ (\w+) = \d+;", re.MULTILINE)
TAG = re.compile(r"\b(\w+)Tag::k(\w+)")
PROTOCOL = pathlib.Path("engine_client/telemetry/protocol")
ACCESSOR = re.compile(rb"_ZNK?10sweepstake2v1(\d+)(\w+)")


def fields_of(text):
    """Pairs of message and field."""
    for name, body in MESSAGE.findall(COMMENT.sub("", text)):
        for field in FIELD.findall(body):
            yield name, field


def accessors_in(data):
    """Pairs of message and accessor, from the mangled names in an object."""
    for digits, rest in ACCESSOR.findall(data):
        length = int(digits)
        message, tail = rest[:length].decode(), rest[length:]
        if (name := re.match(rb"(\d+)", tail)) is not None:
            start = name.end()
            yield message, tail[start:start + int(name.group())].decode()


def tags_in(text, prefix):
    """Pairs of message and accessor, as if each tag that is used were a call of it."""
    for message, name in TAG.findall(COMMENT.sub("", text)):
        yield message, prefix + re.sub(r"(?<!^)([A-Z])", r"_\1", name).lower()


def errors_of(fields, accessors):
    for message, field in fields:
        if f"{message}.{field}" in OTHERS or f"{message}." in OTHERS:
            continue
        calls = {call for owner, call in accessors if owner == message}
        if not calls & {prefix + field for prefix in ("set_", "add_", "mutable_", "set_allocated_")}:
            yield f"{message}.{field} is written nowhere: remove it, and reserve its number and name"
        if not calls & {field, "has_" + field}:
            yield f"{message}.{field} is read nowhere: remove it, and reserve its number and name"


def check(root, build):
    fields = [field for path in sorted((root / "proto").rglob("*.proto")) for field in fields_of(path.read_text(encoding="utf-8"))]
    objects = [path for folder in ("engine_client", "server") for path in (build / folder).rglob("*.o")]
    accessors = {accessor for path in objects for accessor in accessors_in(path.read_bytes())}
    for source, prefix in (("encode.cc", "set_"), ("decode.cc", "")):
        accessors.update(tags_in((root / PROTOCOL / source).read_text(encoding="utf-8"), prefix))
    if not fields or not accessors:
        return fields, ["there is nothing to check: build the preset dev first"]
    return fields, list(errors_of(fields, accessors))


def self_test():
    fields = list(fields_of("""
message Empty {}
message Goodbye {
  reserved 1;
  // Not said; string word = 4;
  string reason = 2;
  oneof rest {
    repeated uint32 counts = 3;
  }
}
"""))
    assert fields == [("Goodbye", "reason"), ("Goodbye", "counts")], fields
    used = [b"_ZN10sweepstake2v17Goodbye10set_reasonIJPKcEEEvOT_DpT0_", b"_ZNK10sweepstake2v17Goodbye6reasonEv",
            b"_ZN10sweepstake2v17Goodbye10add_countsEj", b"_ZNK10sweepstake2v17Goodbye6countsEi"]
    noise = [b"_ZNK10sweepstake2v17Goodbye11counts_sizeEv", b"_ZNK10sweepstake2v17Another6reasonEv"]
    missed = []
    for left_out in [None, *used]:
        data = b"\0".join(name for name in used + noise if name != left_out)
        errors = list(errors_of(fields, set(accessors_in(data))))
        if len(errors) != (left_out is not None):
            missed.append(f"without {left_out}: {errors}")
    tags = set(tags_in("enum class GoodbyeTag { kReason = 2 };  // GoodbyeTag::kCounts\nout.PutNumber(GoodbyeTag::kReason, 1);", "set_"))
    if tags != {("Goodbye", "set_reason")}:
        missed.append(f"tags: {tags}")
    return missed


def main(arguments):
    if arguments == ["--self-test"]:
        errors = self_test()
        print("\n".join(errors) or "each field that is not written or not read was found")
        return 1 if errors else 0
    if len(arguments) != 2:
        print(__doc__, file=sys.stderr)
        return 2
    fields, errors = check(*map(pathlib.Path, arguments))
    print("\n".join(errors) or f"all {len(fields)} fields are written and read")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
