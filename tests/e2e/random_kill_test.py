#!/usr/bin/python3
"""Three servers on one PostgreSQL under load, one of the four killed at random, again and again.

    random_kill_test.py MOTIONDBD MOTIONDB DATA_FOLDER

MOTIONDB_KILLS: number of kills, default 5; MOTIONDB_SEED: of their choice, default 1.

Clients ingest, edit labels, query, wait and list. They send what failed to another server. No acknowledged change may
be lost, no version of a model may have two contents, no answer may be wrong, and all errors must be documented ones.
"""

import base64
import collections
import json
import os
import random
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time

from figure import write_bvh
from postgres_cluster import Cluster, postgres_folder
from programs import SLOWNESS, Server
from several_servers_client import CallError, Client, ServerGone

KILLS = int(os.environ.get("MOTIONDB_KILLS", "5"))
SEED = int(os.environ.get("MOTIONDB_SEED", "1"))
PATIENCE = 60 * SLOWNESS
SERVERS = 3
EDITED = 4  # clips of the database of edits
API = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../docs/api.md")
# Calibrations of a model that is not stored yet: its version is that of the last stored one.
NOT_STORED = {"CALIBRATION_PREVIOUS", "CALIBRATION_TYPICAL"}


def label_of(seed):
    return "steps" if seed % 2 == 0 else "sits"


def frames_of(seed):
    return 40 + seed % 17


def file_of(folder, seed):
    """The bytes of a motion file, in base64."""
    path = os.path.join(folder, f"{threading.get_ident()}.bvh")
    write_bvh(path, seed, frames_of(seed))
    with open(path, "rb") as file:
        return base64.b64encode(file.read()).decode()


def observation_of(file):
    return {"file": {"fileName": "a.bvh", "data": file}}


class Servers:
    """The servers and PostgreSQL."""

    def __init__(self, folder):
        self.folder = folder
        self.cluster = Cluster()
        self.running = [self.start(i) for i in range(SERVERS)]
        self.kills = collections.Counter()

    def start(self, number):
        """A server that is started again has other ports: another program can have taken the former ones."""
        with open(os.path.join(self.folder, f"log{number}"), "a", encoding="utf-8") as log:
            server = Server(self.cluster.url(), "--log-level", "info", "--http-listen", "none",
                            "--web-listen", "127.0.0.1:0", log=log)
        assert server.web and server.process.poll() is None, f"server {number} does not start: {self.log(number)}"
        return server

    def log(self, number):
        with open(os.path.join(self.folder, f"log{number}"), encoding="utf-8") as log:
            return log.read()[-5000:]

    def addresses(self):
        return [server.web for server in self.running]

    def kill(self, chance):
        """Kills one of the four, and starts it again soon."""
        victim = chance.randrange(SERVERS + 1)
        if victim == SERVERS:
            hard = chance.random() < 0.5
            self.cluster.kill(signal.SIGKILL if hard else signal.SIGQUIT)
            self.kills["PostgreSQL by SIGKILL" if hard else "PostgreSQL immediately"] += 1
            time.sleep(chance.uniform(0, 1.5))
            self.cluster.start()
        else:
            self.running[victim].stop(signal.SIGKILL)
            self.kills["server"] += 1
            time.sleep(chance.uniform(0, 1.5))
            self.running[victim] = self.start(victim)

    def models(self):
        """The stored models: (database, version, content). Empty while PostgreSQL is killed."""
        found = subprocess.run(
            ["psql", self.cluster.url(), "-qtAc",
             "SELECT database.name, version, create_time_us, frame_count, clip_count FROM model "
             "JOIN database USING (database_key) WHERE staged = 0"],
            capture_output=True, text=True).stdout
        rows = [line.split("|") for line in found.split()]
        return [(row[0], int(row[1]), tuple(row[2:])) for row in rows]

    def stop(self):
        for server in self.running:
            if server.process.poll() is None:
                server.stop(signal.SIGKILL)
        self.cluster.remove()


class Versions:
    """Contents of the versions of models, which must never change. Thread-safe."""

    def __init__(self):
        self.lock = threading.Lock()
        self.contents = {}

    def note(self, kind, database, version, content):
        with self.lock:
            known = self.contents.setdefault((kind, database, version), content)
        assert known == content, f"two models {version} of {database}: {known}, {content}"


class Load:
    """The clients, what they know to be stored, and what they have seen."""

    def __init__(self, folder, servers):
        self.folder = folder
        self.servers = servers
        self.versions = Versions()
        self.errors = collections.Counter()
        self.lock = threading.Lock()
        self.next_seed = 0
        self.stored = {}      # frames of each acknowledged clip by its id
        self.labels = {}      # acknowledged labels of the database of edits, by clip
        self.doubtful = {}    # labels that were sent after those
        self.calls = collections.Counter()
        self.failures = []
        self.ends = threading.Event()

    def client(self, seed):
        return Client(self.servers.addresses, random.Random(SEED * 1000 + seed), self.errors,
                      PATIENCE)

    def upload(self, client, database, clip, label, file):
        """Stores a clip. Returns its operation, or None if only a repeated call had it stored."""
        header = {"parent": f"databases/{database}", "fileName": f"{clip}.bvh", "clipId": clip,
                  "label": label}
        try:
            return client.call("ClipService/UploadClip", {"header": header, "file": file})["operation"]
        except CallError as error:
            # The call was stored, and its acknowledgement was lost.
            same = f"databases/{database}/clips/{clip}"
            is_same = error.reason == "CLIP_EXISTS" or error.metadata.get("clip") in (clip, same)
            if not (client.retried and error.code == "already_exists" and is_same):
                raise
            return None

    def ingest(self, client, database="d"):
        with self.lock:
            seed = self.next_seed
            self.next_seed += 1
        operation = self.upload(client, database, f"c{seed}", label_of(seed),
                                file_of(self.folder, seed))
        with self.lock:
            self.stored[f"c{seed}"] = frames_of(seed)
        # Another server lists it immediately.
        clip = client.call("ClipService/GetClip", {"name": f"databases/{database}/clips/c{seed}"})
        assert clip["clip"]["frameCount"] == frames_of(seed), clip
        if operation is not None and seed % 4 == 0:
            waited = client.call("OperationService/WaitOperation",
                                 {"name": operation["name"], "timeout": "10s"})["operation"]
            assert "error" not in waited, f"a build has failed: {waited}"

    def query(self, client, seed=None):
        """A stored motion is recognized, before and after it is in the model."""
        if seed is None:
            with self.lock:
                seed = client.chance.randrange(min(self.next_seed, 50))
        answer = client.call("QueryService/Recognize", {
            "database": "databases/d", "whole": True, "topCount": 1,
            "observation": observation_of(file_of(self.folder, seed))})
        label = answer["windows"][0]["labels"][0]["label"]
        assert label == label_of(seed), f"clip c{seed} is {label}: {answer}"

    def edit(self, client):
        """Changes a label. The next answer of any server has it, and no other one."""
        clip = client.chance.randrange(EDITED)
        label = f"label{self.calls['edit']}"
        name = f"databases/edits/clips/c{clip}"
        self.doubtful[clip] = label
        edited = client.call("ClipService/UpdateClip",
                             {"clip": {"name": name, "label": label}, "updateMask": "label"})
        self.labels[clip] = label
        revision = edited.get("revision")
        if not revision:  # a repeated call changed nothing
            return
        answer = client.call("QueryService/Recognize", {
            "database": "databases/edits", "whole": True, "topCount": 1, "minRevision": revision,
            "observation": observation_of(file_of(self.folder, clip))})
        best = answer["windows"][0]["clips"][0]
        assert (best["clip"], best["label"]) == (name, label), f"not {label} of {name}: {answer}"
        assert int(answer["revision"]) >= int(revision), f"{revision}: {answer}"

    def list(self, client):
        with self.lock:
            stored = dict(self.stored)
        self.check_clips(stored, lambda request: client.call("ClipService/ListClips", request))

    @staticmethod
    def check_clips(stored, ask):
        listed, token = {}, ""
        while True:
            page = ask({"parent": "databases/d", "pageSize": 1000, "pageToken": token})
            listed |= {clip["name"].split("/")[-1]: clip["frameCount"] for clip in page["clips"]}
            token = page.get("nextPageToken", "")
            if not token:
                break
        wrong = {clip: frames for clip, frames in stored.items() if listed.get(clip) != frames}
        assert not wrong, f"acknowledged, but not listed: {wrong}"
        return listed

    def observe(self, client):
        """A version that any server serves at any time has one content."""
        for address in self.servers.addresses():
            for database in ("d", "edits"):
                try:
                    self.statistics(client, address, database)
                except (CallError, ServerGone):
                    continue  # killed, or PostgreSQL is
        for database, version, content in self.servers.models():
            self.versions.note("stored", database, version, content)
        time.sleep(0.1)

    def statistics(self, client, address, database):
        """Notes what a server serves, and returns it."""
        found = client.post(address, "DatabaseService/GetDatabase", {
            "name": f"databases/{database}", "view": "DATABASE_VIEW_FULL"})["database"]
        model = found.get("statistics", {})
        if model.get("modelVersion") and model["calibration"] not in NOT_STORED:
            content = tuple(json.dumps(model.get(field)) for field in (
                "frameCount", "clipCount", "nodesPerLayer", "buildSeconds", "addedClipCount"))
            self.versions.note("served", database, model["modelVersion"], content)
        return model

    def run(self):
        def loop(name, seed, pause, action):
            client = self.client(seed)
            try:
                while not self.ends.is_set() and not self.failures:
                    action(client)
                    self.calls[name] += 1
                    time.sleep(client.chance.uniform(0, pause))
            except Exception as failure:  # reported by the main thread
                self.failures.append(failure)
        actions = [("ingest", 1.5, self.ingest), ("ingest", 1.5, self.ingest), ("query", 0.3, self.query),
                   ("query", 0.3, self.query), ("edit", 0.5, self.edit), ("list", 1, self.list),
                   ("observe", 0.2, self.observe)]
        self.threads = [threading.Thread(target=loop, args=(name, seed, pause, action), daemon=True)
                        for seed, (name, pause, action) in enumerate(actions)]
        for thread in self.threads:
            thread.start()

    def stop(self):
        self.ends.set()
        for thread in self.threads:
            thread.join()
        self.check()

    def check(self):
        if self.failures:
            raise self.failures[0]


def documented(error):
    """Whether docs/api.md has the code and the reason of an error."""
    code, reason = error
    if code == "no answer":
        return True
    with open(API, encoding="utf-8") as file:
        words = set(re.findall(r"\b[A-Z][A-Z_]+\b", file.read()))
    return code.upper() in words and reason in words and code not in ("internal", "unknown", "data_loss")


def until(condition, what):
    latest = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < latest, f"not within {PATIENCE} s: {what}"
        time.sleep(0.1)


def fill(load):
    client = load.client(99)
    for database in ("d", "edits"):
        client.call("DatabaseService/CreateDatabase", {
            "databaseId": database, "database": {"markerSet": "source", "minFrames": 4}})
    for clip in range(EDITED):
        load.labels[clip] = load.doubtful[clip] = label_of(clip)
        operation = load.upload(client, "edits", f"c{clip}", label_of(clip), file_of(load.folder, clip))
        load.ingest(client)
    client.call("OperationService/WaitOperation", {"name": operation["name"], "timeout": "20s"})
    until(lambda: serves(load, client, "d", EDITED) and serves(load, client, "edits", EDITED),
          "all servers have the first models")


def serves(load, client, database, clips):
    """Whether all servers serve one stored model with so many clips."""
    models = [load.statistics(client, address, database) for address in load.servers.addresses()]
    return (len({model.get("modelVersion") for model in models}) == 1
            and all(model.get("clipCount") == clips and model["calibration"] not in NOT_STORED
                    for model in models))


def check_all(load):
    """Compares all servers with what was acknowledged."""
    client = load.client(98)
    # A build that a killed server had not requested waits for the next change.
    load.ingest(client)
    for clip, label in load.labels.items():
        labels = {client.post(address, "ClipService/GetClip", {
            "name": f"databases/edits/clips/c{clip}"})["clip"]["label"]
                  for address in load.servers.addresses()}
        assert len(labels) == 1 and labels <= {label, load.doubtful[clip]}, (clip, labels, label)
    sizes = set()
    for address in load.servers.addresses():
        listed = load.check_clips(load.stored, lambda request, address=address: client.post(
            address, "ClipService/ListClips", request))
        sizes.add(len(listed))
    assert len(sizes) == 1, sizes
    until(lambda: serves(load, client, "d", max(sizes)), "all servers have all clips in the model")
    for seed in client.chance.sample(range(load.next_seed), min(load.next_seed, 20)):
        for address in load.servers.addresses():
            found = client.post(address, "QueryService/Find", {
                "database": "databases/d", "topCount": 1, "exhaustive": True,
                "observation": observation_of(file_of(load.folder, seed))})
            assert found["matches"][0]["clip"] == f"databases/d/clips/c{seed}", (seed, found)


def main():
    if postgres_folder() is None:
        print("skipped: PostgreSQL is not installed (deploy/install_packages.sh test)")
        sys.exit(1 if "MOTIONDB_REQUIRE_POSTGRES" in os.environ else 0)
    chance = random.Random(SEED)
    began = time.monotonic()
    with tempfile.TemporaryDirectory() as folder:
        servers = Servers(folder)
        try:
            load = Load(folder, servers)
            fill(load)
            load.run()
            for kill in range(KILLS):
                time.sleep(chance.uniform(0.3, 2) * SLOWNESS)
                servers.kill(chance)
                load.check()
                print(f"{kill + 1} of {KILLS} kills, {len(load.stored)} clips", file=sys.stderr, flush=True)
            time.sleep(2 * SLOWNESS)
            load.stop()
            check_all(load)
            undocumented = [error for error in load.errors if not documented(error)]
            assert not undocumented, f"{undocumented} of {load.errors}"
        except BaseException:
            for number in range(SERVERS):
                print(f"log of server {number}:\n{servers.log(number)}", file=sys.stderr)
            print(f"seed {SEED}; kills: {dict(servers.kills)}", file=sys.stderr)
            raise
        finally:
            servers.stop()
    print(f"{KILLS} kills in {time.monotonic() - began:.0f} s: {dict(servers.kills)}\n"
          f"calls: {dict(load.calls)}; {len(load.stored)} clips, "
          f"{len(load.versions.contents)} contents of versions\nerrors: {dict(load.errors)}")


main()
