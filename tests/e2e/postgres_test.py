#!/usr/bin/python3
"""motiondbd on a real PostgreSQL cluster, which the test starts in a temporary folder.

    postgres_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import signal
import subprocess
import time

from postgres_cluster import PASSWORD, WithCluster, main
from programs import MOTIONDBD, Server


class Postgres(WithCluster):
    def test_answers_are_those_of_a_file_and_survive_a_restart(self):
        server = self.serve()
        self.fill(server)
        server.ask("update", "d", "clip1", "--title", "A slow walk")
        first = self.answers(server)
        self.assertEqual(len(first[1]), 4)
        self.assertEqual(server.ask_one("search", "d", "slow walk")["clip"]["name"],
                         "databases/d/clips/clip1")
        self.assertEqual(server.stop(), 0)
        self.assertEqual(self.answers(self.serve()), first)

        file = Server(self.path("motion.db"))
        self.servers.append(file)
        self.fill(file)
        file.ask("update", "d", "clip1", "--title", "A slow walk")
        recognized = file.ask_one("recognize", "d", self.clip(7, 40))
        self.assertEqual(recognized, first[3])

    def test_a_pooler_is_supported(self):
        server = self.serve(store=self.cluster.url() + "&pooled=1")
        self.fill(server)
        self.assertEqual(len(server.ask("list", "d")), 4)

    def test_without_postgresql_queries_are_answered_and_changes_can_be_repeated(self):
        server = self.serve()
        self.fill(server)
        query = ["recognize", "d", self.clip(7, 40)]
        before = server.ask_one(*query)
        self.cluster.kill()
        self.assertEqual(server.ask_one(*query), before)
        refused = server.run("ingest", "d", self.clip(9))
        self.assertNotEqual(refused.returncode, 0)
        self.assertIn("the store postgresql:", refused.stderr)
        self.assertNotIn(PASSWORD, refused.stderr)
        self.cluster.start()
        for _ in range(100):
            if server.run("ingest", "d", self.clip(9)).returncode == 0:
                break
            time.sleep(0.1)
        self.assertEqual(len(server.ask("list", "d")), 5)

    def test_a_start_without_postgresql_fails_and_no_password_is_shown(self):
        self.cluster.kill()
        started = subprocess.run([MOTIONDBD, "--store", self.cluster.url(), "--listen",
                                  "127.0.0.1:0"], capture_output=True, text=True)
        self.assertEqual(started.returncode, 1)
        self.assertIn("the store postgresql:", started.stderr)
        checked = subprocess.run([MOTIONDBD, "--check-config", "--store", self.cluster.url()],
                                 capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("postgresql://motiondb:***@/postgres", checked.stdout)
        self.assertNotIn(PASSWORD, started.stdout + started.stderr + checked.stdout + checked.stderr)
        self.cluster.start()

    def test_a_backup_is_restored_into_a_file(self):
        server = self.serve()
        self.fill(server)
        first = self.answers(server)
        self.assertEqual(server.run("backup", self.path("copy.mdb")).returncode, 0)
        self.assertEqual(server.run("export-database", "d", self.path("d.mdb")).returncode, 0)
        imported = server.run("import-database", self.path("d.mdb"), "--as", "e")
        self.assertEqual(imported.returncode, 0, imported.stderr)
        self.assertEqual(len(server.ask("list", "e")), 4)
        file = self.serve(store=self.path("motion.db"))
        restored = file.run("restore", self.path("copy.mdb"))
        self.assertEqual(restored.returncode, 0, restored.stderr)
        self.assertEqual(self.answers(file), first)


if __name__ == "__main__":
    main()
