#!/usr/bin/python3
"""motiondbd with too few descriptors or threads or too little memory reports what it needs, or
refuses calls.

    process_limits_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import gzip
import os
import resource
import signal
import subprocess
import tempfile
import threading
import time
import unittest

import programs
from observability_test import OLD_STORES, write_walk
from programs import MOTIONDBD, Server

MIB = 1 << 20
LONE_USER = 61234  # a user without processes

needs_address_space = unittest.skipIf(
    programs.SLOWNESS > 1, "a sanitizer needs more address space than these limits allow")


class Starting(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.folder_of_store = os.path.join(self.folder.name, "store")
        os.mkdir(self.folder_of_store)

    def start(self, limits, user=None):
        """Returns (exit code, standard error) of a server that ends by itself; ("serves", "")
        otherwise."""
        def limit():
            for resource_id, value in limits.items():
                resource.setrlimit(resource_id, (value, value))
            if user is not None:
                os.setgid(user)
                os.setuid(user)

        process = subprocess.Popen(
            [MOTIONDBD, "--store", os.path.join(self.folder_of_store, "motion.db"), "--listen",
             "127.0.0.1:0", "--http-listen", "127.0.0.1:0", "--log-level", "off"],
            stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, preexec_fn=limit)
        serves = any("listening on" in line for line in process.stdout)
        if serves:
            process.send_signal(signal.SIGTERM)
        _, errors = process.communicate(timeout=60 * programs.SLOWNESS)
        if serves:
            self.assertEqual(process.returncode, 0, errors)
        return "serves" if serves else process.returncode, errors

    def test_too_few_descriptors_are_refused_before_the_store_is_touched(self):
        old = os.path.join(self.folder_of_store, "motion.db")
        with gzip.open(os.path.join(OLD_STORES, "version1.db.gz")) as packed:
            version1 = packed.read()
        for has_store in (False, True):
            if has_store:
                with open(old, "wb") as file:
                    file.write(version1)
            for descriptors in (8, 16, 32, 64, 127):
                code, errors = self.start({resource.RLIMIT_NOFILE: descriptors})
                self.assertEqual(code, 1, f"{descriptors}: {errors}")
                self.assertIn(f"may open {descriptors} files, expected at least 128", errors)
                self.assertEqual(errors.count("\n"), 1, errors)
                self.assertEqual(os.listdir(self.folder_of_store), ["motion.db"] if has_store else [])
        with open(old, "rb") as file:
            self.assertEqual(file.read(), version1)
        self.assertEqual(self.start({resource.RLIMIT_NOFILE: 128})[0], "serves")

    def test_too_few_threads_are_refused_before_the_store_is_created(self):
        if os.getuid() != 0:
            self.skipTest("needs root, to run the server as a user without other processes")
        os.chown(self.folder_of_store, LONE_USER, LONE_USER)
        os.chmod(self.folder.name, 0o755)
        if subprocess.run([MOTIONDBD, "--version"], user=LONE_USER, capture_output=True).returncode:
            self.skipTest("another user cannot run " + MOTIONDBD)
        for threads in (2, 8, 20):
            code, errors = self.start({resource.RLIMIT_NPROC: threads}, LONE_USER)
            self.assertEqual(code, 1, errors)
            self.assertRegex(errors, r"cannot start: the process may start \d+ threads, expected \d+")
            self.assertIn("ulimit -u", errors)
            self.assertEqual(os.listdir(self.folder_of_store), [])
        self.assertEqual(self.start({resource.RLIMIT_NPROC: 200}, LONE_USER)[0], "serves")

    @needs_address_space
    def test_with_any_memory_it_serves_or_reports_why_not(self):
        ended = {}
        for mebibytes in range(250, 1001, 125):
            code, errors = self.start({resource.RLIMIT_AS: mebibytes * MIB})
            ended[mebibytes] = code
            if code == "serves":
                for name in os.listdir(self.folder_of_store):
                    os.remove(os.path.join(self.folder_of_store, name))
                continue
            self.assertEqual(code, 1, f"{mebibytes} MiB: {errors}")
            self.assertIn("ulimit -v", errors)
            self.assertEqual(os.listdir(self.folder_of_store), [])
        print(f"\naddress space in MiB, and result: {ended}")
        self.assertIn("serves", ended.values())
        self.assertIn(1, ended.values())


class Running(unittest.TestCase):
    @needs_address_space
    def test_calls_fail_without_memory_and_the_server_continues(self):
        failed = []
        with tempfile.TemporaryDirectory() as folder:
            walk, small = folder + "/walk.bvh", folder + "/small.bvh"
            write_walk(small)
            write_walk(walk, frames=400_000)
            with open(walk, "rb") as file:
                text = file.read()
            # Equal contents are stored once, so the first frames differ.
            large = [f"{folder}/large{i}.bvh" for i in range(8)]
            for i, name in enumerate(large):
                with open(name, "wb") as file:
                    file.write(text.replace(b"\n0 80 0 ", b"\n0 80.%d 0 " % (i + 1), 1))
            for mebibytes in (900, 700):
                server = Server(f"{folder}/{mebibytes}.db", "--http-listen", "none",
                                "--max-frames", "1000000", "--message-memory-mib", "4096",
                                address_space=mebibytes * MIB)
                self.addCleanup(lambda server=server: server.process.poll() is not None
                                or server.stop())
                failed += self.ingest_together(server, large)
                self.assertIsNone(server.process.poll(), "the server has ended")
                latest = time.monotonic() + 30 * programs.SLOWNESS
                # Uses another database: that of the large clips may stay too large to build.
                number = 0
                while not self.serves(server, f"small{number}", small):
                    number += 1
                    self.assertLess(time.monotonic(), latest, "it does not recover")
                self.assertEqual(server.stop(), 0)
        self.assertTrue(failed, "memory did not run out")
        for error in failed:
            self.assertIn("memory", error)

    @staticmethod
    def serves(server, database, file):
        create = ["create", database, "--marker-set", "source", "--min-frames", "4"]
        return all(server.run(*command).returncode == 0 for command in (
            create, ["ingest", database, file], ["recognize", database, file]))

    def ingest_together(self, server, files):
        """Returns the errors of the ingests that failed."""
        server.ask_one("create", "walks", "--marker-set", "source", "--min-frames", "4")
        results = []
        threads = [threading.Thread(target=lambda file=file: results.append(
            server.run("ingest", "walks", file))) for file in files]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        errors = [result.stderr for result in results if result.returncode != 0]
        print(f"\n{len(errors)} of {len(files)} ingests of {os.path.getsize(files[0]) / MIB:.0f} MiB "
              f"failed: {errors[:1]}")
        return errors


if __name__ == "__main__":
    programs.main()
