#!/usr/bin/python3
"""motiondbd on a real PostgreSQL cluster, which the test starts in a temporary folder.

    postgres_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import glob
import os
import pwd
import signal
import subprocess
import sys
import tempfile
import time
import unittest

from figure import write_bvh
from programs import MOTIONDBD, Server, main

PASSWORD = "not-a-secret-of-anybody"


def programs():
    """The folder of initdb and postgres; Debian does not put them on the path. None if missing."""
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"))
    return os.path.dirname(found[-1]) if found else None


class Cluster:
    """PostgreSQL on a Unix socket. As root it runs as the user `postgres`: it refuses root."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        if os.geteuid() == 0:
            os.chown(self.folder.name, pwd.getpwnam("postgres").pw_uid, -1)
        self.data = os.path.join(self.folder.name, "data")
        with open(os.path.join(self.folder.name, "password"), "w", encoding="ascii") as file:
            file.write(PASSWORD)
        os.chmod(file.name, 0o644)
        self.run("initdb", "-A", "scram-sha-256", "--pwfile", file.name, "-E", "UTF8", "--locale=C",
                 "--no-sync", "-U", "motiondb", "-D", self.data).wait()
        self.process = None
        self.start()

    def run(self, program, *arguments):
        return subprocess.Popen([os.path.join(programs(), program), *arguments],
                                user="postgres" if os.geteuid() == 0 else None,
                                cwd=self.folder.name, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)

    def start(self):
        self.process = self.run("postgres", "-D", self.data, "-k", self.folder.name,
                                "-c", "listen_addresses=", "-c", "fsync=off")
        for _ in range(600):
            if subprocess.run([os.path.join(programs(), "pg_isready"), "-h", self.folder.name],
                              stdout=subprocess.DEVNULL).returncode == 0:
                return
            time.sleep(0.1)
        raise AssertionError("PostgreSQL does not start")

    def kill(self):
        self.process.send_signal(signal.SIGQUIT)
        self.process.wait()

    def url(self):
        return f"postgresql://motiondb:{PASSWORD}@/postgres?host={self.folder.name}"

    def remove(self):
        self.kill()
        self.folder.cleanup()


class Postgres(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.cluster = Cluster()
        self.servers = []
        self.log = open(self.path("log"), "w+", encoding="utf-8")

    def tearDown(self):
        for server in self.servers:
            if server.process.poll() is None:
                server.stop(signal.SIGKILL)
        self.cluster.remove()
        self.log.seek(0)
        log = self.log.read()
        self.log.close()
        self.folder.cleanup()
        self.assertNotIn(PASSWORD, log)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def serve(self, *options, store=None):
        self.servers.append(Server(store or self.cluster.url(), "--log-level", "info", *options,
                                   log=self.log))
        return self.servers[-1]

    def clip(self, seed, frames=48):
        path = self.path(f"clip{seed}.bvh")
        write_bvh(path, seed, frames)
        return path

    def fill(self, server):
        server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        server.ask("ingest", "d", *(self.clip(seed) for seed in range(4)), "--label", "moves")

    def answers(self, server):
        described = server.ask_one("describe", "d")
        described.pop("build_seconds")
        return [described, server.ask("list", "d"), server.ask("search", "d", "clip*"),
                server.ask_one("recognize", "d", self.clip(7, 40)), server.ask("history", "d")]

    def test_answers_are_those_of_a_file_and_survive_a_restart(self):
        server = self.serve()
        self.fill(server)
        server.ask("update", "d", "clip1", "--title", "A slow walk")
        first = self.answers(server)
        self.assertEqual(len(first[1]), 4)
        self.assertEqual(server.ask_one("search", "d", "slow walk")["clip"]["name"],
                         "databases/d/clips/clip1")
        self.assertEqual(server.stop(), 0)
        self.assertEqual(self.answers(self.serve()), first)

        file = Server(self.path("motion.db"))
        self.servers.append(file)
        self.fill(file)
        file.ask("update", "d", "clip1", "--title", "A slow walk")
        recognized = file.ask_one("recognize", "d", self.clip(7, 40))
        self.assertEqual(recognized, first[3])

    def test_a_pooler_is_supported(self):
        server = self.serve(store=self.cluster.url() + "&pooled=1")
        self.fill(server)
        self.assertEqual(len(server.ask("list", "d")), 4)

    def test_without_postgresql_queries_are_answered_and_changes_can_be_repeated(self):
        server = self.serve()
        self.fill(server)
        query = ["recognize", "d", self.clip(7, 40)]
        before = server.ask_one(*query)
        self.cluster.kill()
        self.assertEqual(server.ask_one(*query), before)
        refused = server.run("ingest", "d", self.clip(9))
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("the store postgresql:", refused.stderr)
        self.assertNotIn(PASSWORD, refused.stderr)
        self.cluster.start()
        for _ in range(100):
            if server.run("ingest", "d", self.clip(9)).returncode == 0:
                break
            time.sleep(0.1)
        self.assertEqual(len(server.ask("list", "d")), 5)

    def test_a_start_without_postgresql_fails_and_no_password_is_shown(self):
        self.cluster.kill()
        started = subprocess.run([MOTIONDBD, "--store", self.cluster.url(), "--listen",
                                  "127.0.0.1:0"], capture_output=True, text=True)
        self.assertEqual(started.returncode, 1)
        self.assertIn("the store postgresql:", started.stderr)
        checked = subprocess.run([MOTIONDBD, "--check-config", "--store", self.cluster.url()],
                                 capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("postgresql://motiondb:***@/postgres", checked.stdout)
        self.assertNotIn(PASSWORD, started.stdout + started.stderr + checked.stdout + checked.stderr)
        self.cluster.start()

    def test_what_is_not_there_yet_says_so(self):
        server = self.serve()
        refused = server.run("backup", self.path("copy.mdb"))
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("pg_dump or pg_basebackup", refused.stderr)


if __name__ == "__main__":
    if programs() is None:
        print("skipped: PostgreSQL is not installed (deploy/install_packages.sh test)")
        sys.exit(1 if "MOTIONDB_REQUIRE_POSTGRES" in os.environ else 0)
    main()
