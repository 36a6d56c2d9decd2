"""Clients that hold back the end of a request, or do not take an answer: they may take as much
memory and as many places as they are given, and others are answered all the while. Speaks HTTP/2
itself, for no client library leaves a message half sent."""

import os
import select
import socket
import struct
import tempfile
import time
import unittest

import http2
import programs
from figure import write_bvh
from http2 import (ACK, DATA, END_HEADERS, END_STREAM, HEADERS, INITIAL_WINDOW_SIZE, PING, RESET,
                   SETTINGS, WINDOW_UPDATE, frame)
from programs import Server

MIB = 1 << 20


def field(number, payload):
    """A field of a protobuf message: text, bytes or a message."""
    length, rest = b"", len(payload)
    while rest > 127:
        length, rest = length + bytes([rest % 128 + 128]), rest // 128
    return bytes([number * 8 + 2]) + length + bytes([rest]) + payload


class Call:
    """One call on a connection of its own. All of the message is sent but for the bytes held back;
    of the answer as much is taken as the window lets through."""

    def __init__(self, address, method, message, hold_back=0, window=65535):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)))
        self.rest = memoryview(http2.message(message))
        self.hold_back = hold_back
        self.initial = self.window = self.connection_window = 65535
        self.received = b""
        self.over = False
        settings = frame(SETTINGS, 0, 0, struct.pack(">HI", INITIAL_WINDOW_SIZE, window))
        headers = frame(HEADERS, END_HEADERS, 1, http2.request_headers(method))
        self.socket.sendall(http2.START + settings + headers)

    def close(self):
        self.socket.close()

    def go_on(self):
        """Sends what there is room for, and takes what has come; whether there was any of it."""
        try:
            return not self.over and (self.send() | self.receive())
        except OSError:
            self.over = True
            return False

    def send(self):
        count = min(len(self.rest) - self.hold_back, self.window, self.connection_window, 16384)
        if count <= 0:
            return False
        flags = END_STREAM if count == len(self.rest) else 0
        self.socket.sendall(frame(DATA, flags, 1, self.rest[:count]))
        self.rest = self.rest[count:]
        self.window -= count
        self.connection_window -= count
        return True

    def receive(self):
        if not select.select([self.socket], [], [], 0)[0]:
            return False
        received = self.socket.recv(1 << 16)
        self.over = not received
        self.received += received
        while len(self.received) >= 9:
            end = 9 + int.from_bytes(self.received[:3], "big")
            if len(self.received) < end:
                break
            kind, flags = self.received[3:5]
            self.take(kind, flags, int.from_bytes(self.received[5:9], "big"), self.received[9:end])
            self.received = self.received[end:]
        return True

    def take(self, kind, flags, stream, payload):
        if kind == WINDOW_UPDATE and stream == 0:
            self.connection_window += int.from_bytes(payload, "big")
        elif kind == WINDOW_UPDATE:
            self.window += int.from_bytes(payload, "big")
        elif kind == RESET or kind == HEADERS and flags & END_STREAM:
            self.over = True
        elif kind == PING and not flags & ACK:
            self.socket.sendall(frame(PING, ACK, 0, payload))
        elif kind == SETTINGS and not flags & ACK:
            for setting, value in struct.iter_unpack(">HI", payload):
                if setting == INITIAL_WINDOW_SIZE:
                    self.window += value - self.initial
                    self.initial = value
            self.socket.sendall(frame(SETTINGS, ACK, 0, b""))


class SlowClients(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()

    def tearDown(self):
        self.server.stop()
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def serve(self, *options):
        self.server = Server(self.path("motion.db"), *options)

    def memory(self):
        with open(f"/proc/{self.server.process.pid}/status", encoding="ascii") as status:
            [line] = [line for line in status if line.startswith("VmRSS")]
        return int(line.split()[1]) / 1024

    def ended(self, method):
        """How many calls of the method have their answer, taken or not."""
        return sum(int(ended["call_count"]) for ended in self.server.ask_one("status")["methods"]
                   if ended["method"] == method)

    def answered(self, method):
        """Whether a call of the method has its answer, taken or not."""
        return any(ended["method"] == method for ended in self.server.ask_one("status")["methods"])

    def test_requests_that_are_half_sent_take_the_memory_that_they_may(self):
        self.serve("--max-message-mib", "16", "--max-file-mib", "16", "--message-memory-mib", "64")
        before = self.memory()
        message = bytes(15 * MIB)
        calls = [Call(self.server.address, "QueryService/Recognize", message, hold_back=100)
                 for _ in range(120)]
        idle_since = time.monotonic()
        while time.monotonic() - idle_since < 0.5 * programs.SLOWNESS:
            if any([call.go_on() for call in calls]):
                idle_since = time.monotonic()
        held = self.memory() - before
        self.server.ask_one("create", "walks")
        self.assertEqual(len(self.server.ask("list")), 1)
        over = sum(call.over for call in calls)
        for call in calls:
            call.close()
        print(f"\n{len(calls)} calls that hold back the end of 15 MiB each: {held:.0f} MiB, where "
              f"64 may be held; {over} were ended")
        self.assertGreater(held, 30)  # else nothing was tried
        # About 80; more while a busy machine keeps gRPC from ending calls as fast as they send.
        self.assertLess(held, 600)
        self.assertGreater(over, 0)

    def test_an_answer_that_is_not_taken_is_given_up(self):
        self.serve("--silence-limit", "3", "--max-heavy-calls", "1")
        self.server.ask_one("create", "walks", "--marker-set", "source", "--min-frames", "4")
        write_bvh(self.path("walk.bvh"), 0)
        self.server.ask("ingest", "walks", self.path("walk.bvh"), "--label", "walk")
        write_bvh(self.path("long.bvh"), 0, frames=13000)  # a little more than is small
        with open(self.path("long.bvh"), "rb") as file:
            observation = field(1, field(1, b"long.bvh") + field(3, file.read()))
        message = field(1, b"databases/walks") + field(2, observation)
        call = Call(self.server.address, "ObserveService/Represent", message, window=0)
        export = ["export", "walks", "walk", "--out", self.folder.name, "--force"]
        while call.rest:
            call.go_on()
        while not self.answered("ObserveService.Represent"):
            call.go_on()
        begin = time.monotonic()
        while not call.over and time.monotonic() - begin < 60 * programs.SLOWNESS:
            call.go_on()
            # Its place among the heavy calls is free: what it still takes is memory of the budget.
            self.assertEqual(self.server.run(*export).returncode, 0)
        self.assertTrue(call.over)
        call.close()

    def test_answers_that_are_not_taken_are_bounded(self):
        many = ["--max-heavy-calls", "4000"]  # a quarter of them for one client
        self.serve("--max-file-mib", "16", "--message-memory-mib", "64", *many)
        self.server.ask_one("create", "walks", "--marker-set", "source", "--min-frames", "4")
        write_bvh(self.path("walk.bvh"), 0)
        self.server.ask("ingest", "walks", self.path("walk.bvh"), "--label", "walk")
        write_bvh(self.path("long.bvh"), 0, frames=12000)
        with open(self.path("long.bvh"), "rb") as file:
            observation = field(1, field(1, b"long.bvh") + field(3, file.read()))
        message = field(1, b"databases/walks") + field(2, observation)
        before = self.memory()
        calls = []
        for _ in range(60):
            call = Call(self.server.address, "ObserveService/Represent", message, window=0)
            while call.rest and not call.over:
                call.go_on()
            calls.append(call)
        idle_since = time.monotonic()
        while time.monotonic() - idle_since < 2 * programs.SLOWNESS:
            if any([call.go_on() for call in calls]):
                idle_since = time.monotonic()
        held = self.memory() - before
        refused = sum(call.over for call in calls)
        for call in calls:
            call.close()
        print(f"\n{len(calls)} answers of 1 MiB that are not taken: {held:.0f} MiB, where one client may "
              f"hold 32; {refused} were refused")
        self.assertGreater(refused, 10)
        self.assertLess(refused, len(calls))
        # And what works at the moment; a sanitizer keeps what was freed for a while.
        self.assertLess(held, 600 if programs.SLOWNESS > 1 else 120)


if __name__ == "__main__":
    programs.main()
