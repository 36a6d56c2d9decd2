#!/usr/bin/python3
"""The commands that build and test do not get into each other's way.

    recipes_test.py
"""

import os
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")

# Says what it was called as and with; succeeds.
RECORDER = """\
#!/bin/sh
echo "${0##*/} $*" >>"$RECORD"
"""


def read(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


class RunTest(unittest.TestCase):
    """tests/run.sh, with programs in the place of CMake's that only say what they are asked."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        self.write("tests/run.sh", read("tests/run.sh"))
        for program in ("deploy/install_packages.sh", "bin/cmake", "bin/ctest"):
            self.write(program, RECORDER)

    def path(self, name):
        return os.path.join(self.folder, name)

    def write(self, name, text):
        os.makedirs(os.path.dirname(self.path(name)), exist_ok=True)
        with open(self.path(name), "w", encoding="utf-8") as file:
            file.write(text)
        os.chmod(self.path(name), 0o755)

    def calls(self, *arguments):
        subprocess.run([self.path("tests/run.sh"), *arguments], check=True, capture_output=True,
                       env={**os.environ, "PATH": self.path("bin") + ":" + os.environ["PATH"],
                            "RECORD": self.path("record")})
        with open(self.path("record"), encoding="utf-8") as file:
            return file.read().splitlines()

    def test_it_cannot_pass_without_tests(self):
        # The folder may have been configured without them; ctest on its own is content with none.
        for preset in ("release", "asan", "tsan"):
            with self.subTest(preset):
                calls = self.calls(preset)
                configured, = [call for call in calls if call.startswith("cmake --preset")]
                self.assertIn("-DMOTIONDB_BUILD_TESTS=ON", configured)
                tested, = [call for call in calls if call.startswith("ctest")]
                self.assertIn("--no-tests=error", tested)
                os.remove(self.path("record"))


class PackageRecipeTest(unittest.TestCase):
    def test_it_has_a_folder_of_its_own(self):
        # Not the one that tests are built in: it is configured without them.
        configured = re.findall(r"^\$ (cmake .*-DMOTIONDB_BUILD_TESTS=OFF.*)$",
                                read("deploy/README.md"), re.MULTILINE)
        self.assertTrue(configured)
        for line in configured:
            folder = re.search(r" -B (build/\w+) ", line).group(1)
            self.assertNotIn(folder, ("build/dev", "build/release", "build/asan", "build/tsan"))
            self.assertIn(f"--build {folder} ", line)


unittest.main(argv=sys.argv[:1])
