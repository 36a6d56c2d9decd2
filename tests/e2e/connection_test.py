#!/usr/bin/python3
"""Tests the errors of motiondb when TLS settings of client and server do not match.

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

    def error_of(self, server, *flags):
        """Returns the error: one line, within the time limit, with the address. The common
        beginning is removed."""
        began = time.monotonic()
        result = server.run("list", flags=flags)
        self.assertLess(time.monotonic() - began, 2 + 3 * programs.SLOWNESS)
        self.assertEqual(result.returncode, 1)
        begin = f"motiondb: no motiondb server answered at {server.address} within 2 s: "
        self.assertTrue(result.stderr.startswith(begin), result.stderr)
        self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
        return result.stderr.removeprefix(begin)

    def test_valid_clients_are_answered(self):
        for server, flags in ((self.plain, []), (self.tls, self.trust),
                              (self.mutual, [*self.trust, "--tls-certificate", self.certificate,
                                             "--tls-key", self.key])):
            result = server.run("list", flags=flags)
            self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_plain_text_to_a_server_with_tls(self):
        error = self.error_of(self.tls)
        self.assertIn("closes connections in plain text", error)
        self.assertIn("--tls-ca FILE", error)

    def test_tls_to_a_server_without(self):
        error = self.error_of(self.plain, *self.trust)
        self.assertIn("does not use TLS", error)
        self.assertIn("omit --tls", error)

    def test_a_certificate_from_another_authority(self):
        error = self.error_of(self.tls, "--tls-ca", self.other.certificate)
        self.assertIn("its certificate is not signed by " + self.other.certificate, error)
        self.assertIn("--tls-ca", error)
        self.assertIn("an authority that this system trusts", self.error_of(self.tls, "--tls"))

    def test_a_certificate_for_another_name(self):
        error = self.error_of(self.tls, *self.trust, "--tls-server-name", "robots.example")
        self.assertIn("is not for robots.example", error)
        self.assertIn("--tls-server-name", error)

    def test_a_clients_certificate(self):
        error = self.error_of(self.mutual, *self.trust)
        self.assertIn("requires a client certificate", error)
        self.assertIn("--tls-certificate FILE and --tls-key FILE", error)
        stranger, key = self.other.issue("stranger", "robot-7")
        error = self.error_of(self.mutual, *self.trust, "--tls-certificate", stranger, "--tls-key", key)
        self.assertIn("does not trust the authority that signed " + stranger, error)
        error = self.error_of(self.tls, *self.trust, "--tls-certificate", self.certificate, "--tls-key",
                              key)
        self.assertIn(f"{key} is not the key of {self.certificate}", error)

    def test_a_file_without_a_certificate(self):
        broken = os.path.join(self.folder.name, "broken.crt")
        with open(broken, "w") as file:
            file.write("-----BEGIN CERTIFICATE-----\nbroken\n-----END CERTIFICATE-----\n")
        error = self.error_of(self.tls, "--tls-ca", broken)
        self.assertIn(broken + ": contains no valid certificate", error)
        self.assertIn("--tls-ca", error)


class DescriptorsTest(unittest.TestCase):
    def test_excess_connections_are_refused_and_later_accepted(self):
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
                self.assertLess(time.monotonic(), deadline, "it accepts no connections")
            # The store was writable all the time.
            server.ask_one("create", "runs")
            self.assertEqual(server.stop(), 0)


if __name__ == "__main__":
    programs.main()
