#!/usr/bin/python3
"""Two motiondbd on one PostgreSQL cluster: quotas, imports, restores, and pgbouncer.

    shared_store_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import os
import unittest

from postgres_cluster import FOLLOWED, WithCluster, main
from programs import SLOWNESS, wait_for


class SharedStore(WithCluster):
    def await_same_model(self, server, other):
        described = server.ask_one("describe", "d")
        wait_for(lambda: other.ask_one("describe", "d").get("model_version") ==
                 described["model_version"], FOLLOWED, "the model is served by both")

    def test_a_quota_counts_the_clips_of_all_servers(self):
        a, b = (self.serve("--max-database-clips", "4") for _ in range(2))
        self.fill(a)

        def is_refused(server):
            refused = server.run("ingest", "d", self.clip(9))
            return refused.returncode != 0 and "the limit is 4" in refused.stderr

        self.assertTrue(is_refused(a))
        wait_for(lambda: is_refused(b), 2 * SLOWNESS, "the other server refuses a clip")
        a.ask("delete", "d", "clip2", "--yes")
        wait_for(lambda: b.run("ingest", "d", self.clip(9)).returncode == 0, 2 * SLOWNESS,
                 "the other server takes a clip instead of the deleted one")

    def test_an_imported_database_answers_on_all_servers(self):
        a, b = self.serve(), self.serve()
        self.fill(a)
        query = ["recognize", "d", self.clip(7, 40)]
        answer = a.ask(*query)
        a.ask_one("export-database", "d", self.path("d.mdb"))
        a.ask("delete", "d", "--yes")
        wait_for(lambda: "does not exist" in b.run("describe", "d").stderr, FOLLOWED,
                 "the deleted database is gone")
        a.ask_one("import-database", self.path("d.mdb"))
        self.assertEqual(len(b.ask("list", "d")), 4)
        wait_for(lambda: b.run(*query).returncode == 0, FOLLOWED, "the imported model answers")
        self.assertEqual(b.ask(*query), answer)

    def test_a_restored_store_answers_on_all_servers(self):
        a, b = self.serve(), self.serve()
        self.fill(a)
        self.await_same_model(a, b)
        query = ["recognize", "d", self.clip(7, 40)]
        answer = b.ask(*query)
        a.ask_one("backup", self.path("store.mdb"))
        a.ask("ingest", "d", self.clip(8), "--label", "moves")  # not in the backup
        self.await_same_model(a, b)
        a.ask("delete", "d", "--yes")
        # Both may still serve the deleted database; the restored one has its name.
        a.ask_one("restore", self.path("store.mdb"))
        for server in (a, b):
            self.assertEqual(len(server.ask("list", "d")), 4)
            wait_for(lambda: server.run(*query).returncode == 0 and server.ask(*query) == answer,
                     FOLLOWED, "the restored model answers")
        b.ask("ingest", "d", self.clip(9), "--label", "moves")
        self.assertEqual(len(a.ask("list", "d")), 5)

    def test_servers_share_a_store_through_pgbouncer(self):
        pooler = self.cluster.pool()
        if pooler is None:
            self.assertNotIn("MOTIONDB_REQUIRE_POSTGRES", os.environ)
            self.skipTest("pgbouncer is missing")

        def end():
            pooler.terminate()
            pooler.wait(timeout=60)
        self.addCleanup(end)
        a, b = (self.serve(store=self.cluster.pooled_url("postgres")) for _ in range(2))
        self.fill(a)
        self.await_same_model(a, b)
        query = ["recognize", "d", self.clip(7, 40)]
        self.assertEqual(b.ask(*query), a.ask(*query))
        revision = b.ask_one("update", "d", "clip1", "--label", "hops", "--no-wait")["revision"]
        a.ask(*query, "--min-revision", str(revision))
        b.ask("ingest", "d", self.clip(8), "--label", "moves")
        self.assertEqual(len(a.ask("list", "d")), 5)
        self.await_same_model(b, a)
        a.ask("delete", "d", "--yes")
        wait_for(lambda: "does not exist" in b.run("describe", "d").stderr, FOLLOWED,
                 "the deleted database is gone")


if __name__ == "__main__":
    main()
