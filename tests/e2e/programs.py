"""Runs motiondbd and motiondb as processes.

Arguments of every test: MOTIONDBD MOTIONDB DATA_FOLDER
"""

import json
import os
import resource
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

MOTIONDBD, MOTIONDB, DATA = sys.argv[1:4]
# Factor by which the programs may be slower than a release build; tests/run.sh sets it for
# sanitizers.
SLOWNESS = float(os.environ.get("MOTIONDB_TEST_SLOWNESS", "1"))
MODELS = "/usr/share/assimp/models/BVH"


class Server:
    """motiondbd on its own store file. Optional: more options, a log file, limits of descriptors
    and address space (bytes), a cgroup (control_group.py) to start in, and an address."""

    def __init__(self, store, *options, log=None, descriptors=None, address_space=None, group=None,
                 address="127.0.0.1:0"):
        def limit():
            if descriptors:
                resource.setrlimit(resource.RLIMIT_NOFILE, (descriptors, descriptors))
            if address_space:
                resource.setrlimit(resource.RLIMIT_AS, (address_space, address_space))
            if group:
                group.join()

        level = [] if "--log-level" in options else ["--log-level", "error"]
        self.process = subprocess.Popen(
            [MOTIONDBD, "--store", store, "--listen", address, *level, *options],
            stdout=subprocess.PIPE, stderr=log, text=True,
            preexec_fn=limit if descriptors or address_space or group else None)
        self.http = self.web = None  # addresses of its metrics and of its HTTP API, if enabled
        for line in self.process.stdout:
            self.address = line.strip().rsplit(" ", 1)[-1]
            if line.startswith("motiondbd: listening on "):
                break
            if line.startswith("motiondbd: HTTP API at "):
                self.web = self.address
            else:
                self.http = self.address.removesuffix("/metrics")

    def stop(self, with_signal=signal.SIGTERM):
        self.process.send_signal(with_signal)
        code = self.process.wait(timeout=60)
        self.process.stdout.close()
        return code

    def run(self, *arguments):
        return subprocess.run([MOTIONDB, "--server", self.address, *arguments],
                              capture_output=True, text=True)

    def ask(self, *arguments):
        """Returns the command's JSON objects, one per line."""
        result = self.run("--json", *arguments)
        assert result.returncode == 0, f"motiondb {' '.join(arguments)}: {result.stderr}"
        return [json.loads(line) for line in result.stdout.splitlines() if line.strip()]

    def ask_one(self, *arguments):
        answers = self.ask(*arguments)
        assert len(answers) == 1, answers
        return answers[0]

    def metric(self, series):
        """The value of a series, such as 'up{job="a"}', in its metrics."""
        with urllib.request.urlopen(self.http + "/metrics", timeout=30) as page:
            found = [line for line in page.read().decode().splitlines()
                     if line.startswith(series + " ")]
        assert len(found) == 1, f"{series}: {found}"
        return float(found[0].rsplit(" ", 1)[1])


class WithServer(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.store = os.path.join(self.folder.name, "motion.db")
        self.server = Server(self.store)

    def tearDown(self):
        if self.server.process.poll() is None:
            self.server.stop()
        self.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    _filled = {}  # bytes of stores, by key

    def begin_with(self, key, fill):
        """Starts the server again with the store that `fill` makes: once for each key, since builds
        are slow with sanitizers. Later tests get a copy."""
        if key not in self._filled:
            fill()
        assert self.server.stop() == 0
        if key in self._filled:
            with open(self.store, "wb") as file:
                file.write(self._filled[key])
        else:
            with open(self.store, "rb") as file:
                self._filled[key] = file.read()
        self.server = Server(self.store)


def wait_for(condition, seconds, what):
    """Waits until condition() is true, and returns its value."""
    latest = time.monotonic() + seconds
    while not (value := condition()):
        if time.monotonic() > latest:
            raise AssertionError(f"not within {seconds} s: {what}")
        time.sleep(0.05)
    return value


def needs_data():
    """Skips the test, or all tests of a class whose setUpClass calls it, if the data is missing."""
    if not os.path.exists(os.path.join(DATA, "index.tsv")):
        raise unittest.SkipTest(f"no recorded motion in {DATA}")


def main():
    unittest.main(argv=sys.argv[:1], verbosity=2)
