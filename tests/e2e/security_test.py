"""Tests motiondbd with TLS and tokens, as set up by an operator, and motiondb as its users call
it."""

import json
import os
import subprocess
import tempfile
import time
import unittest
import urllib.request

import programs
from figure import write_bvh
from secure_server import Authority, SecureServer


class SecurityTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.store = self.path("motion.db")
        self.server = None
        write_bvh(self.path("swing.bvh"), seed=2, frames=60)

    def tearDown(self):
        self.stop()
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def start(self, *flags, **options):
        self.stop()
        self.server = SecureServer(self.store, *flags, **options)

    def stop(self):
        if self.server is not None:
            self.assertEqual(self.server.stop(), 0)
        self.server = None

    def ok(self, *arguments, **options):
        result = self.server.run(*arguments, **options)
        self.assertEqual(result.returncode, 0, f"{arguments}: {result.stderr}")
        return result.stdout

    def refused(self, *arguments, **options):
        result = self.server.run(*arguments, **options)
        self.assertEqual(result.returncode, 1, f"{arguments}: {result.stdout}")
        return result.stderr

    def start_fails(self, *flags, listen="127.0.0.1:0"):
        result = subprocess.run(
            [programs.MOTIONDBD, "--store", self.store, "--listen", listen, *flags],
            capture_output=True, text=True, timeout=60)
        self.assertEqual(result.returncode, 2)  # a wrong setting: a supervisor must not retry
        self.assertEqual(result.stdout, "")
        return result.stderr

    def make_store(self):
        """On loopback every caller is an administrator: creates the database and the first
        tokens."""
        self.start()
        self.ok("create", "swings", "--marker-set", "source", "--min-frames", "4")
        self.ok("ingest", "swings", self.path("swing.bvh"), "--label", "swing")
        self.ok("create", "others")
        make = lambda *flags: self.ok("token", "create", *flags).strip()
        self.reader = make("--role", "reader", "--database", "swings", "--expires", "1h")
        self.stranger = make("--role", "reader", "--database", "others")
        self.admin = make("--role", "admin", "--description", "first")

    def test_tokens_and_tls(self):
        self.make_store()
        authority = Authority(self.folder.name, "authority")
        certificate, key = authority.issue("server", "localhost")
        self.start("--tls-certificate", certificate, "--tls-key", key, listen="0.0.0.0:0")
        port = self.server.address.rsplit(":", 1)[1]
        self.server.address = "localhost:" + port
        by_tls = ["--tls-ca", authority.certificate]
        recognize = ["recognize", "swings", self.path("swing.bvh")]

        self.assertIn("swing", self.ok(*recognize, token=self.reader, flags=by_tls))
        self.assertIn("a token is needed", self.refused(*recognize, flags=by_tls))
        self.assertIn("not one of this server's",
                      self.refused(*recognize, token=self.reader[:-1] + "x", flags=by_tls))
        self.assertIn("valid for databases/others only",
                      self.refused(*recognize, token=self.stranger, flags=by_tls))
        self.assertIn("needs the role admin",
                      self.refused("delete", "swings", "--yes", token=self.reader, flags=by_tls))
        # `list` shows only the databases that the token is valid for.
        self.assertIn("swings", self.ok("list", token=self.reader, flags=by_tls))
        self.assertNotIn("swings", self.ok("list", token=self.stranger, flags=by_tls))
        # Plain text is not answered, and no token is sent.
        self.assertIn("no motiondb server answered",
                      self.refused("list", address="127.0.0.1:" + port))
        self.assertIn("plain text", self.refused("list", token=self.reader,
                                                 address="robot.example:" + port))

        listed = [json.loads(line) for line in
                  self.ok("token", "list", "--json", token=self.admin, flags=by_tls).splitlines()]
        self.assertEqual(len(listed), 3)
        # A whole token is accepted too: its secret stays in the command line program.
        revoked = self.ok("token", "revoke", self.reader, token=self.admin, flags=by_tls)
        self.assertEqual(revoked, "revoked " + listed[0]["name"] + "\n")
        self.assertIn("was revoked", self.refused(*recognize, token=self.reader, flags=by_tls))

        audit = self.ok("audit", token=self.admin, flags=by_tls)
        for part in ("AccessService.RevokeToken", "DatabaseService.DeleteDatabase",
                     "PERMISSION_DENIED", "127.0.0.1", "ClipService.IngestClip", "anonymous"):
            self.assertIn(part, audit)

        # No secret is in the log or in the store's files.
        self.stop()
        secrets = [token.rsplit("_", 1)[1]
                   for token in (self.reader, self.stranger, self.admin)]
        for name in os.listdir(self.folder.name):
            with open(self.path(name), "rb") as file:
                contents = file.read()
            for secret in secrets:
                self.assertNotIn(secret.encode(), contents, name)
        with open(self.store + ".log") as log:
            self.assertIn("wrong token", log.read())

    def test_certificates_are_replaced_while_the_server_runs(self):
        first = Authority(self.folder.name, "first")
        second = Authority(self.folder.name, "second")
        certificate, key = first.issue("server", "localhost")
        self.start("--tls-certificate", certificate, "--tls-key", key)
        self.ok("list", flags=["--tls-ca", first.certificate])
        self.assertIn("second.crt", self.refused("list", flags=["--tls-ca", second.certificate]))

        # A pair that does not match: the server logs this and keeps the old pair.
        with open(key) as file:
            good_key = file.read()
        with open(key, "w") as file, open(second.key) as other:
            file.write(other.read())
        self.wait_for_log("is not the key of the certificate")
        self.ok("list", flags=["--tls-ca", first.certificate])
        with open(key, "w") as file:
            file.write(good_key)

        second.issue("server", "localhost")
        self.wait_for_log("reloaded certificates")
        deadline = time.time() + 20
        while self.server.run("list", flags=["--tls-ca", second.certificate]).returncode != 0:
            self.assertLess(time.time(), deadline)
        self.refused("list", flags=["--tls-ca", first.certificate])

    def wait_for_log(self, text):
        deadline = time.time() + 20
        while text not in self.server.log():
            self.assertLess(time.time(), deadline, self.server.log())
            time.sleep(0.1)

    def test_mutual_tls(self):
        authority = Authority(self.folder.name, "authority")
        clients = Authority(self.folder.name, "clients")
        certificate, key = authority.issue("server", "storage-7", "DNS:storage-7")
        robot, robot_key = clients.issue("robot", "robot-7")
        stranger, stranger_key = authority.issue("stranger", "robot-7")
        self.start("--tls-certificate", certificate, "--tls-key", key,
                   "--tls-client-ca", clients.certificate, "--authentication", "token",
                   "--certificate-role", "admin")
        trust = ["--tls-ca", authority.certificate, "--tls-server-name", "storage-7"]
        client_flags = [*trust, "--tls-certificate", robot, "--tls-key", robot_key]
        self.ok("create", "swings", flags=client_flags)
        self.assertIn("certificate:robot-7", self.ok("audit", flags=client_flags))
        self.refused("list", flags=trust)
        self.refused("list", flags=[*trust, "--tls-certificate", stranger, "--tls-key",
                                    stranger_key])
        # The name in the server's certificate is checked.
        self.assertIn("certificate is not for ", self.refused("list", flags=client_flags[:2] + client_flags[4:]))

    def test_an_administrators_token_from_a_file(self):
        path = self.path("admin-token")
        with open(path, "w") as file:
            file.write("a-secret-that-an-orchestrator-made\n")
        os.chmod(path, 0o644)
        self.assertIn(path + ": everybody", self.start_fails("--admin-token-file", path))
        os.chmod(path, 0o600)
        self.start("--authentication", "token", "--admin-token-file", path)
        self.refused("create", "swings")
        self.refused("create", "swings", token="another")
        flags = ["--token-file", path]
        self.ok("create", "swings", flags=flags)
        self.assertIn("tokens/admin-token-file", self.ok("audit", flags=flags))

        # Another token in the file replaces the first; a missing file or one without a token
        # changes nothing.
        first, second = "a-secret-that-an-orchestrator-made", "another-that-it-made-a-month-later"
        with open(path, "w") as file:
            file.write(second)
        self.wait_for_log("reloaded admin")
        self.ok("list", token=second)
        self.assertIn("not one of this server's", self.refused("list", token=first))
        os.truncate(path, 0)
        self.wait_for_log("at least 20 characters")
        self.ok("list", token=second)
        os.remove(path)
        self.wait_for_log("No such file")
        self.ok("list", token=second)
        for secret in (first, second):
            self.assertNotIn(secret, self.server.log())

    def test_failed_attempts_are_limited(self):
        self.make_store()
        self.start("--authentication", "token", "--failures-per-minute", "3",
                   "--http-listen", "127.0.0.1:0")
        self.ok("list", token=self.reader)
        for _ in range(3):
            self.assertIn("not one of this server's", self.refused("list", token="mdb_0_0"))
        self.assertIn("too many wrong tokens from 127.0.0.1", self.refused("list", token="mdb_0_0"))
        self.ok("list", token=self.reader)  # a known caller is still served
        self.ok("list", token=self.stranger)  # also a token that was not used before
        self.assertIn("a wrong token from 127.0.0.1", self.server.log())
        self.assertIn("too many wrong tokens from 127.0.0.1", self.server.log())
        # Attempts refused without a check count too, so that an alert sees the guesser.
        with urllib.request.urlopen(self.server.metrics, timeout=30) as answer:
            self.assertIn("motiondb_authentication_failures_total 4\n", answer.read().decode())

    def test_it_does_not_start_unprotected(self):
        message = self.start_fails(listen="0.0.0.0:0")
        self.assertIn("without TLS", message)
        self.assertIn("--insecure", message)
        self.start("--insecure", listen="0.0.0.0:0")
        self.assertIn("INSECURE: 0.0.0.0:0", self.server.log())
        self.ok("list")

    def test_a_missing_admin_token_is_logged(self):
        message = "no valid admin token exists"
        self.start("--authentication", "token")
        self.assertIn(message, self.server.log())
        os.remove(self.server.log_path)
        self.make_store()
        self.start("--authentication", "token")
        self.assertNotIn(message, self.server.log())

    def test_check_config_warns_like_a_start(self):
        authority = Authority(self.folder.name, "authority")
        certificate, key = authority.issue("server", "localhost")
        os.chmod(key, 0o644)
        flags = ["--tls-certificate", certificate, "--tls-key", key]
        self.start(*flags)
        self.assertIn(key + ": everybody on this machine can read it", self.server.log())
        check = subprocess.run([programs.MOTIONDBD, "--store", self.path("none.db"), *flags,
                                "--check-config"], capture_output=True, text=True, timeout=60)
        self.assertEqual(check.returncode, 0)
        self.assertIn(key + ": everybody on this machine can read it", check.stderr)

    def test_bad_files_are_named(self):
        authority = Authority(self.folder.name, "authority")
        certificate, _ = authority.issue("server", "localhost")
        self.assertIn(authority.key + ": is not the key of the certificate in " + certificate,
                      self.start_fails("--tls-certificate", certificate, "--tls-key",
                                       authority.key))
        self.assertIn("/nowhere.crt: cannot be read",
                      self.start_fails("--tls-certificate", "/nowhere.crt", "--tls-key",
                                       authority.key))


if __name__ == "__main__":
    programs.main()
