"""Well-behaved clients that measure the latency of a server."""

import http.client
import json
import subprocess
import threading
import time

LIVEZ_PERIOD = 0.25  # seconds


class Livez:
    """Requests /livez on the HTTP port, on a new connection each time."""

    def __init__(self, address):
        self.address, self.stopped = address, threading.Event()
        self.ms, self.failures = [], 0
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while not self.stopped.wait(LIVEZ_PERIOD):
            began = time.monotonic()
            connection = http.client.HTTPConnection(*self.address, timeout=5)
            try:
                connection.request("GET", "/livez")
                self.failures += connection.getresponse().status != 200
            except (OSError, http.client.HTTPException):
                self.failures += 1
            connection.close()
            self.ms.append(1e3 * (time.monotonic() - began))

    def stop(self):
        self.stopped.set()
        self.thread.join()
        ms = sorted(self.ms) or [0]
        return {"count": len(self.ms), "failures": self.failures, "error": "expected status 200",
                "p99_ms": ms[-(len(ms) // 100) - 1], "max_ms": ms[-1]}


class SteadyClient:
    def __init__(self, program, measured):
        self.process = subprocess.Popen(
            [program, "--server", measured.server.address, "--database", "motion",
             "--motion", measured.motion, *measured.client_options],
            stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        assert self.process.stdout.readline() == "ready\n", "the steady client could not start"

    def stop(self):
        output, _ = self.process.communicate(timeout=60)
        return json.loads(output)
