"""Checks of Kubernetes manifests that run motiondbd."""

import os
import re

from deploy_files import DEPLOY, IMAGE, read, settings, variable_of, yaml

# From docs/benchmarks.md: a million frames of 34 markers need 3.3 GB at the peak of a full build.
BYTES_OF_A_FRAME_BEING_BUILT = 3300

# Allowed fields of the manifests. {}: any value; a list: the schema of each element. Kubernetes
# would ignore or refuse a misspelt field, but no test has a cluster.
METADATA = {"name": {}, "labels": {}, "annotations": {}}
PROBE = {"httpGet": {"path": {}, "port": {}}, "periodSeconds": {}, "timeoutSeconds": {},
         "failureThreshold": {}, "initialDelaySeconds": {}}
CONTAINER = {
    "name": {}, "image": {}, "imagePullPolicy": {}, "args": {},
    "ports": [{"name": {}, "containerPort": {}, "protocol": {}}],
    "env": [{"name": {}, "value": {}, "valueFrom": {"secretKeyRef": {"name": {}, "key": {}},
                                                    "fieldRef": {"fieldPath": {}}}}],
    "startupProbe": PROBE, "livenessProbe": PROBE, "readinessProbe": PROBE,
    "resources": {"requests": {"cpu": {}, "memory": {}}, "limits": {"cpu": {}, "memory": {}}},
    "lifecycle": {"preStop": {"exec": {"command": {}}}},
    "securityContext": {"allowPrivilegeEscalation": {}, "readOnlyRootFilesystem": {},
                        "capabilities": {"drop": {}}},
    "volumeMounts": [{"name": {}, "mountPath": {}, "readOnly": {}}],
}
POD = {
    "enableServiceLinks": {}, "automountServiceAccountToken": {},
    "terminationGracePeriodSeconds": {},
    "topologySpreadConstraints": [{"maxSkew": {}, "topologyKey": {}, "whenUnsatisfiable": {},
                                   "labelSelector": {"matchLabels": {}}}],
    "securityContext": {"runAsNonRoot": {}, "runAsUser": {}, "runAsGroup": {}, "fsGroup": {},
                        "fsGroupChangePolicy": {}, "seccompProfile": {"type": {}}},
    "containers": [CONTAINER],
    "volumes": [{"name": {}, "configMap": {"name": {}}, "emptyDir": {},
                 "secret": {"secretName": {}, "defaultMode": {},
                            "items": [{"key": {}, "path": {}}]}}],
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
    ("apps/v1", "Deployment"): {"metadata": METADATA, "spec": {
        "replicas": {}, "selector": {"matchLabels": {}},
        "strategy": {"type": {}, "rollingUpdate": {"maxUnavailable": {}, "maxSurge": {}}},
        "template": {"metadata": METADATA, "spec": POD}}},
    ("policy/v1", "PodDisruptionBudget"): {"metadata": METADATA, "spec": {
        "maxUnavailable": {}, "selector": {"matchLabels": {}}}},
    # Of the operator CloudNativePG.
    ("postgresql.cnpg.io/v1", "Cluster"): {"metadata": METADATA, "spec": {
        "instances": {}, "minSyncReplicas": {}, "maxSyncReplicas": {},
        "bootstrap": {"initdb": {"database": {}, "owner": {}, "encoding": {}, "dataChecksums": {}}},
        "postgresql": {"parameters": {}}, "storage": {"size": {}}, "walStorage": {"size": {}}}},
}


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


def unknown_fields_of(each):
    """Returns the fields of an object that are not in SCHEMA."""
    body = {k: v for k, v in each.items() if k not in ("apiVersion", "kind")}
    return unknown_fields(body, SCHEMA[(each["apiVersion"], each["kind"])], each["kind"])


def objects_of(file):
    return list(yaml.safe_load_all(read(file)))


class Manifests:
    """Tests of one file, for a unittest.TestCase with its FILE and the KIND of the object with the pods."""

    def setUp(self):
        self.objects = objects_of(self.FILE)
        self.set = self.one(self.KIND)["spec"]
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

    def set_name(self):
        return self.one(self.KIND)["metadata"]["name"]

    def configured(self):
        return dict(re.findall(r'^([a-z-]+) = "?([^"\n]*)"?$', self.config, re.MULTILINE))

    def test_every_field_is_known(self):
        for each in self.objects:
            self.assertEqual(unknown_fields_of(each), [])

    def test_labels_join_services_and_pods(self):
        labels = self.template["metadata"]["labels"]
        for selector in [self.set["selector"]["matchLabels"],
                         *(service["spec"]["selector"] for service in self.all("Service"))]:
            self.assertTrue(selector)
            self.assertLessEqual(selector.items(), labels.items())

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
        for setting in ("tls-certificate", "tls-key", "admin-token-file"):
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
        claims = {claim["metadata"]["name"] for claim in self.set.get("volumeClaimTemplates", [])}
        self.assertEqual(set(self.mounts), volumes | claims)
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
