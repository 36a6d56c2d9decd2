#!/usr/bin/python3
"""Tests the web page in a browser: real servers, real motion, Chromium.

    web_page_test.py MOTIONDBD MOTIONDB DATA_FOLDER PAGE_FOLDER [TEST...]

TEST: name of a file here without .test.mjs, for example session; otherwise all but `speed` and
`large`, which measure times and need an idle machine. `large` reads the store MOTIONDB_LARGE_STORE,
which `motiondb_bench_scale --store FILE` creates. The test files get the servers in MOTIONDB_WEB_TEST
(support/setup.mjs). MOTIONDB_WEB_THROTTLE=4 makes the processor of each page four times slower, to
find races of page and tests. Exit code 77: skipped.
"""

import concurrent.futures
import contextlib
import glob
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

HERE = os.path.dirname(os.path.abspath(__file__))
ROOT = os.path.normpath(os.path.join(HERE, "../.."))
PAGE, TESTS = sys.argv[4], sys.argv[5:]
del sys.argv[4:]
sys.path.insert(0, os.path.join(ROOT, "tests/e2e"))

import programs  # noqa: E402

TIME_LIMIT = 600 * programs.SLOWNESS  # seconds; a run that takes longer hangs
ADMIN_TOKEN = "a-token-of-the-administrator"
# As text these are harmless; as HTML or script they run.
HOSTILE = "<img src=x onerror=\"window.hacked=1\"><script>window.hacked=1</script>'\"&"
HOSTILE_MARKER = "<img/src='x'onerror='window.hacked=1'>"


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(77)


def find_chromium():
    for name in ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"):
        if path := shutil.which(name):
            return path
    return skip("Chromium is missing (deploy/install_packages.sh web-test)")


def check_requirements():
    if shutil.which("node") is None:
        skip("node is missing (deploy/install_packages.sh web)")
    if not os.path.exists(os.path.join(PAGE, "index.html")):
        skip(f"the page is not built: no index.html in {PAGE} (build the target web)")
    if not os.path.isdir(os.path.join(ROOT, "client/web/node_modules/playwright-core")):
        skip("the packages of client/web are not installed (build the target web)")
    if not os.path.isdir(programs.MODELS):
        skip(f"no motion in {programs.MODELS} (deploy/install_packages.sh test)")


def run(server, *arguments):
    result = server.run(*arguments)
    if result.returncode != 0:
        sys.exit(f"web_page_test: motiondb {' '.join(arguments)}: {result.stderr}")


def load_motion(server, folder):
    """Stores a database `demo` with a model, and `hostile`, whose texts are HTML."""
    models = programs.MODELS
    run(server, "create", "demo")
    for file, label in (("01_01", "jump"), ("01_03", "climb"), ("Boxing_Toes", "boxing")):
        run(server, "ingest", "demo", f"{models}/{file}.bvh", "--label", label)
    run(server, "create", "hostile", "--marker-set", "source")
    with open(f"{models}/01_01.bvh", encoding="utf-8") as file:
        motion = file.read()
    os.mkdir(os.path.join(folder, "hostile"))
    hostile = os.path.join(folder, "hostile/01_01.bvh")
    with open(hostile, "w", encoding="utf-8") as file:
        file.write(motion.replace("JOINT Head", "JOINT " + HOSTILE_MARKER))
    run(server, "ingest", "hostile", hostile, "--label", HOSTILE, "--subject", "S" + HOSTILE,
        "--title", "T" + HOSTILE, "--description", "D" + HOSTILE,
        "--field", "note=F" + HOSTILE)
    # Recorded clips with many markers, where they are.
    index = os.path.join(programs.DATA, "index.tsv")
    return os.path.exists(index)


def start_servers(folder):
    """Returns a server without authentication, one with tokens, and one of the large store or None."""
    web = ("--web-listen", "127.0.0.1:0")

    def options(name):
        return (os.path.join(folder, f"{name}.db"), *web)

    open_server = programs.Server(*options("open"), "--http-listen", "127.0.0.1:0")
    token_file = os.path.join(folder, "token")
    with open(os.open(token_file, os.O_CREAT | os.O_WRONLY, 0o600), "w") as file:
        file.write(ADMIN_TOKEN + "\n")
    secure = programs.Server(*options("secure"), "--authentication", "token", "--admin-token-file",
                             token_file)
    store = os.environ.get("MOTIONDB_LARGE_STORE")
    return open_server, secure, programs.Server(store, *web) if store else None


def run_part(names, deadline, output):
    """Runs test files in one process with one browser and servers of its own; returns its exit code."""
    with tempfile.TemporaryDirectory() as folder:
        open_server, secure, large = start_servers(folder)
        try:
            has_recorded = load_motion(open_server, folder)
            setup = {"open": open_server.web, "openMetrics": open_server.http,
                     "secure": secure.web, "adminToken": ADMIN_TOKEN,
                     "openAddress": open_server.address, "secureAddress": secure.address,
                     "motiondb": programs.MOTIONDB, "motiondbd": programs.MOTIONDBD,
                     "models": programs.MODELS,
                     "data": programs.DATA if has_recorded else "", "chromium": find_chromium(),
                     "hostile": HOSTILE, "hostileMarker": HOSTILE_MARKER, "root": ROOT, "folder": folder,
                     "large": {"web": large.web, "pid": large.process.pid} if large else None}
            return subprocess.run(
                ["node", "--test-reporter=spec", os.path.join(HERE, "run_tests.mjs"), *names],
                env=os.environ | {"MOTIONDB_WEB_TEST": json.dumps(setup)}, stdout=output,
                timeout=max(1, deadline - time.monotonic())).returncode
        except subprocess.TimeoutExpired:
            print(f"web_page_test: not finished after {TIME_LIMIT} s", file=output or sys.stdout, flush=True)
            return 1
        finally:
            for server in (open_server, secure, large):
                if server:
                    server.stop()


def main():
    begin = time.monotonic()
    find_chromium()
    check_requirements()
    if TESTS:
        codes = [run_part(TESTS, begin + TIME_LIMIT, None)]
    else:
        # Two halves at the same time, because tests and browser wait for each other; `memory` is the
        # longest.
        names = sorted({os.path.basename(path).removesuffix(".test.mjs")
                        for path in glob.glob(os.path.join(HERE, "*.test.mjs"))}
                       - {"speed", "large"}, key=lambda name: (name == "memory", name))
        half = len(names) // 2
        with contextlib.ExitStack() as stack:
            outputs = [stack.enter_context(tempfile.TemporaryFile("w+")) for _ in range(2)]
            pool = stack.enter_context(concurrent.futures.ThreadPoolExecutor())
            codes = list(pool.map(run_part, (names[:half], names[half:]), [begin + TIME_LIMIT] * 2, outputs))
            for output in outputs:
                output.seek(0)
                print(output.read())
    if any(codes):
        sys.exit("web_page_test: failed")
    print(f"web_page_test: passed in {time.monotonic() - begin:.0f} s")


if __name__ == "__main__":
    main()
