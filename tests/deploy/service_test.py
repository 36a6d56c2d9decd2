#!/usr/bin/python3
"""Tests the interface to service managers and containers: notification, --check-config, exit codes, health.

    service_test.py MOTIONDBD
"""

import contextlib
import os
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import unittest

MOTIONDBD = os.path.abspath(sys.argv[1])
DEPLOY = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../deploy")


def run(*arguments, **variables):
    return subprocess.run([MOTIONDBD, *arguments], capture_output=True, text=True, timeout=60,
                          env={**os.environ, **variables})


def end(server):
    server.kill()
    server.wait()
    server.stdout.close()


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def write(self, name, text):
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        return self.path(name)


class Notification(Folder):
    def check(self, name):
        listener = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(listener.close)
        listener.bind(name.replace("@", "\0", 1) if name.startswith("@") else name)
        listener.settimeout(60)
        server = subprocess.Popen(
            [MOTIONDBD, "--store", self.path("a.db"), "--listen", "127.0.0.1:0",
             "--log-level", "warning"],
            stdout=subprocess.PIPE, text=True, env={**os.environ, "NOTIFY_SOCKET": name})
        self.addCleanup(end, server)
        ready = listener.recv(4096).decode().splitlines()
        self.assertEqual(ready[0], "READY=1")
        address = server.stdout.readline().strip().rsplit(" ", 1)[-1]
        self.assertEqual(ready[1], f"STATUS=listening on {address}")
        host, port = address.rsplit(":", 1)
        socket.create_connection((host, int(port)), timeout=10).close()  # it listens
        server.send_signal(signal.SIGTERM)
        self.assertEqual(listener.recv(4096).decode().splitlines()[0], "STOPPING=1")
        self.assertEqual(server.wait(timeout=60), 0)

    def test_a_socket_in_a_folder(self):
        self.check(self.path("notify"))

    def test_an_abstract_socket(self):
        self.check(f"@motiondb-test-{os.getpid()}")


class CheckConfig(Folder):
    def test_prints_effective_settings_and_sources(self):
        store = self.path("motion.db")
        config = self.write("a.conf", f'# mine\nstore = "{store}"\nthreads = 2\nmax-frames = 9\n')
        result = run("--config", config, "--check-config", "--threads", "4",
                     MOTIONDBD_MAX_FRAMES="7", MOTIONDBD_THREADS="3")
        self.assertEqual(result.returncode, 0, result.stderr)
        lines = [line.split("#") for line in result.stdout.splitlines()]
        settings = {setting.split("=")[0].strip(): (setting.split("=")[1].strip(), place.strip())
                    for setting, place in lines}
        self.assertEqual(settings["store"], (f'"{store}"', f"{config}:2"))
        self.assertEqual(settings["threads"], ("4", "--threads"))
        self.assertEqual(settings["max-frames"], ("7", "MOTIONDBD_MAX_FRAMES"))
        self.assertEqual(settings["rebuild-delay"], ("0.3", "default"))
        self.assertFalse(os.path.exists(store))
        # The output is a configuration file with the same settings.
        again = run("--config", self.write("b.conf", result.stdout), "--check-config")
        self.assertEqual([line.split("#")[0] for line in again.stdout.splitlines()],
                         [line.split("#")[0] for line in result.stdout.splitlines()])

    def example(self, begin):
        """Returns the output in docs/operations.md of the command that begins with `begin`."""
        with open(os.path.join(DEPLOY, "../docs/operations.md"), encoding="utf-8") as readme:
            _, _, rest = readme.read().partition(f"\n$ {begin}")
        shown = rest.partition("\n```")[0].splitlines()[1:]
        self.assertTrue(shown, begin)
        return shown

    def test_operations_md_shows_the_output_for_the_sample(self):
        shown = self.example("MOTIONDBD_THREADS=3 motiondbd --config motiondbd.conf "
                             "--max-frames 50000 --check-config")
        printed = subprocess.run(
            [MOTIONDBD, "--config", "motiondbd.conf", "--max-frames", "50000", "--check-config"],
            cwd=DEPLOY, capture_output=True, text=True, timeout=60,
            env={**os.environ, "MOTIONDBD_THREADS": "3"}).stdout.splitlines()
        shown.remove("...")
        self.assertEqual([line for line in printed if line in shown], shown)

    def test_operations_md_shows_the_output_for_a_wrong_file(self):
        shown = self.example("motiondbd --config wrong.conf")
        self.write("wrong.conf", f'store = "{self.path("a.db")}"\nthreads = -3\nlisen = "x:1"\n')
        wrong = subprocess.run([MOTIONDBD, "--config", "wrong.conf"], cwd=self.folder.name,
                               capture_output=True, text=True, timeout=60)
        self.assertEqual(wrong.stderr.splitlines(), shown)

    def test_a_byte_order_mark_is_ignored(self):
        config = self.write("a.conf", f'\ufeffstore = "{self.path("a.db")}"\n')
        result = run("--config", config, "--check-config")
        self.assertEqual((result.returncode, result.stderr), (0, ""))

    def test_an_unusable_address_is_reported_with_the_reason(self):
        other = socket.create_server(("127.0.0.1", 0))
        self.addCleanup(other.close)
        used = f"127.0.0.1:{other.getsockname()[1]}"
        for address, why in ((used, "Address already in use"),
                             ("192.0.2.1:50051", "Cannot assign requested address")):
            result = run("--store", self.path("a.db"), "--listen", address, "--insecure",
                         "--http-listen", "none", "--log-level", "off")
            self.assertEqual(result.returncode, 1)
            self.assertIn(f"cannot listen on {address}: {why}", result.stderr)

    def test_an_error_has_file_and_line(self):
        config = self.write("a.conf", f'store = "{self.path("a.db")}"\nthreads = -1\nlisen = "x:1"\n')
        for arguments in (["--check-config"], []):
            result = run("--config", config, *arguments)
            self.assertEqual(result.returncode, 2)
            self.assertIn(f"{config}:2: ", result.stderr)
            self.assertIn(f"{config}:3: unknown setting: lisen", result.stderr)
            self.assertEqual(result.stdout, "")

    def test_a_start_refuses_the_same_settings_as_check_config(self):
        # The unit needs the exit code: systemd does not restart after 2.
        for flags, error in ((["--message-memory-mib", "15"], "message-memory-mib"),
                             (["--listen", "0.0.0.0:0"], "without TLS"),
                             (["--tls-certificate", "/absent.crt", "--tls-key", "/absent.key"],
                              "/absent.crt: cannot be read"),
                             (["--http-listen", "127.0.0.1:50051", "--listen", "127.0.0.1:50051"],
                              "listen and http-listen: 127.0.0.1:50051 and"),
                             (["--admin-token-file", "/absent"], "/absent")):
            for check in (["--check-config"], []):
                with self.subTest(flags=flags + check):
                    result = run("--store", self.path("a.db"), *flags, *check,
                                 MOTIONDBD_LISTEN="127.0.0.1:0", MOTIONDBD_HTTP_LISTEN="none")
                    self.assertEqual(result.returncode, 2, result.stderr)
                    self.assertIn(error, result.stderr)
        self.assertFalse(os.path.exists(self.path("a.db")))

    def test_a_missing_folder_at_start_is_not_a_wrong_setting(self):
        self.assertEqual(run("--store", self.path("none/a.db"), "--listen", "127.0.0.1:0",
                             "--http-listen", "none").returncode, 1)

    def test_check_config_reports_a_missing_folder(self):
        result = run("--store", self.path("none/a.db"), "--check-config")
        self.assertEqual(result.returncode, 2)
        self.assertIn("cannot write to folder", result.stderr)
        self.assertFalse(os.path.exists(self.path("none")))

    def test_check_config_does_not_change_an_open_store(self):
        store = self.path("a.db")
        server = subprocess.Popen([MOTIONDBD, "--store", store, "--listen", "127.0.0.1:0",
                                   "--log-level", "warning"], stdout=subprocess.PIPE, text=True)
        self.addCleanup(end, server)
        server.stdout.readline()
        before = os.stat(store)
        self.assertEqual(run("--store", store, "--check-config").returncode, 0)
        self.assertEqual(os.stat(store).st_mtime_ns, before.st_mtime_ns)
        server.terminate()
        self.assertEqual(server.wait(timeout=60), 0)


class NewerStore(Folder):
    """A store that a newer server has upgraded."""

    def test_it_is_refused_and_not_changed(self):
        store = self.path("a.db")
        server = subprocess.Popen([MOTIONDBD, "--store", store, "--listen", "127.0.0.1:0",
                                   "--http-listen", "none", "--log-level", "warning"],
                                  stdout=subprocess.PIPE, text=True)
        self.addCleanup(end, server)
        server.stdout.readline()
        server.terminate()
        self.assertEqual(server.wait(timeout=60), 0)
        with contextlib.closing(sqlite3.connect(store)) as connection:
            connection.execute("PRAGMA user_version = 1000")
        self.assertFalse(os.path.exists(store + "-wal"))  # all is in the file
        with open(store, "rb") as file:
            before = file.read()
        refused = run("--store", store, "--listen", "127.0.0.1:0", "--http-listen", "none")
        self.assertEqual(refused.returncode, 1)
        self.assertIn("the store is of version 1000, from a newer motiondb", refused.stderr)
        self.assertIn(store, refused.stderr)
        self.assertEqual(refused.stdout, "")
        with open(store, "rb") as file:
            self.assertEqual(file.read(), before)


class HealthCheck(Folder):
    """The health check of the image: by HTTP if enabled, otherwise by the gRPC port."""

    CHECK = os.path.join(DEPLOY, "docker/health_check.sh")

    def healthy(self, **variables):
        return subprocess.run([self.CHECK], env={**os.environ, **variables}, timeout=60,
                              capture_output=True).returncode == 0

    def listen(self, host):
        """Starts a server on this address only that answers every request with 200; returns its port."""
        family = socket.AF_INET6 if ":" in host else socket.AF_INET
        try:
            listener = socket.create_server((host, 0), family=family)
        except OSError as error:
            self.skipTest(f"{host}: {error}")
        self.addCleanup(listener.close)

        def answer():
            while True:
                try:
                    connection, _ = listener.accept()
                except OSError:
                    return
                with connection:
                    asked = b""
                    while not asked.endswith(b"\r\n\r\n"):
                        more = connection.recv(4096)
                        if not more:
                            break  # only a connection test
                        asked += more
                    else:
                        connection.sendall(b"HTTP/1.0 200 OK\r\n\r\n")
        threading.Thread(target=answer, daemon=True).start()
        return listener.getsockname()[1]

    def test_it_connects_to_the_configured_address(self):
        for listened, named in (("127.0.0.1", "127.0.0.1"), ("127.0.0.1", "0.0.0.0"),
                                ("127.0.0.1", "localhost"), ("127.0.0.1", "[::]"),
                                ("127.0.0.2", "127.0.0.2"), ("::1", "[::1]")):
            with self.subTest(named, listened=listened):
                port = self.listen(listened)
                self.assertTrue(self.healthy(MOTIONDBD_HTTP_LISTEN=f"{named}:{port}"))
                self.assertTrue(self.healthy(MOTIONDBD_HTTP_LISTEN="none",
                                             MOTIONDBD_LISTEN=f"{named}:{port}"))
        port = self.listen("127.0.0.2")
        self.assertFalse(self.healthy(MOTIONDBD_HTTP_LISTEN=f"127.0.0.1:{port}"))

    def start(self, http):
        server = subprocess.Popen([MOTIONDBD, "--store", self.path("a.db"), "--listen", "127.0.0.1:0",
                                   "--http-listen", http, "--log-level", "warning"],
                                  stdout=subprocess.PIPE, text=True)
        self.addCleanup(end, server)
        return server

    def test_by_http(self):
        server = self.start("127.0.0.1:0")
        http = server.stdout.readline().split("http://")[1].split("/")[0]
        self.assertIn("listening on", server.stdout.readline())
        self.assertTrue(self.healthy(MOTIONDBD_HTTP_LISTEN=http))
        server.terminate()
        server.wait(timeout=60)
        self.assertFalse(self.healthy(MOTIONDBD_HTTP_LISTEN=http))

    def test_without_http(self):
        server = self.start("none")
        address = server.stdout.readline().strip().rsplit(" ", 1)[-1]
        variables = {"MOTIONDBD_HTTP_LISTEN": "none", "MOTIONDBD_LISTEN": address}
        self.assertTrue(self.healthy(**variables))
        server.terminate()
        server.wait(timeout=60)
        self.assertFalse(self.healthy(**variables))


unittest.main(argv=sys.argv[:1])
