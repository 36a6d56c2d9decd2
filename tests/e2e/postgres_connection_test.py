#!/usr/bin/python3
"""How motiondbd connects to PostgreSQL, and a full disk of PostgreSQL.

    postgres_connection_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import contextlib
import os
import socket
import subprocess
import tempfile
import time

from observability_test import get
from postgres_cluster import PASSWORD, WithCluster, main
from programs import MOTIONDBD, SLOWNESS
from secure_server import Authority


class Connections(WithCluster):
    """TLS, password files and service files, as libpq has them. tearDown checks the log."""

    def setUp(self):
        super().setUp()
        self.passwords = self.path("passwords")
        self.write("passwords", f"*:*:*:motiondb:{PASSWORD}\n")
        self.authority = Authority(self.folder.name, "authority")
        certificate, key = self.authority.issue("postgres", "localhost")
        for path in (certificate, key):
            os.rename(path, os.path.join(self.cluster.folder.name, os.path.basename(path)))
            path = os.path.join(self.cluster.folder.name, os.path.basename(path))
            self.cluster.give(path)
            os.chmod(path, 0o600)
        with socket.socket() as free:
            free.bind(("127.0.0.1", 0))
            self.port = free.getsockname()[1]
        files = os.path.join(self.cluster.folder.name, "postgres")
        self.cluster.kill()
        self.cluster.settings = ["-c", "listen_addresses=127.0.0.1", "-c", f"port={self.port}",
                                 "-c", "ssl=on", "-c", f"ssl_cert_file={files}.crt",
                                 "-c", f"ssl_key_file={files}.key"]
        with open(os.path.join(self.cluster.data, "pg_hba.conf"), "w", encoding="ascii") as rules:
            rules.write("hostssl all all 127.0.0.1/32 scram-sha-256\n"
                        "local all all scram-sha-256\n")
        self.cluster.start(self.port)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(self.path(name), 0o600)

    def start(self, store, **variables):
        """Returns whether the store can be used, and the error."""
        environment = {key: value for key, value in os.environ.items() if not key.startswith("PG")}
        # A migration connects, refuses the target, and ends.
        ran = subprocess.run([MOTIONDBD, "migrate", store, self.path("text")], capture_output=True,
                             text=True, env={**environment, "HOME": self.folder.name, **variables})
        self.assertEqual(ran.returncode, 1)
        self.assertNotIn(PASSWORD, ran.stdout + ran.stderr)
        return "of version 0" in ran.stderr, ran.stderr

    def test_tls(self):
        base = f"postgresql://motiondb@localhost:{self.port}/postgres?passfile={self.passwords}"
        trusted = f"&sslmode=verify-full&sslrootcert={self.authority.certificate}"
        self.assertEqual(self.start(base + trusted)[0], True)
        self.assertEqual(self.start(base + trusted + "&hostaddr=127.0.0.1")[0], True)
        stranger = Authority(self.folder.name, "stranger")
        usable, error = self.start(base + f"&sslmode=verify-full&sslrootcert={stranger.certificate}")
        self.assertFalse(usable)
        self.assertIn("certificate verify failed", error)
        usable, error = self.start(base + "&sslmode=disable")
        self.assertFalse(usable)
        self.assertIn("no encryption", error)
        server = self.serve(store=base + trusted)
        self.fill(server)
        self.assertEqual(len(server.ask("list", "d")), 4)

    def test_passwords_and_services(self):
        place = f"localhost:{self.port}/postgres"
        url = f"postgresql://motiondb@{place}"
        self.assertTrue(self.start(url, PGPASSFILE=self.passwords)[0])
        self.assertTrue(self.start(url, PGPASSWORD=PASSWORD)[0])
        self.assertTrue(self.start(url + f"?passfile={self.passwords}")[0])
        self.write(".pgpass", f"localhost:*:*:motiondb:{PASSWORD}\n")
        self.assertTrue(self.start(url)[0])
        os.remove(self.path(".pgpass"))
        usable, error = self.start(url)
        self.assertFalse(usable)
        self.assertIn("no password supplied", error)
        # A password that is wrong is not shown either.
        usable, error = self.start(f"postgresql://motiondb:{PASSWORD}x@{place}")
        self.assertFalse(usable)
        self.assertIn("password authentication failed", error)
        self.write("services", f"[store]\nhost=localhost\nport={self.port}\nuser=motiondb\n"
                               f"dbname=postgres\npassfile={self.passwords}\n")
        self.assertTrue(self.start("postgresql:///?service=store",
                                   PGSERVICEFILE=self.path("services"))[0])


class FullDisk(WithCluster):
    """The disk of PostgreSQL is full: changes are refused, and succeed again when there is space."""

    def test_changes_are_refused_until_there_is_space(self):
        place = tempfile.TemporaryDirectory()
        self.addCleanup(place.cleanup)
        os.chmod(place.name, 0o755)
        disk = os.path.join(place.name, "disk")
        os.mkdir(disk)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=48m", "tmpfs", disk],
                                 capture_output=True, text=True)
        if mounted.returncode != 0:
            self.skipTest("a tmpfs cannot be mounted here: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", disk], check=True)  # the cluster has ended
        self.cluster.give(disk)
        self.cluster.sql(f"CREATE TABLESPACE small LOCATION '{disk}'")
        self.cluster.sql("CREATE DATABASE small TEMPLATE template0 ENCODING 'UTF8' TABLESPACE small")
        server = self.serve("--http-listen", "127.0.0.1:0", store=self.cluster.url("small"))
        self.fill(server)
        before = server.ask_one("recognize", "d", self.clip(7, 40))
        other = os.path.join(disk, "other")
        # Other processes take and free space meanwhile.
        with open(other, "wb", buffering=0) as file, contextlib.suppress(OSError):
            while True:
                file.write(bytes(4096))
        refused = None
        for seed in range(10, 60):  # there is some room in the files of the tables
            refused = server.run("ingest", "d", self.clip(seed, 2000))
            if refused.returncode != 0:
                break
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("could not extend file", refused.stderr)
        self.assertIn("SQLSTATE 53100", refused.stderr)
        self.assertEqual(server.ask_one("recognize", "d", self.clip(7, 40)), before)
        self.assertEqual(self.ready(server, 503), 503)
        os.remove(other)
        self.assertEqual(self.ready(server, 200), 200)
        added = server.run("ingest", "d", self.clip(99, 2000))
        self.assertEqual(added.returncode, 0, added.stderr)

    def ready(self, server, wanted):
        """Returns the status of /readyz, at the latest after 10 s."""
        latest = time.monotonic() + 10 * SLOWNESS
        while (status := get(server.http, "/readyz")[0]) != wanted and time.monotonic() < latest:
            time.sleep(0.1)
        return status


if __name__ == "__main__":
    main()
