#!/usr/bin/python3
"""A backup of a PostgreSQL cluster and its restore; a standby that takes over from its primary.

    postgres_failover_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import signal
import subprocess
import threading
import time

from postgres_cluster import PASSWORD, Cluster, WithCluster, main
from programs import MOTIONDBD, SLOWNESS


class Copy(Cluster):
    """A cluster made by pg_basebackup from a running one. Starts as a standby of it, or apart."""

    def __init__(self, primary, *settings, standby):
        self.settings = [word for setting in settings for word in ("-c", setting)]
        self.make_folder()
        connection = f"host={primary.folder.name} user=motiondb password={PASSWORD} application_name=copy"
        mode = ["-R"] if standby else []
        assert self.run("pg_basebackup", "-d", connection, "-D", self.data, "-X", "stream", "-c", "fast",
                        "--no-sync", *mode).wait() == 0
        self.start()

    def promote(self):
        assert self.run("pg_ctl", "promote", "-D", self.data).wait() == 0


class Failover(WithCluster):
    def setUp(self):
        super().setUp()
        self.copies = []

    def tearDown(self):
        for copy in self.copies:
            copy.remove()
        super().tearDown()

    def copy(self, **options):
        self.copies.append(Copy(self.cluster, **options))
        return self.copies[-1]

    def test_a_base_backup_is_restored(self):
        server = self.serve()
        self.fill(server)
        first = self.answers(server)
        restored = self.copy(standby=False)
        # Not in the backup.
        server.ask("ingest", "d", self.clip(50), "--label", "later")
        second = self.serve(store=restored.url())
        self.assertEqual(self.answers(second), first)
        verified = second.run("verify")
        self.assertEqual(verified.returncode, 0, verified.stdout + verified.stderr)
        second.ask("ingest", "d", self.clip(51))

    def test_acknowledged_clips_survive_the_primary(self):
        standby = self.copy(standby=True)
        self.cluster.sql("ALTER SYSTEM SET synchronous_standby_names = 'copy'")
        self.cluster.sql("SELECT pg_reload_conf()")
        folders = f"{self.cluster.folder.name},{standby.folder.name}"
        server = self.serve(store=f"postgresql://motiondb:{PASSWORD}@/postgres?host={folders}")
        self.fill(server)
        acknowledged, ended = [], threading.Event()

        def ingest():
            for seed in range(10, 10_000):
                if ended.is_set():
                    return
                if server.run("ingest", "d", self.clip(seed)).returncode == 0:
                    acknowledged.append(f"databases/d/clips/clip{seed}")

        client = threading.Thread(target=ingest)
        client.start()
        self.wait_for(lambda: len(acknowledged) >= 5)
        self.cluster.process.send_signal(signal.SIGKILL)
        self.cluster.process.wait()
        before = len(acknowledged)
        standby.promote()
        self.wait_for(lambda: len(acknowledged) >= before + 5)
        ended.set()
        client.join()
        stored = {clip["name"] for clip in server.ask("list", "d")}
        self.assertEqual(set(acknowledged) - stored, set())
        self.assertEqual(server.run("verify").returncode, 0)

    def test_a_start_waits_for_the_promotion_of_a_standby(self):
        self.fill(self.serve())
        standby = self.copy(standby=True)
        self.cluster.kill()
        # The second gets a session, in which it cannot begin a change.
        waiting = [subprocess.Popen([MOTIONDBD, "--store", standby.url() + attributes, "--listen",
                                     "127.0.0.1:0", "--http-listen", "none"], text=True,
                                    stdout=subprocess.PIPE, stderr=self.log)
                   for attributes in ("", "&target_session_attrs=any")]
        for server in waiting:
            self.addCleanup(server.communicate)
            self.addCleanup(server.kill)

        def log():
            with open(self.log.name, encoding="utf-8") as file:
                return file.read()

        self.wait_for(lambda: log().count("retrying until it can be reached") == 2)
        standby.promote()
        for server in waiting:
            self.assertIn("listening", server.stdout.readline())
        self.assertEqual(log().count("the store can be reached"), 2)

    def wait_for(self, condition):
        latest = time.monotonic() + 60 * SLOWNESS
        while not condition():
            self.assertLess(time.monotonic(), latest)
            time.sleep(0.05)


if __name__ == "__main__":
    main()
