#!/usr/bin/python3
"""Tests deploy/nginx/motiondb.conf: every query through nginx with TLS and a token.

    front_test.py MOTIONDBD MOTIONDB
"""

import json
import os
import re
import shutil
import socket
import ssl
import subprocess
import sys
import tempfile
import unittest

MOTIONDBD, MOTIONDB = sys.argv[1:3]
HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77
TOKEN = "a-token-of-this-test-alone-0123456789abcdef"
sys.path.append(os.path.join(HERE, "../e2e"))
from nginx_proxy import FRONT, Nginx, WithProcesses, free_port


class WithNginx(WithProcesses):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.mkdtemp()
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.nginx = Nginx(cls.folder, [cls.start_server()])
        cls.addClassCleanup(cls.nginx.stop)

    @classmethod
    def path(cls, name):
        return os.path.join(cls.folder, name)

    @classmethod
    def run_motiondb(cls, *arguments, token=TOKEN):
        return subprocess.run([MOTIONDB, *cls.nginx.options, "--json", *arguments],
                              capture_output=True, text=True, timeout=120,
                              env={**os.environ, "MOTIONDB_TOKEN": token})


class Front(WithNginx):
    @classmethod
    def start_server(cls):
        with open(os.open(cls.path("token"), os.O_CREAT | os.O_WRONLY, 0o600), "w",
                  encoding="utf-8") as file:
            file.write(TOKEN)
        # For the server, all calls through nginx come from loopback.
        server = cls.start(MOTIONDBD, "--store", cls.path("a.db"), "--listen", "127.0.0.1:0",
                           "--authentication", "token", "--admin-token-file", cls.path("token"),
                           "--http-listen", "none", "--log-level", "error",
                           stdout=subprocess.PIPE, text=True)
        return server.stdout.readline().strip().rsplit(" ", 1)[-1]

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        for name, speed in (("walk", "1"), ("run", "2")):
            with open(cls.path(f"{name}.bvh"), "w", encoding="utf-8") as file:
                subprocess.run([os.path.join(HERE, "walk.py"), "6", speed], stdout=file, check=True)
        cls.ask("create", "demo", "--marker-set", "source", "--min-frames", "4")
        for name in ("walk", "run"):
            cls.ask("ingest", "demo", cls.path(f"{name}.bvh"), "--label", name)

    @classmethod
    def ask(cls, *arguments):
        result = cls.run_motiondb(*arguments)
        assert result.returncode == 0, f"{arguments}: {result.stderr}"
        return [json.loads(line) for line in result.stdout.splitlines()]

    def test_recognize(self):
        self.assertIn("run", json.dumps(self.ask("recognize", "demo", self.path("run.bvh"))))

    def test_estimate(self):
        self.assertTrue(self.ask("estimate", "demo", self.path("run.bvh")))

    def test_predict(self):
        self.assertTrue(self.ask("predict", "demo", self.path("run.bvh"), "--at", "2",
                                 "--horizon", "0.1,0.5"))

    def test_plan(self):
        # A goal that the short walk can reach.
        plan, = self.ask("plan", "demo", "--start", "walk@1", "--goal", "0.4,0,0",
                         "--search-seconds", "1")
        self.assertGreater(plan["motion"]["frame_count"], 1)

    def test_observe(self):
        # A stream with many messages in both directions.
        answers = self.ask("observe", "demo", self.path("run.bvh"))
        self.assertGreater(len(answers), 20)

    def test_a_large_file(self):
        # Larger than the default limit of nginx, 1 MiB.
        with open(self.path("long.bvh"), "w", encoding="utf-8") as file:
            subprocess.run([os.path.join(HERE, "walk.py"), "240", "1.3"], stdout=file, check=True)
        self.assertGreater(os.path.getsize(self.path("long.bvh")), 1 << 20)
        self.assertTrue(self.ask("recognize", "demo", self.path("long.bvh"), "--window", "all"))

    def test_errors_are_forwarded(self):
        result = self.run_motiondb("describe", "absent")
        self.assertEqual(result.returncode, 1)
        self.assertIn("absent", result.stderr)

    def test_a_wrong_token_is_refused(self):
        result = self.run_motiondb("list", token="mdb_none_of_this")
        self.assertEqual(result.returncode, 1)
        self.assertIn("token", result.stderr)

    def test_tls_and_http2(self):
        context = ssl.create_default_context(cafile=self.path("motiondb.crt"))
        context.set_alpn_protocols(["h2"])
        with socket.create_connection(("127.0.0.1", self.nginx.port)) as plain, \
                context.wrap_socket(plain, server_hostname="motion.example.org") as secured:
            self.assertEqual(secured.selected_alpn_protocol(), "h2")
            self.assertIn(secured.version(), ("TLSv1.2", "TLSv1.3"))
        with open(self.path("access.log"), encoding="utf-8") as file:
            calls = re.findall(r'"POST (/motiondb\.v1\.\S+) HTTP/2\.0" 200', file.read())
        self.assertGreaterEqual(calls.count("/motiondb.v1.ClipService/IngestClip"), 2)

    def test_other_paths_are_unimplemented(self):
        result = subprocess.run(
            ["curl", "-s", "-D-", "--http2", "--cacert", self.path("motiondb.crt"), "--resolve",
             f"motion.example.org:{self.nginx.port}:127.0.0.1",
             f"https://motion.example.org:{self.nginx.port}/other"],
            capture_output=True, text=True, check=True)
        self.assertIn("grpc-status: 12", result.stdout)


class Timeouts(unittest.TestCase):
    def test_timeouts_are_longer_than_the_idle_timeout(self):
        # The defaults of nginx, 60 s, would close idle streams that motiondbd allows.
        with open(FRONT, encoding="utf-8") as file:
            front = file.read()
        with open(os.path.join(HERE, "../../deploy/motiondbd.conf"), encoding="utf-8") as file:
            limit = int(re.search(r"^#silence-limit = (\d+)$", file.read(), re.MULTILINE).group(1))
        for setting in ("client_body_timeout", "send_timeout", "grpc_read_timeout",
                        "grpc_send_timeout", "keepalive_timeout"):
            hours = re.search(rf"^  {setting} (\d+)h;$", front, re.MULTILINE)
            self.assertTrue(hours, setting)
            self.assertGreater(3600 * int(hours.group(1)), limit, setting)


class WithoutServer(WithNginx):
    @classmethod
    def start_server(cls):
        return f"127.0.0.1:{free_port()}"

    def test_nginx_returns_a_grpc_error(self):
        result = self.run_motiondb("list")
        self.assertEqual(result.returncode, 1)
        self.assertIn("motiondbd does not respond", result.stderr)


for program in ("nginx", "openssl", "curl"):
    if not shutil.which(program, path=os.environ["PATH"] + ":/usr/sbin"):
        print(f"skipped: no {program}; deploy/install_packages.sh deploy-test")
        sys.exit(SKIPPED)
os.environ["PATH"] += ":/usr/sbin"
unittest.main(argv=sys.argv[:1])
