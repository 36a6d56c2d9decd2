#!/usr/bin/python3
"""motiondbd on a real PostgreSQL cluster, which the test starts in a temporary folder.

    postgres_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import signal
import subprocess
import time

from observability_test import get
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

    def start(self, store):
        """A server whose output can be read; it need not become ready."""
        server = subprocess.Popen([MOTIONDBD, "--store", store, "--listen", "127.0.0.1:0",
                                   "--http-listen", "127.0.0.1:0", "--log-level", "error"],
                                  stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(server.kill)
        return server

    def test_a_start_waits_for_postgresql_and_shows_no_password(self):
        self.cluster.kill()
        ended, waiting = self.start(self.cluster.url()), self.start(self.cluster.url())
        for server in (ended, waiting):
            line = server.stderr.readline()
            self.assertIn("the store postgresql:", line)
            self.assertIn("retrying until it can be reached", line)
        page = waiting.stdout.readline().strip().rsplit(" ", 1)[-1].removesuffix("/metrics")
        self.assertEqual(get(page, "/readyz")[0], 503)
        self.assertEqual(get(page, "/livez")[0], 200)
        time.sleep(1)
        ended.send_signal(signal.SIGTERM)
        output, error = ended.communicate(timeout=30)
        self.assertEqual((ended.returncode, error), (0, ""))
        self.assertNotIn("listening", output)
        self.cluster.start()
        self.assertIn("the store can be reached", waiting.stderr.readline())
        self.assertIn("listening", waiting.stdout.readline())
        self.assertEqual(get(page, "/readyz")[0], 200)
        waiting.send_signal(signal.SIGTERM)
        output, error = waiting.communicate(timeout=30)
        self.assertEqual((waiting.returncode, error), (0, ""))

    def test_a_start_that_postgresql_refuses_fails_and_no_password_is_shown(self):
        for store, why in ((self.cluster.url("missing"), '"missing" does not exist'),
                           (self.cluster.url().replace(PASSWORD, "wrong"), "authentication failed")):
            started = self.start(store)
            output, error = started.communicate(timeout=30)
            self.assertEqual(started.returncode, 1)
            self.assertIn("the store postgresql:", error)
            self.assertIn(why, error)
            self.assertNotIn(PASSWORD, output + error)
        checked = subprocess.run([MOTIONDBD, "--check-config", "--store", self.cluster.url()],
                                 capture_output=True, text=True)
        self.assertEqual(checked.returncode, 0, checked.stderr)
        self.assertIn("postgresql://motiondb:***@/postgres", checked.stdout)
        self.assertNotIn(PASSWORD, checked.stdout + checked.stderr)

    def test_a_role_that_owns_only_its_database(self):
        # As docs/operations.md has it; the role of the other tests is a superuser.
        self.cluster.sql(f"CREATE ROLE plain LOGIN PASSWORD '{PASSWORD}'")
        self.cluster.sql("CREATE DATABASE owned OWNER plain ENCODING 'UTF8' TEMPLATE template0")
        server = self.serve(store=self.cluster.url("owned").replace("motiondb:", "plain:"))
        self.fill(server)
        first = self.answers(server)
        self.assertEqual(server.run("backup", self.path("copy.mdb")).returncode, 0)
        self.assertEqual(server.run("verify").returncode, 0)
        self.assertEqual(server.stop(), 0)
        self.assertEqual(self.answers(self.serve(
            store=self.cluster.url("owned").replace("motiondb:", "plain:"))), first)

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
