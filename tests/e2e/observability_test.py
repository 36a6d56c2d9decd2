#!/usr/bin/python3
"""Tests the metrics, health, log and status of a real server, and the files that use them.

    observability_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import gzip
import http.client
import json
import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from prometheus_client.parser import text_string_to_metric_families

import promql
from programs import MOTIONDB, MOTIONDBD, Server, main

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "..")
DASHBOARD = os.path.join(ROOT, "deploy/grafana/motiondb.json")
RULES = os.path.join(ROOT, "deploy/prometheus/motiondb.rules.yml")
SCRAPE = os.path.join(ROOT, "deploy/prometheus/prometheus.yml")
SEVERAL = os.path.join(ROOT, "deploy/prometheus/several.yml")
OLD_STORES = os.path.join(ROOT, "tests/storage/old_stores")
PAGE = os.path.join(ROOT, "docs/metrics.md")

BVH = """HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftUpLeg
  {
    OFFSET 10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT LeftLeg
    {
      OFFSET 0 -40 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 -40 0
      }
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -10 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightLeg
    {
      OFFSET 0 -40 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 -40 0
      }
    }
  }
}
MOTION
Frames: %d
Frame Time: 0.0166667
"""


def write_walk(path, frames=90):
    """Writes a figure whose legs swing."""
    with open(path, "w") as file:
        file.write(BVH % frames)
        for i in range(frames):
            swing = 30 * (abs(i % 60 - 30) / 15 - 1)
            file.write(f"0 80 {i} 0 0 0 0 {swing} 0 0 0 0 0 {-swing} 0 0 0 0\n")


def get(address, path, method="GET"):
    """Returns status and body."""
    connection = http.client.HTTPConnection(address.removeprefix("http://"), timeout=30)
    connection.request(method, path)
    answer = connection.getresponse()
    body = answer.read().decode()
    connection.close()
    return answer.status, body


def scrape(server):
    """Returns (families by name, value of each sample by name and labels)."""
    status, text = get(server.http, "/metrics")
    assert status == 200, text
    families = {family.name: family for family in text_string_to_metric_families(text)}
    values = {(sample.name, tuple(sorted(sample.labels.items()))): sample.value
              for family in families.values() for sample in family.samples}
    return families, values


def value(values, name, **labels):
    return values.get((name, tuple(sorted(labels.items()))))


class Observability(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.log = open(self.path("log"), "w+")
        self.server = Server(self.path("motion.db"), "--http-listen", "127.0.0.1:0",
                             "--log-format", "json", "--log-level", "debug",
                             "--grace-seconds", "20", log=self.log)

    def tearDown(self):
        if self.server.process.poll() is None:
            self.server.stop()
        self.log.close()
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def log_lines(self):
        with open(self.path("log")) as log:
            return [json.loads(line) for line in log]

    def make_database(self, name="walks"):
        self.server.ask_one("create", name, "--marker-set", "source", "--min-frames", "4")
        write_walk(self.path("walk.bvh"))
        self.server.ask("ingest", name, self.path("walk.bvh"), "--label", "walk")

    def test_metrics_move_with_calls(self):
        _, before = scrape(self.server)
        self.assertEqual(value(before, "motiondb_databases"), 0)
        self.make_database()
        self.server.ask_one("recognize", "walks", self.path("walk.bvh"))
        self.assertNotEqual(self.server.run("describe", "nothing").returncode, 0)
        families, after = scrape(self.server)
        requests = "motiondb_requests_total"
        self.assertEqual(value(before, requests, method="QueryService.Recognize", code="OK"), 0)
        self.assertEqual(value(after, requests, method="QueryService.Recognize", code="OK"), 1)
        self.assertEqual(value(after, requests, method="DatabaseService.GetDatabase",
                               code="NOT_FOUND"), 1)
        self.assertEqual(value(after, "motiondb_request_seconds_count",
                               method="QueryService.Recognize"), 1)
        self.assertEqual(value(after, "motiondb_database_clips", database="walks"), 1)
        self.assertEqual(value(after, "motiondb_database_frames", database="walks"), 90)
        self.assertEqual(value(after, "motiondb_model_version", database="walks"), 1)
        self.assertEqual(value(after, "motiondb_rebuilds_total", database="walks",
                               outcome="succeeded"), 1)
        windows = "motiondb_recognized_windows_total"
        self.assertGreater(value(after, windows, database="walks", answer="uncalibrated"), 5)
        self.assertEqual(value(after, windows, database="walks", answer="known"), 0)
        self.assertEqual(value(after, windows, database="walks", answer="unknown"), 0)
        self.assertGreater(value(after, "motiondb_store_bytes"), 0)
        self.assertGreater(value(after, "motiondb_log_bytes"), 0)
        disk = os.statvfs(self.path("motion.db"))
        self.assertEqual(value(after, "motiondb_disk_bytes"), disk.f_blocks * disk.f_frsize)
        free = value(after, "motiondb_disk_free_bytes")
        self.assertTrue(0 < free < value(after, "motiondb_disk_bytes"), free)
        self.assertEqual(value(after, "motiondb_certificate_end_time_seconds"), 0)
        self.assertLess(value(after, "motiondb_model_age_seconds", database="walks"), 60)
        self.assertEqual(families["motiondb_request_seconds"].type, "histogram")
        self.assertEqual(families["motiondb_rebuild_seconds"].type, "summary")
        self.server.ask_one("delete", "walks", "--yes")
        _, deleted = scrape(self.server)
        self.assertFalse([key for key in deleted if ("database", "walks") in key[1]])

    def test_status_agrees_with_the_metrics(self):
        self.make_database()
        status = self.server.ask_one("status")
        _, values = scrape(self.server)
        [walks] = status["databases"]
        self.assertEqual(walks["clip_count"], 1)
        self.assertEqual(walks["model_version"],
                         value(values, "motiondb_model_version", database="walks"))
        self.assertEqual(walks["frame_count"],
                         value(values, "motiondb_model_frames", database="walks"))
        self.assertGreater(int(walks["stored_frame_count"]), 0)
        self.assertEqual(int(walks["stored_frame_count"]),
                         value(values, "motiondb_database_frames", database="walks"))
        self.assertEqual(int(walks["byte_count"]),
                         value(values, "motiondb_database_bytes", database="walks"))
        self.assertEqual(int(walks["succeeded_rebuild_count"]),
                         value(values, "motiondb_rebuilds_total", database="walks",
                               outcome="succeeded"))
        for method in status["methods"]:
            shown = value(values, "motiondb_request_seconds_count", method=method["method"])
            self.assertEqual(int(method["call_count"]), shown)
        ended = sum(count for (name, _), count in values.items()
                    if name == "motiondb_requests_total")
        self.assertEqual(int(status["call_count"]) + 1, ended)  # plus the status call itself
        self.assertTrue(status["serving"])
        self.assertEqual(int(status["disk_bytes"]), value(values, "motiondb_disk_bytes"))
        self.assertGreater(int(status["disk_free_bytes"]), 0)
        self.assertGreater(int(status["memory_bytes"]), 1 << 20)
        text = self.server.run("status")
        self.assertEqual(text.returncode, 0, text.stderr)
        self.assertRegex(text.stdout, r"store +[0-9.]+ KiB, log .*; [0-9.]+ \wiB of [0-9.]+ \wiB free")
        self.assertRegex(text.stdout, r"SIZE \(MiB\) +STREAMS\nwalks +1 +90 +0\.[0-9]+ +0\n")
        self.assertRegex(text.stdout, r"REBUILDS +TIME \(s\)\nwalks +1 +90 ")
        self.assertRegex(text.stdout, r"P99 \(ms\)\n(\w+\.\w+ .*\n)*ClipService.IngestClip +1 +[0-9.]+ ")
        print("\n" + text.stdout)

    def test_health(self):
        self.assertEqual(get(self.server.http, "/livez"), (200, "alive\n"))
        self.assertEqual(get(self.server.http, "/readyz"), (200, "ready\n"))
        self.assertEqual(get(self.server.http, "/metrics", "POST")[0], 405)
        self.assertEqual(get(self.server.http, "/nothing")[0], 404)

    def test_not_ready_while_draining(self):
        self.server.ask_one("create", "walks")
        # An ingest whose file never ends, until it is killed.
        pipe = self.path("walk.bvh")
        os.mkfifo(pipe)
        ingest = subprocess.Popen(
            [MOTIONDB, "--server", self.server.address, "ingest", "walks", pipe],
            stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        with open(pipe, "w") as file:
            file.write("HIERARCHY\n" + "#" * (3 << 20))
            file.flush()
            deadline = time.monotonic() + 30
            while value(scrape(self.server)[1], "motiondb_open_requests") == 0:
                self.assertLess(time.monotonic(), deadline, "the ingest does not begin")
                time.sleep(0.05)
            self.server.process.send_signal(signal.SIGTERM)
            while get(self.server.http, "/readyz")[0] == 200:
                self.assertLess(time.monotonic(), deadline, "the server does not drain")
                time.sleep(0.02)
            status, body = get(self.server.http, "/readyz")
            self.assertEqual(status, 503)
            self.assertIn("draining", body)
            self.assertEqual(get(self.server.http, "/livez")[0], 200)
            self.assertEqual(value(scrape(self.server)[1], "motiondb_serving"), 0)
            ingest.kill()
            ingest.wait()
        self.assertEqual(self.server.process.wait(timeout=60), 0)
        self.server.process.stdout.close()

    def test_every_line_of_the_log_is_json(self):
        self.make_database()
        self.server.run("describe", 'no"thing\n\x01')
        self.server.run("describe", "nothing")
        self.assertEqual(self.server.stop(), 0)
        lines = self.log_lines()
        for line in lines:
            self.assertRegex(line["time"], r"^\d{4}-\d\d-\d\dT\d\d:\d\d:\d\d\.\d{3}Z$")
            self.assertIn(line["level"], ("debug", "info", "warning", "error"))
            self.assertIsInstance(line["message"], str)
        calls = [line for line in lines if "method" in line]
        missing = [line for line in calls if line["code"] == "NOT_FOUND"]
        self.assertEqual(len(missing), 2)
        for line in missing:
            self.assertEqual(line["method"], "DatabaseService.GetDatabase")
            self.assertEqual(line["level"], "debug")
            self.assertTrue(line["peer"].startswith("ipv4:127.0.0.1:"), line)
            self.assertGreaterEqual(line["milliseconds"], 0)
        identities = [line["request_id"] for line in calls]
        self.assertEqual(len(set(identities)), len(identities))
        stored = [line for line in lines if "stored: frames=90;" in line["message"]]
        self.assertEqual(len(stored), 1)
        self.assertIn(stored[0]["request_id"], identities)

    def test_an_upgrade_of_the_store_is_logged_once(self):
        store = self.path("old.db")
        with gzip.open(os.path.join(OLD_STORES, "version1.db.gz")) as old, open(store, "wb") as new:
            new.write(old.read())
        with open(self.path("upgrade.log"), "w") as log:
            for end in (signal.SIGKILL, signal.SIGTERM, signal.SIGTERM):
                Server(store, "--http-listen", "none", "--log-level", "info", log=log).stop(end)
        with open(self.path("upgrade.log")) as log:
            logged = [line for line in log if "upgraded" in line]
        self.assertEqual(len(logged), 1, logged)
        self.assertRegex(logged[0], r"info .*old\.db upgraded from version 1 to \d+: older servers")

    def test_a_failed_start_is_json_too(self):
        failed = subprocess.run(
            [MOTIONDBD, "--store", self.path("no/folder/motion.db"), "--listen", "127.0.0.1:0",
             "--http-listen", "none", "--log-format", "json", "--log-level", "off"],
            capture_output=True, text=True)
        self.assertEqual(failed.returncode, 1)
        [line] = [json.loads(line) for line in failed.stderr.splitlines()]
        self.assertEqual(line["level"], "critical")
        self.assertIn("motion.db", line["message"])

    def test_unauthenticated_pages_are_logged_at_every_level(self):
        for listen, logged in (("0.0.0.0:0", True), ("127.0.0.1:0", False)):
            with open(self.path("open.log"), "w+") as log:
                server = Server(self.path("open.db"), "--http-listen", listen,
                                "--log-level", "off", log=log)
                self.assertEqual(server.stop(), 0)
                log.seek(0)
                self.assertEqual("no authentication" in log.read(), logged, listen)

    def test_a_closed_log_pipe_does_not_end_the_server(self):
        reader, writer = os.pipe()
        with os.fdopen(writer, "w") as log:
            server = Server(self.path("unread.db"), "--http-listen", "none",
                            "--log-level", "debug", log=log)
        os.close(reader)
        server.ask_one("create", "walks")
        self.assertEqual(server.ask_one("status")["databases"][0]["name"], "databases/walks")
        self.assertEqual(server.stop(), 0)

    def test_a_slow_call_is_a_warning(self):
        with open(self.path("slow.log"), "w") as log:
            server = Server(self.path("slow.db"), "--slow-call-seconds", "0.001",
                            "--http-listen", "none", "--log-level", "warning", log=log)
            server.ask_one("create", "walks")
            self.assertEqual(server.stop(), 0)
        with open(self.path("slow.log")) as log:
            text = log.read()
        self.assertRegex(text, r"warning slow call request_id=\S+ "
                               r"method=DatabaseService\.CreateDatabase code=OK milliseconds=")

    def test_dashboard_rules_and_page_match_exported_metrics(self):
        self.make_database()
        families, values = scrape(self.server)
        series = {}
        for name, labels in values:
            values_by_label = series.setdefault(name, {})
            for label, label_value in labels:
                values_by_label.setdefault(label, set()).add(label_value)
        expressions = dashboard_expressions() + rule_expressions()
        self.assertGreater(len(expressions), 40)
        wrong = [f"{expression}: {problem}" for expression in expressions
                 for problem in promql.problems(expression, series)]
        self.assertEqual(wrong, [])
        used = {name for expression in expressions
                for name, _ in promql.selectors(expression)} - {"up"}
        self.assertGreater(len(used), 25)
        with open(PAGE) as page:
            explained = set(re.findall(r"^\| `(\w+)` \| (?:counter|gauge|histogram|summary) \|",
                                       page.read(), re.MULTILINE))
        exported = {name + ("_total" if family.type == "counter" else "")
                    for name, family in families.items()}
        self.assertEqual(explained, exported)

    def test_promtool_accepts_what_prometheus_reads(self):
        promtool = shutil.which("promtool")
        if promtool is None:
            self.skipTest("no promtool; deploy/install_packages.sh deploy-test")
        self.make_database()
        _, text = get(self.server.http, "/metrics")
        for arguments, given in ((["check", "metrics"], text), (["check", "config", SCRAPE], None),
                                 (["check", "config", SEVERAL], None),
                                 (["check", "rules", RULES], None),
                                 (["test", "rules", RULES.replace(".yml", ".test.yml")], None)):
            checked = subprocess.run([promtool, *arguments], input=given, capture_output=True,
                                     text=True)
            self.assertEqual(checked.returncode, 0, checked.stdout + checked.stderr)

    def test_problems_of_an_expression_are_found(self):
        series = {"a_total": {"code": {"OK", "INTERNAL"}}, "b": {}}
        self.assertEqual(promql.problems('sum by (code) (rate(a_total{code="OK"}[5m])) / b', series),
                         [])
        self.assertEqual(promql.problems("rate(c_total[5m]) > 1e9", series), ["no metric c_total"])
        self.assertEqual(promql.problems('b{code="OK"}', series), ["b has no label code"])
        self.assertEqual(promql.problems('a_total{code="ok"} / a_total{code!="OK"}', series),
                         ["a_total has no code ok"])
        self.assertEqual(promql.problems('a_total{code=~"OK|(INTERNAL|DATA)", code=~"$code"}', series),
                         ["a_total has no code DATA"])
        self.assertEqual(promql.problems("sum by (method) (a_total)", series),
                         ["no metric has the label method"])


def dashboard_expressions():
    with open(DASHBOARD) as file:
        dashboard = json.load(file)
    expressions = [target["expr"] for panel in dashboard["panels"]
                   for target in panel.get("targets", [])]
    expressions += [note["expr"] for note in dashboard["annotations"]["list"] if "expr" in note]
    for variable in dashboard["templating"]["list"]:
        query = variable["query"]
        if isinstance(query, dict):  # label_values(SELECTOR, LABEL)
            selector, label = re.fullmatch(r"label_values\((.*), (\w+)\)", query["query"]).groups()
            expressions.append(f"sum by ({label}) ({selector})")
    return expressions


def rule_expressions():
    """Returns the values of the keys `expr`, on one line or as an indented block."""
    with open(RULES) as file:
        text = file.read()
    found = re.findall(r"^( *)expr: (\|\n(?:\1 +.*\n)+|.*\n)", text, re.MULTILINE)
    return [expression.lstrip("|") for _, expression in found]


if __name__ == "__main__":
    main()
