#!/usr/bin/python3
"""Clients of several motiondbd on one PostgreSQL cluster: several addresses, and nginx, which sends
the calls about a database to one server. Servers are killed.

    client_failover_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import json
import os
import re
import shutil
import signal
import socket
import subprocess
import tempfile
import threading
import time
import unittest
import urllib.request

import http2
import nginx_proxy
import secure_server
from figure import write_bvh
from postgres_cluster import FOLLOWED, Cluster, main
from programs import MOTIONDB, SLOWNESS, Server, wait_for

RATE_HZ = 60  # of write_bvh
DATABASES = [f"walks-{i}" for i in range(8)]


def run(options, *arguments):
    return subprocess.run([MOTIONDB, *options, *arguments], capture_output=True, text=True)


def shortened(source, path, first):
    """Writes a BVH file without its first frames."""
    with open(source, encoding="ascii") as file:
        head, frames = file.read().split("Frame Time: 0.0166667\n")
    rows = frames.splitlines(keepends=True)[first:]
    head = re.sub(r"Frames: \d+", f"Frames: {len(rows)}", head)
    with open(path, "w", encoding="ascii") as file:
        file.write(head + "Frame Time: 0.0166667\n" + "".join(rows))


class ClientFailover(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()
        cls.addClassCleanup(cls.cluster.remove)

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.cluster.sql(f"CREATE DATABASE {self._testMethodName}")
        self.servers = []
        self.tls = ()  # options of motiondb

    def path(self, name):
        return os.path.join(self.folder, name)

    def serve(self, count, *options):
        for _ in range(count):
            server = Server(self.cluster.url(self._testMethodName), "--http-listen", "127.0.0.1:0",
                            "--log-level", "off", *options)
            self.addCleanup(self.kill, server)
            self.servers.append(server)
        return self.servers

    @staticmethod
    def kill(server):
        if server.process.poll() is None:
            server.stop(signal.SIGKILL)

    def options(self, *servers):
        """The addresses of some servers, or of all, as options of motiondb."""
        addresses = [server.address for server in servers or self.servers]
        return ("--server", ",".join(addresses), *self.tls)

    def clip(self, seed, frames=48):
        path = self.path(f"clip{seed}.bvh")
        write_bvh(path, seed, frames)
        return path

    def fill(self, database="d"):
        first = self.options(self.servers[0])
        self.ask(first, "create", database, "--marker-set", "source", "--min-frames", "4")
        self.ask(first, "ingest", database, *(self.clip(seed) for seed in range(4)), "--label",
                 "moves")
        model, = self.ask(first, "describe", database)
        for server in self.servers:
            wait_for(lambda: self.ask(self.options(server), "describe", database)[0][
                "model_version"] == model["model_version"], FOLLOWED, "all servers have the model")

    def ask(self, options, *arguments):
        result = run(options, "--json", *arguments)
        self.assertEqual(result.returncode, 0, result.stderr)
        return [json.loads(line) for line in result.stdout.splitlines()]

    @unittest.skipUnless(shutil.which("openssl"), "openssl is missing")
    def test_several_addresses(self):
        # With TLS, so that the certificate is compared with each address.
        authority = secure_server.Authority(self.folder, "ca")
        certificate, key = authority.issue("server", "motiondb")
        self.tls = ("--tls-ca", authority.certificate)
        a, b, c = self.serve(3, "--tls-certificate", certificate, "--tls-key", key)
        self.fill()
        query = ["recognize", "d", self.clip(7, 40)]
        answer = self.ask(self.options(), *query)
        a.stop(signal.SIGKILL)
        self.assertEqual(self.ask(self.options(), *query), answer)
        # A change reaches the next server; SIGTERM drains the one that was asked.
        self.ask(self.options(), "create", "e")
        b.stop(signal.SIGTERM)
        self.assertEqual(len(self.ask(self.options(), "list")), 2)
        c.stop(signal.SIGKILL)
        failed = run(self.options(), "list")
        self.assertEqual(failed.returncode, 1)
        for server in self.servers:
            self.assertIn(f"no motiondb server answered at {server.address}", failed.stderr)

    def observe(self, options, clip, kill_after, victim):
        """Observes a clip, kills a server after some answers, and returns the answers and the
        report on standard error."""
        with subprocess.Popen([MOTIONDB, *options, "--json", "observe", "d", clip, "--realtime"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as client:
            answers = []
            for line in client.stdout:
                answers.append(json.loads(line))
                if len(answers) == kill_after:
                    victim().stop(signal.SIGKILL)
            report = client.stderr.read()
        self.assertEqual(client.returncode, 0, report)
        return answers, report

    def check_observed(self, other, clip, frames, answers, report):
        # Each frame has one answer, in order.
        self.assertEqual([int(answer["frame"]) for answer in answers], list(range(frames)))
        found = re.search(r"continued after [\d.]+ s; further answers do not depend on the "
                          r"(\d+) frames before ([\d.]+) s\n$", report)
        self.assertTrue(found, report)
        lost = int(found[1])
        self.assertAlmostEqual(lost / RATE_HZ, float(found[2]), delta=0.006)
        # All frames of the last second were sent again, so `lost` + 60 frames had an answer. The
        # further answers are those of a stream that begins after the lost frames.
        continued = lost + RATE_HZ
        shortened(clip, self.path("rest.bvh"), lost)
        rest = other.ask("observe", "d", self.path("rest.bvh"))
        for answer, expected in zip(answers[continued:], rest[RATE_HZ:], strict=True):
            for field in ("state", "labels", "familiarity"):
                self.assertEqual(answer.get(field), expected.get(field), answer["frame"])
        return continued

    def test_observe_continues_at_another_address(self):
        a, b = self.serve(2)
        self.fill()
        clip = self.clip(8, 180)
        answers, report = self.observe(self.options(), clip, 90, lambda: a)
        continued = self.check_observed(b, clip, 180, answers, report)
        self.assertIn(a.address, report)
        self.assertGreaterEqual(continued, 90)
        # The earlier answers depend on all frames.
        whole = b.ask("observe", "d", clip)
        self.assertEqual([answer["state"] for answer in answers[:continued]],
                         [answer["state"] for answer in whole[:continued]])

    def calls(self):
        """The number of GetDatabase calls that each living server has answered."""
        counts = []
        for server in self.servers:
            if server.process.poll() is not None:
                counts.append(0)
                continue
            with urllib.request.urlopen(server.http + "/metrics") as page:
                found = re.search(r'^motiondb_requests_total{code="OK",'
                                  r'method="DatabaseService.GetDatabase"} (\d+)$',
                                  page.read().decode(), re.MULTILINE)
            counts.append(int(found[1]) if found else 0)
        return counts

    def owner(self, nginx, database):
        """The only server that answers calls about the database through nginx."""
        before = self.calls()
        for _ in range(2):
            self.ask(nginx.options, "describe", database)
        answered = [after - earlier for after, earlier in zip(self.calls(), before)]
        owners = [server for server, count in zip(self.servers, answered) if count > 0]
        self.assertEqual(len(owners), 1, f"{database}: {answered}")
        return owners[0]

    @unittest.skipUnless(shutil.which("nginx", path=nginx_proxy.PATH) and shutil.which("openssl"),
                         "nginx or openssl is missing")
    def test_nginx_sends_a_database_to_one_server(self):
        self.serve(3)
        nginx = nginx_proxy.Nginx(self.folder, [server.address for server in self.servers])
        self.addCleanup(nginx.stop)
        for database in DATABASES:
            self.ask(nginx.options, "create", database)
        self.fill()
        owners = {database: self.owner(nginx, database) for database in DATABASES}
        self.assertGreater(len(set(owners.values())), 1)  # the hash of ports, which are random

        # Calls without a database: any server. An operation is known to all.
        self.ask(nginx.options, "list")
        self.ask(nginx.options, "operations", "list")

        # The owner of `d` is killed during an observation, while others query.
        victim = self.owner(nginx, "d")
        failed, queries, ended = [], [], threading.Event()

        def query():
            while not ended.is_set():
                result = run(nginx.options, "recognize", "d", self.path("clip1.bvh"))
                queries.append(result)
                if result.returncode != 0:
                    failed.append(result.stderr)

        clip = self.clip(8, 150)
        threads = [threading.Thread(target=query) for _ in range(4)]
        for thread in threads:
            thread.start()
        try:
            answers, report = self.observe(nginx.options, clip, 75, lambda: victim)
        finally:
            ended.set()
            for thread in threads:
                thread.join()
        self.assertEqual(failed, [])
        self.assertGreater(len(queries), 4)
        new_owner = self.owner(nginx, "d")
        self.check_observed(new_owner, clip, 150, answers, report)

        # Its databases have moved, and only they.
        for database, owner in owners.items():
            if owner is victim:
                self.assertIsNot(self.owner(nginx, database), victim)
            else:
                self.assertIs(self.owner(nginx, database), owner, database)

    @staticmethod
    def begin_upload(server):
        """Begins a call, for whose end a server that stops waits. Returns its socket."""
        header = b"\x0a\x0bdatabases/d\x12\x05a.bvh"
        connection = socket.create_connection(server.address.split(":"), timeout=60)
        connection.sendall(
            http2.START + http2.frame(http2.SETTINGS, 0, 0, b"") +
            http2.header_frames(0, 1, http2.request_headers("ClipService/IngestClip")) +
            http2.frame(http2.DATA, 0, 1, http2.message(b"\x0a" + bytes([len(header)]) + header)) +
            http2.frame(http2.PING, 0, 0, b"received"))
        received = b""
        while b"received" not in received:
            received += connection.recv(65536)
        return connection

    @unittest.skipUnless(shutil.which("nginx", path=nginx_proxy.PATH) and shutil.which("openssl"),
                         "nginx or openssl is missing")
    def test_a_rolling_restart_behind_nginx_fails_no_call(self):
        self.serve(3)
        self.fill()
        # nginx tries a server again after 1 s instead of 10 s.
        nginx = nginx_proxy.Nginx(self.folder, [server.address + " fail_timeout=1s"
                                                for server in self.servers])
        self.addCleanup(nginx.stop)
        failed, calls, ended = [], [], threading.Event()

        def ask(name, *arguments):
            while not ended.is_set():
                result = run(nginx.options, *[word.format(len(calls)) for word in arguments])
                calls.append(name)
                if result.returncode != 0:
                    failed.append(result.stderr)

        clients = [("recognize", "d", self.path("clip1.bvh"))] * 3 + [("create", "n{}")]
        threads = [threading.Thread(target=ask, args=(client[0], *client)) for client in clients]
        for thread in threads:
            thread.start()
        try:
            for index, old in enumerate(self.servers):
                before = len(calls)
                upload = self.begin_upload(old)
                ending = threading.Timer(2, upload.close)
                ending.start()
                began = time.monotonic()
                self.assertEqual(old.stop(signal.SIGTERM), 0)
                self.assertGreater(time.monotonic() - began, 1)
                ending.join()
                self.servers[index] = Server(self.cluster.url(self._testMethodName), "--log-level",
                                             "off", address=old.address)
                self.addCleanup(self.kill, self.servers[index])
                time.sleep(1.5)
                wait_for(lambda: len(calls) >= before + 8, 30 * SLOWNESS, "calls go on")
        finally:
            ended.set()
            for thread in threads:
                thread.join()
        self.assertEqual(failed, [])
        self.assertGreater(calls.count("create"), 3)


if __name__ == "__main__":
    main()
