#!/usr/bin/python3
"""Stores of earlier versions: their clips are derived again, also if the server is killed
meanwhile.

    reprocess_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import glob
import gzip
import os
import random
import signal
import sqlite3
import struct
import time
import unittest
import zlib

from figure import write_bvh
from programs import SLOWNESS, Server, WithServer, main

OLD_STORES = os.path.join(os.path.dirname(__file__), "../storage/old_stores")
CLIPS = 600  # more than two transactions of derived clips
KILLS = 60 if SLOWNESS == 1 else 10  # with sanitizers, the server hardly starts between kills
REPRESENTATION = 5  # core::kRepresentationVersion
ADDED_COLUMNS = ("representation_version", "tried_version", "tried_time_us", "derive_error", "given_metres_per_unit",
                 "given_up_axis", "given_frame_rate_hz", "given_leg_length_m", "given_take")
ANNOTATION_COLUMNS = {"clip": ("title", "description", "annotations", "revision", "edit_time_us"),
                      "database": ("revision", "removed_revision"), "model": ("revision",)}
KINDS = {int: b"\1", float: b"\2", str: b"\3", bytes: b"\4", type(None): b"\5"}


def row_crc(*values):
    """Returns the store's checksum of a row (storage/sqlite/row_checksum.h)."""
    crc = 0
    for value in values:
        crc = zlib.crc32(KINDS[type(value)], crc)
        if isinstance(value, int):
            crc = zlib.crc32(struct.pack("<q", value), crc)
        elif isinstance(value, float):
            crc = zlib.crc32(struct.pack("<d", value), crc)
        elif value is not None:
            text = value.encode() if isinstance(value, str) else value
            crc = zlib.crc32(text, zlib.crc32(struct.pack("<I", len(text)), crc))
    return crc


def downgrade(store):
    """Downgrades a store from version 10 to version 7, with a database that repairs glitches."""
    database = sqlite3.connect(store)
    database.create_function("row_crc", -1, row_crc)
    database.execute("ALTER TABLE clip ADD COLUMN label TEXT NOT NULL DEFAULT ''")
    database.execute("UPDATE clip SET label = ifnull((SELECT label FROM segment "
                     "WHERE segment.clip_key = clip.clip_key), '')")
    for table in ("build_lease", "segment", "tombstone", "edit", "clip_text"):
        database.execute(f"DROP TABLE {table}")
    for index in ("clip_by_revision", "model_by_revision", "unfinished_operation"):
        database.execute(f"DROP INDEX {index}")
    for table, columns in ANNOTATION_COLUMNS.items():
        for column in columns:
            database.execute(f"ALTER TABLE {table} DROP COLUMN {column}")
    for column in ADDED_COLUMNS:
        database.execute(f"ALTER TABLE clip DROP COLUMN {column}")
    database.execute("ALTER TABLE operation DROP COLUMN kind")
    database.execute("UPDATE database SET glitches = 'repair'")
    for table in ("clip", "operation", "database", "model"):
        columns = [row[1] for row in database.execute(f"PRAGMA table_info({table})") if row[1] != "row_crc"]
        database.execute(f"UPDATE {table} SET row_crc = row_crc({', '.join(columns)})")
    database.execute("PRAGMA user_version = 7")
    database.commit()
    database.close()


def write_clip(path, seed):
    """Writes a clip. In every third clip, three frames have displaced hips."""
    write_bvh(path, seed)
    if seed % 3:
        return
    with open(path, encoding="ascii") as file:
        lines = file.read().splitlines()
    for frame in range(20, 23):
        place = len(lines) - 48 + frame
        lines[place] = "9000 " + lines[place].split(" ", 1)[1]
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")


def await_operations(server, database):
    """Waits until no operation is left. Returns the newest operation."""
    for _ in range(1000):
        operations = server.ask("operations", "list", database)
        pending = [operation["name"] for operation in operations
                   if operation["state"] in ("OPERATION_STATE_PENDING", "OPERATION_STATE_RUNNING")]
        if not pending:
            return operations[0]
        server.run("operations", "wait", pending[-1].rsplit("/", 1)[-1])
    raise AssertionError("operations do not end")


class Reprocess(WithServer):
    def restart(self, store):
        if self.server.process.poll() is None:
            self.server.stop()
        self.store = store
        self.server = Server(store, "--rebuild-delay", "0")

    def check_is_new(self, database, count):
        clips = self.server.ask("list", database)
        self.assertEqual(len(clips), count)
        for clip in clips:
            self.assertEqual(clip["representation_version"], REPRESENTATION)
            self.assertEqual(clip["derive_error"], "")
        described = self.server.ask_one("describe", database)
        self.assertEqual(described["clip_count"], count)
        self.assertEqual(described["underived_clip_count"], 0)
        verified = self.server.run("verify")
        self.assertEqual(verified.returncode, 0, verified.stdout + verified.stderr)
        return clips

    def test_stores_of_earlier_versions(self):
        paths = sorted(glob.glob(f"{OLD_STORES}/version*.db.gz"))
        self.assertGreaterEqual(len(paths), 7)
        for path in paths:
            with self.subTest(os.path.basename(path)):
                store = self.path(os.path.basename(path).removesuffix(".gz"))
                with gzip.open(path) as packed, open(store, "wb") as file:
                    file.write(packed.read())
                self.restart(store)
                operation = await_operations(self.server, "walks")
                self.assertEqual(operation["state"], "OPERATION_STATE_SUCCEEDED")
                self.check_is_new("walks", 2)
                reprocessed = self.server.ask_one("reprocess", "walks")["operation"]
                self.assertEqual(reprocessed["kind"], "OPERATION_KIND_REPROCESS")
                self.assertIn("clips derived again: 2, changed: 0", reprocessed["stage"])

    def test_kills(self):
        self.server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4", "--glitches", "keep")
        paths = [self.path(f"c{seed}.bvh") for seed in range(CLIPS)]
        for seed, path in enumerate(paths):
            write_clip(path, seed)
        ingested = self.server.run("ingest", "d", *paths)
        self.assertEqual(ingested.returncode, 0, ingested.stderr)
        kept = {clip["name"] for clip in self.server.ask("list", "d") if clip["glitches"]}
        self.assertEqual(len(kept), CLIPS // 3)
        model = self.server.ask_one("describe", "d")["model_version"]
        self.server.stop()
        downgrade(self.store)

        moments = random.Random(1)
        seen = set()  # numbers of derived clips when the server was killed
        answers = 0
        for _ in range(KILLS):
            self.restart(self.store)
            latest = time.monotonic() + moments.uniform(0.0, 1.0)
            while time.monotonic() < latest:
                described = self.server.ask_one("describe", "d")
                if described["model_version"] != model:
                    break
                # The earlier model, with all its clips, answers.
                self.assertEqual(described["clip_count"], CLIPS)
                answers += self.server.run("recognize", "d", paths[1]).returncode == 0
            derived = sum(clip["representation_version"] == REPRESENTATION for clip in self.server.ask("list", "d"))
            seen.add(derived)
            self.server.stop(signal.SIGKILL)
            if described["model_version"] != model:
                break
        print(f"killed with {sorted(seen)} of {CLIPS} clips derived; {answers} queries answered meanwhile")

        self.restart(self.store)
        self.assertEqual(await_operations(self.server, "d")["state"], "OPERATION_STATE_SUCCEEDED")
        clips = self.check_is_new("d", CLIPS)
        for clip in clips:
            expected = "repaired (1)" if clip["name"] in kept else ""
            self.assertTrue(clip["glitches"].startswith(expected) and bool(clip["glitches"]) == bool(expected),
                            clip["glitches"])
        self.assertEqual(self.server.stop(), 0)
        # The states of the earlier model are deleted.
        database = sqlite3.connect(self.store)
        self.assertEqual(database.execute("SELECT count(*) FROM clip").fetchone(), (CLIPS,))
        database.close()


main()
