"""A real PostgreSQL cluster in a temporary folder, and servers on it."""

import contextlib
import glob
import os
import pwd
import signal
import subprocess
import sys
import tempfile
import time
import unittest

import programs
from figure import write_bvh
from programs import SLOWNESS, Server

PASSWORD = "not-a-secret-of-anybody"
POOLER = "/usr/sbin/pgbouncer"
POOLER_PORT = 6432
# A change on one server is on all after the next look (1 s), with some time to load the model.
FOLLOWED = 2.5 * SLOWNESS


def postgres_folder():
    """The folder of initdb and postgres; Debian does not put them on the path. None if missing."""
    found = sorted(glob.glob("/usr/lib/postgresql/*/bin/initdb"))
    return os.path.dirname(found[-1]) if found else None


class Cluster:
    """PostgreSQL on a Unix socket. As root it runs as the user `postgres`: it refuses root."""

    def __init__(self, *settings):
        self.settings = [word for setting in settings for word in ("-c", setting)]
        self.make_folder()
        with open(os.path.join(self.folder.name, "password"), "w", encoding="ascii") as file:
            file.write(PASSWORD)
        os.chmod(file.name, 0o644)
        self.run("initdb", "-A", "scram-sha-256", "--pwfile", file.name, "-E", "UTF8", "--locale=C",
                 "--no-sync", "-U", "motiondb", "-D", self.data).wait()
        self.process = None
        self.start()

    def make_folder(self):
        self.folder = tempfile.TemporaryDirectory()
        self.give(self.folder.name)
        self.data = os.path.join(self.folder.name, "data")

    @staticmethod
    def give(path):
        """Makes the cluster's user the owner of a file or folder."""
        if os.geteuid() == 0:
            os.chown(path, pwd.getpwnam("postgres").pw_uid, -1)

    def sql(self, script, database="postgres"):
        ran = subprocess.run([os.path.join(postgres_folder(), "psql"), "-X", "-d", self.url(database), "-c", script],
                             capture_output=True, text=True)
        assert ran.returncode == 0, ran.stderr

    def run(self, program, *arguments):
        return subprocess.Popen([os.path.join(postgres_folder(), program), *arguments],
                                user="postgres" if os.geteuid() == 0 else None,
                                cwd=self.folder.name, stdout=subprocess.DEVNULL,
                                stderr=subprocess.DEVNULL)

    def start(self, port=5432):
        self.process = None
        for _ in range(600):
            # After a SIGKILL it refuses to start until the processes of its predecessor have ended.
            if self.process is None or self.process.poll() is not None:
                self.process = self.run("postgres", "-D", self.data, "-k", self.folder.name,
                                        "-c", "listen_addresses=", "-c", "fsync=off", *self.settings)
            if subprocess.run([os.path.join(postgres_folder(), "pg_isready"), "-h", self.folder.name,
                               "-p", str(port)],
                              stdout=subprocess.DEVNULL).returncode == 0:
                return
            time.sleep(0.1)
        raise AssertionError("PostgreSQL does not start")

    def kill(self, with_signal=signal.SIGQUIT):
        self.process.send_signal(with_signal)
        self.process.wait()

    def signal_all(self, signal_number):
        """Sends SIGSTOP, for a PostgreSQL that does not respond, or SIGCONT to all its processes."""
        process = self.process.pid
        self.process.send_signal(signal_number)
        with open(f"/proc/{process}/task/{process}/children", encoding="ascii") as children:
            for child in children.read().split():
                with contextlib.suppress(ProcessLookupError):  # it has just ended
                    os.kill(int(child), signal_number)

    def url(self, database="postgres"):
        return f"postgresql://motiondb:{PASSWORD}@/{database}?host={self.folder.name}"

    def pool(self):
        """Starts pgbouncer in transaction mode. Returns its process; None if it is missing."""
        if not os.path.exists(POOLER):
            return None
        settings = os.path.join(self.folder.name, "pgbouncer.ini")
        with open(settings, "w", encoding="ascii") as file:
            file.write(f"[databases]\n* = user=motiondb password={PASSWORD} "
                       f"host={self.folder.name}\n[pgbouncer]\npool_mode = transaction\n"
                       f"auth_type = any\nlisten_port = {POOLER_PORT}\n"
                       f"unix_socket_dir = {self.folder.name}\n")
        os.chmod(settings, 0o644)
        pooler = subprocess.Popen([POOLER, settings], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.DEVNULL,
                                  user="postgres" if os.geteuid() == 0 else None)
        socket = os.path.join(self.folder.name, f".s.PGSQL.{POOLER_PORT}")
        programs.wait_for(lambda: os.path.exists(socket), 60, "pgbouncer listens")
        return pooler

    def pooled_url(self, database):
        return f"{self.url(database)}&port={POOLER_PORT}&pooled=1"

    def remove(self):
        self.kill()
        self.folder.cleanup()


class WithCluster(unittest.TestCase):
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
        # The scores of a search depend on the engine.
        found = sorted(match["clip"]["name"] for match in server.ask("search", "d", "moves"))
        return [described, server.ask("list", "d"), found,
                server.ask_one("recognize", "d", self.clip(7, 40)), server.ask("history", "d")]


def main():
    """Runs the tests of a program, if PostgreSQL is installed."""
    if postgres_folder() is None:
        print("skipped: PostgreSQL is not installed (deploy/install_packages.sh test)")
        sys.exit(1 if "MOTIONDB_REQUIRE_POSTGRES" in os.environ else 0)
    programs.main()
