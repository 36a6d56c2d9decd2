#!/usr/bin/python3
"""Several motiondbd on one PostgreSQL cluster, which the test starts in a temporary folder.

    several_servers_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import json
import os
import signal
import subprocess
import tempfile
import time
import unittest

from figure import write_bvh
from postgres_cluster import Cluster, main
from programs import MOTIONDB, SLOWNESS, Server

# A change on one server is on all after the next look (1 s), with some time to load the model.
FOLLOWED = 2.5 * SLOWNESS
TAKEN_OVER = 10 * SLOWNESS


def wait_for(condition, seconds, what):
    """Waits until condition() is true, and returns its value."""
    latest = time.monotonic() + seconds
    while not (value := condition()):
        if time.monotonic() > latest:
            raise AssertionError(f"not within {seconds} s: {what}")
        time.sleep(0.05)
    return value


class SeveralServers(unittest.TestCase):
    cluster = None
    databases = 0

    @classmethod
    def setUpClass(cls):
        cls.cluster = Cluster()

    @classmethod
    def tearDownClass(cls):
        cls.cluster.remove()

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        SeveralServers.databases += 1
        self.store = self.cluster.url().replace("/postgres?", f"/servers{self.databases}?")
        self.sql(f"CREATE DATABASE servers{self.databases}", self.cluster.url())
        self.servers = []

    def tearDown(self):
        for server in self.servers:
            if server.process.poll() is None:
                server.process.send_signal(signal.SIGCONT)
                server.stop(signal.SIGKILL)
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def sql(self, query, store=None):
        return subprocess.run(["psql", store or self.store, "-qtAc", query], check=True,
                              capture_output=True, text=True).stdout.strip()

    def serve(self, count, *options):
        for _ in range(count):
            log = open(self.path(f"log{len(self.servers)}"), "w", encoding="utf-8")
            self.servers.append(Server(self.store, "--log-level", "info", *options, log=log))
            log.close()
        return self.servers

    def log(self, server):
        with open(self.path(f"log{self.servers.index(server)}"), encoding="utf-8") as file:
            return file.read()

    def clip(self, seed, frames=48):
        path = self.path(f"clip{seed}.bvh")
        write_bvh(path, seed, frames)
        return path

    def builder(self):
        """The server that has the build lease, or None."""
        holder = self.sql("SELECT holder FROM build_lease WHERE expire_time_us > "
                          "extract(epoch FROM clock_timestamp()) * 1000000")
        found = [server for server in self.servers
                 if holder.split("/")[1:2] == [str(server.process.pid)]]
        return found[0] if found else None

    def models(self):
        return self.sql("SELECT string_agg(version::text, ' ' ORDER BY version) FROM model "
                        "WHERE staged = 0")

    def begin_long_build(self, first):
        """Requests a build of some seconds; returns its operation and the server that runs it."""
        first.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        first.ask("ingest", "d", self.clip(0), "--label", "moves")
        clips = [self.clip(seed, 4000) for seed in range(1, 11)]
        first.ask("ingest", "d", *clips, "--label", "moves", "--no-wait")
        operation = self.operations(first)[0]["name"]
        builder = wait_for(lambda: self.state(first, operation) == "RUNNING" and self.builder(), 30,
                           "a build begins")
        return operation, builder

    def operations(self, server):
        return server.ask("operations", "list")

    def state(self, server, operation):
        found = [one for one in self.operations(server) if one["name"] == operation]
        return self.short(found[0]["state"]) if found else None

    @staticmethod
    def short(state):
        return state.removeprefix("OPERATION_STATE_")

    def await_operation(self, server, operation):
        return self.short(server.ask_one("operations", "wait", operation)["operation"]["state"])

    def test_what_one_server_changes_all_serve(self):
        a, b, c = self.serve(3)
        a.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        b.ask("ingest", "d", *(self.clip(seed) for seed in range(4)), "--label", "moves")
        began = time.monotonic()
        for server in (a, c):
            self.assertEqual(len(server.ask("list", "d")), 4)
            wait_for(lambda: server.run("recognize", "d", self.clip(7, 40)).returncode == 0,
                     FOLLOWED, "a new model answers")
        self.assertLess(time.monotonic() - began, 2 * FOLLOWED)
        version = b.ask_one("describe", "d")["model_version"]
        answer = b.ask("recognize", "d", self.clip(7, 40))
        for server in (a, c):
            wait_for(lambda: server.ask_one("describe", "d")["model_version"] == version, FOLLOWED,
                     "the newest model is served")
            self.assertEqual(server.ask("recognize", "d", self.clip(7, 40)), answer)

        # A query waits for the revision of a change on another server.
        revision = a.ask_one("update", "d", "clip1", "--label", "hops", "--no-wait")["revision"]
        began = time.monotonic()
        c.ask("recognize", "d", self.clip(7, 40), "--min-revision", str(revision))
        self.assertLess(time.monotonic() - began, FOLLOWED)

        # Operations are waited for, listed and shown anywhere.
        b.ask("ingest", "d", self.clip(8), "--label", "moves", "--no-wait")
        operation = self.operations(c)[0]["name"]
        self.assertEqual(self.await_operation(a, operation), "SUCCEEDED")
        self.assertEqual(self.state(c, operation), "SUCCEEDED")
        wait_for(lambda: c.ask_one("describe", "d")["clip_count"] == 5, FOLLOWED,
                 "a further clip is in the model")

        c.ask("delete", "d", "clip2", "--yes")
        self.assertEqual(len(a.ask("list", "d")), 4)
        b.ask("delete", "d", "--yes")
        for server in (a, c):
            wait_for(lambda: "does not exist" in server.run("describe", "d").stderr, FOLLOWED,
                     "a deleted database is gone")
        a.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        for server in (b, c):
            self.assertEqual(server.ask("list", "d"), [])

    def test_a_revoked_token_is_refused_by_all(self):
        secret = "a-token-of-the-administrator"
        with open(os.open(self.path("token"), os.O_CREAT | os.O_WRONLY, 0o600), "w",
                  encoding="ascii") as file:
            file.write(secret + "\n")
        a, b = self.serve(2, "--authentication", "token", "--admin-token-file", self.path("token"))

        def run(server, token, *arguments):
            return subprocess.run([MOTIONDB, "--server", server.address, *arguments], text=True,
                                  capture_output=True, env=os.environ | {"MOTIONDB_TOKEN": token})

        made = json.loads(run(a, secret, "--json", "token", "create", "--role", "reader").stdout)
        self.assertEqual(run(b, made["secret"], "list").returncode, 0)
        run(a, secret, "token", "revoke", made["token"]["name"])
        wait_for(lambda: run(b, made["secret"], "list").returncode != 0, 2 * SLOWNESS,
                 "the token is refused")

    def test_a_killed_builder_is_replaced(self):
        servers = self.serve(2)
        operation, builder = self.begin_long_build(servers[0])
        builder.stop(signal.SIGKILL)
        other = next(server for server in servers if server is not builder)
        wait_for(lambda: self.builder() is other, TAKEN_OVER, "another server builds")
        self.assertEqual(self.await_operation(other, operation), "SUCCEEDED")
        self.assertEqual(other.ask_one("describe", "d")["clip_count"], 11)

    def test_a_stopped_builder_publishes_nothing(self):
        servers = self.serve(2)
        operation, builder = self.begin_long_build(servers[0])
        builder.process.send_signal(signal.SIGSTOP)
        other = next(server for server in servers if server is not builder)
        wait_for(lambda: self.builder() is other, TAKEN_OVER, "another server builds")
        self.assertEqual(self.await_operation(other, operation), "SUCCEEDED")
        models = self.models()
        builder.process.send_signal(signal.SIGCONT)
        wait_for(lambda: "has taken over" in self.log(builder), 20 * SLOWNESS, "it is fenced")
        version = other.ask_one("describe", "d")["model_version"]
        wait_for(lambda: builder.ask_one("describe", "d")["model_version"] == version, FOLLOWED,
                 "it serves the model of the other server")
        self.assertEqual(self.models(), models)
        self.assertEqual(self.state(builder, operation), "SUCCEEDED")

    def test_a_build_is_cancelled_by_another_server(self):
        servers = self.serve(2)
        operation, builder = self.begin_long_build(servers[0])
        models = self.models()
        other = next(server for server in servers if server is not builder)
        cancelled = other.ask_one("operations", "cancel", operation)
        self.assertEqual(self.short(cancelled["operation"]["state"]), "CANCELLED")
        wait_for(lambda: self.builder() is None, 5 * SLOWNESS, "the build stops")
        self.assertEqual(self.models(), models)
        self.assertEqual(self.state(builder, operation), "CANCELLED")

    def test_servers_survive_a_stop_of_postgresql(self):
        servers = self.serve(2)
        a, b = servers
        a.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        a.ask("ingest", "d", *(self.clip(seed) for seed in range(3)), "--label", "moves")
        query = ["recognize", "d", self.clip(7, 40)]
        wait_for(lambda: b.run(*query).returncode == 0, FOLLOWED, "both servers answer")
        answers = [server.ask(*query) for server in servers]
        self.cluster.kill()
        try:
            for _ in range(3):
                self.assertEqual([server.ask(*query) for server in servers], answers)
                refused = b.run("ingest", "d", self.clip(9))
                self.assertNotEqual(refused.returncode, 0)
                self.assertIn("the store postgresql:", refused.stderr)
                time.sleep(1)
        finally:
            self.cluster.start()
        wait_for(lambda: b.run("ingest", "d", self.clip(9)).returncode == 0, 15 * SLOWNESS,
                 "clips are stored again")
        wait_for(lambda: a.ask_one("describe", "d")["clip_count"] == 4, 15 * SLOWNESS,
                 "the clip is in the model of both")


if __name__ == "__main__":
    main()
