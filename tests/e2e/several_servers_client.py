"""A client of several servers: calls the HTTP API of one, and tries again with another."""

import collections
import http.client
import json
import threading
import time

# Errors after which docs/api.md tells a client to try again.
RETRIED = {"unavailable", "aborted", "deadline_exceeded"}
TIME_LIMIT = 20  # of a call, s


class CallError(Exception):
    """An answer that is an error of the API."""

    def __init__(self, method, code, reason, message, metadata):
        super().__init__(f"{method}: {code} {reason}: {message}")
        self.code, self.reason, self.metadata = code, reason, metadata


class ServerGone(Exception):
    """The connection failed or ended without an answer."""


def error_of(method, body):
    """The error of a response of the Connect protocol."""
    try:
        answer = json.loads(body)
        details = [detail.get("debug", {}) for detail in answer.get("details", [])]
    except ValueError:
        return CallError(method, "unknown", "", repr(body[:200]), {})
    info = next((detail for detail in details if "reason" in detail), {})
    return CallError(method, answer["code"], info.get("reason", ""), answer.get("message", ""),
                     info.get("metadata", {}))


class Client:
    """Calls any of the servers. One thread uses it. `addresses()`: the HTTP APIs of the servers that
    may run; `errors`: counts of (code, reason) that all clients have seen."""

    lock = threading.Lock()

    def __init__(self, addresses, chance, errors=None, patience=60):
        self.addresses = addresses
        self.chance = chance
        self.errors = errors if errors is not None else collections.Counter()
        self.patience = patience  # longest time until a call succeeds, s
        self.retried = False      # whether the last call was sent more than once

    def post(self, address, method, request, time_limit=TIME_LIMIT):
        connection = http.client.HTTPConnection(address.removeprefix("http://"),
                                                timeout=time_limit + 10)
        try:
            connection.request("POST", f"/motiondb.v1.{method}", json.dumps(request),
                               {"Content-Type": "application/json",
                                "Connect-Timeout-Ms": str(1000 * time_limit)})
            answer = connection.getresponse()
            body = answer.read()
        except (OSError, http.client.HTTPException) as error:
            raise ServerGone(f"{method} at {address}: {error!r}") from error
        finally:
            connection.close()
        if answer.status != 200:
            raise error_of(method, body)
        return json.loads(body)

    def call(self, method, request):
        """Calls a random server, and again another one after an error that allows it."""
        latest = time.monotonic() + self.patience
        self.retried = False
        while True:
            try:
                return self.post(self.chance.choice(self.addresses()), method, request)
            except ServerGone as gone:
                self.count("no answer", "")
                error = gone
            except CallError as refused:
                self.count(refused.code, refused.reason)
                if refused.code not in RETRIED:
                    raise
                error = refused
            if time.monotonic() > latest:
                raise AssertionError(f"not within {self.patience} s: {error}")
            self.retried = True
            time.sleep(self.chance.uniform(0.02, 0.2))

    def count(self, code, reason):
        with self.lock:
            self.errors[code, reason] += 1
