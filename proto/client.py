#!/usr/bin/env python3
"""A game without an engine: it speaks the protocol, and simulates three algorithms with known costs. CLIENT.md explains each step.

    protoc -I proto --python_out=OUT proto/sweepstake/v1/telemetry.proto
    PYTHONPATH=OUT proto/client.py 127.0.0.1:7433 --seconds 60        # needs the Python packages grpcio and protobuf
"""

import argparse
import collections
import queue
import random
import signal
import threading
import time

import grpc
from sweepstake.v1 import telemetry_pb2 as wire

COST_NS = {"Grid": 900_000, "KDTree": 300_000, "SAP": 600_000}  # detection time of each algorithm
FRAME_NS, BATCH_FRAMES = 16_666_667, 15


class Game:
    def __init__(self, arguments):
        arms = [wire.Arm(name=name, backend_version=1) for name in COST_NS]
        self.hello = wire.Hello(protocol_version=1, project="example", scene="simulated", machine_class="example", arms=arms, mode=wire.MODE_AI,
                                time_scale=arguments.time_scale)
        self.sequence, self.frame, self.outcome, self.unacknowledged = 0, 0, None, collections.deque()
        self.end, self.least_delay_s = time.monotonic() + arguments.seconds, 0

    def send(self, **message):
        """Numbers a message with evidence, and keeps it until the daemon has it on disk."""
        self.sequence += 1
        self.unacknowledged.append(wire.StreamTelemetryRequest(sequence=self.sequence, **message))
        self.outbox.put(self.unacknowledged[-1])

    def connect(self, stream, token):
        """Opens a stream with Hello, and sends again what is not on disk."""
        self.outbox, self.inbox = queue.SimpleQueue(), queue.SimpleQueue()
        self.outbox.put(wire.StreamTelemetryRequest(hello=self.hello))
        self.call = stream(iter(self.outbox.get, None), metadata=[("authorization", f"Bearer {token}")] if token else [])
        first = next(self.call)
        if not first.HasField("welcome"):
            raise ConnectionError("the daemon is shutting down")
        welcome, self.least_delay_s = first.welcome, 0
        print(f"session {welcome.session_id}, resumed: {welcome.resumed}, policy {welcome.policy}", flush=True)
        self.hello.session_id, self.hello.resume_token, self.settling_s = welcome.session_id, welcome.resume_token, welcome.settling_ms / 1000
        self.forget(welcome.acknowledged_sequence)
        if not welcome.resumed:  # a new session counts from 1
            for self.sequence, request in enumerate(self.unacknowledged, 1):
                request.sequence = self.sequence
        for request in self.unacknowledged:
            self.outbox.put(request)
        threading.Thread(target=self.read, args=(self.call, self.inbox), daemon=True).start()

    @staticmethod
    def read(call, inbox):
        try:
            for response in call:
                inbox.put(response)
            inbox.put(None)  # the daemon has ended the stream
        except grpc.RpcError as error:
            inbox.put(error)

    def forget(self, sequence):
        while self.unacknowledged and self.unacknowledged[0].sequence <= sequence:
            self.unacknowledged.popleft()

    def handle(self, response):
        self.forget(response.acknowledgement.sequence)
        if response.HasField("reconnect"):
            self.least_delay_s = response.reconnect.delay_ms / 1000
        if response.HasField("switch_command"):
            command, arm = response.switch_command, response.switch_command.arm
            executed = arm != self.hello.active_arm
            self.hello.active_arm, self.hello.switch_epoch = arm, self.hello.switch_epoch + executed
            self.settled_at = time.monotonic() + executed * self.settling_s
            self.outcome = wire.SwitchOutcome(command_id=command.command_id, arm=arm, switch_epoch=self.hello.switch_epoch, executed=executed,
                                              rebuild_time_ns=COST_NS[self.name(arm)], reason=command.reason)
            print(f"switched to {self.name(arm)} ({wire.SwitchReason.Name(command.reason)})", flush=True)

    def name(self, arm):
        return self.hello.arms[arm].name

    def cost_ns(self, arm):
        return round(COST_NS[self.name(arm)] * random.lognormvariate(0, 0.02))

    def play(self):
        """Measures a batch of frames of the active algorithm, and a sweep of the shadow lane over all algorithms on the same frames."""
        arm, columns = self.hello.active_arm, {"object_count": 3_000, "native_bytes": 1 << 20, "aabb_check_count": 10_000, "flags": 0}
        columns |= {"arm": self.hello.active_arm, "switch_epoch": self.hello.switch_epoch, "frame_time_ns": FRAME_NS}
        batch = wire.FrameBatch(first_frame_index=self.frame, detection_time_ns=[self.cost_ns(arm) for _ in range(BATCH_FRAMES)])
        for column, value in columns.items():
            getattr(batch, column).extend([value] * BATCH_FRAMES)
        for visited in range(len(COST_NS)):
            batch.shadow_samples.add(first_frame_index=self.frame, arm=visited, detection_time_ns=self.cost_ns(visited), frame_count=8, object_count=3_000,
                                     flags=wire.SHADOW_FLAG_ACTIVE if visited == arm else 0)
        self.frame += BATCH_FRAMES
        self.send(frame_batch=batch)
        if self.outcome and time.monotonic() >= self.settled_at:
            self.send(switch_outcome=self.outcome)
            self.outcome = None

    def run(self):
        """Plays until its end, then says goodbye. Raises grpc.RpcError or ConnectionError if the connection is lost before."""
        while True:
            time.sleep(BATCH_FRAMES * FRAME_NS / 1e9)
            while not self.inbox.empty():
                response = self.inbox.get()
                if response is None or isinstance(response, grpc.RpcError):
                    raise response or ConnectionError("the daemon has ended the stream")
                self.handle(response)
            if time.monotonic() >= self.end:
                break
            self.play()
        self.outbox.put(wire.StreamTelemetryRequest(goodbye=wire.Goodbye()))
        self.outbox.put(None)
        while isinstance(response := self.inbox.get(), wire.StreamTelemetryResponse):  # the stream ends when all evidence is on disk
            self.handle(response)
        if response is not None:
            print(f"the daemon has not confirmed the end: {response.details()}", flush=True)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("daemon", help="HOST:PORT")
    parser.add_argument("--token", default="", help="sent as `authorization: Bearer TOKEN`")
    parser.add_argument("--seconds", type=float, default=60, help="Ctrl-C ends it before, in an orderly way")
    parser.add_argument("--time-scale", type=float, default=1, help="divides the daemon's intervals, if it allows that (--max-time-scale)")
    arguments = parser.parse_args()
    game, failures = Game(arguments), 0
    signal.signal(signal.SIGINT, lambda *_: setattr(game, "end", 0))
    while True:
        try:
            with grpc.insecure_channel(arguments.daemon) as channel:
                stream = channel.stream_stream("/sweepstake.v1.TelemetryService/StreamTelemetry", wire.StreamTelemetryRequest.SerializeToString,
                                               wire.StreamTelemetryResponse.FromString)
                game.connect(stream, arguments.token)
                failures = 0
                return game.run()
        except (grpc.RpcError, ConnectionError, StopIteration) as error:
            if isinstance(error, grpc.RpcError) and error.code() in (grpc.StatusCode.PERMISSION_DENIED, grpc.StatusCode.UNAUTHENTICATED):
                raise
            if time.monotonic() >= game.end:
                raise
            print(f"connection lost: {error.details() if isinstance(error, grpc.RpcError) else error}", flush=True)
            time.sleep(game.least_delay_s + random.uniform(0, min(10, 0.1 * 2 ** min(failures, 10))))  # full jitter, at most ten seconds
            failures += 1


if __name__ == "__main__":
    main()
