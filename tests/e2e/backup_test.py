#!/usr/bin/python3
"""Tests backup, restore, verify, and export and import of databases with the real programs.

    backup_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import contextlib
import glob
import json
import os
import signal
import sqlite3
import subprocess
import threading
import time

from figure import write_bvh
from programs import MOTIONDB, MOTIONDBD, Server, WithServer, main


class Backup(WithServer):
    def setUp(self):
        super().setUp()
        self.server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        self.ingest(self.server, *range(6))
        write_bvh(self.path("seen.bvh"), seed=2, frames=40)

    def ingest(self, server, *seeds):
        paths = []
        for seed in seeds:
            paths.append(self.path(f"clip{seed}.bvh"))
            write_bvh(paths[-1], seed)
        server.ask("ingest", "d", *paths, "--label", "moves")

    def answers(self, server, name="d"):
        """Returns answers of a server without durations, and with "d" as name of the database."""
        described = server.ask_one("describe", name)
        described.pop("build_seconds")
        plan = server.ask_one("plan", name, "--start", "clip0@0.1", "--goal", "0.8,0,0", "--seed", "3")
        self.assertEqual(plan["outcome"], "EXACT")  # not cut short by the time limit
        del plan["effort"]["search_seconds"], plan["effort"]["total_seconds"]
        answers = [described, server.ask("list", name), plan,
                   server.ask_one("recognize", name, self.path("seen.bvh")),
                   server.ask_one("estimate", name, self.path("seen.bvh")),
                   server.ask_one("predict", name, self.path("seen.bvh"), "--at", "0.5"),
                   server.ask("segments", "list", name), server.ask("history", name),
                   sorted(match["clip"]["name"] for match in server.ask("search", name, "clip*"))]
        return json.loads(json.dumps(answers).replace(f"databases/{name}", "databases/d"))

    def test_force_does_not_replace_the_store_itself(self):
        size = os.path.getsize(self.store)
        refused = self.server.run("backup", "--force", self.store)
        self.assertEqual(refused.returncode, 1)
        self.assertIn(self.store + ": is or was a server's store", refused.stderr)
        self.server.stop()
        os.remove(self.store + "-lock")
        os.rename(self.store, self.path("moved.db"))
        other = Server(self.path("other.db"))
        try:
            refused = other.run("backup", "--force", self.path("moved.db"))
            self.assertEqual(refused.returncode, 1)
            self.assertIn("moved.db: is a motiondb store", refused.stderr)
            self.assertGreaterEqual(os.path.getsize(self.path("moved.db")), size)
            backup = self.path("copy.mdb")
            for _ in range(2):
                other.ask("backup", "--force", backup)  # a backup may be overwritten
            self.assertEqual(glob.glob(self.path("*.part*")), [])
        finally:
            other.stop()

    def test_a_restored_server_gives_the_same_answers(self):
        backup = self.path("copy.mdb")
        saved = self.server.ask_one("backup", backup)
        self.assertEqual(saved["total_bytes"], os.path.getsize(backup))
        self.assertEqual(glob.glob(backup + ".part*"), [])
        other = Server(self.path("other.db"))
        try:
            self.assertEqual(other.ask_one("restore", backup),
                             {"database_count": 1, "clip_count": 6})
            self.assertEqual(self.answers(other), self.answers(self.server))
            verified = other.run("verify")
            self.assertEqual(verified.returncode, 0)
            self.assertIn("verified 1 database, 6 clips, 1 model, 1 skeleton, ", verified.stdout)
            # The stored model is read, not rebuilt: its version is unchanged. The next version is a
            # build, or an extension followed by a build if builds are slow.
            version = other.ask_one("describe", "d")["model_version"]
            self.ingest(other, 50)
            self.assertIn(other.ask_one("describe", "d")["model_version"], (version + 1, version + 2))
            again = other.run("restore", backup)
            self.assertNotEqual(again.returncode, 0)
            self.assertIn("empty store", again.stderr)
        finally:
            other.stop()

    def test_an_imported_database_gives_the_same_answers(self):
        self.server.ask("update", "d", "clip1", "--title", "A walk", "--label", "walks")
        self.server.ask("segments", "add", "d", "clip2", "--from", "0", "--to", "0.5", "--label",
                        "jumps", "--track", "feet")
        for operation in self.server.ask("operations", "list", "d"):
            self.server.run("operations", "wait", operation["name"].split("/")[-1])
        file = self.path("d.motiondb")
        saved = self.server.ask_one("export-database", "d", file)
        self.assertEqual(saved["total_bytes"], os.path.getsize(file))
        self.assertIn("already exists", self.server.run("export-database", "d", file).stderr)
        self.server.ask_one("export-database", "d", file, "--force")
        expected = self.answers(self.server)
        self.assertEqual(self.server.ask_one("import-database", file, "--as", "copy"),
                         {"name": "databases/copy", "clip_count": 6})
        self.assertEqual(self.answers(self.server, "copy"), expected)
        refused = self.server.run("import-database", file)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("database 'd' already exists", refused.stderr)
        other = Server(self.path("other.db"))
        try:
            other.ask_one("create", "before")
            self.assertIn("imported d, 6 clips", other.run("import-database", file).stdout)
            self.assertEqual(self.answers(other), expected)
            self.assertEqual(other.run("verify").returncode, 0)
            other.stop()
            other = Server(self.path("other.db"))
            self.assertEqual(self.answers(other), expected)
            # Its history goes on.
            last = other.ask("history", "d")[0]["name"].split("/")[-1]
            other.ask("undo", "d", last)
            self.ingest(other, 50)
            self.assertEqual(len(other.ask("list", "d")), 7)
            self.assertEqual(len(self.server.ask("list", "d")), 6)
        finally:
            other.stop()
        third = Server(self.path("third.db"))
        try:
            self.assertEqual(third.ask_one("restore", file), {"database_count": 1, "clip_count": 6})
            self.assertEqual(self.answers(third), expected)
        finally:
            third.stop()

    def test_a_wrong_file_is_not_imported(self):
        file = self.path("d.motiondb")
        self.server.ask_one("export-database", "d", file)
        with open(file, "rb") as exported:
            good = exported.read()
        self.server.ask_one("create", "second")
        self.server.ask_one("backup", self.path("two.mdb"))
        with open(self.path("two.mdb"), "rb") as two:
            backup_of_two = two.read()
        log = open(self.path("log"), "w+")
        other = Server(self.path("other.db"), log=log)
        try:
            other.ask_one("create", "before")
            for wrong, expected in ((good[:-100], "cut off"), (b"not at all", "not a backup"),
                                    (b"", "the exported database is empty"),
                                    (good[:5000] + b"\0\1\2\3" + good[5004:], "checksum"),
                                    (backup_of_two, "the file has 2 databases")):
                with open(self.path("wrong.mdb"), "wb") as wrong_file:
                    wrong_file.write(wrong)
                refused = other.run("import-database", self.path("wrong.mdb"), "--as", "new")
                self.assertEqual(refused.returncode, 1)
                self.assertIn(expected, refused.stderr)
                self.assertEqual(len(other.ask("list")), 1)
            self.assertIn("restore", other.run("import-database", self.path("two.mdb")).stderr)
            log.seek(0)
            self.assertEqual(log.read(), "")
        finally:
            other.stop()
            log.close()
        refused = self.server.run("export-database", "d", self.store, "--force")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("is or was a server's store", refused.stderr)
        missing = self.server.run("export-database", "none", self.path("none.mdb"))
        self.assertIn("database 'none' does not exist", missing.stderr)
        self.assertFalse(os.path.exists(self.path("none.mdb")))

    def test_a_killed_import_leaves_nothing_visible(self):
        file = self.path("d.motiondb")
        self.server.ask_one("export-database", "d", file)
        other = Server(self.path("other.db"))
        try:
            for delay in (0.001, 0.01, 0.03, 0.1):
                importer = subprocess.Popen(
                    [MOTIONDB, "--server", other.address, "import-database", file],
                    stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                time.sleep(delay)
                other.stop(signal.SIGKILL)
                importer.wait()
                other = Server(self.path("other.db"))
                for _ in other.ask("list"):  # it was stored before the kill
                    self.assertEqual(self.answers(other), self.answers(self.server))
                    other.ask("delete", "--yes", "d")
            other.ask_one("import-database", file)
            self.assertEqual(self.answers(other), self.answers(self.server))
            self.assertEqual(other.run("verify").returncode, 0)
        finally:
            other.stop()

    def test_backups_during_ingest(self):
        stop = threading.Event()
        failures = []

        def add_load():
            seed = 100
            while not stop.is_set():
                try:
                    self.ingest(self.server, seed)
                    self.server.ask_one("recognize", "d", self.path("seen.bvh"))
                except AssertionError as error:
                    failures.append(error)
                seed += 1

        thread = threading.Thread(target=add_load)
        thread.start()
        for number in range(3):
            self.server.ask_one("backup", self.path(f"copy{number}.mdb"))
        stop.set()
        thread.join()
        self.assertEqual(failures, [])
        other = Server(self.path("other.db"))
        try:
            other.ask_one("restore", self.path("copy2.mdb"))
            self.assertEqual(other.run("verify").returncode, 0)
            other.ask_one("recognize", "d", self.path("seen.bvh"))
        finally:
            other.stop()

    def test_an_unreadable_store_is_reported_with_advice(self):
        self.server.stop()
        with open(self.store, "r+b") as file:
            file.seek(100)  # the list of tables
            file.write(bytes(512))
        result = subprocess.run([MOTIONDBD, "--store", self.store, "--listen",
                                 "127.0.0.1:0", "--http-listen", "none"], capture_output=True,
                                text=True, timeout=60)
        self.assertEqual(result.returncode, 1)
        self.assertIn("malformed", result.stderr)
        self.assertIn("restore a backup into a new store", result.stderr)

    def test_a_corrupt_backup_is_refused(self):
        backup = self.path("copy.mdb")
        self.server.ask_one("backup", backup)
        with open(backup, "rb") as file:
            good = file.read()
        with contextlib.closing(sqlite3.connect(self.path("photos.db"))) as photos:
            photos.execute("CREATE TABLE photo (name)")
        with open(self.path("photos.db"), "rb") as file:
            other_file = file.read()
        log = open(self.path("log"), "w+")
        other = Server(self.path("other.db"), log=log)
        try:
            for corrupt, expected in ((good[:-100], "cut off"), (good[:100], "cut off"),
                                      (b"not at all", "not a backup"), (other_file, "not a backup"),
                                      (b"", "motiondb: the backup is empty"),
                                      (good[:5000] + b"\0\1\2\3" + good[5004:], "checksum")):
                with open(self.path("corrupt.mdb"), "wb") as file:
                    file.write(corrupt)
                refused = other.run("restore", self.path("corrupt.mdb"))
                self.assertNotEqual(refused.returncode, 0)
                self.assertIn(expected, refused.stderr)
                self.assertEqual(other.ask("list"), [])
            other.ask_one("restore", backup)
            # It is not a server error.
            log.seek(0)
            self.assertEqual(log.read(), "")
        finally:
            other.stop()
            log.close()

    def test_files_are_not_replaced(self):
        backup = self.path("copy.mdb")
        self.server.ask_one("backup", backup)
        self.assertIn("already exists", self.server.run("backup", backup).stderr)
        self.assertEqual(self.server.run("backup", backup, "--force").returncode, 0)
        self.assertNotEqual(self.server.run("backup", self.path("no/folder/x")).returncode, 0)
        self.assertNotEqual(self.server.run("restore", self.path("missing")).returncode, 0)

    def test_verify_names_a_corrupt_clip_and_others_stay_usable(self):
        summary = json.loads(self.server.run("--json", "verify").stdout.splitlines()[-1])
        self.assertEqual(summary["summary"]["clip_count"], 6)
        self.server.stop()
        with sqlite3.connect(self.store) as store:
            store.execute("UPDATE clip_chunk SET chunk = CAST(substr(chunk, 1, 100) || x'A5A5' || "
                          "substr(chunk, 103) AS BLOB) WHERE kind = 3 AND clip_key = "
                          "(SELECT clip_key FROM clip WHERE id = 'clip3')")
        store.close()
        self.server = Server(self.store)
        verified = self.server.run("verify")
        self.assertNotEqual(verified.returncode, 0)
        self.assertIn("corrupt: databases/d/clips/clip3: states: chunk 0", verified.stdout)
        # The other clips are built into a model, and the clip can be replaced.
        self.ingest(self.server, 60)
        self.assertEqual(self.server.ask_one("describe", "d")["clip_count"], 6)
        self.assertEqual(self.server.run("delete", "d", "clip3").returncode, 0)
        self.ingest(self.server, 3)
        self.assertEqual(self.server.ask_one("describe", "d")["clip_count"], 7)
        self.assertEqual(self.server.run("verify").returncode, 0)


main()
