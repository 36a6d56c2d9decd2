#!/usr/bin/python3
"""What motiondb says where it does not come through to a server that has TLS, or has none.

    connection_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import os
import socket
import tempfile
import time
import unittest

import programs
from secure_server import Authority, SecureServer


class ConnectionTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.folder.cleanup)
        cls.authority = Authority(cls.folder.name, "authority")
        cls.other = Authority(cls.folder.name, "other")
        cls.certificate, cls.key = cls.authority.issue("server", "localhost")
        pair = ["--tls-certificate", cls.certificate, "--tls-key", cls.key]
        cls.plain = cls.start("plain")
        cls.tls = cls.start("tls", *pair)
        cls.mutual = cls.start("mutual", *pair, "--tls-client-ca", cls.authority.certificate)
        cls.trust = ["--tls-ca", cls.authority.certificate]

    @classmethod
    def start(cls, name, *flags):
        server = SecureServer(os.path.join(cls.folder.name, name + ".db"), *flags)
        cls.addClassCleanup(server.stop)
        return server

    def said(self, server, *flags):
        """One line, in time, that names the address; without what is the same in all."""
        began = time.monotonic()
        result = server.run("list", flags=flags)
        self.assertLess(time.monotonic() - began, 2 + 3 * programs.SLOWNESS)
        self.assertEqual(result.returncode, 1)
        begin = f"motiondb: no motiondb server answered at {server.address} within 2 s: "
        self.assertTrue(result.stderr.startswith(begin), result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        return result.stderr.removeprefix(begin)

    def test_who_should_be_answered_is(self):
        for server, flags in ((self.plain, []), (self.tls, self.trust),
                              (self.mutual, [*self.trust, "--tls-certificate", self.certificate,
                                             "--tls-key", self.key])):
            result = server.run("list", flags=flags)
            self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_plain_text_to_a_server_with_tls(self):
        said = self.said(self.tls)
        self.assertIn("closes connections in plain text", said)
        self.assertIn("--tls-ca FILE", said)

    def test_tls_to_a_server_without(self):
        said = self.said(self.plain, *self.trust)
        self.assertIn("does not speak TLS", said)
        self.assertIn("leave out --tls", said)

    def test_a_certificate_of_another_authority(self):
        said = self.said(self.tls, "--tls-ca", self.other.certificate)
        self.assertIn("its certificate is not signed by " + self.other.certificate, said)
        self.assertIn("--tls-ca", said)
        self.assertIn("an authority that this system trusts", self.said(self.tls, "--tls"))

    def test_a_certificate_for_another_name(self):
        said = self.said(self.tls, *self.trust, "--tls-server-name", "robots.example")
        self.assertIn("is not made out to robots.example", said)
        self.assertIn("--tls-server-name", said)

    def test_a_clients_certificate(self):
        said = self.said(self.mutual, *self.trust)
        self.assertIn("asks for a client's certificate", said)
        self.assertIn("--tls-certificate FILE and --tls-key FILE", said)
        stranger, key = self.other.issue("stranger", "robot-7")
        said = self.said(self.mutual, *self.trust, "--tls-certificate", stranger, "--tls-key", key)
        self.assertIn("does not trust who signed " + stranger, said)
        said = self.said(self.tls, *self.trust, "--tls-certificate", self.certificate, "--tls-key",
                         key)
        self.assertIn(f"{key} is not the key of {self.certificate}", said)

    def test_a_file_without_a_certificate(self):
        broken = os.path.join(self.folder.name, "broken.crt")
        with open(broken, "w") as file:
            file.write("-----BEGIN CERTIFICATE-----\nbroken\n-----END CERTIFICATE-----\n")
        said = self.said(self.tls, "--tls-ca", broken)
        self.assertIn(broken + ": holds no certificate of use", said)
        self.assertIn("--tls-ca", said)


class DescriptorsTest(unittest.TestCase):
    def test_connections_beyond_are_refused_and_taken_again(self):
        with tempfile.TemporaryDirectory() as folder, open(folder + "/log", "w+") as log:
            server = programs.Server(folder + "/motion.db", "--http-listen", "none",
                                     "--log-level", "warning", log=log, descriptors=128)
            host, port = server.address.rsplit(":", 1)
            server.ask_one("create", "walks")
            silent = [socket.create_connection((host, int(port)), timeout=30) for _ in range(300)]
            deadline = time.monotonic() + 30 * programs.SLOWNESS
            while "connections are refused" not in open(folder + "/log").read():
                self.assertLess(time.monotonic(), deadline)
                time.sleep(0.05)
            for connection in silent:
                connection.close()
            while server.run("list").returncode != 0:
                self.assertLess(time.monotonic(), deadline, "it takes no connections any more")
            # It could write all the while.
            server.ask_one("create", "runs")
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    programs.main()
