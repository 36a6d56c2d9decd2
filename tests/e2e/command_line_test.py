#!/usr/bin/python3
"""The command line as users see it: wrong usage, suggestions, several files, output files, CSV.

    command_line_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import csv
import json
import os
import shutil
import subprocess

from command_line import CommandLine
from programs import MOTIONDB, Server, main


class Options(CommandLine):
    def test_options_without_effect_on_the_method_are_refused(self):
        seen = self.files[0]
        for option in ("--layer=2", "--floor=0", "--paths=3"):
            name = option.split("=")[0]
            self.refuse(f"{name} has no effect with --method best", "recognize", "walks", seen, option)
            self.server.ask_one("recognize", "walks", seen, option, "--method", "paper")
            # The profile is made by the paper's method.
            self.server.ask_one("recognize", "walks", seen, option, "--plot-profile",
                                self.path("profile.svg"))
        self.refuse("--unknown-threshold has no effect with --method paper", "recognize", "walks",
                    seen, "--method", "paper", "--unknown-threshold", "0.3")

    def test_usage_errors_exit_with_2(self):
        seen = self.files[0]
        for expected, *arguments in (
                ("unknown command: recognise; did you mean 'recognize'?", "recognise", "walks", seen),
                ("unknown command: lst; did you mean 'list'?", "operations", "lst"),
                ("unknown option: --windw; did you mean '--window'?", "recognize", "walks", seen, "--windw=1"),
                ("unknown option: --jsn; did you mean '--json'?", "--jsn", "list"),
                ("unknown command: pln; did you mean 'plan'?", "help", "pln"),
                ("unexpected argument: more", "describe", "walks", "more"),
                ("'.fbx' is no format", "plan", "walks", "--goal", "1,0,0", "--out", "plan.fbx"),
                ("FILE.svg", "plan", "walks", "--goal", "1,0,0", "--plot", "plan.pdf"),
                ("FILE.svg", "recognize", "walks", seen, "--plot", "answer.pdf"),
                ("need one file", "recognize", "walks", *self.files, "--plot", "answer.svg"),
                ("no format", "export", "walks", "clip0", "--as", "fbx"),
                ("no format", "convert", seen, self.path("x.txt")),
                ("nothing to ingest", "ingest", "walks"),
                ("--quiet excludes", "ingest", "walks", seen, "--quiet", "--json"),
                ("did you mean 30d?", "token", "create", "--role", "reader", "--expires", "30"),
                ("prints no table", "describe", "walks", "--csv"),
                ("--csv excludes --json", "list", "--csv", "--json"),
                ("three numbers", "plan", "walks", "--goal", "1deg,0,0"),
                ("expected standard34, source or a file", "create", "new", "--marker-set", "standrd34"),
                ("expected either", "marker-set", "show")):
            self.refuse(expected, *arguments)

    def test_databases_and_clips_are_suggested(self):
        for expected, *arguments in (
                ("'walk' does not exist; did you mean 'walks'?", "recognize", "walk", self.files[0]),
                ("did you mean 'walks'?", "describe", "wlaks"),
                ("did you mean 'walks'?", "ingest", "walkss", self.files[0]),
                ("has no clip 'clip'; did you mean 'clip0'?", "delete", "walks", "clip"),
                ("did you mean 'clip3'?", "export", "walks", "cilp3"),
                ("did you mean 'clip2'?", "plan", "walks", "--goal", "1,0,0", "--start", "clp2@0.1")):
            self.refuse(expected, *arguments, code=1)
        self.assertNotIn("did you mean", self.refuse("does not exist", "describe", "other", code=1).stderr)

    def test_degrees(self):
        plans = [self.server.ask_one("plan", "walks", "--start", "clip0@0.1", "--goal", f"0.5,0,{heading}",
                                     "--tolerance", f"0.3,{tolerance}", "--method", "random")
                 for heading, tolerance in (("0.1745329252", "0.5235987756"), ("10deg", "30deg"),
                                            ("0.1745329252rad", "30deg"))]
        for plan in plans:
            del plan["effort"]["search_seconds"], plan["effort"]["total_seconds"]
        self.assertEqual(plans[0]["outcome"], plans[1]["outcome"])
        self.assertEqual(plans[1]["outcome"], plans[2]["outcome"])

    def test_outputs_are_checked_before_computing(self):
        missing = self.path("none/answer")
        calls = lambda: sum(method["call_count"] for method in self.server.ask_one("status")["methods"]
                            if method["method"].startswith("QueryService"))
        before = calls()
        for command in (["recognize", "walks", self.files[0], "--plot", missing + ".svg"],
                        ["recognize", "walks", self.files[0], "--plot-profile", missing + ".svg"],
                        ["recognize", "walks", self.files[0], "--output", missing],
                        ["plan", "walks", "--goal", "1,0,0", "--out", missing + ".bvh"],
                        ["plan", "walks", "--goal", "1,0,0", "--plot", missing + ".svg"],
                        ["convert", self.files[0], missing + ".trc"],
                        ["inspect", self.files[0], "--plot", missing + ".svg"]):
            self.refuse("cannot be written", *command, code=1)
        self.assertEqual(calls(), before)
        self.refuse("neither a regular file nor", "list", "--output", self.folder.name, code=1)


class Restored(CommandLine):
    def test_restore_lists_tokens_that_become_valid(self):
        kept = self.server.ask_one("token", "create", "--role", "admin")["token"]["name"]
        revoked = self.server.ask_one("token", "create", "--role", "reader")["token"]["name"]
        dead = self.server.ask_one("token", "create", "--role", "reader")["token"]["name"]
        self.server.run("token", "revoke", dead)
        backup = self.path("copy.mdb")
        self.server.ask("backup", backup)
        self.server.run("token", "revoke", revoked)
        # In its own store the token stays revoked.
        self.server.run("delete", "walks", "--yes")
        own = self.server.run("restore", backup)
        self.assertEqual(own.returncode, 0, own.stderr)
        self.assertNotIn("valid", own.stdout)
        # Another store has no record of the revocation.
        other = Server(self.path("other.db"))
        try:
            for json_flag in ([], ["--json"]):
                restored = other.run("restore", backup, *json_flag)
                self.assertEqual(restored.returncode, 0, restored.stderr)
                listed = restored.stderr if json_flag else restored.stdout
                self.assertIn("2 tokens of the backup are valid now", listed)
                for name in (kept, revoked):
                    self.assertIn(name.split("/")[1], listed)
                self.assertNotIn(dead.split("/")[1], listed)
                if json_flag:
                    self.assertEqual(json.loads(restored.stdout), {"database_count": 1, "clip_count": 4})
                other.stop()
                other = Server(self.path("third.db"))
        finally:
            other.stop()


class Files(CommandLine):
    def test_several_files_folders_and_standard_input(self):
        folder = self.path("recordings")
        os.mkdir(folder)
        for file in self.files[:2]:
            shutil.copy(file, folder)
        names = [os.path.join(folder, os.path.basename(file)) for file in self.files[:2]]
        for command in (["recognize", "walks"], ["estimate", "walks"], ["predict", "walks", "--at", "1"],
                        ["find", "walks"]):
            alone = [self.server.ask_one(*command, name) for name in names]
            self.assertNotIn("file", alone[0])
            expected = [{"file": name, **answer} for name, answer in zip(names, alone)]
            self.assertEqual(self.server.ask(*command, *names), expected)
            self.assertEqual(self.server.ask(*command, folder), expected)
            piped = subprocess.run([MOTIONDB, "--server", self.server.address, "--json", *command, "-"],
                                   input="\n".join(names), capture_output=True, text=True, check=True)
            self.assertEqual([json.loads(line) for line in piped.stdout.splitlines()], expected)
            text = self.server.run(*command, folder).stdout
            for name in names:
                self.assertEqual(text.count(name + "\n"), 1)

    def test_a_bad_file_does_not_stop_the_others(self):
        bad = self.path("empty.bvh")
        open(bad, "w", encoding="ascii").close()
        for command in (["recognize", "walks"], ["estimate", "walks"], ["predict", "walks"], ["find", "walks"]):
            result = self.server.run("--json", *command, bad, self.files[0], self.path("none.bvh"))
            self.assertEqual(result.returncode, 1)
            self.assertEqual([json.loads(line)["file"] for line in result.stdout.splitlines()], [self.files[0]])
            for text in (bad, "none.bvh: no such file", "2 of 3 files had no answer"):
                self.assertIn(text, result.stderr)
        self.refuse(f"motiondb: {bad}: the file is empty\n", "ingest", "walks", bad, code=1)

    def test_output_and_csv(self):
        answers = self.path("answers")
        printed = self.server.run("recognize", "walks", *self.files, "--json").stdout
        self.assertEqual(self.server.run("recognize", "walks", *self.files, "--json", "--output", answers).stdout, "")
        with open(answers, encoding="utf-8") as file:
            self.assertEqual(file.read(), printed)
        self.assertEqual(self.server.run("describe", "none", "--output", answers + "2").returncode, 1)
        self.assertFalse(os.path.exists(answers + "2"))
        rows = self.csv("recognize", "walks", *self.files)
        windows = [{"file": answer["file"], **window} for answer in map(json.loads, printed.splitlines())
                   for window in answer["windows"]]
        self.assertEqual([row["FILE"] for row in rows], [window["file"] for window in windows])
        for row, window in zip(rows, windows):
            self.assertAlmostEqual(float(row["FAMILIARITY"]), window["familiarity"], places=6)
        predicted = self.csv("predict", "walks", self.files[0], "--every", "0.5")
        self.assertNotIn("FILE", predicted[0])
        self.assertEqual(len(predicted), 6 * len(self.server.ask("predict", "walks", self.files[0], "--every", "0.5")))
        path, = self.server.ask_one("estimate", "walks", self.files[0])["paths"]
        runs = self.csv("estimate", "walks", self.files[0])
        self.assertEqual([int(run["NODE"]) for run in runs for _ in range(int(run["FRAMES"]))], path["node_ids"])
        self.assertEqual([row["CLIP"] for row in self.csv("list", "walks")], [f"clip{i}" for i in range(4)])
        for command in (["list"], ["operations", "list"], ["audit"], ["formats"], ["token", "list"],
                        ["mapping", "list", "walks"]):
            self.csv(*command)

    def csv(self, *command):
        result = self.server.run(*command, "--csv")
        self.assertEqual(result.returncode, 0, result.stderr)
        return list(csv.DictReader(result.stdout.splitlines(), strict=True))


main()
