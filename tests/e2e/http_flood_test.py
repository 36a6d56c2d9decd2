#!/usr/bin/python3
"""Eight clients flood an HTTP port: others must be answered, and memory must stay small.

    http_flood_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import http.client
import multiprocessing
import os
import selectors
import socket
import ssl
import tempfile
import time
import unittest

import programs
from floods import BOMB, CALL, CLIENT_HELLO, DEEP, PAGE, json_call
from programs import Server
from secure_server import Authority

MIB = 1 << 20
ATTACKER, PROBE = "127.0.0.2", "127.0.0.3"
SECONDS = 3.0
MAX_ANSWER_SECONDS = 0.25 if programs.SLOWNESS == 1 else 5
METRICS = b"GET /metrics HTTP/1.1\r\nHost: test\r\n\r\n"


class Port:
    """The port that is attacked. `tls`: of its connections, or None."""

    def __init__(self, number, tls):
        self.number, self.tls = number, tls

    def connect_bare(self):
        return socket.create_connection(("127.0.0.1", self.number), timeout=5,
                                        source_address=(ATTACKER, 0))

    def connect(self):
        bare = self.connect_bare()
        return self.tls.wrap_socket(bare, server_hostname="localhost") if self.tls else bare


def trickle(connect, begin, more, count=100):
    """Keeps connections open and sends a few bytes at a time on each."""
    held = []
    while True:
        if len(held) < count:
            held.append(connect())
            held[-1].sendall(begin)
        for connection in held[:]:
            try:
                connection.sendall(more)
            except OSError:
                connection.close()
                held.remove(connection)
        time.sleep(0.01)


def slow_headers(port, _request):
    trickle(port.connect, b"GET /readyz HTTP/1.1\r\n", b"X: y\r\n")


def slow_bodies(port, _request):
    """Announces bodies of 8 MiB."""
    trickle(port.connect, json_call(b'{"page_token":"', 8 * MIB), b"xxxx")


def slow_hellos(port, _request):
    """Sends the first message of a handshake byte by byte."""
    trickle(port.connect_bare, CLIENT_HELLO[:-32], b"x", 50)


def hold(connect, count, begin=b""):
    """Keeps connections open that send nothing more."""
    held = []
    while True:
        held.append(connect())
        held[-1].sendall(begin)
        if len(held) > count:
            held.pop(0).close()


def half_hellos(port, _request):
    """A handshake that has begun costs the server 47 KiB."""
    hold(port.connect_bare, 50, CLIENT_HELLO)


def handshakes(port, _request):
    while True:
        port.connect().close()


def large_headers(port, _request):
    while True:
        with port.connect() as connection:
            connection.sendall(b"GET /readyz HTTP/1.1\r\n")
            for _ in range(1000):
                connection.sendall(b"X: " + b"x" * 1000 + b"\r\n")


def many_connections(port, _request):
    hold(port.connect, 200)


def pipelined(port, request):
    """Sends requests without end and never reads the answers."""
    while True:
        with port.connect() as connection:
            while True:
                connection.sendall(50 * request)


def fast(port, request):
    """Sends requests and reads answers as fast as possible."""
    while True:
        with port.connect() as connection:
            while True:
                connection.sendall(request)
                if not connection.recv(1 << 20):
                    break


def many_readers(port, request):
    """Keeps many connections that always wait for a page."""
    waiting = selectors.DefaultSelector()
    while True:
        while len(waiting.get_map()) < 64:
            connection = port.connect()
            connection.sendall(request)
            waiting.register(connection, selectors.EVENT_READ)
        for key, _ in waiting.select():
            try:
                if key.fileobj.recv(1 << 20):
                    key.fileobj.sendall(request)
                    continue
            except OSError:
                pass
            waiting.unregister(key.fileobj)
            key.fileobj.close()


def bombs(port, _request):
    """Sends bodies that are deep, or 1,000 times larger after gzip."""
    while True:
        for body in (DEEP, BOMB):
            with port.connect() as connection:
                connection.sendall(body)
                connection.recv(1 << 20)


def attack(kind, port, request):
    os.nice(10)  # the attackers must not take the server's processor time
    while True:
        try:
            kind(port, request)
        except OSError:
            time.sleep(0.001)


def resident(pid):
    with open(f"/proc/{pid}/statm") as file:
        return int(file.read().split()[1]) * os.sysconf("SC_PAGESIZE") / MIB


def new_probe(port):
    source = {"timeout": 10, "source_address": (PROBE, 0)}
    if port.tls:
        return http.client.HTTPSConnection("127.0.0.1", port.number, context=port.tls, **source)
    return http.client.HTTPConnection("127.0.0.1", port.number, **source)


def get_page(port, number):
    probe = new_probe(port)
    probe.request("GET", ("/livez", "/readyz", "/metrics")[number % 3])
    status = probe.getresponse().status
    probe.close()
    return status


def list_databases(port, _number):
    probe = new_probe(port)
    probe.request("POST", "/motiondb.v1.DatabaseService/ListDatabases", "{}",
                  {"Content-Type": "application/json"})
    status = probe.getresponse().status
    probe.close()
    return status


KINDS = [slow_headers, large_headers, many_connections, pipelined, many_readers, fast]


class HttpFlood(unittest.TestCase):
    def test_probes_are_answered_while_eight_clients_flood_the_port(self):
        self.check(["--http-listen"], lambda server: server.http, get_page, METRICS,
                   [*KINDS, many_connections, many_readers])

    def test_calls_are_answered_while_eight_clients_flood_the_api(self):
        self.check(["--web-listen"], lambda server: server.web, list_databases, CALL,
                   [*KINDS, slow_bodies, bombs])

    def test_calls_are_answered_while_eight_clients_flood_the_page_over_tls(self):
        with tempfile.TemporaryDirectory() as folder:
            authority = Authority(folder, "authority")
            certificate, key = authority.issue("server", "localhost")
            tls = ssl.create_default_context(cafile=authority.certificate)
            self.check(["--tls-certificate", certificate, "--tls-key", key, "--web-listen"],
                       lambda server: server.web, list_databases, PAGE,
                       [slow_hellos, half_hellos, handshakes, many_connections, slow_headers,
                        slow_bodies, large_headers, fast], tls)

    def check(self, settings, address, probe, request, kinds, tls=None):
        with tempfile.TemporaryDirectory() as folder:
            server = Server(folder + "/motion.db", *settings, "127.0.0.1:0")
            self.addCleanup(lambda: server.process.poll() is not None or server.stop())
            port = Port(int(address(server).rsplit(":", 1)[1]), tls)
            before = resident(server.process.pid)
            attackers = [multiprocessing.Process(target=attack, args=(kind, port, request),
                                                 daemon=True) for kind in kinds]
            for attacker in attackers:
                attacker.start()
            try:
                time.sleep(0.5)  # all attackers run
                times, peak = [], 0.0
                begin = time.monotonic()
                while time.monotonic() - begin < SECONDS:
                    asked = time.monotonic()
                    self.assertEqual(probe(port, len(times)), 200)
                    times.append(time.monotonic() - asked)
                    peak = max(peak, resident(server.process.pid))
                    time.sleep(0.01)
            finally:
                for attacker in attackers:
                    attacker.kill()
                for attacker in attackers:
                    attacker.join()
            times.sort()
            print(f"\n{len(times)} probes: half within {1000 * times[len(times) // 2]:.0f} ms, all within "
                  f"{1000 * times[-1]:.0f} ms; memory {before:.0f} -> {peak:.0f} MiB")
            self.assertLess(times[-1], MAX_ANSWER_SECONDS)
            if programs.SLOWNESS == 1:  # sanitizers delay the return of freed memory
                self.assertLess(peak - before, 32)
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    programs.main()
