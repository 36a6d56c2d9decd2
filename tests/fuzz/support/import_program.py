"""Runs motiondb-import with its limits, and checks what its answers promise."""

import json
import os
import signal
import subprocess
import tempfile
import threading
import time

CPU_SECONDS = 2
MEMORY_MIB = 512
PLAIN_MIB = 16
LIMITS = ["--max-cpu-seconds", str(CPU_SECONDS), "--max-memory-mib", str(MEMORY_MIB),
          "--max-plain-mib", str(PLAIN_MIB)]
MAX_SECONDS = 2 * CPU_SECONDS + 6  # the machine may be busy
CRASHED = ("the reader crashed", "the reader failed", "the reader made a forbidden system call")
EXHAUSTED = ("reading needs more", "reading takes longer", "was killed", "the result is larger")
INVALID_ARGUMENT = 3
RESOURCE_EXHAUSTED = 8


class Violation(Exception):
    pass


def expect(promise, what):
    if not promise:
        raise Violation(what)


class Program:
    """Runs motiondb-import, and checks exit code, time and memory."""

    def __init__(self, path):
        self.path = path

    def run(self, command, requests, sandboxed, fill=None):
        """Returns its output and the time in seconds. `fill`: byte of allocated memory, so that
        answers which depend on uninitialized memory differ."""
        if fill is None:
            fill = 0xAA if sandboxed else 0x33
        text = "".join(json.dumps(request) + "\n" for request in requests)
        options = LIMITS + ([] if sandboxed else ["--no-sandbox"])
        if command == "inspect":
            options += ["--jobs", "2"]
        began = time.monotonic()
        with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
            process = subprocess.Popen([self.path, command, *options], stdin=subprocess.PIPE,
                                       stdout=out, stderr=errors,
                                       env=os.environ | {"MALLOC_PERTURB_": str(fill)})
            timer = threading.Timer(MAX_SECONDS * len(requests), process.kill)
            timer.start()
            try:
                process.stdin.write(text.encode())
                process.stdin.close()
            except BrokenPipeError:
                pass  # it has ended: its exit code tells why
            # Includes the memory of its children, for which it has waited.
            _, status, usage = os.wait4(process.pid, 0)
            timer.cancel()
            process.returncode = os.waitstatus_to_exitcode(status)
            seconds = time.monotonic() - began
            out.seek(0)
            errors.seek(0)
            message = errors.read(1000).decode(errors="replace")
            expect(process.returncode != -signal.SIGKILL and seconds <= MAX_SECONDS * len(requests),
                   f"it takes {seconds:.1f} s")
            expect(process.returncode == 0, f"exit code {process.returncode}: {message}")
            expect(not message, f"standard error: {message}")
            used_mib = usage.ru_maxrss >> 10
            expect(not sandboxed or used_mib <= MEMORY_MIB, f"{used_mib} MiB of memory")
            return out.read(), seconds


def check_error(error, names):
    """Returns the kind of result that the error is."""
    expect(isinstance(error, str) and error, "an empty error")
    if any(text in error for text in CRASHED):
        return "crashed"
    if any(text in error for text in EXHAUSTED):
        return "exhausted"
    expect(any(name in error for name in names), f"an error without the name of the file: {error}")
    return "rejected"


def check_single(command, answer, names):
    """Checks one answer of `read` or `convert`, and returns the kind of result."""
    line, separator, content = answer.partition(b"\n")
    expect(separator, f"no header in {len(answer)} bytes")
    try:
        header = json.loads(line)
    except ValueError:
        raise Violation(f"a header that is not JSON: {line[:200]}") from None
    expect(isinstance(header, dict) and header.get("bytes") == len(content),
           f"{len(content)} bytes after the header {line[:200]}")
    if "error" in header:
        expect(not content, "an error with content")
        kind = check_error(header["error"], names)
        expect(any(name in header["error"] for name in names),
               f"an error without the name of the file: {header['error']}")
        code = RESOURCE_EXHAUSTED if kind == "exhausted" else INVALID_ARGUMENT
        expect(header.get("code") == code,
               f"code {header.get('code')} of the error {header['error']}")
        return kind
    expect(content, "neither error nor content")
    fields = {"bytes"} if command == "read" else {"bytes", "report", "points", "frame_count",
                                                  "frame_rate_hz", "losses"}
    expect(set(header) == fields, f"the fields {sorted(header)}")
    return "accepted"


def check_inspected(output, names):
    """Checks the answers of `inspect`, and returns the kind of each result with the result.
    `names`: of the files of each request."""
    results = {}
    for line in output.splitlines():
        try:
            answer = json.loads(line)
        except ValueError:
            raise Violation(f"a line that is not JSON: {line[:200]}") from None
        expect(isinstance(answer, dict) and set(answer) == {"index", "file", "result"},
               f"an answer with other fields: {line[:200]}")
        index = answer["index"]
        expect(index not in results, f"two answers for request {index}")
        results[index] = answer["result"]
    expect(sorted(results) == list(range(len(names))), f"answers for {sorted(results)}")
    return [(check_error(results[i]["error"], of_one) if "error" in results[i] else "accepted",
             results[i]) for i, of_one in enumerate(names)]
