#!/usr/bin/python3
"""Two motiondbd on a PostgreSQL that stops, or hangs: what they answer, and how they recover.

    postgres_outage_test.py MOTIONDBD MOTIONDB DATA_FOLDER

MOTIONDB_POSTGRES_STOP=30 stops PostgreSQL for 30 s instead of 3 s.
"""

import base64
import json
import os
import signal
import time
import urllib.error
import urllib.request

from observability_test import get
from postgres_cluster import FOLLOWED, WithCluster, main
from programs import SLOWNESS, wait_for

STOP_SECONDS = float(os.environ.get("MOTIONDB_POSTGRES_STOP", "3"))


class Outage(WithCluster):
    @staticmethod
    def post(server, call, request):
        """Returns the status and the answer of a call of the HTTP API."""
        sent = urllib.request.Request(f"{server.web}/motiondb.v1.{call}", json.dumps(request).encode(),
                                      {"Content-Type": "application/json"})
        try:
            with urllib.request.urlopen(sent, timeout=60) as page:
                return page.status, json.load(page)
        except urllib.error.HTTPError as error:
            return error.code, json.load(error)

    def assert_unreachable(self, server):
        """Ingests, lists and filters return UNAVAILABLE with STORE_UNREACHABLE and a delay."""
        with open(self.clip(9), "rb") as stream:
            data = base64.b64encode(stream.read()).decode()
        name, file = "databases/d", {"fileName": "clip9.bvh", "data": data}
        for call, request in {
                "ClipService/UploadClip": {"header": {"parent": name, "clipId": "clip9",
                                                      "fileName": "clip9.bvh"}, "file": data},
                "ClipService/ListClips": {"parent": name},
                "QueryService/Recognize": {"database": name, "observation": {"file": file},
                                           "filter": 'label = "moves"'}}.items():
            status, answer = self.post(server, call, request)
            self.assertEqual((status, answer["code"]), (503, "unavailable"), (call, answer))
            details = {detail["type"]: detail["debug"] for detail in answer["details"]}
            self.assertEqual(details["google.rpc.ErrorInfo"]["reason"], "STORE_UNREACHABLE", call)
            delay = float(details["google.rpc.RetryInfo"]["retryDelay"].removesuffix("s"))
            self.assertGreater(delay, 0, call)
        refused = server.run("ingest", "d", self.clip(9))
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("the store postgresql:", refused.stderr)

    def assert_recovered(self, a, b):
        """Waits until both servers are ready, and a new clip is in the model of both."""
        for server in (a, b):
            wait_for(lambda: get(server.http, "/readyz")[0] == 200, 15 * SLOWNESS, "ready")
        b.ask("ingest", "d", self.clip(9))
        for server in (a, b):
            wait_for(lambda: server.ask_one("describe", "d")["clip_count"] == 5, 15 * SLOWNESS,
                     "the clip is in the model of both")

    def fill_and_query(self):
        """Returns two servers that both answer a query, the query, and their answers."""
        options = ("--web-listen", "127.0.0.1:0", "--http-listen", "127.0.0.1:0")
        servers = [self.serve(*options) for _ in range(2)]
        self.fill(servers[0])
        query = ["recognize", "d", self.clip(7, 40)]
        wait_for(lambda: servers[1].run(*query).returncode == 0, FOLLOWED, "both servers answer")
        return servers, query, [server.ask(*query) for server in servers]

    def test_postgresql_hangs(self):
        servers, query, answers = self.fill_and_query()
        a, b = servers
        self.cluster.signal_all(signal.SIGSTOP)
        try:
            began = time.monotonic()
            self.assertEqual([server.ask(*query) for server in servers], answers)
            self.assertLess(time.monotonic() - began, 3 * SLOWNESS)
            self.assertEqual(get(b.http, "/readyz")[0], 503)
            b.metric("motiondb_store_look_age_seconds")
            self.assertLess(time.monotonic() - began, 10 * SLOWNESS)
            self.assert_unreachable(b)
            self.assertEqual([server.ask(*query) for server in servers], answers)
        finally:
            self.cluster.signal_all(signal.SIGCONT)
        self.assert_recovered(a, b)

    def test_postgresql_stops(self):
        servers, query, answers = self.fill_and_query()
        a, b = servers
        self.cluster.kill()
        began = time.monotonic()
        try:
            while time.monotonic() - began < STOP_SECONDS:
                self.assertEqual([server.ask(*query) for server in servers], answers)
                self.assert_unreachable(b)
                time.sleep(1)
            self.assertGreater(a.metric("motiondb_store_look_age_seconds"), 2)
            failed = 'motiondb_store_sessions_total{outcome="failed"}'
            self.assertGreater(a.metric(failed), 0)
        finally:
            self.cluster.start()
        self.assert_recovered(a, b)
        wait_for(lambda: a.metric("motiondb_store_look_age_seconds") < 2, 15 * SLOWNESS,
                 "changes are seen again")
        wait_for(lambda: a.metric('motiondb_model_missing_revisions{database="d"}') == 0,
                 15 * SLOWNESS, "the model has all changes")
        self.assertGreaterEqual(a.metric("motiondb_store_max_readers"), 2)


if __name__ == "__main__":
    main()
