#!/usr/bin/python3
"""The HTTP API with clients of others: curl, @connectrpc/connect-node, and @redocly/cli for its
OpenAPI document.

    connect_test.py MOTIONDBD MOTIONDB DATA_FOLDER BUILD_FOLDER
"""

import base64
import filecmp
import gzip
import json
import os
import shutil
import struct
import subprocess
import sys
import tempfile
import unittest

import programs
import secure_server
from programs import MODELS

BUILD_FOLDER = sys.argv.pop()
HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "../.."))
WEB = ("--web-listen", "127.0.0.1:0")
OFFLINE = {"REDOCLY_TELEMETRY": "off", "REDOCLY_SUPPRESS_UPDATE_NOTICE": "true"}


def envelope(content, flags=0):
    return struct.pack(">BI", flags, len(content)) + content


def envelopes(body):
    while body:
        flags, size = struct.unpack(">BI", body[:5])
        yield flags, body[5:5 + size]
        body = body[5 + size:]


@unittest.skipUnless(shutil.which("curl"), "curl is missing")
class Curl(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def start(self, *options):
        server = programs.Server(self.path("motion.db"), *WEB, *options)
        self.addCleanup(lambda: server.process.poll() is not None or server.stop())
        return server

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def curl(self, *arguments, data=None):
        """Returns the HTTP status and the body."""
        result = subprocess.run(["curl", "-sS", "-w", "%{http_code}", *arguments],
                                input=data, capture_output=True, check=True)
        return int(result.stdout[-3:]), result.stdout[:-3]

    def post(self, url, call, request, *arguments):
        status, body = self.curl("-H", "Content-Type: application/json", "--data-binary", "@-",
                                 *arguments, f"{url}/motiondb.v1.{call}",
                                 data=json.dumps(request).encode())
        return status, json.loads(body)

    def test_create_ingest_and_query(self):
        server = self.start()
        status, answer = self.post(server.web, "DatabaseService/CreateDatabase",
                                   {"databaseId": "demo"})
        self.assertEqual((status, answer["database"]["name"]), (200, "databases/demo"))
        file = f"{MODELS}/Boxing_Toes.bvh"
        self.assertEqual(server.run("ingest", "demo", file, "--label", "boxing").returncode, 0)
        with open(file, "rb") as stream:
            data = base64.b64encode(stream.read()).decode()
        request = {"database": "databases/demo",
                   "observation": {"file": {"fileName": "a.bvh", "data": data}}}
        status, plain = self.post(server.web, "QueryService/Recognize", request)
        self.assertEqual(status, 200)
        self.assertEqual(plain["windows"][0]["labels"][0]["label"], "boxing")
        status, zipped = self.post(server.web, "QueryService/Recognize", request, "--compressed")
        self.assertEqual((status, zipped), (200, plain))
        body = gzip.compress(json.dumps(request).encode())
        status, sent = self.curl("--compressed", "-H", "Content-Type: application/json",
                                 "-H", "Content-Encoding: gzip", "--data-binary", "@-",
                                 f"{server.web}/motiondb.v1.QueryService/Recognize", data=body)
        self.assertEqual((status, json.loads(sent)), (200, plain))

        status, body = self.curl(
            "-H", "Content-Type: application/connect+json", "--data-binary", "@-",
            f"{server.web}/motiondb.v1.ClipService/ExportClip",
            data=envelope(b'{"name": "databases/demo/clips/Boxing_Toes"}'))
        parts = [(flags, json.loads(message)) for flags, message in envelopes(body)]
        self.assertEqual((status, parts[-1]), (200, (2, {})))
        with open(file, "rb") as stream:
            self.assertEqual(b"".join(base64.b64decode(part.get("fileBlock", ""))
                                      for _, part in parts), stream.read())
        status, answer = self.post(server.web, "DatabaseService/GetDatabase",
                                   {"name": "databases/none"})
        self.assertEqual((status, answer["code"]), (404, "not_found"))
        self.assertEqual(server.stop(), 0)

    def test_tls_and_tokens(self):
        authority = secure_server.Authority(self.folder.name, "ca")
        certificate, key = authority.issue("server", "motiondb")
        token = "a-token-of-the-administrator"
        with open(os.open(self.path("token"), os.O_CREAT | os.O_WRONLY, 0o600), "w") as file:
            file.write(token + "\n")
        server = secure_server.SecureServer(
            self.path("secure.db"), *WEB, "--tls-certificate", certificate, "--tls-key", key,
            "--authentication", "token", "--admin-token-file", self.path("token"))
        self.addCleanup(lambda: server.process.poll() is not None or server.stop())
        self.assertTrue(server.web.startswith("https://"))
        trusted = ("--cacert", authority.certificate)
        listing = ("DatabaseService/ListDatabases", {})
        status, answer = self.post(server.web, *listing, *trusted)
        self.assertEqual((status, answer["code"]), (401, "unauthenticated"))
        bearer = ("-H", f"Authorization: Bearer {token}")
        self.assertEqual(self.post(server.web, *listing, *trusted, *bearer)[0], 200)
        self.assertEqual(self.post(server.web, *listing, *trusted, "-H",
                                   "Authorization: Bearer wrong")[0], 401)
        status, made = self.post(server.web, "AccessService/CreateToken",
                                 {"token": {"role": "ROLE_READER"}}, *trusted, *bearer)
        self.assertEqual(status, 200)
        reader = ("-H", f"Authorization: Bearer {made['secret']}")
        self.assertEqual(self.post(server.web, *listing, *trusted, *reader)[0], 200)
        status, answer = self.post(server.web, "DatabaseService/CreateDatabase",
                                   {"databaseId": "x"}, *trusted, *reader)
        self.assertEqual((status, answer["code"]), (403, "permission_denied"))
        status, entries = self.post(server.web, "AccessService/ListAuditEntries", {}, *trusted,
                                    *bearer)
        self.assertEqual({entry["peer"] for entry in entries["entries"]}, {"127.0.0.1"})
        self.check_cookies(server.web, trusted, token)
        # Plain text at a port with TLS.
        plain = subprocess.run(["curl", "-sS", server.web.replace("https", "http")],
                               capture_output=True)
        self.assertNotEqual(plain.returncode, 0)

    def check_cookies(self, web, trusted, token):
        """The session of a browser over TLS: its cookie has no name that another host could set."""
        origin = ("-H", f"Origin: {web.rstrip('/')}")
        jar = self.path("cookies")
        status, _ = self.curl(*trusted, *origin, "-D", self.path("head"), "-c", jar,
                              "-H", "Content-Type: application/json", "--data-binary", "@-",
                              f"{web}/login", data=json.dumps({"token": token}).encode())
        self.assertEqual(status, 200)
        with open(self.path("head")) as head:
            cookies = [line for line in head if line.lower().startswith("set-cookie:")]
        self.assertEqual(len(cookies), 1)
        name, value = cookies[0].split(":", 1)[1].split(";")[0].strip().split("=", 1)
        self.assertEqual(name, "__Host-motiondb_token")
        attributes = [part.strip() for part in cookies[0].split(";")[1:]]
        self.assertEqual(attributes, ["Path=/", "HttpOnly", "SameSite=Strict", "Secure"])

        def list_databases(*arguments):
            return self.post(web, "DatabaseService/ListDatabases", {}, *trusted, "-H",
                             "Connect-Protocol-Version: 1", *arguments)

        self.assertEqual(list_databases(*origin, "-b", jar)[0], 200)
        # The name of a cookie without TLS, which any host could set.
        self.assertEqual(list_databases(*origin, "-b", f"motiondb_token={value}")[0], 401)
        plain = ("-H", f"Origin: {web.replace('https', 'http').rstrip('/')}")
        status, answer = list_databases(*plain, "-b", jar)
        self.assertEqual((status, answer["code"]), (403, "permission_denied"))

    def test_the_openapi_document(self):
        server = self.start()
        status, body = self.curl(f"{server.web}/openapi.json")
        self.assertEqual(status, 200)
        document = json.loads(body)
        self.assertEqual(document["openapi"], "3.1.0")
        recognize = document["paths"]["/motiondb.v1.QueryService/Recognize"]["post"]
        self.assertIn("application/json", recognize["requestBody"]["content"])
        self.assertNotIn("/motiondb.v1.ClipService/IngestClip", document["paths"])
        request = document["components"]["schemas"]["motiondb.v1.RecognizeRequest"]
        self.assertIn("observation", request["properties"])


class Packages(unittest.TestCase):
    """Packages of npm; skipped if they cannot be installed."""

    @classmethod
    def setUpClass(cls):
        for program in ("node", "npm", "protoc"):
            if shutil.which(program) is None:
                raise unittest.SkipTest(f"{program} is missing")
        cls.folder = os.path.join(BUILD_FOLDER, "connect")
        os.makedirs(cls.folder, exist_ok=True)
        shutil.copy(os.path.join(HERE, "connect", "client.mjs"), cls.folder)
        lock = os.path.join(cls.folder, "package-lock.json")
        wanted = os.path.join(HERE, "connect", "package-lock.json")
        if os.path.exists(lock) and filecmp.cmp(lock, wanted, shallow=False):
            return  # installed by an earlier run
        shutil.copy(os.path.join(HERE, "connect", "package.json"), cls.folder)
        shutil.copy(wanted, lock)
        installed = subprocess.run(["npm", "ci", "--silent", "--no-audit", "--no-fund",
                                    "--ignore-scripts"], cwd=cls.folder)
        if installed.returncode != 0:
            os.remove(lock)
            raise unittest.SkipTest("npm cannot install the packages")

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.server = programs.Server(os.path.join(folder.name, "motion.db"), *WEB)
        self.addCleanup(self.server.stop)

    def test_connect_node(self):
        generated = os.path.join(self.folder, "generated")
        os.makedirs(generated, exist_ok=True)
        protos = [os.path.join("motiondb/v1", name)
                  for name in os.listdir(f"{ROOT}/proto/motiondb/v1")]
        subprocess.run(["protoc", "-I", f"{ROOT}/proto", f"--es_out={generated}",
                        "--es_opt=target=js,import_extension=js", f"--plugin=protoc-gen-es={self.folder}"
                        "/node_modules/.bin/protoc-gen-es", *protos], check=True)
        for name in ("a", "b"):
            self.server.run("create", name)
        result = subprocess.run(["node", "client.mjs", generated, self.server.web],
                                cwd=self.folder, capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        answers = json.loads(result.stdout)
        self.assertEqual(set(answers), {"proto", "json", "protoGzip", "jsonGzip"})
        for name, answer in answers.items():
            with self.subTest(name):
                self.assertEqual(answer["databases"], ["databases/a", "databases/b"])
                self.assertGreater(answer["backupBytes"], 10_000)
                self.assertGreater(answer["verified"], 0)
                self.assertEqual(answer["notFound"]["code"], "NotFound")
                self.assertEqual(answer["invalid"]["code"], "InvalidArgument")
                self.assertIn("google.rpc.BadRequest", answer["invalid"]["types"])
                self.assertEqual(answer["brokenStream"]["code"], "NotFound")
                self.assertEqual(answer["clientStream"]["code"], "Unimplemented")
                self.assertIn("gRPC", answer["clientStream"]["message"])

    def test_redocly_accepts_the_openapi_document(self):
        path = os.path.join(self.folder, "openapi.json")
        subprocess.run(["curl", "-sS", "-o", path, f"{self.server.web}/openapi.json"], check=True)
        lint = subprocess.run(["node_modules/.bin/redocly", "lint", "openapi.json"],
                              cwd=self.folder, env=os.environ | OFFLINE, capture_output=True,
                              text=True)
        self.assertEqual(lint.returncode, 0, lint.stdout + lint.stderr)


if __name__ == "__main__":
    programs.main()
