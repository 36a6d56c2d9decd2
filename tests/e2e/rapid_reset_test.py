#!/usr/bin/python3
"""Clients that begin calls and break them off as fast as they can: they take no memory to speak of,
and others are answered all the while; who breaks off what came too late goes on.

    rapid_reset_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import socket
import struct
import threading
import time
import unittest

import http2
import programs

CANCEL = struct.pack(">I", 8)
PER_WRITE = 50


def calls(first):
    """So many calls as bytes, each broken off at once."""
    def call(stream):
        return (http2.frame(http2.HEADERS, http2.END_HEADERS, stream, HEADERS) +
                http2.frame(http2.DATA, http2.END_STREAM, stream, http2.message(b"")) +
                http2.frame(http2.RESET, 0, stream, CANCEL))
    return b"".join(call(2 * number + 1) for number in range(first, first + PER_WRITE))


HEADERS = http2.request_headers("DatabaseService/ListDatabases")


class Client:
    """A connection whose answers are thrown away."""

    def __init__(self, address):
        host, port = address.rsplit(":", 1)
        self.socket = socket.create_connection((host, int(port)))
        self.socket.sendall(http2.START + http2.frame(http2.SETTINGS, 0, 0, b""))
        self.reader = threading.Thread(target=self.read)
        self.reader.start()

    def read(self):
        try:
            while self.socket.recv(1 << 16):
                pass
        except OSError:
            pass

    def break_off(self, count, seconds=0):
        """How many calls it came to, over so long a time, before the server ended the connection."""
        began = time.monotonic()
        for sent in range(0, count, PER_WRITE):
            try:
                self.socket.sendall(calls(sent))
            except OSError:
                return sent
            time.sleep(max(0, began + seconds * sent / count - time.monotonic()))
        return count

    def close(self):
        try:
            self.socket.shutdown(socket.SHUT_RDWR)
        except OSError:
            pass
        self.reader.join()
        self.socket.close()


class RapidReset(programs.WithServer):
    def most_memory(self):
        """In MiB, since the server's start."""
        with open(f"/proc/{self.server.process.pid}/status", encoding="ascii") as status:
            [line] = [line for line in status if line.startswith("VmHWM")]
        return int(line.split()[1]) / 1024

    def test_a_flood_takes_no_memory_to_speak_of(self):
        clients = [Client(self.server.address) for _ in range(4)]
        # Without an end of it, these came to 4 GB, or to nothing, as the scheduler would have it.
        count = int(50_000 / min(programs.SLOWNESS, 5))
        floods = [threading.Thread(target=client.break_off, args=[count]) for client in clients]
        for flood in floods:
            flood.start()
        while any(flood.is_alive() for flood in floods):
            result = self.server.run("--timeout", str(60 * programs.SLOWNESS), "list")
            self.assertEqual((result.returncode, result.stderr), (0, ""))
        for client in clients:
            client.close()
        print(f"at most {self.most_memory():.0f} MiB")
        self.assertLess(self.most_memory(), 700 * min(programs.SLOWNESS, 4))
        self.server.ask_one("create", "walks")

    def test_who_breaks_calls_off_now_and_then_goes_on(self):
        client = Client(self.server.address)
        self.assertEqual(client.break_off(3000, seconds=6), 3000)
        client.close()


if __name__ == "__main__":
    programs.main()
