#!/usr/bin/python3
"""A server that is killed at any moment keeps what it acknowledged, and nothing is damaged.

    kill_test.py MOTIONDBD MOTIONDB DATA_FOLDER [--kills N] [--seed S]

Ingest, deletion of clips and of databases, rebuilds and queries go on while SIGKILL comes, N times (10 if not told). After
each, a new server on the same store must verify it and have all whose making was acknowledged, nothing whose deletion was,
and nothing that nobody made.
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

# Who deletes waits for the model without the clip: models are built at once.
OPTIONS = ["--rebuild-delay", "0"]


def ask(server, *arguments):
    """Asks a server that should be well, again where the machine is so busy that it is not reached in time."""
    for _ in range(20):
        result = server.run(*arguments)
        assert server.process.poll() is None, f"the server ended: {server.process.returncode}"
        if "no motiondb server answered" not in result.stderr:
            break
    assert result.returncode == 0, f"{arguments}: {result.stdout}{result.stderr}"
    return result


class Things:
    """Clips of a database, or databases: which are to be there, and which not."""

    def __init__(self):
        self.lock = threading.Lock()
        self.tried = 0
        self.stored = set()    # acknowledged, and no deletion was begun
        self.doubtful = set()  # begun to be deleted, and not acknowledged
        self.deleted = set()   # its deletion was acknowledged
        self.made = 0          # acknowledgements
        self.cut_off = [0, 0]  # deletions that a kill cut off: that came to nothing, and that were done

    def new(self, count):
        """Names that nobody has."""
        with self.lock:
            self.tried += count
            return [f"c{number}" for number in range(self.tried - count, self.tried)]

    def keep(self, name):
        with self.lock:
            self.stored.add(name)
            self.made += 1

    def begin_deletion(self, choice):
        """One that is there, from now on perhaps; None if there are few."""
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

    def check(self, there):
        """Takes what is `there` after a kill for the truth, if it can be that."""
        assert self.stored <= there, f"lost: {sorted(self.stored - there)}"
        assert not self.deleted & there, f"came back: {sorted(self.deleted & there)}"
        strangers = there - {f"c{number}" for number in range(self.tried)}
        assert not strangers, f"nobody made: {sorted(strangers)}"
        for name in self.doubtful:
            self.cut_off[name not in there] += 1
        self.deleted |= self.doubtful - there
        self.doubtful = set()
        self.stored = set(there)

    def __str__(self):
        return (f"{self.made} made, {len(self.deleted) - self.cut_off[1]} deleted (of those cut off "
                f"{self.cut_off[1]} were done, {self.cut_off[0]} not)")


class Load:
    """What clients do to one server until it is gone, and what it acknowledged."""

    def __init__(self, folder):
        self.folder = folder
        self.clips = Things()
        self.databases = Things()
        self.queries = 0
        write_bvh(f"{folder}/query.bvh", seed=4, frames=40)

    def ingest(self, server):
        clips = self.clips.new(3)
        paths = [f"{self.folder}/{clip}.bvh" for clip in clips]
        for path, clip in zip(paths, clips):
            write_bvh(path, int(clip[1:]))
        # Each clip is printed as it is acknowledged.
        printed = server.run("--json", "ingest", "d", *paths).stdout
        for clip in clips:
            if f"/clips/{clip}\"" in printed:
                self.clips.keep(clip)
        for path in paths:
            os.remove(path)

    def create(self, server):
        """A database with the clips of a query."""
        [name] = self.databases.new(1)
        if server.run("create", name, "--marker-set", "source", "--min-frames", "4").returncode == 0:
            self.databases.keep(name)
            server.run("ingest", name, f"{self.folder}/query.bvh")

    def delete(self, server, things, choice, *where):
        name = things.begin_deletion(choice)
        if name is None:
            time.sleep(0.01)
        elif server.run("delete", "--yes", *where, name).returncode == 0:
            things.end_deletion(name)

    def query(self, server):
        if server.run("recognize", "d", f"{self.folder}/query.bvh").returncode == 0:
            self.queries += 1

    def run(self, server, seed, gone):
        """Threads that press on until `gone` is set."""
        def loop(what):
            while not gone.is_set():
                what()
        choice = random.Random(seed).choice
        whats = [lambda: self.ingest(server), lambda: self.ingest(server), lambda: self.create(server),
                 lambda: self.delete(server, self.clips, choice, "d"),
                 lambda: self.delete(server, self.clips, choice, "d"),
                 lambda: self.delete(server, self.databases, choice), lambda: self.query(server)]
        threads = [threading.Thread(target=loop, args=(what,)) for what in whats]
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
            if kill % 2:  # not before a deletion was acknowledged, however slow the machine
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
          f"{load.databases}; {load.queries} queries; nothing lost, nothing damaged")


main()
