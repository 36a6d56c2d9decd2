#!/usr/bin/python3
"""Tests the files for several servers: the compose file, its processes without containers, and the manifests.

    topology_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import json
import os
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

from deploy_files import DEPLOY, IMAGE, MOTIONDBD, read, settings, variable_of, yaml
from manifests import Manifests, objects_of, unknown_fields_of

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../e2e"))
from figure import write_bvh  # noqa: E402
from nginx_proxy import FRAME, WithProcesses, free_port, write_certificate  # noqa: E402
from postgres_cluster import PASSWORD, Cluster, postgres_folder  # noqa: E402
from programs import MOTIONDB  # noqa: E402

COMPOSE = yaml.safe_load(read("compose.several.yml"))
SERVICES = COMPOSE["services"]
SERVERS = [name for name in SERVICES if name.startswith("motiondb")]
SECRETS = "/srv/motiondb/secrets"
TOKEN = "a-token-of-this-test-alone-0123456789abcdef"

def until(condition, what, seconds=60):
    latest = time.monotonic() + seconds
    while not (value := condition()):
        assert time.monotonic() < latest, f"not within {seconds} s: {what}"
        time.sleep(0.1)
    return value


def targets_of_prometheus():
    configuration = yaml.safe_load(read("prometheus/several.yml"))
    return [target for job in configuration["scrape_configs"]
            for group in job["static_configs"] for target in group["targets"]]


class ComposeTest(unittest.TestCase):
    def test_three_servers_are_the_image(self):
        self.assertEqual(len(SERVERS), 3)
        for name in SERVERS:
            server = SERVICES[name]
            environment = server["environment"] | {"MOTIONDBD_ADVERTISE": f"{SERVERS[0]}:50051"}
            self.assertEqual(server | {"environment": environment}, SERVICES[SERVERS[0]])
            self.assertEqual(server["environment"]["MOTIONDBD_ADVERTISE"], f"{name}:50051")
            known = {variable_of(setting) for setting in settings()}
            self.assertLessEqual(set(server["environment"]) - {"PGPASSWORD"}, known)
            self.assertTrue(os.path.exists(os.path.join(DEPLOY, server["build"]["context"],
                                                        server["build"]["dockerfile"])))
            self.assertNotIn("ports", server)  # it has no TLS

    def test_only_loopback_is_published(self):
        for name, service in SERVICES.items():
            for port in service.get("ports", []):
                self.assertTrue(port.startswith("127.0.0.1:"), f"{name}: {port}")

    def test_mounts_exist(self):
        for name, service in SERVICES.items():
            for mount in service["volumes"]:
                source = mount.split(":")[0]
                if source.startswith("."):
                    self.assertTrue(os.path.exists(os.path.join(DEPLOY, source)), f"{name}: {source}")
                elif not source.startswith(SECRETS):
                    self.assertIn(source, COMPOSE["volumes"])

    def test_the_store_is_the_database(self):
        user, host, name = re.fullmatch(r"postgresql://(\w+)@(\w+)/(\w+)",
                                        SERVICES[SERVERS[0]]["environment"]["MOTIONDBD_STORE"]).groups()
        database = SERVICES[host]["environment"]
        self.assertEqual((database["POSTGRES_USER"], database["POSTGRES_DB"]), (user, name))
        self.assertEqual(database["POSTGRES_PASSWORD"],
                         SERVICES[SERVERS[0]]["environment"]["PGPASSWORD"])

    def test_prometheus_scrapes_all(self):
        http = IMAGE.variables["MOTIONDBD_HTTP_LISTEN"].rsplit(":", 1)[1]
        self.assertEqual(targets_of_prometheus(), [f"{name}:{http}" for name in SERVERS])
        self.assertIn("--config.file=/etc/prometheus/several.yml", SERVICES["prometheus"]["command"])


class Topology(WithProcesses):
    """The processes of the compose file on loopback, with ports and folders of the test."""

    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        os.chmod(cls.folder, 0o755)
        cls.cluster = Cluster()
        cls.addClassCleanup(cls.cluster.remove)
        cls.cluster.sql("CREATE DATABASE motiondb")
        cls.write_secrets()
        cls.servers = {name: cls.start_server(SERVICES[name]) for name in SERVERS}
        cls.front = cls.start_nginx()
        cls.prometheus = cls.start_prometheus()

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def write(cls, name, text):
        with open(cls.path(name), "w", encoding="utf-8") as file:
            file.write(text)

    @classmethod
    def write_secrets(cls):
        write_certificate(cls.path("server.key"), cls.path("server.crt"))
        cls.write("admin-token", TOKEN)
        os.chmod(cls.path("admin-token"), 0o440)

    @classmethod
    def start_server(cls, service):
        mounted, = [mount.split(":")[1] for mount in service["volumes"] if mount.startswith(SECRETS)]
        variables = {name: value.replace(mounted, cls.folder)
                     for name, value in service["environment"].items()}
        variables["MOTIONDBD_STORE"] = variables["MOTIONDBD_STORE"].replace(
            "@postgres/motiondb", f"@/motiondb?host={cls.cluster.folder.name}")
        server = cls.start(MOTIONDBD, *service["command"], stdout=subprocess.PIPE, text=True, env={
            **os.environ, **variables, "PGPASSWORD": PASSWORD, "MOTIONDBD_LISTEN": "127.0.0.1:0",
            "MOTIONDBD_HTTP_LISTEN": "127.0.0.1:0", "MOTIONDBD_LOG_LEVEL": "error"})
        server.http = server.stdout.readline().split("http://")[1].split("/")[0]
        server.address = server.stdout.readline().strip().rsplit(" ", 1)[-1]
        return server

    @classmethod
    def start_nginx(cls):
        script = SERVICES["nginx"]["command"][-1].splitlines()
        assert script.pop().startswith("exec nginx"), script
        script = "\n".join(script)
        mounts = [mount.split(":")[:2] for mount in SERVICES["nginx"]["volumes"]]
        for source, inside in mounts:
            if source.startswith("."):
                script = script.replace(f" {inside} ", f" {os.path.join(DEPLOY, source)} ")
        script = script.replace("/etc/nginx/conf.d/default.conf", cls.path("motiondb.conf"))
        subprocess.run(["sh", "-ec", script], check=True)
        with open(cls.path("motiondb.conf"), encoding="utf-8") as file:
            front = file.read()
        port = free_port()
        replaced = {inside: source.replace(SECRETS, cls.folder)
                    for source, inside in mounts if source.startswith(SECRETS)}
        replaced |= {f"server {name}:50051;": f"server {server.address};"
                     for name, server in cls.servers.items()}
        replaced["listen 443 ssl http2;"] = f"listen 127.0.0.1:{port} ssl http2;"
        for old, new in replaced.items():
            assert front.count(old) == 1, f"{old} is {front.count(old)} times in the configuration"
            front = front.replace(old, new)
        cls.write("motiondb.conf", front)
        cls.write("nginx.conf", FRAME.format(folder=cls.folder))
        command = ["nginx", "-p", cls.folder, "-e", cls.path("error.log"), "-c", cls.path("nginx.conf")]
        subprocess.run([*command, "-t", "-q"], check=True)
        cls.start(*command)
        return f"127.0.0.1:{port}"

    @classmethod
    def start_prometheus(cls):
        configuration = read("prometheus/several.yml").replace("interval: 15s", "interval: 1s")
        for target in targets_of_prometheus():
            name = target.split(":")[0]
            configuration = configuration.replace(target, cls.servers[name].http)
        cls.write("prometheus.yml", configuration)
        shutil.copy(os.path.join(DEPLOY, "prometheus/motiondb.rules.yml"), cls.folder)
        address = f"127.0.0.1:{free_port()}"
        cls.start("prometheus", f"--config.file={cls.path('prometheus.yml')}", "--log.level=error",
                  f"--storage.tsdb.path={cls.path('data')}", f"--web.listen-address={address}")
        return address

    def run_motiondb(self, *arguments):
        return subprocess.run(
            [MOTIONDB, "--server", self.front, "--tls-ca", self.path("server.crt"), "--tls-server-name",
             "motion.example.org", "--json", *arguments],
            capture_output=True, text=True, timeout=120, env={**os.environ, "MOTIONDB_TOKEN": TOKEN})

    def ask(self, *arguments):
        result = until(lambda: (ran := self.run_motiondb(*arguments)).returncode == 0 and ran,
                       arguments[0], 20)
        return [json.loads(line) for line in result.stdout.splitlines()]

    def query(self, page):
        try:
            with urllib.request.urlopen(f"http://{self.prometheus}/api/v1/{page}", timeout=10) as answer:
                return json.load(answer)["data"]
        except OSError:
            return {}

    def up(self):
        return sorted(result["value"][1] for result in self.query("query?query=up").get("result", []))

    def test_a_server_is_killed(self):
        write_bvh(self.path("walk.bvh"), 0)
        self.ask("create", "demo", "--marker-set", "source", "--min-frames", "4")
        self.ask("ingest", "demo", self.path("walk.bvh"), "--label", "walk")
        self.assertIn("walk", json.dumps(self.ask("recognize", "demo", self.path("walk.bvh"))))
        until(lambda: self.up() == ["1", "1", "1"], "Prometheus reads the metrics of all")
        rules = self.query("rules")["groups"][0]["rules"]
        self.assertIn("MotiondbStoreLag", [rule["name"] for rule in rules])
        killed = self.servers[SERVERS[1]]
        killed.send_signal(signal.SIGKILL)
        killed.wait()
        for _ in range(5):
            self.assertIn("walk", json.dumps(self.ask("recognize", "demo", self.path("walk.bvh"))))
        self.assertEqual(len(self.ask("list", "demo")), 1)
        until(lambda: self.up() == ["0", "1", "1"], "Prometheus misses the killed server")


class KubernetesTest(Manifests, unittest.TestCase):
    FILE, KIND = "kubernetes/several.yaml", "Deployment"

    def test_disruptions_leave_servers(self):
        replicas = self.set["replicas"]
        self.assertGreaterEqual(replicas, 2)
        budget = self.one("PodDisruptionBudget")["spec"]
        self.assertLess(budget["maxUnavailable"], replicas)
        self.assertEqual(budget["selector"], self.set["selector"])
        update = self.set["strategy"]
        self.assertEqual(update["type"], "RollingUpdate")
        self.assertEqual(update["rollingUpdate"], {"maxUnavailable": 0, "maxSurge": 1})
        spread, = self.pod["topologySpreadConstraints"]
        self.assertEqual(spread["labelSelector"], self.set["selector"])

    def test_calls_end_before_the_server(self):
        command, seconds = self.container["lifecycle"]["preStop"]["exec"]["command"]
        self.assertEqual(command, "sleep")
        self.assertGreater(self.pod["terminationGracePeriodSeconds"],
                           int(seconds) + int(self.configured()["grace-seconds"]))

    def test_the_store_is_from_a_secret(self):
        self.assertNotIn("store", self.configured())
        sources = {variable["name"]: variable["valueFrom"]["secretKeyRef"]
                   for variable in self.container["env"]
                   if "secretKeyRef" in variable.get("valueFrom", {})}
        self.assertEqual(set(sources), {"MOTIONDBD_STORE", "PGPASSWORD"})
        secret, = [volume["secret"] for volume in self.pod["volumes"] if volume["name"] == "store"]
        self.assertEqual({source["name"] for source in sources.values()}, {secret["secretName"]})
        keys = [source["key"] for source in sources.values()] + [item["key"] for item in secret["items"]]
        recipe = self.recipe(secret["secretName"], keys)
        url = re.search(r"url='([^']*)'", recipe).group(1)
        self.assertIn("sslmode=verify-full", url)
        self.assertIn(f"sslrootcert={self.mounts['store']}/ca.crt", url)

    def recipe(self, secret, keys):
        """Returns the command that creates a secret; it must have the keys."""
        pattern = rf"secret generic {secret} (?:.*\\\n)*.*"
        command = re.search(pattern, read(self.FILE)).group(0)
        for key in keys:
            self.assertRegex(command, rf"--from-(file|literal)={re.escape(key)}(?![\w.-])")
        return command

    def test_the_servers_reach_each_other(self):
        names = [variable["name"] for variable in self.container["env"]]
        variables = dict(zip(names, self.container["env"]))
        # Kubernetes replaces only the names of variables that stand before.
        self.assertLess(names.index("POD_IP"), names.index("MOTIONDBD_ADVERTISE"))
        self.assertEqual(variables["POD_IP"]["valueFrom"]["fieldRef"]["fieldPath"], "status.podIP")
        self.assertEqual(variables["MOTIONDBD_ADVERTISE"]["value"],
                         IMAGE.variables["MOTIONDBD_LISTEN"].replace("0.0.0.0", "$(POD_IP)"))
        configured = self.configured()
        # The certificate has the name of the service, for clients.
        self.assertIn(configured["tls-peer-name"],
                      [service["metadata"]["name"] for service in self.all("Service")])
        secret, = [volume["secret"]["secretName"] for volume in self.pod["volumes"]
                   if volume["name"] == "tls"]
        files = [configured[setting] for setting in ("tls-certificate", "tls-key", "tls-peer-ca")]
        self.assertEqual({os.path.dirname(file) for file in files}, {self.mounts["tls"]})
        self.recipe(secret, map(os.path.basename, files))

    def test_the_cluster_of_the_operator(self):
        cluster, = objects_of("kubernetes/postgresql.yaml")
        self.assertEqual(unknown_fields_of(cluster), [])
        spec = cluster["spec"]
        self.assertGreater(spec["instances"], spec["maxSyncReplicas"])
        self.assertGreaterEqual(spec["minSyncReplicas"], 1)
        # Six sessions of each server (docs/operations.md), one server more during an update.
        sessions = 6 * (self.set["replicas"] + self.set["strategy"]["rollingUpdate"]["maxSurge"])
        self.assertGreater(int(spec["postgresql"]["parameters"]["max_connections"]), 2 * sessions)


os.environ["PATH"] += ":/usr/sbin"
for program in ("nginx", "openssl", "prometheus"):
    if not shutil.which(program) or postgres_folder() is None:
        print(f"skipped: no {program} or PostgreSQL; deploy/install_packages.sh test deploy-test")
        sys.exit(77)
unittest.main(argv=sys.argv[:1])
