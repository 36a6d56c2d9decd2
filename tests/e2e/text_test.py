"""Texts that must not act on a terminal, tokens in wrong places, and file names from a server."""

import json
import os
import re
import signal
import socket
import sqlite3
import subprocess
import threading
import xml.dom.minidom

import programs
from figure import write_bvh

# Line feed, escapes of 7 and 8 bits, changes of the writing direction, separators, a byte order
# mark.
HOSTILE = "A\n\x1b[31m\x9b2J\u202e\u2066\u2028\u2029\u061c\u200f\ufeff\x7fZ"
CONTROLS = re.compile("[\x00-\x09\x0b-\x1f\x7f-\x9f\u061c\u200e\u200f\u2028-\u202e\u2066-\u206f\ufeff]")
TOKEN = "mdb_0123456789ab_" + "c" * 64


class StallingRelay:
    """A relay between one client and the server: passes a limited number of the server's bytes,
    then stalls."""

    def __init__(self, server, max_bytes):
        self.stalled = threading.Event()
        self.listener = socket.create_server(("127.0.0.1", 0))
        self.address = f"127.0.0.1:{self.listener.getsockname()[1]}"
        host, port = server.rsplit(":", 1)
        self.server = socket.create_connection((host, int(port)))
        self.client = None
        threading.Thread(target=self.accept, args=(max_bytes,), daemon=True).start()

    def accept(self, max_bytes):
        self.client, _ = self.listener.accept()
        threading.Thread(target=self.relay, args=(self.client, self.server, None),
                         daemon=True).start()
        self.relay(self.server, self.client, max_bytes)
        self.stalled.set()

    @staticmethod
    def relay(source, target, max_bytes):
        passed = 0
        try:
            while max_bytes is None or passed < max_bytes:
                data = source.recv(4096)
                if not data:
                    return
                target.sendall(data)
                passed += len(data)
        except OSError:
            pass

    def close(self):
        for end in (self.client, self.server, self.listener):
            end.close()


class TextTest(programs.WithServer):
    def setUp(self):
        super().setUp()
        self.swing = self.path("swing.bvh")
        write_bvh(self.swing, seed=2)

    def restart(self, *options, log=None):
        if self.server.process.poll() is None:
            self.assertEqual(self.server.stop(), 0)
        self.server = programs.Server(self.store, *options, log=log)

    def make_database(self):
        for arguments in (("create", "d", "--marker-set", "source", "--min-frames", "4"),
                          ("ingest", "d", self.swing, "--label", "swing")):
            result = self.server.run(*arguments)
            self.assertEqual(result.returncode, 0, result.stderr)

    def store_in_clip(self, **columns):
        """Writes into the store what an earlier version accepted, or a hostile server would
        send."""
        self.assertEqual(self.server.stop(), 0)
        with sqlite3.connect(self.store) as database:
            for column, value in columns.items():
                table = "segment" if column == "label" else "clip"
                database.execute(f"UPDATE {table} SET {column} = ?", (value,))
        database.close()
        self.restart()

    def assert_harmless(self, text):
        self.assertIsNone(CONTROLS.search(text), repr(text))
        self.assertNotIn("A\n", text)

    def test_texts_are_refused(self):
        self.make_database()
        for option in ("--label", "--subject"):
            for text in ("a\u009bb", "a\u202eb", "a\u2028b", "a\u200fb", "a\nb", TOKEN):
                result = self.server.run("ingest", "d", self.swing, option, text)
                self.assertEqual(result.returncode, 1)
                self.assertIn(option.strip("-"), result.stderr)
                self.assert_harmless(result.stderr)
                self.assertNotIn("c" * 8, result.stderr)
        for name in ("a\u009b.bvh", ".a.bvh", "-rf.bvh"):
            write_bvh(self.path(name), seed=4)
            result = self.server.run("ingest", "d", "--", self.path(name))
            self.assertEqual(result.returncode, 1, name)
            self.assert_harmless(result.stderr)
        markers = self.path("m.txt")
        with open(markers, "w", encoding="utf-8") as file:
            file.write("motiondb-marker-set 1\nname m\nmarker a\u202eb\nmarker c\nhips c a\u202eb\n")
        self.assertIn("U+202E", self.server.run("create", "e", "--marker-set", markers).stderr)
        result = self.server.run("token", "create", "--role", "reader", "--description", "a\u2067b")
        self.assertIn("U+2067", result.stderr)

    def test_stored_texts_are_shown_without_controls(self):
        self.make_database()
        self.store_in_clip(label=HOSTILE, subject=HOSTILE, file_name=HOSTILE + ".bvh",
                           source_report=HOSTILE)
        plot, profile = self.path("plot.svg"), self.path("profile.svg")
        commands = [["list", "d"], ["describe", "d"], ["audit"], ["operations", "list"], ["status"],
                    ["recognize", "d", self.swing, "--plot", plot], ["verify"],
                    ["recognize", "d", self.swing, "--plot-profile", profile],
                    ["export", "d", "swing", "--out", self.path("out")]]
        for command in commands:
            result = self.server.run(*command)
            self.assert_harmless(result.stdout)
            self.assert_harmless(result.stderr)
            self.assertGreater(len(result.stdout) + len(result.stderr), 0)
        for picture in (plot, profile):
            with open(picture, encoding="utf-8") as file:
                self.assert_harmless(file.read())
            xml.dom.minidom.parse(picture)
        printed = self.server.run("--json", "list", "d").stdout
        self.assert_harmless(printed)
        self.assertEqual(json.loads(printed)["label"], HOSTILE)

    def test_log_is_harmless_and_has_no_tokens(self):
        with open(self.path("log"), "w+", encoding="utf-8") as log:
            self.restart("--log-level", "debug", log=log)
            self.make_database()
            self.server.run("describe", "a\u009b\u202e\nb")
            for command in (["describe", TOKEN], ["operations", "wait", TOKEN], ["delete", TOKEN],
                            ["delete", "d", TOKEN], ["create", TOKEN], ["list", TOKEN],
                            ["export", "d", TOKEN, "--out", self.path("out")],
                            ["recognize", TOKEN, self.swing], ["token", "revoke", TOKEN + "x"],
                            ["ingest", "d", self.swing, "--label", TOKEN],
                            ["ingest", TOKEN, self.swing],
                            ["plan", "d", "--goal", "1,1,0", "--start", TOKEN + "@1"]):
                result = self.server.run(*command)
                self.assertEqual(result.returncode, 1, command)
                self.assertNotIn("c" * 8, result.stdout + result.stderr, command)
            self.assertNotIn("c" * 8, self.server.run("--json", "audit").stdout)
            self.assertEqual(self.server.stop(), 0)
            log.seek(0)
            text = log.read()
        self.assertIn("mdb_0123456789ab_...", text)
        self.assertNotIn("c" * 8, text)
        self.assert_harmless(text)
        with open(self.store, "rb") as store:
            self.assertNotIn(b"c" * 8, store.read())

    def test_export_writes_only_its_own_file(self):
        self.make_database()
        out = self.path("out")
        os.mkdir(out)
        victim = self.path("victim")
        with open(victim, "w", encoding="ascii") as file:
            file.write("precious")
        for name in ("swing.bvh.partial", "swing.bvh"):
            os.symlink(victim, os.path.join(out, name))
        self.assertEqual(self.server.run("export", "d", "swing", "--out", out).returncode, 1)
        result = self.server.run("export", "d", "swing", "--out", out, "--force")
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse(os.path.islink(os.path.join(out, "swing.bvh")))
        with open(victim, encoding="ascii") as file:
            self.assertEqual(file.read(), "precious")
        for name in (".bashrc", "-rf.bvh", "../evil.bvh", "a\u009b.bvh"):
            self.store_in_clip(file_name=name)
            result = self.server.run("export", "d", "swing", "--out", self.path("new"))
            self.assertEqual(result.returncode, 1, name)
            self.assertIn("neither '.' nor '-'", result.stderr)
            self.assertEqual(os.listdir(self.path("new")), [])
        self.assertEqual(sorted(os.listdir(out)), ["swing.bvh", "swing.bvh.partial"])

    def test_dump_and_pictures_follow_no_links(self):
        self.make_database()
        victims = self.path("victims")
        os.makedirs(os.path.join(victims, "01"))
        victim = os.path.join(victims, "01", "mean.npy")
        with open(victim, "w", encoding="ascii") as file:
            file.write("precious")
        for name in ("states.npy.partial", "model.json.partial"):
            os.makedirs(self.path("dump"), exist_ok=True)
            os.symlink(victim, os.path.join(self.path("dump"), name))
        os.symlink(victims, os.path.join(self.path("dump"), "layers"))
        result = self.server.run("dump", "d", self.path("dump"), "--force")
        self.assertEqual(result.returncode, 1)
        self.assertIn("layers: expected a folder or nothing", result.stderr)
        os.unlink(os.path.join(self.path("dump"), "layers"))
        self.assertEqual(self.server.run("dump", "d", self.path("dump"), "--force").returncode, 0)
        plot = self.path("plot.svg")
        for name in (plot, plot + ".partial"):
            os.symlink(victim, name)
        result = self.server.run("recognize", "d", self.swing, "--plot", plot)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertFalse(os.path.islink(plot))
        with open(victim, encoding="ascii") as file:
            self.assertEqual(file.read(), "precious")

    def test_an_interrupt_leaves_no_file(self):
        self.make_database()
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            out = self.path(f"out{number}")
            os.mkdir(out)
            relay = StallingRelay(self.server.address, max_bytes=50_000)
            client = subprocess.Popen(
                [programs.MOTIONDB, "--server", relay.address, "backup", os.path.join(out, "copy.db")],
                stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
            self.assertTrue(relay.stalled.wait(timeout=30))
            client.send_signal(number)
            self.assertEqual(client.wait(timeout=30), -number)
            relay.close()
            self.assertEqual(os.listdir(out), [])

    def test_a_drain_during_an_ingest_reports_the_stored_clips(self):
        self.make_database()
        # Many clips, so that the build still runs when the server is stopped.
        files = []
        for seed in range(10, 40):
            files.append(self.path(f"clip{seed}.bvh"))
            write_bvh(files[-1], seed=seed, frames=600)
        client = subprocess.Popen(
            [programs.MOTIONDB, "--server", self.server.address, "ingest", "d", "--verbose", *files],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.assertIn("clip10", client.stdout.readline())
        self.server.process.send_signal(signal.SIGTERM)
        _, error = client.communicate(timeout=60)
        self.assertEqual(self.server.process.wait(timeout=60), 0)
        self.server.process.stdout.close()
        self.assertEqual(client.returncode, 1)
        self.assertRegex(error, "[1-9][0-9]* clips? (is|are) stored")


if __name__ == "__main__":
    programs.main()
