#!/usr/bin/python3
"""The command line on a terminal: width, colours, help, merged windows, completion in shells.

    terminal_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import concurrent.futures
import os
import re
import shlex
import shutil
import subprocess

from command_line import CommandLine
from programs import MOTIONDB, main
from terminal import COLOUR

COMPLETIONS = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../deploy/completion")


def commands_below(words=()):
    """Yields the words of all commands, from their help."""
    yield list(words)
    text = subprocess.run([MOTIONDB, *words, "--help"], capture_output=True, text=True,
                          check=True).stdout
    listed = text.partition("Subcommands:\n")[2].partition("\n\n")[0]
    for command in re.findall(r"^  ([a-z-]+)", listed, re.MULTILINE):
        yield from commands_below([*words, command])


class Terminal(CommandLine):
    def test_no_table_is_wider_than_the_terminal(self):
        self.server.run("token", "create", "--role", "reader", "--description", "word " * 40)
        self.server.run("update", "walks", "clip0", "--title", "step " * 20, "--tag", "t" * 60)
        tables = [["list"], ["list", "walks"], ["operations", "list"], ["token", "list"], ["audit"],
                  ["status"], ["formats"], ["recognize", "walks", self.files[0], "--every-window"],
                  ["predict", "walks", self.files[0]], ["mapping", "list", "walks"],
                  ["segments", "list", "walks"], ["history", "walks"], ["search", "walks", "step"],
                  ["list", "walks", "--facets", "label,track"]]
        for columns in (40, 60, 80, 120):
            for command in tables:
                for line in COLOUR.sub("", self.show(*command, columns=columns)).splitlines():
                    is_sentence = line.startswith(("from ", "no probability", "the model is new", "and "))
                    self.assertTrue(is_sentence or len(line) <= columns, (columns, command, line))
        # In a pipe nothing is cut.
        self.assertIn(("word " * 40).strip()[:180], self.server.run("token", "list").stdout)

    def test_help_fits_and_has_examples_that_parse(self):
        examples = []
        for words in commands_below():
            shown = COLOUR.sub("", self.show(*words, "--help"))
            for line in shown.splitlines():
                self.assertLessEqual(len(line), 80, line)
            found = re.findall(r"^  (motiondb .*)$", shown.partition("\nExamples:\n")[2], re.MULTILINE)
            self.assertTrue(found, words)
            examples += found
            if words and words[0] != "help":
                self.assertEqual(self.server.run("help", *words).stdout,
                                 self.server.run(*words, "--help").stdout)
        self.assertGreater(len(examples), 50)

        def run(example):
            # Another server, in an empty folder: anything but a usage error.
            result = subprocess.run([os.path.abspath(MOTIONDB), "--server", "127.0.0.1:1", *shlex.split(example)[1:]],
                                    capture_output=True, text=True, cwd=self.folder.name)
            self.assertNotEqual(result.returncode, 2, (example, result.stderr))

        # Together, because each waits for the server for two seconds.
        with concurrent.futures.ThreadPoolExecutor(40) as pool:
            list(pool.map(run, examples))

    def test_colours(self):
        colours = COLOUR.findall
        self.assertTrue(colours(self.show("list")))
        self.assertTrue(colours(self.show("list", "--help")))
        self.assertFalse(colours(self.show("list", environment={"NO_COLOR": "1"})))
        self.assertFalse(colours(self.show("list", environment={"TERM": "dumb"})))
        self.assertFalse(colours(self.show("list", "--csv")))
        self.assertFalse(colours(self.server.run("list").stdout))
        self.show("list", "--output", self.path("list.txt"))
        with open(self.path("list.txt"), encoding="utf-8") as file:
            self.assertEqual(file.read(), self.server.run("list").stdout)

    def test_windows_are_merged_and_the_summary_comes_first(self):
        command = ["recognize", "walks", self.files[0]]
        windows = self.server.ask_one(*command)["windows"]
        every = self.server.run(*command, "--every-window").stdout.splitlines()
        merged = self.server.run(*command).stdout.splitlines()
        self.assertEqual(len([line for line in every if re.match(r" *\d", line)]), len(windows))
        rows = [line.split() for line in merged if re.match(r" *\d", line)]
        self.assertEqual(sum(int(row[2]) for row in rows), len(windows))
        self.assertLess(len(rows), len(windows))
        self.assertEqual(float(rows[0][0]), 0)
        self.assertAlmostEqual(float(rows[-1][1]), windows[-1]["end_seconds"], delta=0.006)
        share = re.compile(r"^(big step|sit|unknown) \d+ % \(")
        tall = COLOUR.sub("", self.show(*command, "--every-window", rows=100)).splitlines()
        low = COLOUR.sub("", self.show(*command, "--every-window", rows=8)).splitlines()
        self.assertRegex(low[0], share)
        self.assertFalse(share.match(tall[0]))
        self.assertEqual(sorted(low), sorted(tall))

    def test_version(self):
        text = self.server.run("version").stdout
        self.assertEqual(text, self.server.run("--version").stdout)
        self.assertEqual(text, f"motiondb {self.server.ask_one('version')['version']}\n")


class Completion(CommandLine):
    def setUp(self):
        super().setUp()
        self.environment = {**os.environ, "MOTIONDB_SERVER": self.server.address,
                            "PATH": os.path.dirname(os.path.abspath(MOTIONDB)) + ":" + os.environ["PATH"]}

    # The words before the cursor, and what is offered.
    CASES = ((["reco"], ["recognize"]), (["recognize", "wal"], ["walks"]), (["token", "cr"], ["create"]),
             (["export", "walks", "clip"], ["clip0", "clip1", "clip2", "clip3"]),
             (["plan", "walks", "--start", "clip1"], ["clip1@"]), (["plan", "walks", "--label", "s"], ["sit"]),
             (["ingest", "walks", "x.bvh", "--label", "big"], ["big step"]),
             (["recognize", "walks", "--method", ""], ["best", "paper"]),
             (["recognize", "walks", "--unk"], ["--unknown-threshold"]), (["list", "--js"], ["--json"]),
             (["token", "create", "--database", ""], ["walks"]), (["help", "restor"], ["restore"]),
             (["create", "wal"], []), (["recognize", "walks", "cl"], []))

    def run_shell(self, command):
        result = subprocess.run(command, capture_output=True, text=True, env=self.environment, timeout=60)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result.stdout.splitlines()

    def test_bash(self):
        script = ('. "$1"; shift; COMP_WORDS=("$@"); COMP_CWORD=$(($# - 1)); _motiondb; '
                  '[ ${#COMPREPLY[@]} = 0 ] || printf "%s\\n" "${COMPREPLY[@]}"')
        for words, expected in self.CASES + ((["recognize", "walks", "--method", "=", "b"], ["best"]),):
            offered = self.run_shell(["bash", "-c", script, "-", f"{COMPLETIONS}/motiondb.bash", "motiondb", *words])
            self.assertEqual([shlex.split(word)[0] for word in offered], expected, words)

    def test_fish(self):
        if shutil.which("fish") is None:
            self.skipTest("no fish; deploy/install_packages.sh deploy-test")
        for words, expected in self.CASES:
            if not expected:
                continue  # fish then offers files
            line = " ".join(["motiondb", *(shlex.quote(word) if word else "" for word in words)])
            offered = self.run_shell(["fish", "--no-config", "-c",
                                      f"source {COMPLETIONS}/motiondb.fish; complete -C {shlex.quote(line)}"])
            self.assertEqual(sorted(word.split("\t")[0] for word in offered), sorted(expected), words)

    def test_zsh(self):
        if shutil.which("zsh") is None:
            self.skipTest("no zsh; deploy/install_packages.sh deploy-test")
        # The functions of the completion system, replaced by ones that print.
        script = ("words=(\"${(@)argv[2,-1]}\"); CURRENT=$#words; "
                  "_describe() { print -rl -- \"${(@P)2}\" }; _files() { }; . $1")
        for words, expected in self.CASES:
            offered = self.run_shell(["zsh", "-f", "-c", script, "zsh", f"{COMPLETIONS}/_motiondb", "motiondb", *words])
            self.assertEqual([word.split(":")[0] for word in offered], expected, words)

    def test_without_a_server_or_with_a_typo_nothing_is_offered(self):
        for words in (["describe", ""], ["export", "none", "c"], ["nonsense", "--unknown", ""]):
            result = subprocess.run([MOTIONDB, "__complete", "--server", "127.0.0.1:1", *words],
                                    capture_output=True, text=True, timeout=60)
            self.assertEqual((result.returncode, result.stderr), (0, ""), words)
            self.assertEqual([line for line in result.stdout.splitlines() if words[0] != "nonsense"], [], words)


main()
