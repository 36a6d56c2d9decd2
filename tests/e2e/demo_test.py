#!/usr/bin/python3
"""Runs the queries of the quickstart, deploy/demo/demo.sh, and compares what it prints with the
truth.

    demo_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import filecmp
import os
import re
import signal
import subprocess
import tempfile
import unittest

from programs import MODELS, MOTIONDB, MOTIONDBD, main

DEMO = os.path.join(os.path.dirname(__file__), "../../deploy/demo")


class Demo(unittest.TestCase):
    def setUp(self):
        if not os.path.exists(f"{MODELS}/Boxing_Toes.bvh"):
            self.skipTest("no boxer; deploy/install_packages.sh demo")
        self.folder = tempfile.TemporaryDirectory()
        self.demo = os.path.join(self.folder.name, "demo")
        self.programs = os.path.join(self.folder.name, "bin")
        os.mkdir(self.programs)
        for program in (MOTIONDBD, MOTIONDB):
            os.symlink(program, os.path.join(self.programs, os.path.basename(program)))

    def tearDown(self):
        os.kill(self.server_process(), signal.SIGTERM)
        self.folder.cleanup()

    def server_process(self):
        with open(os.path.join(self.demo, "server.pid"), encoding="ascii") as file:
            return int(file.read())

    def run_demo(self):
        """Returns the output of each command by its arguments, and the last lines by their names."""
        result = subprocess.run([f"{DEMO}/demo.sh", self.programs, self.demo], text=True,
                                stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=600)
        self.assertEqual(result.returncode, 0, result.stdout)
        parts = re.split(r"^\$ motiondb (.*)\n", result.stdout, flags=re.MULTILINE)
        outputs = dict(zip(parts[1::2], parts[2::2]))
        ending = dict(re.findall(r"^([a-z ]+): +(.*)$", parts[-1], flags=re.MULTILINE))
        return outputs, ending

    def test_every_answer_agrees_with_the_truth(self):
        os.mkdir(self.demo)
        other = subprocess.Popen(["sleep", "1000"])
        with open(os.path.join(self.demo, "server.pid"), "w", encoding="ascii") as file:
            file.write(str(other.pid))
        outputs, ending = self.run_demo()
        self.assertIsNone(other.poll(), "only a server of the demo is stopped")
        other.kill()
        other.wait()
        text = outputs["recognize demo new"]
        files = re.split(r"^(new/\S+)\.bvh\n", text, flags=re.MULTILINE)
        self.assertEqual(len(files[1::2]), 9, text)
        for path, answers in zip(files[1::2], files[2::2]):
            kind = os.path.basename(path).split("-")[0]
            truth = "unknown" if kind == "boxing" else kind
            printed = re.findall(r"^ *[0-9.]+ +[0-9.]+ +[0-9]+ +(\S+)", answers, flags=re.MULTILINE)
            self.assertGreater(len(printed), 0, text)
            self.assertEqual(set(printed), {truth}, text)
            self.assertRegex(answers, rf"(?m)^{truth} 100 % ")

        predicted = next(text for name, text in outputs.items() if name.startswith("predict "))
        titles = re.split(r"  +", next(line for line in predicted.splitlines()
                                       if "AHEAD" in line).strip())
        row = re.split(r"  +", next(line for line in predicted.splitlines()
                                    if line.strip().startswith("0.40 ")).strip())
        values = dict(zip(titles, row))
        self.assertLessEqual(float(values["ACTUAL (m)"]), 2 * float(values["ERROR (m)"]), predicted)

        planned = next(text for name, text in outputs.items() if name.startswith("plan "))
        self.assertTrue(planned.startswith("EXACT\n"), planned)
        for name in ("plan.svg", "plan.bvh"):
            self.assertGreater(os.path.getsize(os.path.join(self.demo, name)), 1000)

        self.assertEqual(ending["programs"], os.path.realpath(self.programs))
        address = ending["server"].split()[0]
        self.assertIn(f"motiondbd --store {self.demo}/motion.db --listen {address}",
                      ending["restart"])
        self.assertIn(f"{self.demo}/plan.svg", ending["open next"])
        listed = subprocess.run([MOTIONDB, "--server", address, "list"], capture_output=True,
                                text=True)
        self.assertIn("demo", listed.stdout)

        # Again: the same motion and answers, by a new server.
        first = self.server_process()
        stored = os.path.join(self.folder.name, "stored")
        os.rename(os.path.join(self.demo, "stored"), stored)
        again, _ = self.run_demo()
        self.assertNotEqual(self.server_process(), first)
        self.assertFalse(os.path.exists(f"/proc/{first}/exe"))
        names = os.listdir(stored)
        self.assertEqual(len(names), 33)
        same, _, _ = filecmp.cmpfiles(stored, os.path.join(self.demo, "stored"), names, False)
        self.assertEqual(sorted(same), sorted(names))
        for name, text in outputs.items():
            if name.startswith(("recognize ", "predict ")):
                self.assertEqual(again[name], text)


if __name__ == "__main__":
    main()
