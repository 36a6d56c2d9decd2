#!/usr/bin/python3
"""Costs of several servers on one PostgreSQL, for docs/capacity.md: servers at rest, changes, notifications, and the
size of the store. Prints tables. The processor times need no idle machine. It takes about eight minutes.

    several_servers_cost.py MOTIONDBD MOTIONDB DATA_FOLDER [SECONDS]
"""

import glob
import os
import re
import signal
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../e2e"))
from figure import write_bvh  # noqa: E402
from postgres_cluster import PASSWORD, Cluster  # noqa: E402
from programs import DATA, Server  # noqa: E402

SECONDS = float(sys.argv[4]) if len(sys.argv) > 4 else 20
EDITS = 100
CLIPS = 1000
NOTIFICATIONS = 2000


def processor_seconds(process_id):
    """Processor time of the threads of a process."""
    total = 0
    for thread in glob.glob(f"/proc/{process_id}/task/*/schedstat"):
        with open(thread, encoding="ascii") as file:
            total += int(file.read().split()[0])
    return total / 1e9


def children_of(process_id):
    with open(f"/proc/{process_id}/task/{process_id}/children", encoding="ascii") as file:
        return file.read().split()


class Bench:
    def __init__(self, folder):
        self.folder = folder
        self.cluster = Cluster("listen_addresses=127.0.0.1", "max_connections=1100", "shared_buffers=256MB",
                               "fsync=on")
        self.servers = []

    def url(self):
        return f"postgresql://motiondb:{PASSWORD}@127.0.0.1/postgres"

    def sql(self, query):
        return subprocess.run(["psql", self.url(), "-qtAc", query], check=True, capture_output=True,
                              text=True).stdout.strip()

    def serve(self, count):
        while len(self.servers) > count:
            self.servers.pop().stop()
        while len(self.servers) < count:
            self.servers.append(Server(self.url(), "--http-listen", "none"))

    def transferred(self):
        """Bytes that PostgreSQL has received and sent on its open connections."""
        text = subprocess.run(["ss", "-tinH", "sport", "=", ":5432"], check=True, capture_output=True, text=True).stdout
        return [sum(map(int, re.findall(rf"\b{name}:(\d+)", text))) for name in ("bytes_received", "bytes_sent")]

    def snapshot(self):
        return {"time": time.monotonic(),
                "transactions": int(self.sql("SELECT sum(xact_commit) FROM pg_stat_database")),
                # Of all sessions that exist before and after; those of psql are not counted.
                "postgres": sum(map(processor_seconds, children_of(self.cluster.process.pid))),
                "servers": sum(processor_seconds(server.process.pid) for server in self.servers),
                "received": self.transferred()[0], "sent": self.transferred()[1]}

    def during(self, action):
        time.sleep(3)  # statistics of PostgreSQL are up to a second old
        before = self.snapshot()
        action()
        time.sleep(2)
        after = self.snapshot()
        return {name: after[name] - before[name] for name in before}

    def at_rest(self):
        print("servers at rest, for each server and second:\n"
              "| servers | databases | transactions | ms of PostgreSQL | ms of the server | bytes to / from PostgreSQL |")
        databases = 0
        for wanted in (1, 10, 100):
            self.serve(1)
            for databases in range(databases, wanted):
                self.servers[0].ask_one("create", f"d{databases}", "--marker-set", "source", "--min-frames", "4")
            databases = wanted
            for count in (1, 4):
                self.serve(count)
                cost = self.during(lambda: time.sleep(SECONDS))
                each = count * cost["time"]
                print(f"| {count} | {wanted} | {cost['transactions'] / each:.2f} | {1e3 * cost['postgres'] / each:.2f} | "
                      f"{1e3 * cost['servers'] / each:.2f} | {cost['received'] / each:.0f} / {cost['sent'] / each:.0f} |",
                      flush=True)

    def changes(self):
        """Title changes, which need no build, by one client on the first server."""
        print("a changed title, beyond the cost at rest:\n"
              "| clips | servers | ms for the client | transactions | ms of PostgreSQL | ms of all servers | "
              "bytes to / from PostgreSQL |")
        clips = 0
        for wanted, count in ((1, 1), (1, 2), (1, 4), (1, 8), (CLIPS, 1), (CLIPS, 8)):
            self.serve(1)
            if wanted > clips:
                paths = [os.path.join(self.folder, f"clip{seed}.bvh") for seed in range(clips, wanted)]
                for seed, path in enumerate(paths, clips):
                    write_bvh(path, seed)
                self.servers[0].ask("ingest", "d0", *paths)
                clips = wanted
            self.serve(count)
            idle = self.during(lambda: time.sleep(SECONDS))

            def edit():
                for i in range(EDITS):
                    self.servers[0].ask("update", "d0", "clip0", "--title", f"{wanted} {count} {i}")
                    time.sleep(0.1)
            cost = self.during(edit)
            spent = cost["time"]
            for name, value in idle.items():
                if name != "time":
                    cost[name] = (cost[name] - value * spent / idle["time"]) / EDITS
            print(f"| {clips} | {count} | {1e3 * (spent - 2) / EDITS - 100:.0f} | {cost['transactions']:.1f} | "
                  f"{1e3 * cost['postgres']:.2f} | {1e3 * cost['servers']:.2f} | "
                  f"{cost['received']:.0f} / {cost['sent']:.0f} |", flush=True)
        self.serve(0)

    def notifications(self):
        script = os.path.join(self.folder, "notify.sql")
        with open(script, "w", encoding="ascii") as file:
            file.write("SELECT pg_notify('bench', '7 name');\n")
        print("a notification, sent one after the other:\n| listeners | ms for the sender | ms of PostgreSQL |")
        listeners = []
        for count in (0, 10, 100, 300, 1000):
            while len(listeners) < count:
                listener = subprocess.Popen(["psql", self.url(), "-q"], stdin=subprocess.PIPE, text=True,
                                            stdout=subprocess.DEVNULL)
                listener.stdin.write("LISTEN bench;\n")
                listener.stdin.flush()
                listeners.append(listener)
            while int(self.sql("SELECT count(*) FROM pg_stat_activity WHERE query LIKE 'LISTEN bench%'")) < count:
                time.sleep(0.2)
            some = max(100, NOTIFICATIONS // max(1, count // 10))
            result = {}

            def send():
                result["text"] = subprocess.run(["pgbench", "-n", "-f", script, "-t", str(some), self.url()], check=True,
                                                capture_output=True, text=True).stdout
            cost = self.during(send)
            latency = re.search(r"latency average = ([0-9.]+) ms", result["text"]).group(1)
            print(f"| {count} | {latency} | {1e3 * cost['postgres'] / some:.2f} |", flush=True)
        for listener in listeners:
            listener.kill()

    def size(self):
        """Recorded clips with their files and the model."""
        self.serve(1)
        self.servers[0].ask_one("create", "sized")
        files = sorted(glob.glob(f"{DATA}/cmu/**/*.amc", recursive=True))[:60]
        if not files:
            print(f"no recorded motion in {DATA}")
            return
        began = time.monotonic()
        self.servers[0].ask("ingest", "sized", *files)
        frames = sum(clip["frame_count"] for clip in self.servers[0].ask("list", "sized"))
        print(f"{len(files)} AMC files, {frames} frames, {time.monotonic() - began:.1f} s with the build; bytes of a frame:")
        print(self.sql(
            f"SELECT relname, round(pg_total_relation_size(oid) / {frames}.0) FROM pg_class WHERE relkind = 'r' "
            f"AND pg_total_relation_size(oid) > 5 * {frames} AND relnamespace = 'public'::regnamespace ORDER BY 2 DESC"))

    def run(self):
        try:
            self.at_rest()
            self.changes()
            self.notifications()
            self.size()
        finally:
            for server in self.servers:
                if server.process.poll() is None:
                    server.stop(signal.SIGKILL)
            self.cluster.remove()


if __name__ == "__main__":
    with tempfile.TemporaryDirectory() as temporary:
        Bench(temporary).run()
