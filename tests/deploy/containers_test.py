#!/usr/bin/python3
"""Tests that image, compose file, manifests and settings of motiondbd agree.

    containers_test.py MOTIONDBD
"""

import json
import os
import re
import subprocess
import sys
import tempfile
import unittest

from deploy_files import DEPLOY, IMAGE, MOTIONDBD, read, settings, variable_of, yaml
from manifests import Manifests

# Secrets of a server that other machines can reach.
SECRETS = ("server.crt", "server.key", "admin-token")


def write_secrets(folder):
    """Writes a certificate, its key and an admin token, with the modes in docs/operations.md."""
    certificate, key, token = [os.path.join(folder, name) for name in SECRETS]
    subprocess.run(["openssl", "req", "-x509", "-newkey", "ec", "-pkeyopt", "ec_paramgen_curve:prime256v1",
                    "-nodes", "-days", "2", "-subj", "/CN=motiondb", "-keyout", key, "-out", certificate],
                   check=True, capture_output=True)
    with open(token, "w", encoding="ascii") as file:
        subprocess.run(["openssl", "rand", "-hex", "32"], check=True, stdout=file)
    for path in (certificate, key, token):
        os.chmod(path, 0o440)


def seconds(text):
    return int(re.fullmatch(r"(\d+)s", text).group(1))


class DockerfileTest(unittest.TestCase):
    def test_signals_user_and_stages(self):
        self.assertEqual(IMAGE.of("STOPSIGNAL"), ["SIGTERM"])
        self.assertEqual(len(IMAGE.of("HEALTHCHECK")), 1)
        self.assertEqual(IMAGE.of("ENTRYPOINT"), ['["motiondbd"]'])
        self.assertNotIn(IMAGE.user.split(":")[0], ("root", "0"))
        froms = [rest for name, rest in IMAGE.all_lines if name == "FROM"]
        self.assertEqual(froms, ["${BASE} AS build", "${BASE}"])
        self.assertIn(("ARG", "BASE=debian:bookworm-slim"), IMAGE.all_lines)

    def test_the_last_stage_has_no_compiler(self):
        installed = " ".join(IMAGE.of("RUN"))
        self.assertNotRegex(installed, r"g\+\+|gcc|cmake|-dev|install_packages")

    def test_variables_are_settings(self):
        known = {variable_of(name) for name in settings()}
        self.assertLessEqual(set(IMAGE.variables), known)

    def test_exposed_ports_are_the_listeners(self):
        listened = {int(IMAGE.variables[name].rsplit(":", 1)[1])
                    for name in ("MOTIONDBD_LISTEN", "MOTIONDBD_HTTP_LISTEN")}
        self.assertEqual(IMAGE.ports, listened)

    def test_the_volume_contains_the_store(self):
        store = re.search(r'^store = "(.*)"', read("motiondbd.conf"), re.MULTILINE).group(1)
        self.assertEqual(os.path.dirname(store), IMAGE.volume)


class ComposeTest(unittest.TestCase):
    def setUp(self):
        self.compose = yaml.safe_load(read("compose.yml"))
        self.services = self.compose["services"]

    def test_server_is_the_image(self):
        server = self.services["motiondb"]
        self.assertTrue(os.path.exists(os.path.join(DEPLOY, server["build"]["context"],
                                                    server["build"]["dockerfile"])))
        known = settings()
        self.assertLessEqual(set(server["environment"]), {variable_of(name) for name in known})
        self.assertLessEqual({word.lstrip("-") for word in server["command"]}, known)
        self.assertEqual([mount.split(":")[1] for mount in server["volumes"]], [IMAGE.volume])
        for port in server["ports"]:
            host, _, inside = port.split(":")
            self.assertEqual(host, "127.0.0.1")  # it runs with --insecure
            self.assertIn(int(inside), IMAGE.ports)
        self.assertGreater(seconds(server["stop_grace_period"]), 10)

    def serving_others(self):
        """Returns the server after the steps in the comment at the top of the file."""
        text = re.sub(r"^( *)#(?=\S)", r"\1", read("compose.yml"), flags=re.MULTILINE)
        server = yaml.safe_load(text)["services"]["motiondb"]
        mount, = [mount.split(":")[:2] for mount in server["volumes"] if mount.endswith(":ro")]
        return server["environment"], *mount

    def test_commented_settings_serve_other_machines(self):
        environment, _, mounted = self.serving_others()
        with tempfile.TemporaryDirectory() as folder:
            write_secrets(folder)
            variables = {name: value.replace(mounted, folder)
                         for name, value in {**IMAGE.variables, **environment}.items()
                         if name != "MOTIONDBD_CONFIG"}

            def check():
                return subprocess.run(
                    [MOTIONDBD, "--store", os.path.join(folder, "a.db"), "--check-config"],
                    env={**os.environ, **variables}, capture_output=True, text=True)
            checked = check()
            self.assertEqual((checked.returncode, checked.stderr), (0, ""))
            for name in SECRETS:
                with self.subTest(without=name):
                    secret = os.path.join(folder, name)
                    os.rename(secret, secret + ".away")
                    checked = check()
                    os.rename(secret + ".away", secret)
                    self.assertEqual(checked.returncode, 2)
                    self.assertIn(f"{secret}: ", checked.stderr)

    def test_operations_md_has_the_same_settings(self):
        environment, source, mounted = self.serving_others()
        readme = read("../docs/operations.md")
        command, = re.findall(r"^\$ (docker run -d .*(?:\n    .*)*)", readme, re.MULTILINE)
        self.assertEqual(dict(re.findall(r"-e (\w+)=(\S+)", command)),
                         {name: value for name, value in environment.items()
                          if value.startswith(mounted)})
        self.assertIn(f"-v {source}:{mounted}:ro", command)
        self.assertNotIn("--insecure", command)
        owners = re.findall(rf"^\$ sudo install .*-o (\d+) -g (\d+) .*{source}$", readme, re.MULTILINE)
        self.assertEqual([":".join(owner) for owner in owners], [IMAGE.user] * 2)

    def test_mounts_exist(self):
        for name, service in self.services.items():
            for mount in service["volumes"]:
                source = mount.split(":")[0]
                if source.startswith("."):
                    self.assertTrue(os.path.exists(os.path.join(DEPLOY, source)), f"{name}: {source}")
                else:
                    self.assertIn(source, self.compose["volumes"])

    def test_prometheus_scrapes_the_server(self):
        configuration = yaml.safe_load(read("prometheus/prometheus.yml"))
        targets = [target for job in configuration["scrape_configs"]
                   for group in job["static_configs"] for target in group["targets"]]
        http = IMAGE.variables["MOTIONDBD_HTTP_LISTEN"].rsplit(":", 1)[1]
        self.assertEqual(targets, [f"motiondb:{http}"])
        for rules in configuration["rule_files"]:
            yaml.safe_load(read("prometheus", rules))

    def test_grafana_uses_prometheus(self):
        source = yaml.safe_load(read("grafana/provisioning/datasources/prometheus.yml"))
        self.assertEqual([s["url"] for s in source["datasources"]], ["http://prometheus:9090"])
        provider = yaml.safe_load(read("grafana/provisioning/dashboards/motiondb.yml"))
        folder = provider["providers"][0]["options"]["path"]
        mounted = [m.split(":")[1] for m in self.services["grafana"]["volumes"]]
        self.assertIn(f"{folder}/motiondb.json", mounted)
        self.assertEqual(json.loads(read("grafana/motiondb.json"))["uid"], "motiondb")


class AlertsTest(unittest.TestCase):
    """Tests that every alert has a test case. tests/e2e/observability_test.py runs them with promtool."""

    def test_every_alert_fires_in_a_test_case(self):
        groups = yaml.safe_load(read("prometheus/motiondb.rules.yml"))["groups"]
        alerts = {rule["alert"] for group in groups for rule in group["rules"]}
        cases = [case for test in yaml.safe_load(read("prometheus/motiondb.rules.test.yml"))["tests"]
                 for case in test["alert_rule_test"]]
        self.assertGreater(len(alerts), 10)
        self.assertEqual({case["alertname"] for case in cases if case["exp_alerts"]}, alerts)


class KubernetesTest(Manifests, unittest.TestCase):
    FILE, KIND = "kubernetes/motiondb.yaml", "StatefulSet"

    def test_one_server_has_the_headless_service(self):
        headless = [s["metadata"]["name"] for s in self.all("Service")
                    if s["spec"].get("clusterIP") == "None"]
        self.assertEqual(headless, [self.set["serviceName"]])
        self.assertEqual(self.set["replicas"], 1)

    def test_operations_md_upgrades_this_container(self):
        name, container = re.search(r"set image statefulset/(\S+) (\w+)=", read("../docs/operations.md")).groups()
        self.assertEqual((name, container), (self.set_name(), self.container["name"]))

    def test_the_store_is_in_its_volume(self):
        self.assertEqual(os.path.dirname(self.configured()["store"]), self.mounts["store"])
        self.assertEqual(self.mounts["store"], IMAGE.volume)


unittest.main(argv=sys.argv[:1])
