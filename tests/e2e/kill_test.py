#!/usr/bin/python3
"""A server that is killed at any moment keeps all acknowledged changes, and nothing is corrupt.

    kill_test.py MOTIONDBD MOTIONDB DATA_FOLDER [--kills N] [--seed S]

Clients ingest, delete clips and databases, and query while SIGKILL is sent N times (default 10). After each kill a new
server on the same store must verify it. It must have everything whose creation was acknowledged, nothing whose deletion
was acknowledged, and nothing unknown.
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

# A deletion waits for the model without the clip, so models are built immediately.
OPTIONS = ["--rebuild-delay", "0"]


def ask(server, *arguments):
    """Runs a command on a healthy server. Retries if a busy machine does not connect in time."""
    for _ in range(20):
        result = server.run(*arguments)
        assert server.process.poll() is None, f"the server ended: {server.process.returncode}"
        if "no motiondb server answered" not in result.stderr:
            break
    assert result.returncode == 0, f"{arguments}: {result.stdout}{result.stderr}"
    return result


class NameTracker:
    """Names of clips or databases that must exist, and of those that must not."""

    def __init__(self):
        self.lock = threading.Lock()
        self.tried = 0
        self.stored = set()    # acknowledged; no deletion begun
        self.doubtful = set()  # deletion begun, not acknowledged
        self.deleted = set()   # deletion acknowledged
        self.created = 0       # number of acknowledged creations
        self.interrupted = [0, 0]  # interrupted deletions: not done, done

    def new(self, count):
        """Returns unused names."""
        with self.lock:
            self.tried += count
            return [f"c{number}" for number in range(self.tried - count, self.tried)]

    def keep(self, name):
        with self.lock:
            self.stored.add(name)
            self.created += 1

    def begin_deletion(self, choice):
        """Picks a stored name and marks it doubtful; None if few are left."""
        with self.lock:
            if len(self.stored) < 3:
                return None
            name = choice(sorted(self.stored))
            self.stored.remove(name)
            self.doubtful.add(name)
            return name

    def end_deletion(self, name):
        with self.lock:
            self.doubtful.remove(name)
            self.deleted.add(name)

    def check(self, existing):
        """Checks the names that exist after a kill, and takes them as the new state."""
        assert self.stored <= existing, f"lost: {sorted(self.stored - existing)}"
        assert not self.deleted & existing, f"came back: {sorted(self.deleted & existing)}"
        strangers = existing - {f"c{number}" for number in range(self.tried)}
        assert not strangers, f"unknown: {sorted(strangers)}"
        for name in self.doubtful:
            self.interrupted[name not in existing] += 1
        self.deleted |= self.doubtful - existing
        self.doubtful = set()
        self.stored = set(existing)

    def __str__(self):
        return (f"{self.created} created, {len(self.deleted) - self.interrupted[1]} deleted (interrupted: "
                f"{self.interrupted[1]} done, {self.interrupted[0]} not done)")


class Load:
    """The load of clients on one server until it is killed, and the acknowledged changes."""

    def __init__(self, folder):
        self.folder = folder
        self.clips = NameTracker()
        self.databases = NameTracker()
        self.queries = 0
        write_bvh(f"{folder}/query.bvh", seed=4, frames=40)

    def ingest(self, server):
        clips = self.clips.new(3)
        paths = [f"{self.folder}/{clip}.bvh" for clip in clips]
        for path, clip in zip(paths, clips):
            write_bvh(path, int(clip[1:]))
        # The client prints each clip when it is acknowledged.
        printed = server.run("--json", "ingest", "d", *paths).stdout
        for clip in clips:
            if f"/clips/{clip}\"" in printed:
                self.clips.keep(clip)
        for path in paths:
            os.remove(path)

    def create(self, server):
        """Creates a database with the clip of a query."""
        [name] = self.databases.new(1)
        if server.run("create", name, "--marker-set", "source", "--min-frames", "4").returncode == 0:
            self.databases.keep(name)
            server.run("ingest", name, f"{self.folder}/query.bvh")

    def delete(self, server, names, choice, *where):
        name = names.begin_deletion(choice)
        if name is None:
            time.sleep(0.01)
        elif server.run("delete", "--yes", *where, name).returncode == 0:
            names.end_deletion(name)

    def query(self, server):
        if server.run("recognize", "d", f"{self.folder}/query.bvh").returncode == 0:
            self.queries += 1

    def run(self, server, seed, gone):
        """Starts threads that run until `gone` is set."""
        def loop(action):
            while not gone.is_set():
                action()
        choice = random.Random(seed).choice
        actions = [lambda: self.ingest(server), lambda: self.ingest(server), lambda: self.create(server),
                   lambda: self.delete(server, self.clips, choice, "d"),
                   lambda: self.delete(server, self.clips, choice, "d"),
                   lambda: self.delete(server, self.databases, choice), lambda: self.query(server)]
        threads = [threading.Thread(target=loop, args=(action,)) for action in actions]
        for thread in threads:
            thread.start()
        return threads

    def check(self, server):
        def names(*where):
            listed = ask(server, "--json", "list", *where).stdout.splitlines()
            return {json.loads(line)["name"].rsplit("/", 1)[-1] for line in listed}
        ask(server, "verify")
        self.clips.check(names("d"))
        self.databases.check(names() - {"d"})


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
        server = Server(store, *OPTIONS)
        server.ask_one("create", "d", "--marker-set", "source", "--min-frames", "4")
        for kill in range(kills):
            gone = threading.Event()
            deleted = len(load.clips.deleted)
            threads = load.run(server, seed * 1000 + kill, gone)
            if kill % 2:  # waits for an acknowledged deletion, however slow the machine is
                latest = time.monotonic() + 20
                while len(load.clips.deleted) == deleted and time.monotonic() < latest:
                    time.sleep(0.01)
            time.sleep(moments.uniform(0.02, 1.2))
            gone.set()
            server.stop(signal.SIGKILL)
            for thread in threads:
                thread.join()
            server = Server(store, *OPTIONS)
            try:
                load.check(server)
            except AssertionError as error:
                raise AssertionError(f"after kill {kill + 1} of {kills}, seed {seed}") from error
            left = [name for name in os.listdir(folder) if name.startswith(".motion.db.")]
            assert not left, left
        assert server.stop() == 0
    print(f"{kills} kills in {time.monotonic() - began:.0f} s; clips: {load.clips}; databases: "
          f"{load.databases}; {load.queries} queries; nothing lost, nothing corrupt")


main()
