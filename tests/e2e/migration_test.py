#!/usr/bin/python3
"""motiondb migrate between a file and a real PostgreSQL cluster.

    migration_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import os
import signal
import subprocess
import time

from postgres_cluster import PASSWORD, WithCluster, main
from programs import MODELS, MOTIONDB, MOTIONDBD, SLOWNESS


class Migration(WithCluster):
    """motiondb migrate between a file and PostgreSQL."""

    def setUp(self):
        super().setUp()
        self.environment = dict(os.environ, PGPASSFILE=self.path("passwords"))
        with open(self.path("passwords"), "w", encoding="utf-8") as file:
            file.write(f"*:*:*:motiondb:{PASSWORD}\n")
        os.chmod(self.path("passwords"), 0o600)
        self.postgres = f"postgresql://motiondb@/postgres?host={self.cluster.folder.name}"

    def migrate(self, source, target, program=(MOTIONDB, "migrate")):
        return subprocess.run([*program, source, target], capture_output=True, text=True,
                              env=self.environment)

    def test_there_and_back_answers_are_equal(self):
        file = self.serve(store=self.path("motion.db"))
        self.fill(file)
        if os.path.isdir(MODELS):
            file.ask("ingest", "d", *(f"{MODELS}/{name}.bvh" for name in ("01_01", "01_03")))
        first = self.answers(file)
        refused = self.migrate(self.path("motion.db"), self.postgres)
        self.assertEqual(refused.returncode, 1)
        self.assertIn("in use (process", refused.stderr)
        self.assertEqual(file.stop(), 0)
        for source, target in [(self.path("motion.db"), self.postgres),
                               (self.postgres, self.path("back.db"))]:
            done = self.migrate(source, target)
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("all rows are equal", done.stdout)
            server = self.serve(store=self.cluster.url() if target == self.postgres else target)
            self.assertEqual(self.answers(server), first)
            self.assertEqual(server.run("verify").returncode, 0)
            self.assertEqual(server.stop(), 0)
        again = self.migrate(self.path("motion.db"), self.postgres)
        self.assertEqual(again.returncode, 1)
        self.assertIn("is not empty", again.stderr)
        wrong = subprocess.run([MOTIONDBD, "migrate", "one"], capture_output=True, text=True)
        self.assertEqual(wrong.returncode, 2)

    def test_a_killed_migration_continues(self):
        file = self.serve(store=self.path("motion.db"))
        self.fill(file)
        for i in range(3):
            file.ask("ingest", "d", *(self.clip(100 * i + seed, 400) for seed in range(4, 44)))
        first = self.answers(file)
        self.assertEqual(file.stop(), 0)
        for source, target in [(self.path("motion.db"), self.postgres),
                               (self.postgres, self.path("back.db"))]:
            begun = time.monotonic()
            kills = 0
            for delay in (0.05, 0.1, 0.15, 0.2, 0.25, 0.3, 0.4, 0.5):
                process = subprocess.Popen([MOTIONDBD, "migrate", source, target], text=True,
                                           env=self.environment, stdout=subprocess.DEVNULL,
                                           stderr=subprocess.PIPE)
                try:
                    process.wait(timeout=delay * SLOWNESS)
                except subprocess.TimeoutExpired:
                    process.kill()
                    kills += 1
                errors = process.communicate()[1]
                if process.returncode == 0 or "is not empty" in errors:  # killed when it was done
                    break
                self.assertEqual(process.returncode, -signal.SIGKILL, errors)
            else:
                done = self.migrate(source, target, (MOTIONDBD, "migrate"))
                self.assertEqual(done.returncode, 0, done.stderr)
            self.assertGreater(kills, 1, f"{time.monotonic() - begun} s")
        self.assertEqual(self.answers(self.serve(store=self.path("back.db"))), first)
        self.assertEqual(self.answers(self.serve()), first)


if __name__ == "__main__":
    main()
