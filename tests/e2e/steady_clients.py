"""Well-behaved clients that measure the latency of a server."""

import base64
import http.client
import json
import subprocess
import threading
import time

PERIOD = 0.25  # seconds, of requests over HTTP
WINDOW_SECONDS = 0.4


class Repeated:
    """Calls `ask` every PERIOD seconds on a thread of its own and measures it. `ask` returns the
    HTTP status, and fails with OSError or HTTPException."""

    def __init__(self, ask):
        self.ask, self.stopped = ask, threading.Event()
        self.ms, self.failures, self.error = [], 0, ""
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def run(self):
        while not self.stopped.wait(PERIOD):
            began = time.monotonic()
            try:
                status = self.ask()
                failure = "" if status == 200 else f"status {status}"
            except (OSError, http.client.HTTPException) as error:
                failure = repr(error)
            self.failures += failure != ""
            self.error = self.error or failure
            self.ms.append(1e3 * (time.monotonic() - began))

    def stop(self):
        self.stopped.set()
        self.thread.join()
        ms = sorted(self.ms) or [0]
        return {"count": len(self.ms), "failures": self.failures, "error": self.error,
                "p99_ms": ms[-(len(ms) // 100) - 1], "max_ms": ms[-1]}


def livez(address):
    """Returns a request of /livez on the HTTP port, on a new connection each time."""
    def ask():
        connection = http.client.HTTPConnection(*address, timeout=5)
        try:
            connection.request("GET", "/livez")
            return connection.getresponse().status
        finally:
            connection.close()
    return ask


class WebClient:
    """Recognizes 0.4 s of motion over the HTTP API (JSON), on a new connection each time. `tls`: of
    its connections, or None."""

    def __init__(self, address, tls, token, database, motion):
        self.address, self.tls, self.token = address, tls, token
        with open(motion, "rb") as file:
            data = base64.b64encode(file.read()).decode()
        status, answer = self.call("ObserveService/Represent", {
            "database": database, "observation": {"file": {"fileName": "motion.bvh", "data": data}}})
        assert status == 200, answer
        markers = json.loads(answer)["markers"]
        frames = round(WINDOW_SECONDS * markers["frameRateHz"])
        positions = base64.b64decode(markers["positions"])
        size = len(positions) // markers["frameCount"]
        window = {"frameCount": frames,
                  "positions": base64.b64encode(positions[:frames * size]).decode()}
        self.request = {"database": database, "observation": {"markers": markers | window}}

    def call(self, method, request):
        """Returns the HTTP status and the body."""
        connection = (http.client.HTTPSConnection(*self.address, context=self.tls, timeout=5)
                      if self.tls else http.client.HTTPConnection(*self.address, timeout=5))
        try:
            headers = {"Content-Type": "application/json"}
            if self.token:
                headers["Authorization"] = f"Bearer {self.token}"
            connection.request("POST", f"/motiondb.v1.{method}", json.dumps(request),
                               headers)
            response = connection.getresponse()
            return response.status, response.read()
        finally:
            connection.close()

    def recognize(self):
        return self.call("QueryService/Recognize", self.request)[0]


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
