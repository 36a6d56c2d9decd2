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

try:
    import yaml
except ImportError:
    print("skipped: no python3-yaml; deploy/install_packages.sh deploy-test")
    sys.exit(77)

MOTIONDBD = sys.argv[1]
DEPLOY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../deploy")

# From docs/benchmarks.md: a million frames of 34 markers need 3.3 GB at the peak of a full build.
BYTES_OF_A_FRAME_BEING_BUILT = 3300

# Secrets of a server that other machines can reach.
SECRETS = ("server.crt", "server.key", "admin-token")

# Allowed fields of the manifests. {}: any value; a list: the schema of each element. Kubernetes
# would ignore or refuse a misspelt field, but no test has a cluster.
METADATA = {"name": {}, "labels": {}, "annotations": {}}
PROBE = {"httpGet": {"path": {}, "port": {}}, "periodSeconds": {}, "timeoutSeconds": {},
         "failureThreshold": {}, "initialDelaySeconds": {}}
CONTAINER = {
    "name": {}, "image": {}, "imagePullPolicy": {}, "args": {},
    "ports": [{"name": {}, "containerPort": {}, "protocol": {}}],
    "env": [{"name": {}, "value": {}, "valueFrom": {}}],
    "startupProbe": PROBE, "livenessProbe": PROBE, "readinessProbe": PROBE,
    "resources": {"requests": {"cpu": {}, "memory": {}}, "limits": {"cpu": {}, "memory": {}}},
    "securityContext": {"allowPrivilegeEscalation": {}, "readOnlyRootFilesystem": {},
                        "capabilities": {"drop": {}}},
    "volumeMounts": [{"name": {}, "mountPath": {}, "readOnly": {}}],
}
POD = {
    "enableServiceLinks": {}, "automountServiceAccountToken": {},
    "terminationGracePeriodSeconds": {},
    "securityContext": {"runAsNonRoot": {}, "runAsUser": {}, "runAsGroup": {}, "fsGroup": {},
                        "fsGroupChangePolicy": {}, "seccompProfile": {"type": {}}},
    "containers": [CONTAINER],
    "volumes": [{"name": {}, "configMap": {"name": {}}, "emptyDir": {},
                 "secret": {"secretName": {}, "defaultMode": {}}}],
}
SCHEMA = {
    ("v1", "ConfigMap"): {"metadata": METADATA, "data": {}},
    ("v1", "Service"): {"metadata": METADATA, "spec": {
        "clusterIP": {}, "publishNotReadyAddresses": {}, "selector": {},
        "ports": [{"name": {}, "port": {}, "targetPort": {}, "appProtocol": {}}]}},
    ("apps/v1", "StatefulSet"): {"metadata": METADATA, "spec": {
        "serviceName": {}, "replicas": {}, "selector": {"matchLabels": {}},
        "template": {"metadata": METADATA, "spec": POD},
        "volumeClaimTemplates": [{"metadata": METADATA, "spec": {
            "accessModes": {}, "storageClassName": {},
            "resources": {"requests": {"storage": {}}}}}]}},
}


def read(*path):
    with open(os.path.join(DEPLOY, *path), encoding="utf-8") as file:
        return file.read()


def unknown_fields(value, schema, where):
    """Returns the paths of `value` that are not in `schema`."""
    if schema == {}:
        return []
    if isinstance(schema, list):
        assert isinstance(value, list), f"{where} is not a list"
        return [bad for i, member in enumerate(value)
                for bad in unknown_fields(member, schema[0], f"{where}[{i}]")]
    assert isinstance(value, dict), f"{where} is not an object"
    return [bad for name, member in value.items()
            for bad in ([f"{where}.{name}"] if name not in schema
                        else unknown_fields(member, schema[name], f"{where}.{name}"))]


def settings():
    text = subprocess.run([MOTIONDBD, "--help"], capture_output=True, text=True, check=True).stdout
    return set(re.findall(r"^ +--([a-z][-a-z]*)", text, re.MULTILINE))


def variable_of(setting):
    return "MOTIONDBD_" + setting.upper().replace("-", "_")


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


class Image:
    """The last stage of the Dockerfile."""
    def __init__(self):
        text = read("docker/Dockerfile").replace("\\\n", " ")
        last = text[text.rindex("\nFROM "):]
        self.lines = re.findall(r"^([A-Z]+) (.*)$", last, re.MULTILINE)
        self.all_lines = re.findall(r"^([A-Z]+) (.*)$", text, re.MULTILINE)
        self.variables = dict(re.findall(r"(MOTIONDBD_\w+)=(\S+)", " ".join(self.of("ENV"))))
        self.ports = {int(port) for line in self.of("EXPOSE") for port in line.split()}
        self.user, self.volume = self.of("USER")[0], self.of("VOLUME")[0]

    def of(self, instruction):
        return [rest for name, rest in self.lines if name == instruction]


IMAGE = Image()


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


class KubernetesTest(unittest.TestCase):
    def setUp(self):
        self.objects = list(yaml.safe_load_all(read("kubernetes/motiondb.yaml")))
        self.set = self.one("StatefulSet")["spec"]
        self.template = self.set["template"]
        self.pod = self.template["spec"]
        self.container, = self.pod["containers"]
        self.config = self.one("ConfigMap")["data"]["motiondbd.conf"]
        self.mounts = {m["name"]: m["mountPath"] for m in self.container["volumeMounts"]}

    def all(self, kind):
        return [o for o in self.objects if o["kind"] == kind]

    def one(self, kind):
        found, = self.all(kind)
        return found

    def configured(self):
        return dict(re.findall(r'^([a-z-]+) = "?([^"\n]*)"?$', self.config, re.MULTILINE))

    def test_every_field_is_known(self):
        for each in self.objects:
            schema = SCHEMA[(each["apiVersion"], each["kind"])]
            body = {k: v for k, v in each.items() if k not in ("apiVersion", "kind")}
            self.assertEqual(unknown_fields(body, schema, each["kind"]), [])

    def test_labels_join_services_and_pods(self):
        labels = self.template["metadata"]["labels"]
        for selector in [self.set["selector"]["matchLabels"],
                         *(service["spec"]["selector"] for service in self.all("Service"))]:
            self.assertTrue(selector)
            self.assertLessEqual(selector.items(), labels.items())
        headless = [s["metadata"]["name"] for s in self.all("Service")
                    if s["spec"].get("clusterIP") == "None"]
        self.assertEqual(headless, [self.set["serviceName"]])
        self.assertEqual(self.set["replicas"], 1)

    def test_operations_md_upgrades_this_container(self):
        name, container = re.search(r"set image statefulset/(\S+) (\w+)=", read("../docs/operations.md")).groups()
        self.assertEqual((name, container),
                         (self.one("StatefulSet")["metadata"]["name"], self.container["name"]))

    def test_ports_match_the_image(self):
        ports = {port["name"]: port["containerPort"] for port in self.container["ports"]}
        self.assertEqual(set(ports.values()), IMAGE.ports)
        for service in self.all("Service"):
            for port in service["spec"]["ports"]:
                self.assertEqual(ports[port["targetPort"]], port["port"])
        self.assertEqual(IMAGE.variables["MOTIONDBD_LISTEN"], f"0.0.0.0:{ports['grpc']}")
        self.assertEqual(IMAGE.variables["MOTIONDBD_HTTP_LISTEN"], f"0.0.0.0:{ports['http']}")
        annotations = self.template["metadata"]["annotations"]
        self.assertEqual(annotations["prometheus.io/port"], str(ports["http"]))
        for probe in ("startupProbe", "livenessProbe", "readinessProbe"):
            self.assertEqual(self.container[probe]["httpGet"]["port"], "http")

    def test_the_image_overrides_no_setting(self):
        overridden = {name for name in self.configured() if variable_of(name) in IMAGE.variables}
        self.assertEqual(overridden, set())

    def test_paths_are_pages_of_the_server(self):
        with open(os.path.join(DEPLOY, "../server/observability/health_server.cc"),
                  encoding="utf-8") as file:
            pages = set(re.findall(r'pages\["(/\w+)"\]', file.read()))
        asked = {self.container[probe]["httpGet"]["path"]
                 for probe in ("startupProbe", "livenessProbe", "readinessProbe")}
        self.assertEqual(asked, {"/livez", "/readyz"})
        asked.add(self.template["metadata"]["annotations"]["prometheus.io/path"])
        self.assertLessEqual(asked, pages)

    def test_settings_are_known_and_their_files_mounted(self):
        configured = self.configured()
        self.assertLessEqual(set(configured), settings())
        self.assertEqual(len(configured), len(self.config.strip().splitlines()))
        folders = set(self.mounts.values())
        for setting in ("tls-certificate", "tls-key", "admin-token-file", "store"):
            self.assertIn(os.path.dirname(configured[setting]), folders, setting)
        self.assertEqual(os.path.dirname(IMAGE.variables["MOTIONDBD_CONFIG"]),
                         self.mounts["configuration"])
        self.assertGreater(self.pod["terminationGracePeriodSeconds"],
                           int(configured["grace-seconds"]))

    def test_the_largest_database_fits_the_memory_limit(self):
        limit = re.fullmatch(r"(\d+)Gi", self.container["resources"]["limits"]["memory"])
        frames = int(self.configured()["max-database-frames"])
        built = frames * BYTES_OF_A_FRAME_BEING_BUILT
        self.assertLess(built, int(limit.group(1)) << 30)

    def test_every_mount_has_its_volume(self):
        volumes = {volume["name"] for volume in self.pod["volumes"]}
        claims = {claim["metadata"]["name"] for claim in self.set["volumeClaimTemplates"]}
        self.assertEqual(set(self.mounts), volumes | claims)
        self.assertEqual(self.mounts["store"], IMAGE.volume)
        for volume in self.pod["volumes"]:
            if "configMap" in volume:
                self.assertEqual(volume["configMap"]["name"], self.one("ConfigMap")["metadata"]["name"])
            if "secret" in volume:
                self.assertEqual(volume["secret"]["defaultMode"] & 0o007, 0)

    def test_the_pod_is_unprivileged(self):
        user, group = map(int, IMAGE.user.split(":"))
        context = self.pod["securityContext"]
        self.assertTrue(context["runAsNonRoot"])
        self.assertEqual((context["runAsUser"], context["runAsGroup"], context["fsGroup"]),
                         (user, group, group))
        self.assertEqual(context["seccompProfile"]["type"], "RuntimeDefault")
        context = self.container["securityContext"]
        self.assertFalse(context["allowPrivilegeEscalation"])
        self.assertTrue(context["readOnlyRootFilesystem"])
        self.assertEqual(context["capabilities"]["drop"], ["ALL"])


unittest.main(argv=sys.argv[:1])
