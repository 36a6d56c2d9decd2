"""A server with a small database, for tests of the command line."""

from figure import write_bvh
from programs import MOTIONDB, WithServer
from terminal import run_on_terminal


class CommandLine(WithServer):
    def setUp(self):
        super().setUp()
        self.server.ask_one("create", "walks", "--marker-set", "source", "--min-frames", "4")
        self.files = []
        for seed in range(4):
            self.files.append(self.path(f"clip{seed}.bvh"))
            write_bvh(self.files[-1], seed, frames=120)
            self.server.ask("ingest", "walks", self.files[-1],
                            "--label", "big step" if seed % 2 == 0 else "sit")

    def refuse(self, expected, *arguments, code=2):
        result = self.server.run(*arguments)
        self.assertEqual(result.returncode, code, (arguments, result.stderr))
        self.assertIn(expected, result.stderr)
        self.assertEqual(result.stdout, "")
        if code == 2:
            self.assertRegex(result.stderr, r"Try `motiondb[a-z -]* --help`\.\n$")
        return result

    def show(self, *arguments, columns=80, rows=24, environment=None):
        code, shown, error = run_on_terminal(
            [MOTIONDB, "--server", self.server.address, *arguments], columns, rows, environment)
        self.assertEqual(code, 0, (arguments, error))
        return shown
