#!/usr/bin/python3
"""Checks README.md and docs/: output of commands, code, links and names.

    docs_test.py MOTIONDBD MOTIONDB
"""

import glob
import os
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

MOTIONDBD, MOTIONDB = [os.path.abspath(path) for path in sys.argv[1:3]]
ROOT = os.path.normpath(os.path.join(os.path.dirname(os.path.abspath(__file__)), "../.."))
MODELS = "/usr/share/assimp/models/BVH"
PAGES = ["README.md"] + sorted(os.path.relpath(path, ROOT) for path in glob.glob(f"{ROOT}/docs/*.md"))
GENERATED = "docs/command_line.md"
SOURCES = ("core", "import", "storage", "server", "client", "text", "tests", "proto", "deploy")
# A block of code, with an optional comment before it that states why it is not run.
BLOCK = re.compile(r"(?:^<!-- not run: (?P<reason>[^\n]+) -->\n)?^```(?P<language>\w*)\n(?P<text>.*?)^```$",
                   re.MULTILINE | re.DOTALL)
NUMBER = re.compile(r"[-+]*\d+(\.\d+)?")


def read(path):
    with open(os.path.join(ROOT, path), encoding="utf-8") as file:
        return file.read()


def blocks(page):
    return [match.groupdict() for match in BLOCK.finditer(read(page))]


def shell_blocks(page):
    """Blocks with commands to run."""
    return [block["text"] for block in blocks(page) if block["reason"] is None
            and (block["language"] == "sh" or re.search(r"^\$ ", block["text"], re.MULTILINE))]


def commands(text):
    """Returns [(command, expected output lines)]. A backslash continues a command."""
    result = []
    for line in text.splitlines():
        if line.startswith("$ "):
            result.append((line[2:], []))
        elif result and not result[-1][1] and result[-1][0].endswith("\\"):
            result[-1] = (result[-1][0] + "\n" + line, [])
        elif result:
            result[-1][1].append(line)
        else:
            result.append((line, []))  # in a block marked as shell
    return result


def stable(line):
    """Returns the line with numbers and column widths normalised, because they vary."""
    return " ".join(NUMBER.sub("N", line).split())


def matches(shown, printed):
    """Returns the number of shown lines that match the printed ones; len(shown) if all lines match.
    "..." matches any lines, and at the end of a line the rest of the line."""
    printed = [stable(line) for line in printed]
    ends = {0}  # possible numbers of printed lines that the shown lines so far match
    for count, line in enumerate(shown):
        wanted = stable(line)
        if wanted == "...":
            ends = set(range(min(ends), len(printed) + 1))
        elif wanted.endswith("..."):
            begin = wanted.removesuffix("...").rstrip()
            ends = {end + 1 for end in ends if end < len(printed) and printed[end].startswith(begin)}
        else:
            ends = {end + 1 for end in ends if end < len(printed) and printed[end] == wanted}
        if not ends:
            return count
    return len(shown) if len(printed) in ends else len(shown) - 1


def difference(shown, printed):
    """Returns the first shown line that does not match, or None."""
    count = matches(shown, printed)
    return None if count == len(shown) else shown[count]


class Session:
    """A server, and a shell in a temporary folder for the commands of a page."""

    def __init__(self):
        self.folder = tempfile.TemporaryDirectory()
        self.server = None
        path = os.pathsep.join([os.path.dirname(MOTIONDBD), os.path.dirname(MOTIONDB), os.environ["PATH"]])
        self.environment = {**os.environ, "PATH": path}
        for name in [name for name in self.environment if name.startswith("MOTIONDB")]:
            del self.environment[name]

    def run(self, command):
        """Returns exit code and output lines. Variables persist for the next command."""
        script = f'[ ! -e .state ] || . ./.state\n{command}\ncode=$?\ndeclare -p B >.state 2>/dev/null\nexit $code\n'
        ran = subprocess.run(["bash", "-c", script], cwd=self.folder.name, env=self.environment, text=True,
                             stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=300)
        return ran.returncode, ran.stdout.splitlines()

    def serve(self, command="motiondbd --store motion.db --listen 127.0.0.1:50051"):
        """Starts the server at a free port instead of the port in the command."""
        command = re.sub(r"--listen 127\.0\.0\.1:\d+", "--listen 127.0.0.1:0", command)
        self.server = subprocess.Popen(["bash", "-c", f"exec {command} --http-listen none --log-level error"],
                                       cwd=self.folder.name, env=self.environment, text=True,
                                       stdout=subprocess.PIPE)
        line = self.server.stdout.readline().rstrip("\n")
        self.environment["MOTIONDB_SERVER"] = line.rsplit(" ", 1)[-1]
        return 0, [line]

    def close(self):
        if self.server is not None:
            self.server.terminate()
            self.server.wait(timeout=60)
            self.server.stdout.close()
        self.folder.cleanup()


class CommandsTest(unittest.TestCase):
    """The shown output of each command is its real output."""

    def check(self, page):
        session = Session()
        self.addCleanup(session.close)
        if not any("$ motiondbd " in block for block in shell_blocks(page)):
            session.serve()
        count = 0
        for block in shell_blocks(page):
            for command, shown in commands(block):
                serves = command.startswith("motiondbd ")
                code, printed = session.serve(command) if serves else session.run(command)
                self.assertEqual(code, 0, f"{page}: {command}\n" + "\n".join(printed))
                wrong = difference(shown, printed) if shown else None
                self.assertIsNone(wrong, f"{page}: {command}\nshows: {wrong}\nprinted:\n" + "\n".join(printed[-20:]))
                count += 1
        return count

    def test_the_tour(self):
        if not os.path.exists(MODELS):
            self.skipTest("no motion to ingest; deploy/install_packages.sh demo")
        self.assertGreater(self.check("README.md"), 6)

    def test_the_pages(self):
        for page in PAGES[1:]:
            if shell_blocks(page):
                with self.subTest(page):
                    if MODELS in read(page) and not os.path.exists(MODELS):
                        self.skipTest("no motion to ingest; deploy/install_packages.sh demo")
                    self.check(page)

    def test_a_difference_is_found(self):
        printed = ["model 1", "a  7.5 s", "b 3", "the end"]
        for shown in (["model 2", "a 1 s", "b 3", "the end"], ["...", "the end"], ["model 1", "..."],
                      ["model 1", "a ...", "...", "the ..."], ["..."]):
            self.assertIsNone(difference(shown, printed), shown)
        for shown in (["model 1"], ["modes 1", "..."], ["...", "c 3", "..."], ["...", "the end", "more"],
                      ["the end", "..."]):
            self.assertIsNotNone(difference(shown, printed), shown)


class CodeTest(unittest.TestCase):
    def test_the_snippet_is_an_example_that_is_built(self):
        text, = [block["text"] for block in blocks("README.md") if block["language"] == "cpp"]
        self.assertEqual(text, read("client/example/name_motion.cc"))
        self.assertIn("name_motion", read("client/example/CMakeLists.txt"))

    def test_the_client_in_python(self):
        plugin = shutil.which("grpc_python_plugin")
        protoc = shutil.which("protoc")
        has_grpc = subprocess.run(["/usr/bin/python3", "-c", "import grpc"], capture_output=True)
        if plugin is None or protoc is None or has_grpc.returncode != 0:
            self.skipTest("no gRPC for Python; apt install protobuf-compiler-grpc python3-grpcio")
        if not os.path.exists(MODELS):
            self.skipTest("no motion to ingest; deploy/install_packages.sh demo")
        session = Session()
        self.addCleanup(session.close)
        session.serve()
        text, = [block["text"] for block in blocks("docs/api.md") if block["language"] == "python"]
        with open(os.path.join(session.folder.name, "client.py"), "w", encoding="utf-8") as file:
            file.write(text)
        made = session.run(f"{protoc} -I {ROOT}/proto --python_out=. --grpc_out=. "
                           f"--plugin=protoc-gen-grpc={plugin} {ROOT}/proto/motiondb/v1/*.proto")
        self.assertEqual(made[0], 0, made[1])
        code, printed = session.run("PROTOCOL_BUFFERS_PYTHON_IMPLEMENTATION=python /usr/bin/python3 -B client.py "
                                    f'"$MOTIONDB_SERVER" {MODELS}/Boxing_Toes.bvh')
        self.assertEqual(code, 0, "\n".join(printed))
        self.assertEqual([stable(line) for line in printed],
                         ["label boxing", "horizons N", "metres from the goal N", "frame N boxing"])

    def test_the_command_line_page_is_up_to_date(self):
        script = "deploy/manual/write_command_line.py"
        written = subprocess.run(["/usr/bin/python3", "-B", os.path.join(ROOT, script), MOTIONDB, MOTIONDBD],
                                 capture_output=True, text=True, check=True).stdout
        self.assertEqual(written.splitlines(), read(GENERATED).splitlines(),
                         f"out of date; to regenerate: {script} MOTIONDB MOTIONDBD > {GENERATED}")


def anchors(page):
    """Returns the anchors of headings, as on repository web pages."""
    return {re.sub(r"[^\w -]", "", heading.lower()).replace(" ", "-")
            for heading in re.findall(r"^#+ (.*)$", read(page), re.MULTILINE)}


class NamesTest(unittest.TestCase):
    """Links, files and names in pages exist."""

    def test_links_lead_somewhere(self):
        for page in PAGES:
            for link in re.findall(r"\]\(([^)\s]+)\)|src=\"([^\"]+)\"", read(page)):
                target, _, anchor = (link[0] or link[1]).partition("#")
                if target.startswith(("http:", "https:")):
                    continue
                path = os.path.normpath(os.path.join(os.path.dirname(page), target)) if target else page
                self.assertTrue(os.path.exists(os.path.join(ROOT, path)), f"{page}: {target}")
                if anchor:
                    self.assertIn(anchor, anchors(path), f"{page}: {target}")

    def test_files_exist(self):
        known = re.compile(r"(?<![\w/.{-])((?:" + "|".join(SOURCES + ("docs",)) + r")/[\w./-]*\w|"
                           r"[A-Z]+\.md)(?![\w{*])")
        for page in PAGES:
            for path in known.findall(re.sub(r"https?://\S+", "", read(page))):
                self.assertTrue(os.path.exists(os.path.join(ROOT, path)), f"{page}: {path}")

    def test_names_are_in_the_sources(self):
        words = set()
        for folder in SOURCES:
            for path in glob.glob(f"{ROOT}/{folder}/**/*.*", recursive=True):
                if path.endswith((".h", ".cc", ".proto", ".py", ".yml")):
                    with open(path, encoding="utf-8") as file:
                        words.update(re.findall(r"\w+", file.read()))
        for page in PAGES:
            if page == GENERATED:
                continue
            for name in re.findall(r"`((?:\w+::)*[A-Z][a-z]+[A-Z]\w*(?:::\w+)*|\w+::\w+)`", read(page)):
                for part in name.split("::"):
                    self.assertTrue(part in words, f"{page}: `{name}` is not in the sources")

    def test_every_reason_of_an_error_is_documented(self):
        reasons = set()
        for folder in ("core", "server", "storage"):
            for path in glob.glob(f"{ROOT}/{folder}/**/*.cc", recursive=True):
                with open(path, encoding="utf-8") as file:
                    reasons.update(re.findall(r'WithReason\(\s*"([A-Z_]+)"', file.read()))
        self.assertGreater(len(reasons), 20)
        documented = set(re.findall(r"[A-Z_]{4,}", read("docs/api.md")))
        self.assertEqual(reasons - documented, set())

    def test_pages_are_short_and_narrow(self):
        self.assertLessEqual(len(read("README.md").splitlines()), 150)
        for page in PAGES:
            if page == GENERATED:
                continue
            text = BLOCK.sub("", read(page))
            for line in text.splitlines():
                if not line.startswith(("|", "<")):
                    self.assertLessEqual(len(line), 100, f"{page}: {line}")


unittest.main(argv=sys.argv[:1], verbosity=2)
