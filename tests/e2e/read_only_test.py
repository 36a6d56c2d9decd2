#!/usr/bin/python3
"""motiondbd --read-only answers queries and refuses changes, also on a read-only file system.

    read_only_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import os
import shutil
import signal
import subprocess

from figure import write_bvh
from programs import Server, WithServer, main

WHY = "restart motiondbd without --read-only"


class ReadOnly(WithServer):
    def setUp(self):
        super().setUp()
        self.server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        for number in range(3):
            write_bvh(self.path(f"clip{number}.bvh"), number)
        self.server.ask("ingest", "d", *(self.path(f"clip{number}.bvh") for number in range(3)))
        write_bvh(self.path("seen.bvh"), seed=2, frames=40)
        write_bvh(self.path("new.bvh"), seed=9)

    def answers(self):
        return [self.server.ask("list"), self.server.ask("list", "d"),
                self.server.ask_one("recognize", "d", self.path("seen.bvh"))]

    def require_read_only(self, before):
        self.assertEqual(self.answers(), before)
        for command in (["create", "e"], ["ingest", "d", self.path("new.bvh")],
                        ["delete", "--yes", "d"], ["delete", "--yes", "d", "clip0"]):
            refused = self.server.run(*command)
            self.assertNotEqual(refused.returncode, 0, command)
            self.assertIn(WHY, refused.stderr)
        self.assertEqual(self.server.run("verify").returncode, 0)
        self.assertEqual(self.answers(), before)
        self.assertEqual(self.server.stop(), 0)

    def test_queries_are_answered_and_changes_refused(self):
        before = self.answers()
        for kill in (signal.SIGKILL, signal.SIGTERM):
            self.server.stop(kill)
            size = os.path.getsize(self.store)
            self.server = Server(self.store, "--read-only")
            self.require_read_only(before)
            self.assertEqual(os.path.getsize(self.store), size)
            self.server = Server(self.store)
            self.assertEqual(self.answers(), before)

    def test_on_a_read_only_file_system(self):
        before = self.answers()
        self.server.stop(signal.SIGKILL)
        disk = self.path("disk")
        os.mkdir(disk)
        if subprocess.run(["mount", "-t", "tmpfs", "none", disk], capture_output=True).returncode != 0:
            self.skipTest("a tmpfs cannot be mounted here")
        try:
            for suffix in ("", "-wal"):
                shutil.copy(self.store + suffix, os.path.join(disk, "motion.db" + suffix))
            # Without its WAL, as after an orderly stop.
            Server(self.store).stop()
            shutil.copy(self.store, os.path.join(disk, "alone.db"))
            subprocess.run(["mount", "-o", "remount,ro", disk], check=True)
            for name in ("motion.db", "alone.db"):
                self.server = Server(os.path.join(disk, name), "--read-only")
                self.require_read_only(before)
        finally:
            if self.server.process.poll() is None:
                self.server.stop()
            subprocess.run(["umount", disk], check=True)


main()
