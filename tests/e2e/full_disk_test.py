#!/usr/bin/python3
"""A real server on a small disk that others fill: it reports the full disk and recovers by itself.

    full_disk_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import os
import subprocess
import tempfile
import time
import unittest

import programs
from observability_test import get, scrape, value, write_walk
from programs import Server

MIB = 1 << 20


class SimulatedDisk(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.disk = os.path.join(self.folder.name, "disk")
        os.mkdir(self.disk)
        mounted = subprocess.run(["mount", "-t", "tmpfs", "-o", "size=32m", "tmpfs", self.disk],
                                 capture_output=True, text=True)
        if mounted.returncode != 0:
            self.skipTest("a tmpfs cannot be mounted here: " + mounted.stderr.strip())
        self.addCleanup(subprocess.run, ["umount", self.disk], check=True)
        self.server = Server(os.path.join(self.disk, "motion.db"), "--http-listen", "127.0.0.1:0",
                             "--disk-reserve-mib", "8")
        self.addCleanup(self.server.stop)

    def await_readiness(self, status):
        latest = time.monotonic() + 10 * programs.SLOWNESS
        while (answer := get(self.server.http, "/readyz"))[0] != status:
            self.assertLess(time.monotonic(), latest, answer)
            time.sleep(0.05)
        return answer[1]

    def ingest(self, label):
        walk = os.path.join(self.folder.name, label + ".bvh")
        write_walk(walk, 90 + len(label))
        return self.server.run("ingest", "walks", walk, "--label", label)

    def test_not_ready_while_the_disk_is_full(self):
        self.server.ask_one("create", "walks", "--marker-set", "source", "--min-frames", "4")
        self.assertEqual(self.ingest("w").returncode, 0)
        self.assertEqual(get(self.server.http, "/readyz"), (200, "ready\n"))
        other = os.path.join(self.disk, "other")
        with open(other, "wb") as file:
            file.write(bytes(24 * MIB))
        self.assertIn("--disk-reserve-mib", self.await_readiness(503))
        refused = self.ingest("wa")
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("--disk-reserve-mib", refused.stderr)
        _, values = scrape(self.server)
        self.assertGreaterEqual(value(values, "motiondb_store_failed_writes_total",
                                      reason="no_space"), 1)
        self.assertEqual(value(values, "motiondb_store_failed_writes_total", reason="io_error"), 0)
        shown = self.server.run("status").stdout
        self.assertIn("serving, but not ready: queries are answered, but nothing is stored", shown)
        self.assertRegex(shown, r"[0-9]+ failed writes?;")
        walk = os.path.join(self.folder.name, "w.bvh")
        self.assertEqual(self.server.run("recognize", "walks", walk).returncode, 0)
        os.remove(other)
        self.assertEqual(self.await_readiness(200), "ready\n")
        self.assertEqual(self.ingest("wal").returncode, 0)


if __name__ == "__main__":
    programs.main()
