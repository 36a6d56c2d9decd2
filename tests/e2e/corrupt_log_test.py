#!/usr/bin/python3
"""A flipped bit in the WAL of a killed server is logged at the next start and reported by status
and verify.

    corrupt_log_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import json
import os
import re
import signal

from figure import write_bvh
from programs import Server, WithServer, main

CLIPS = 12
FRAME_BYTES = 24 + 16384


class CorruptLog(WithServer):
    def ingest_and_kill(self):
        self.server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        paths = [self.path(f"c{number}.bvh") for number in range(CLIPS)]
        for number, path in enumerate(paths):
            write_bvh(path, number)
        self.server.ask("ingest", "d", *paths)
        self.server.stop(signal.SIGKILL)

    def start(self):
        self.log = open(self.path("log"), "w+")
        self.addCleanup(self.log.close)
        self.server = Server(self.store, log=self.log)

    def logged(self):
        self.log.seek(0)
        return self.log.read()

    def test_a_flipped_bit_is_reported(self):
        self.ingest_and_kill()
        log_path = self.store + "-wal"
        frames = (os.path.getsize(log_path) - 32) // FRAME_BYTES
        self.assertGreater(frames, 20)
        bad = frames // 2
        with open(log_path, "r+b") as file:
            file.seek(32 + (bad - 1) * FRAME_BYTES + 8000)
            byte = file.read(1)[0]
            file.seek(-1, os.SEEK_CUR)
            file.write(bytes([byte ^ 16]))
        expected = f"is corrupt at its frame {bad}: SQLite drops {frames - bad} valid frames after it"
        self.start()
        self.assertIn(expected, self.logged())
        [status] = self.server.ask("status")
        self.assertIn(expected, json.dumps(status))
        verified = self.server.run("verify")
        self.assertEqual(verified.returncode, 1)
        self.assertIn(expected, verified.stdout)
        # Still reported after another start, until the saved copy of the log is deleted.
        self.server.stop()
        self.start()
        verified = self.server.run("verify")
        self.assertEqual(verified.returncode, 1)
        copy = re.search(r"delete '([^']*)'", verified.stdout).group(1)
        os.remove(copy)
        self.server.stop()
        self.start()
        self.assertEqual(self.server.run("verify").returncode, 0)
        self.assertEqual(self.logged(), "")

    def test_a_kill_alone_is_not_reported(self):
        self.ingest_and_kill()
        self.start()
        self.assertEqual(len(self.server.ask("list", "d")), CLIPS)
        self.assertEqual(self.server.run("verify").returncode, 0)
        self.assertEqual(self.logged(), "")

    def test_changes_fail_if_the_wal_is_missing(self):
        self.server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        write_bvh(self.path("before.bvh"), 1)
        self.server.ask("ingest", "d", self.path("before.bvh"))
        os.remove(self.store + "-wal")
        for number in range(5):
            path = self.path(f"after{number}.bvh")
            write_bvh(path, 10 + number)
            refused = self.server.run("ingest", "d", path)
            self.assertNotEqual(refused.returncode, 0)
            self.assertIn(f"the store's log '{self.store}-wal' is gone", refused.stderr)
        self.server.stop(signal.SIGKILL)
        self.start()
        self.assertEqual([clip["name"] for clip in self.server.ask("list", "d")],
                         ["databases/d/clips/before"])
        self.assertEqual(self.server.run("verify").returncode, 0)


main()
