#!/usr/bin/python3
"""Concurrent editors of segments lose and duplicate no edit, while the server is killed.

    edit_kill_test.py MOTIONDBD MOTIONDB DATA_FOLDER [--edits N] [--kills N] [--seed S]

Eight clients of the HTTP API create N segments (default 1000) with ids of their own, relabel a part of them with the
etag that they read, and count in a field of one clip. SIGKILL is sent at random moments; a new server on the same store
continues. A client repeats what was not acknowledged. A watch that reconnects must build the same state as the lists.
"""

import argparse
import http.client
import json
import os
import random
import signal
import subprocess
import sys
import tempfile
import threading
import time
import urllib.error
import urllib.request

from figure import write_bvh
from programs import MOTIONDB, SLOWNESS, Server

CLIENTS = 8


class Store:
    """A server that is killed and started again at the same address."""

    def __init__(self, folder):
        self.path = os.path.join(folder, "motion.db")
        self.server = Server(self.path, "--web-listen", "127.0.0.1:0")
        self.address = self.server.address
        self.web = self.server.web
        self.kills = 0

    def kill(self):
        self.server.stop(signal.SIGKILL)
        self.kills += 1
        for _ in range(100):  # the address may be in use for a moment
            web_address = self.web.removeprefix("http://")
            self.server = Server(self.path, "--web-listen", web_address, address=self.address)
            if self.server.process.poll() is None and self.server.address == self.address:
                return
            time.sleep(0.1)
        raise AssertionError("the server does not start again")

    def ask(self, *arguments):
        return self.server.ask(*arguments)

    def call(self, method, request):
        """Repeats a call until a server answers it. Returns the answer and an empty code, or an empty answer and the
        code of the error."""
        body = json.dumps(request).encode()
        headers = {"Content-Type": "application/json"}
        while True:
            try:
                call = urllib.request.Request(f"{self.web}/motiondb.v1.{method}", body, headers)
                with urllib.request.urlopen(call, timeout=60 * SLOWNESS) as answer:
                    return json.load(answer), ""
            except urllib.error.HTTPError as error:
                code = json.load(error)["code"]
                if code != "unavailable":
                    return {}, code
            except (OSError, http.client.HTTPException):
                pass  # the server was killed before, during or after the call
            time.sleep(0.05)

    def answer(self, method, request):
        answer, code = self.call(method, request)
        assert code == "", f"{method}: {code}"
        return answer


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
        segment = {"label": label, "track": f"track{self.number}", "startSeconds": k * 0.01,
                   "endSeconds": (k + 1) * 0.01}
        _, code = self.store.call("SegmentService/CreateSegment", {
            "parent": f"databases/d/clips/clip{k % 4}", "segment": segment, "segmentId": name})
        if code:  # stored, but the acknowledgement was lost
            assert code == "already_exists", code
            self.repeated += 1
        self.labels[f"clip{k % 4}/{name}"] = label

    def relabel(self):
        """Nobody else changes the segment: with its etag the change happens once or not at all."""
        name = self.random.choice(sorted(self.labels))
        label = f"new{self.random.randrange(1000)}"
        clip, segment_id = name.split("/")
        resource = f"databases/d/clips/{clip}/segments/{segment_id}"
        while True:
            listed = self.store.answer("SegmentService/ListSegments", {
                "parent": f"databases/d/clips/{clip}", "pageSize": 1000})["segments"]
            segment, = [each for each in listed if each["name"] == resource]
            if segment["label"] == label:
                break
            change = {"name": resource, "label": label, "etag": segment["etag"]}
            _, code = self.store.call("SegmentService/UpdateSegment", {"segment": change, "updateMask": "label"})
            if not code:
                break
            assert code == "aborted", code
        self.labels[name] = label

    def count(self):
        """Adds one to a field that all clients change: a lost update would lose a count."""
        mine = f"c{self.number}"
        resource = "databases/d/clips/clip0"
        while True:
            clip = self.store.answer("ClipService/GetClip", {"name": resource})["clip"]
            fields = {name: value["number"] for name, value in clip.get("fields", {}).items()}
            if fields.get(mine, 0) == self.counted + 1:  # an acknowledgement was lost
                break
            changed = {mine: {"number": self.counted + 1}, "sum": {"number": fields.get("sum", 0) + 1}}
            change = {"name": resource, "etag": clip["etag"], "fields": changed}
            _, code = self.store.call("ClipService/UpdateClip", {
                "clip": change, "updateMask": f"fields.{mine},fields.sum"})
            if not code:
                break
            assert code == "aborted", code
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
        store.ask("create", "d", "--marker-set", "source")
        store.ask("ingest", "d", *files, "--label", "walk")
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
        listed = store.ask("segments", "list", "d", "--filter", "NOT track = action")
        found = {each["name"].split("/clips/")[1].replace("/segments/", "/"): each["label"] for each in listed}
        assert found == expected, f"lost or changed: {set(expected.items()) ^ set(found.items())}"
        clips = store.ask("list", "d", "--filter", "name = clip0")
        counted = sum(editor.counted for editor in editors)
        assert clips[0]["fields"]["sum"]["number"] == counted, (clips[0]["fields"], counted)
        # The last changes reach the watch.
        current = store.ask("watch", "d", "--until-current")
        latest = time.monotonic() + 30 * SLOWNESS
        while state["revision"] < int(current[-1]["revision"]) and time.monotonic() < latest:
            time.sleep(0.1)
        state["done"] = True
        if state["process"]:
            state["process"].terminate()
        follower.join()
        everything = store.ask("segments", "list", "d")
        watched = {name: each for name, each in state["objects"].items() if "/segments/" in name}
        assert watched == {each["name"]: each for each in everything}, "the watch missed a change"
        store.ask("verify")
        store.server.stop()
        print(f"{len(expected)} segments, {counted} counts, {store.kills} kills, "
              f"{sum(editor.repeated for editor in editors)} lost acknowledgements: no edit lost or repeated")


if __name__ == "__main__":
    main()
