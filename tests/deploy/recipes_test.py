#!/usr/bin/python3
"""Tests the scripts and documented commands that build, test and back up.

    recipes_test.py
"""

import os
import re
import subprocess
import sys
import tempfile
import time
import unittest

ROOT = os.path.join(os.path.dirname(os.path.abspath(__file__)), "../..")

# Records its name and arguments; succeeds.
RECORDER = """\
#!/bin/sh
echo "${0##*/} $*" >>"$RECORD"
"""


def read(*path):
    with open(os.path.join(ROOT, *path), encoding="utf-8") as file:
        return file.read()


class RunTest(unittest.TestCase):
    """tests/run.sh with fake cmake and ctest that record their arguments."""

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

    def test_it_fails_without_tests(self):
        # The folder may be configured without tests; by default ctest succeeds with no tests.
        for preset in ("release", "asan", "tsan"):
            with self.subTest(preset):
                calls = self.calls(preset)
                configured, = [call for call in calls if call.startswith("cmake --preset")]
                self.assertIn("-DMOTIONDB_BUILD_TESTS=ON", configured)
                tested, = [call for call in calls if call.startswith("ctest")]
                self.assertIn("--no-tests=error", tested)
                os.remove(self.path("record"))


# Log of ctest: one test with two skipped cases, and one test with a duplicate skip line.
CTEST_LOG = """\
1/2 Test: plan
test_a (x) ... skipped 'no data'
test_b (x) ... skipped 'no data'
OK (skipped=2)
Test time =  12.50 sec
Test Passed.
2/2 Test: storage
  skipped: no tmpfs
  skipped: no tmpfs
Test time =   3.20 sec
Test Passed.
"""


class DecidingRunTest(unittest.TestCase):
    """.ci/run with fake steps."""

    def run_it(self, package, image):
        with tempfile.TemporaryDirectory() as folder:
            for name, text in ((".ci/run", read(".ci/run")), ("deploy/install_packages.sh", "#!/bin/sh\n"),
                               ("tests/run.sh", "#!/bin/sh\n"), ("tests/fuzz/run.sh", "#!/bin/sh\n"),
                               ("tests/architecture/check_locks.sh", "#!/bin/sh\n"),
                               ("tests/architecture/check_tidy.sh", "#!/bin/sh\n"),
                               ("tests/deploy/package_test.sh", "#!/bin/sh\n" + package),
                               ("tests/deploy/image_test.sh", "#!/bin/sh\n" + image),
                               ("build/release/Testing/Temporary/LastTest.log", CTEST_LOG),
                               ("build/asan/Testing/Temporary/LastTest.log", ""),
                               ("build/tsan/Testing/Temporary/LastTest.log", "")):
                path = os.path.join(folder, name)
                os.makedirs(os.path.dirname(path), exist_ok=True)
                with open(path, "w", encoding="utf-8") as file:
                    file.write(text)
                os.chmod(path, 0o755)
            return subprocess.run([os.path.join(folder, ".ci/run")], capture_output=True, text=True)

    def test_it_lists_skipped_tests(self):
        ran = self.run_it("echo skipped: needs root\nexit 77\n", "exit 0\n")
        self.assertEqual((ran.returncode, ran.stderr), (0, ""))
        self.assertEqual(ran.stdout.partition("== skipped: ")[2].splitlines(),
                         ["4", "release: plan: test_a (x) ... skipped 'no data'",
                          "release: plan: test_b (x) ... skipped 'no data'",
                          "release: storage: skipped: no tmpfs", "package: skipped: needs root"])

    def test_it_lists_durations(self):
        table = self.run_it("exit 0\n", "exit 0\n").stdout.partition("== minutes")[2].splitlines()
        steps = ["packages", "release", "asan", "tsan", "fuzz", "locks", "tidy", "package", "image", "all"]
        self.assertEqual([line.split()[0] for line in table[1:11]], steps)
        self.assertEqual(table[11:13], ["release plan 12 s", "release storage 3 s"])

    def test_a_failed_step_fails_the_run(self):
        for steps in (("exit 3\n", "exit 0\n"), ("exit 0\n", "exit 3\n")):
            self.assertEqual(self.run_it(*steps).returncode, 3)


class PackageRecipeTest(unittest.TestCase):
    def test_it_has_its_own_build_folder(self):
        # A folder of tests would be configured without tests.
        configured = re.findall(r"^\$ (cmake .*-DMOTIONDB_BUILD_TESTS=OFF.*)$",
                                read("docs/operations.md"), re.MULTILINE)
        self.assertTrue(configured)
        for line in configured:
            folder = re.search(r" -B (build/\w+) ", line).group(1)
            self.assertNotIn(folder, ("build/dev", "build/release", "build/asan", "build/tsan"))
            self.assertIn(f"--build {folder} ", line)


# A fake motiondb that creates the file of a backup.
BACKS_UP = """\
for last; do :; done
#
echo "$@"
[ "$last" = verify ] || touch "$last"
"""


class NightlyBackupTest(unittest.TestCase):
    """The cron line of docs/operations.md with a fake motiondb."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = folder.name
        os.mkdir(self.path("bin"))
        os.mkdir(self.path("backups"))
        for days in (29, 32):
            self.touch(f"backups/{days}.motiondb", days)

    def path(self, name):
        return os.path.join(self.folder, name)

    def touch(self, name, days):
        with open(self.path(name), "w", encoding="utf-8"):
            pass
        then = time.time() - days * 86400
        os.utime(self.path(name), (then, then))

    def kept(self, motiondb):
        """Runs the line with the script `motiondb`; returns the files in the folder and the exit code."""
        with open(self.path("bin/motiondb"), "w", encoding="utf-8") as file:
            file.write("#!/bin/sh\n" + motiondb)
        os.chmod(self.path("bin/motiondb"), 0o755)
        line, = re.findall(r"^\d+ \d+ \* \* \* backup (.*)$", read("docs/operations.md"), re.MULTILINE)
        self.assertNotRegex(line, r"(?<!\\)%")  # cron ends the command there
        command = line.replace("\\%", "%").replace("/var/backups/motiondb", self.path("backups"))
        ran = subprocess.run(["/bin/sh", "-c", command], capture_output=True, text=True,
                             env={"PATH": self.path("bin") + ":/usr/bin:/bin"})
        self.assertEqual((ran.stdout, ran.stderr), ("", ""))
        return sorted(os.listdir(self.path("backups"))), ran.returncode

    def test_it_is_named_by_date_and_deletes_old_backups(self):
        kept, code = self.kept(BACKS_UP)
        self.assertEqual(code, 0)
        self.assertEqual(len(kept), 2)
        self.assertRegex(kept[0], r"^20\d\d-\d\d-\d\d\.motiondb$")
        self.assertEqual(kept[1], "29.motiondb")

    def test_a_corrupt_store_deletes_no_backups(self):
        kept, code = self.kept('[ "$last" != verify ] || exit 1\n'.join(BACKS_UP.split("#\n")))
        self.assertEqual((len(kept), kept[1:], code), (3, ["29.motiondb", "32.motiondb"], 1))

    def test_a_failed_backup_deletes_no_backups(self):
        kept, code = self.kept("exit 1\n")
        self.assertEqual((kept, code), (["29.motiondb", "32.motiondb"], 1))


unittest.main(argv=sys.argv[:1])
