#!/usr/bin/env python3
"""Changes valid motion files at random and has motiondb-import read them, with and without its
sandbox. Whatever the file does to its reader, the program must exit with 0 and one valid answer,
within its limits of time and memory. Prints a table; exits with 1 on a violation, and keeps its
input in build/fuzz/findings.

  tests/fuzz/import_fuzz.py [--program PATH] [--seconds S] [--runs N] [--seed N]

Input i depends on the seed and i only. assimp may crash, exhaust its limits, or give another answer
each time (unstable); motiondb's own readers may not.
"""

import argparse
import concurrent.futures
import hashlib
import json
import os
import random as randoms
import resource
import shutil
import sys
import tempfile
import threading
import time

ROOT = os.path.dirname(os.path.dirname(os.path.dirname(os.path.abspath(__file__))))
sys.dont_write_bytecode = True
sys.path[:0] = [os.path.join(ROOT, "tests/fuzz", folder) for folder in ("seeds", "support")]
import import_seeds  # noqa: E402
import mutations  # noqa: E402
from import_program import Program, Violation, check_inspected, check_single, expect  # noqa: E402

BATCH = 16  # files of one process of `inspect`
SINGLE_EVERY = 4  # which of them `read` and `convert` get too
WITHOUT_SANDBOX_MIB = 2048  # protects the machine
COLUMNS = ["runs", "accepted", "rejected", "exhausted", "crashed", "unstable", "slowest"]
WRITTEN = ["bvh", "trc", "c3d", "csv", "npz", "gltf"]


class Input:
    """A changed file on disk, and its request."""

    def __init__(self, seeds, seed, index, folder):
        random = randoms.Random(f"{seed}/{index}")
        # Every format equally often, and mostly files that are accepted.
        name = random.choice(sorted({one.format for one in seeds}))
        motions = [one for one in seeds if one.format == name and one.is_motion]
        if random.randrange(5) == 0 or not motions:
            motions = [one for one in seeds if one.format == name]
        base = random.choice(motions)
        self.format = base.format
        self.is_ours = base.is_ours
        self.index = index
        data, skeleton, suffix = base.data, base.skeleton, base.suffix
        mutate = {".npz": mutations.mutated_npz, ".glb": mutations.mutated_glb,
                  ".gltf": mutations.mutated_json, ".fbx": mutations.mutated_in_place,
                  ".c3d": mutations.mutated_in_place}.get(suffix, mutations.mutated)
        if random.randrange(4) == 0:
            mutate = mutations.mutated
        if skeleton and random.randrange(2):
            skeleton = mutations.mutated(random, skeleton)
        elif random.randrange(8) == 0:
            self.format = "gzip"
            suffix += ".gz"
            data = mutations.mutated_gzip(random, data, mutate)
        else:
            data = mutate(random, data)
        self.files = [self.write(folder, suffix, data)]
        self.names = ["input" + suffix]
        self.request = {"file": self.files[0], "name": self.names[0],
                        "written_as": random.choice(WRITTEN)}
        if skeleton and random.randrange(16):
            self.files.append(self.write(folder, base.skeleton_suffix, skeleton))
            self.names.append("input" + base.skeleton_suffix)
            self.request |= {"skeleton": self.files[1], "skeleton_name": self.names[1]}
        if random.randrange(4) == 0:
            self.request |= random.choice(
                [{"metres_per_unit": 0.01}, {"up_axis": "x"}, {"frame_rate_hz": 1000},
                 {"take": "take"}, {"leg_length_m": 0.9}])

    def write(self, folder, suffix, data):
        path = os.path.join(folder, f"{self.index}{suffix}")
        with open(path, "wb") as file:
            file.write(data)
        return path

    def remove(self):
        for path in self.files:
            os.remove(path)


class Session:
    def __init__(self, program, seeds, options, folder):
        self.program = Program(program)
        self.seeds = seeds
        self.options = options
        self.folder = folder
        self.lock = threading.Lock()
        self.next = 0
        self.statistics = {}
        self.violations = 0
        self.stop_at = time.monotonic() + options.seconds if options.seconds else None

    def take(self):
        """Returns the indices of the next inputs; none at the end."""
        with self.lock:
            if self.stop_at and time.monotonic() >= self.stop_at:
                return range(0)
            end = self.next + BATCH
            if self.options.runs:
                end = min(end, self.options.runs)
            indices = range(self.next, end)
            self.next = end
            return indices

    def count(self, one, kind, seconds=0.0):
        with self.lock:
            row = self.statistics.setdefault(one.format, dict.fromkeys(COLUMNS, 0))
            row["runs"] += 1
            row[kind] += 1
            row["slowest"] = max(row["slowest"], seconds)
        if kind == "crashed" and self.options.keep_crashes:
            for path in one.files:
                shutil.copy(path, self.options.keep_crashes)
        expect(kind in ("accepted", "rejected") or not one.is_ours,
               f"a reader of motiondb {kind} its limits" if kind == "exhausted" else
               f"a reader of motiondb {kind}")

    def report(self, one, command, sandboxed, violation):
        with self.lock:
            self.violations += 1
            os.makedirs(self.options.findings, exist_ok=True)
            kept = []
            for path, name in zip(one.files, one.names):
                with open(path, "rb") as file:
                    digest = hashlib.sha1(file.read()).hexdigest()[:12]
                suffix = name.removeprefix("input")
                kept.append(os.path.join(self.options.findings, f"import-{digest}{suffix}"))
                shutil.copy(path, kept[-1])
            request = one.request | dict(zip(("file", "skeleton"), kept))
            mode = "" if sandboxed else " --no-sandbox"
            print(f"violation: {command}{mode}: {violation}\n  input {one.index}: "
                  f"{json.dumps(request)}", file=sys.stderr, flush=True)

    def inspect(self, inputs, sandboxed):
        """Returns kinds and results, or nothing after a violation."""
        try:
            output, _ = self.program.run("inspect", [one.request for one in inputs], sandboxed)
            answers = check_inspected(output, [one.names for one in inputs])
        except Violation as violation:
            # Finds the input.
            if len(inputs) == 1:
                self.report(inputs[0], "inspect", sandboxed, violation)
            elif all([self.inspect([one], sandboxed) for one in inputs]):
                self.report(inputs[0], "inspect", sandboxed,
                            f"{violation} (only together with the next {len(inputs) - 1} inputs)")
            return []
        for one, (kind, result) in zip(inputs, answers):
            try:
                self.count(one, kind)
            except Violation as violation:
                self.report(one, "inspect", sandboxed, f"{violation}: {result['error']}")
        return answers

    def single(self, one, command, sandboxed):
        """Returns the kind and the answer, or nothing after a violation."""
        try:
            answer, seconds = self.program.run(command, [one.request], sandboxed)
            kind = check_single(command, answer, one.names)
            self.count(one, kind, seconds)
            return kind, answer
        except Violation as violation:
            self.report(one, command, sandboxed, violation)
            return None

    def compare(self, one, command, boxed, free):
        """The sandbox must not change what is read."""
        if {boxed[0], free[0]} & {"crashed", "exhausted"} or boxed[1] == free[1]:
            return
        if not one.is_ours:  # assimp can use uninitialized memory
            try:
                answers = {self.program.run("read", [one.request], True, fill)[0]
                           for fill in (0x33, 0x55, 0xAA, 0xFF)}
            except Violation as violation:
                self.report(one, "read", True, violation)
                return
            if len(answers) > 1:
                with self.lock:
                    self.statistics[one.format]["unstable"] += 1
                return
        self.report(one, command, True,
                    "the answer differs without sandbox, or depends on uninitialized memory")

    def work(self):
        while indices := self.take():
            inputs = [Input(self.seeds, self.options.seed, index, self.folder) for index in indices]
            boxed, free = self.inspect(inputs, True), self.inspect(inputs, False)
            for one, with_sandbox, without in zip(inputs, boxed, free):
                self.compare(one, "inspect", with_sandbox, without)
            for one in inputs[::SINGLE_EVERY]:
                for command in ("read", "convert"):
                    answers = [self.single(one, command, sandboxed) for sandboxed in (True, False)]
                    if all(answers):
                        self.compare(one, command, *answers)
            for one in inputs:
                one.remove()

    def table(self):
        lines = [["format", *COLUMNS]]
        for name, row in sorted(self.statistics.items()):
            lines.append([name, *(str(row[column]) for column in COLUMNS[:-1]),
                          f"{row['slowest']:.2f} s"])
        widths = [max(len(line[i]) for line in lines) for i in range(len(lines[0]))]
        for line in lines:
            print("  ".join(cell.ljust(width) for cell, width in zip(line, widths)).rstrip())


def check_seeds(program, seeds, folder):
    """Unchanged files of ours must be accepted: otherwise nothing is tested."""
    for index, seed in enumerate(seeds):
        paths = [os.path.join(folder, f"seed{index}{suffix}")
                 for suffix in (seed.suffix, seed.skeleton_suffix) if suffix]
        for path, data in zip(paths, (seed.data, seed.skeleton)):
            with open(path, "wb") as file:
                file.write(data)
        request = {"file": paths[0]} | ({"skeleton": paths[1]} if len(paths) > 1 else {})
        answer, _ = Program(program).run("read", [request], True)
        if check_single("read", answer, paths) != "accepted":
            sys.exit(f"seed {paths[0]}: {answer[:500].decode(errors='replace')}")


def main():
    parser = argparse.ArgumentParser(description=__doc__.partition("\n\n")[0])
    parser.add_argument("--program",
                        default=os.path.join(ROOT, "build/release/import/motiondb-import"))
    parser.add_argument("--seconds", type=float, help="time; default 20 without --runs")
    parser.add_argument("--runs", type=int, help="number of inputs")
    parser.add_argument("--seed", type=int, default=int.from_bytes(os.urandom(4), "little"))
    parser.add_argument("--jobs", type=int, default=os.cpu_count())
    parser.add_argument("--findings", default=os.path.join(ROOT, "build/fuzz/findings"))
    parser.add_argument("--keep-crashes", metavar="FOLDER", help="keeps files that crash assimp")
    options = parser.parse_args()
    if not options.seconds and not options.runs:
        options.seconds = 20
    if options.keep_crashes:
        os.makedirs(options.keep_crashes, exist_ok=True)
    # Inherited by all processes.
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_AS, (WITHOUT_SANDBOX_MIB << 20,) * 2)
    with tempfile.TemporaryDirectory() as folder:
        own = import_seeds.own_seeds(options.program, folder)
        check_seeds(options.program, own, folder)
        models = import_seeds.model_seeds(options.program)
        if not models:
            print("skipped: FBX and Collada: no assimp-testmodels")
        session = Session(options.program, own + models, options, folder)
        with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
            for worker in [pool.submit(session.work) for _ in range(options.jobs)]:
                worker.result()  # or its exception
    print(f"motiondb-import: {session.next} inputs, seed {options.seed}")
    session.table()
    return 1 if session.violations else 0


if __name__ == "__main__":
    sys.exit(main())
