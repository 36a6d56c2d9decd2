#!/usr/bin/python3
"""Concurrent editors of segments lose and duplicate no edit, while the server is killed.

    edit_kill_test.py MOTIONDBD MOTIONDB DATA_FOLDER [--edits N] [--kills N] [--seed S]

Eight clients create N segments (default 1000) with ids of their own, relabel a part of them with the etag that they
read, and count in a field of one clip. SIGKILL is sent at random moments; a new server on the same store continues.
A client repeats what was not acknowledged. A watch that reconnects must build the same state as the lists.
"""

import argparse
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time

from figure import write_bvh
from programs import MOTIONDB, SLOWNESS, Server

CLIENTS = 8


class Store:
    """A server that is killed and started again at the same address."""

    def __init__(self, folder):
        self.path = os.path.join(folder, "motion.db")
        self.server = Server(self.path)
        self.address = self.server.address
        self.kills = 0

    def kill(self):
        self.server.stop(signal.SIGKILL)
        self.kills += 1
        for _ in range(100):  # the address may be in use for a moment
            self.server = Server(self.path, address=self.address)
            if self.server.process.poll() is None and self.server.address == self.address:
                return
            time.sleep(0.1)
        raise AssertionError("the server does not start again")

    def run(self, *arguments):
        return subprocess.run([MOTIONDB, "--server", self.address, "--json", *arguments], capture_output=True,
                              text=True)

    def until_answered(self, *arguments):
        """Repeats a call until a server answers it. Returns code and the objects of the answer, or the error."""
        while True:
            result = self.run(*arguments)
            if result.returncode == 0:
                return 0, [json.loads(line) for line in result.stdout.splitlines() if line.strip()]
            # What clients report of a server that was killed before, during or after a call.
            lost = ("is not available", "no motiondb server answered")
            if not any(words in result.stderr for words in lost):
                return result.returncode, result.stderr
            time.sleep(0.05)


class Editor(threading.Thread):
    """Creates its part of the segments, one after the other, and counts them in a shared field."""

    def __init__(self, store, number, edits, seed):
        super().__init__(daemon=True)  # a failure ends the test immediately
        self.store = store
        self.number = number
        self.edits = edits
        self.random = random.Random(seed * 1000 + number)
        self.labels = {}  # by segment
        self.counted = 0
        self.repeated = 0
        self.failure = None

    def run(self):
        try:
            for k in range(self.edits):
                self.create(k)
                if self.random.random() < 0.3:
                    self.relabel()
                if k % 25 == 0:
                    self.count()
        except Exception as failure:  # reported by the main thread
            self.failure = failure

    def create(self, k):
        """A track of its own for each client: segments of one track do not overlap."""
        name, label = f"e{self.number}-{k}", f"label{k % 7}"
        start = k * 0.01
        code, answer = self.store.until_answered(
            "segments", "add", "d", f"clip{k % 4}", "--from", f"{start:.2f}", "--to", f"{start + 0.01:.2f}",
            "--label", label, "--track", f"track{self.number}", "--id", name)
        if code != 0:  # stored, but the acknowledgement was lost
            assert "ALREADY_EXISTS" in answer or "has" in answer, answer
            self.repeated += 1
        self.labels[f"clip{k % 4}/{name}"] = label

    def relabel(self):
        """Nobody else changes the segment: with its etag the change happens once or not at all."""
        name = self.random.choice(sorted(self.labels))
        label = f"new{self.random.randrange(1000)}"
        while True:
            _, found = self.store.until_answered("segments", "list", "d", "--clip", name.split("/")[0])
            segment, = [each for each in found if each["name"].endswith("/" + name.split("/")[1])]
            if segment["label"] == label:
                break
            code, _ = self.store.until_answered("segments", "update", "d", name, "--label", label, "--etag",
                                                segment["etag"])
            if code == 0:
                break
        self.labels[name] = label

    def count(self):
        """Adds one to a field that all clients change: a lost update would lose a count."""
        while True:
            _, clips = self.store.until_answered("list", "d", "--filter", "name = clip0")
            clip, = clips
            fields = {name: value["number"] for name, value in clip.get("fields", {}).items()}
            mine = f"c{self.number}"
            if fields.get(mine, 0) == self.counted + 1:  # an acknowledgement was lost
                break
            code, _ = self.store.until_answered("update", "d", "clip0", "--field", f"{mine}={self.counted + 1}",
                                                "--field", f"sum={int(fields.get('sum', 0)) + 1}", "--etag",
                                                clip["etag"])
            if code == 0:
                break
        self.counted += 1


def watch(store, state):
    """Follows the database until `state["done"]`, and continues from the last revision after each kill."""
    revision = 0
    while not state["done"]:
        process = subprocess.Popen([MOTIONDB, "--server", store.address, "--json", "watch", "d", "--from",
                                    str(revision)], stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
        state["process"] = process
        for line in process.stdout:
            message = json.loads(line)
            revision = max(revision, int(message.get("revision", 0)))
            for kind in ("segment", "clip"):
                if kind in message:
                    state["objects"][message[kind]["name"]] = message[kind]
            if "deleted" in message:
                state["objects"].pop(message["deleted"], None)
            state["revision"] = revision
        process.wait()
        state["process"] = None


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--edits", type=int, default=1000)
    parser.add_argument("--kills", type=int, default=8)
    parser.add_argument("--seed", type=int, default=1)
    options = parser.parse_args(sys.argv[4:])
    edits = max(1, int(options.edits / SLOWNESS)) // CLIENTS
    chance = random.Random(options.seed)
    with tempfile.TemporaryDirectory() as folder:
        store = Store(folder)
        files = []
        for k in range(4):
            files.append(os.path.join(folder, f"clip{k}.bvh"))
            write_bvh(files[-1], k, frames=120)
        assert store.run("create", "d", "--marker-set", "source").returncode == 0
        ingested = store.run("ingest", "d", *files, "--label", "walk")
        assert ingested.returncode == 0, ingested.stderr
        state = {"done": False, "objects": {}, "revision": 0, "process": None}
        follower = threading.Thread(target=watch, args=(store, state), daemon=True)
        follower.start()
        editors = [Editor(store, k, edits, options.seed) for k in range(CLIENTS)]
        for editor in editors:
            editor.start()
        running = True
        while running:
            time.sleep(chance.uniform(0.3, 2) * SLOWNESS)
            running = any(editor.is_alive() for editor in editors)
            for editor in editors:
                if editor.failure:
                    store.server.stop(signal.SIGKILL)
                    raise editor.failure
            if running and store.kills < options.kills:
                store.kill()

        expected = {name: label for editor in editors for name, label in editor.labels.items()}
        _, listed = store.until_answered("segments", "list", "d", "--filter", "NOT track = action")
        found = {each["name"].split("/clips/")[1].replace("/segments/", "/"): each["label"] for each in listed}
        assert found == expected, f"lost or changed: {set(expected.items()) ^ set(found.items())}"
        _, clips = store.until_answered("list", "d", "--filter", "name = clip0")
        counted = sum(editor.counted for editor in editors)
        assert clips[0]["fields"]["sum"]["number"] == counted, (clips[0]["fields"], counted)
        # The last changes reach the watch.
        _, current = store.until_answered("watch", "d", "--until-current")
        latest = time.monotonic() + 30 * SLOWNESS
        while state["revision"] < int(current[-1]["revision"]) and time.monotonic() < latest:
            time.sleep(0.1)
        state["done"] = True
        if state["process"]:
            state["process"].terminate()
        follower.join()
        _, everything = store.until_answered("segments", "list", "d")
        watched = {name: each for name, each in state["objects"].items() if "/segments/" in name}
        assert watched == {each["name"]: each for each in everything}, "the watch missed a change"
        verified = store.run("verify")
        assert verified.returncode == 0, verified.stdout + verified.stderr
        store.server.stop()
        print(f"{len(expected)} segments, {counted} counts, {store.kills} kills, "
              f"{sum(editor.repeated for editor in editors)} lost acknowledgements: no edit lost or repeated")


if __name__ == "__main__":
    main()
