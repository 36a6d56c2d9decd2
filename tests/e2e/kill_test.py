#!/usr/bin/python3
"""A server that is killed at any moment keeps what it acknowledged, and nothing is damaged.

    kill_test.py MOTIONDBD MOTIONDB DATA_FOLDER [--kills N] [--seed S]

Ingest, deletion, rebuilds and queries go on while SIGKILL comes, N times (10 if not told). After each, a new server on the
same store must verify it and have every clip whose ingest was acknowledged, no clip whose deletion was, and none that
nobody sent.
"""

import json
import os
import random
import signal
import sys
import tempfile
import threading
import time

from figure import write_bvh
from programs import Server


def ask(server, *arguments):
    """Asks a server that should be well, again where the machine is so busy that it is not reached in time."""
    for _ in range(20):
        result = server.run(*arguments)
        assert server.process.poll() is None, f"the server ended: {server.process.returncode}"
        if "no motiondb server answered" not in result.stderr:
            break
    assert result.returncode == 0, f"{arguments}: {result.stdout}{result.stderr}"
    return result


class Load:
    """What clients do to one server until it is gone, and what it acknowledged."""

    def __init__(self, folder):
        self.folder = folder
        self.lock = threading.Lock()
        self.next_clip = 0
        self.sent = set()       # every clip that anybody tried to ingest
        self.stored = set()     # acknowledged, and no deletion of it was begun
        self.deleted = set()    # its deletion was acknowledged
        self.acknowledged = {"ingest": 0, "delete": 0, "query": 0}
        write_bvh(f"{folder}/query.bvh", seed=4, frames=40)

    def ingest(self, server):
        with self.lock:
            numbers = range(self.next_clip, self.next_clip + 3)
            self.next_clip += len(numbers)
            clips = [f"c{number}" for number in numbers]
            self.sent.update(clips)
        paths = [f"{self.folder}/{clip}.bvh" for clip in clips]
        for path, number in zip(paths, numbers):
            write_bvh(path, number)
        # Each clip is printed as it is acknowledged.
        printed = server.run("--json", "ingest", "d", *paths).stdout
        with self.lock:
            for clip in clips:
                if f"/clips/{clip}\"" in printed:
                    self.stored.add(clip)
                    self.acknowledged["ingest"] += 1
        for path in paths:
            os.remove(path)

    def delete(self, server, choice):
        with self.lock:
            if len(self.stored) < 4:
                return
            clip = choice(sorted(self.stored))
            self.stored.remove(clip)  # from now on it may be there or not
        if server.run("delete", "d", clip).returncode == 0:
            with self.lock:
                self.deleted.add(clip)
                self.acknowledged["delete"] += 1

    def query(self, server):
        if server.run("recognize", "d", f"{self.folder}/query.bvh").returncode == 0:
            with self.lock:
                self.acknowledged["query"] += 1

    def run(self, server, seed, gone):
        """Threads that press on until `gone` is set."""
        def loop(what):
            while not gone.is_set():
                what()
        choice = random.Random(seed).choice
        whats = [lambda: self.ingest(server), lambda: self.ingest(server),
                 lambda: self.delete(server, choice), lambda: self.query(server)]
        threads = [threading.Thread(target=loop, args=(what,)) for what in whats]
        for thread in threads:
            thread.start()
        return threads

    def check(self, server):
        ask(server, "verify")
        listed = ask(server, "--json", "list", "d").stdout.splitlines()
        there = {json.loads(line)["name"].rsplit("/", 1)[-1] for line in listed}
        assert self.stored <= there, f"lost: {sorted(self.stored - there)}"
        assert not self.deleted & there, f"came back: {sorted(self.deleted & there)}"
        assert there <= self.sent, f"nobody sent: {sorted(there - self.sent)}"


def argument(name, default):
    return int(sys.argv[sys.argv.index(name) + 1]) if name in sys.argv else default


def main():
    kills = argument("--kills", 10)
    seed = argument("--seed", 1)
    moments = random.Random(seed)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        store = f"{folder}/motion.db"
        load = Load(folder)
        server = Server(store)
        server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        for kill in range(kills):
            gone = threading.Event()
            threads = load.run(server, seed * 1000 + kill, gone)
            time.sleep(moments.uniform(0.02, 1.2))
            gone.set()
            server.stop(signal.SIGKILL)
            for thread in threads:
                thread.join()
            server = Server(store)
            try:
                load.check(server)
            except AssertionError as error:
                raise AssertionError(f"after kill {kill + 1} of {kills}, seed {seed}") from error
            left = [name for name in os.listdir(folder) if "-backup-" in name or "-restore-" in name]
            assert not left, left
        assert server.stop() == 0
    print(f"{kills} kills in {time.monotonic() - began:.0f} s; acknowledged before them: "
          f"{load.acknowledged['ingest']} ingests, {load.acknowledged['delete']} deletions, "
          f"{load.acknowledged['query']} queries; nothing lost, nothing damaged")


main()
