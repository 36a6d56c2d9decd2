#!/usr/bin/python3
"""Tests the real programs on recorded motion: server process, socket, SQLite file, command line,
NumPy.

    real_motion_test.py MOTIONDBD MOTIONDB DATA_FOLDER

Uses the motion of Debian's assimp-testmodels.
"""

import json
import os
import signal
import time

import numpy

from programs import MODELS, Server, WithServer, main


class AnyMachine(WithServer):
    """Uses motion that can be installed on every machine."""

    def setUp(self):
        if not os.path.isdir(MODELS):
            self.skipTest(f"assimp-testmodels is not installed: {MODELS} is missing")
        super().setUp()  # last: tearDown does not run for a skipped test

    def ingest(self, *names):
        self.server.ask_one("create", "demo")
        self.server.ask("ingest", "demo", *[f"{MODELS}/{name}.bvh" for name in names])

    def begin_with_clips(self, *names):
        self.begin_with(names, lambda: self.ingest(*names))

    def test_all_queries(self):
        self.begin_with_clips("01_01", "01_03", "Boxing_Toes")
        described = self.server.ask_one("describe", "demo")
        self.assertEqual(described["clip_count"], 3)
        self.assertEqual(described["nodes_per_layer"][0], 1)
        self.assertEqual(sum(described["nodes_per_layer"]), described["node_count"])
        self.assertEqual(described["nodes_per_layer"][-1], described["bottom_node_count"])
        self.assertEqual(len(described["nodes_per_layer"]), described["layer_count"])
        self.assertEqual(described["model_version"], 1, "a burst of ingests costs one rebuild")
        self.assertGreater(described["build_seconds"], 0)

        windows = self.server.ask_one("recognize", "demo", f"{MODELS}/01_01.bvh")["windows"]
        self.assertGreater(len(windows), 100)
        own = sum(w["clips"][0]["clip"].endswith("/01_01") for w in windows)
        self.assertGreater(own, 0.9 * len(windows))
        for window in windows:
            self.assertAlmostEqual(window["end_seconds"] - window["start_seconds"], 0.4, places=6)
            self.assertAlmostEqual(sum(l["probability"] for l in window["labels"]), 1, places=6)

        estimate = self.server.ask_one("estimate", "demo", f"{MODELS}/01_01.bvh", "--paths", "3")
        logs = [path["log_probability"] for path in estimate["paths"]]
        self.assertEqual(len(logs), 3)
        self.assertEqual(logs, sorted(logs, reverse=True))
        self.assertEqual(estimate["paths"][0]["node_ids"][-1], estimate["state"]["node_id"])

        prediction = self.server.ask_one("predict", "demo", f"{MODELS}/01_01.bvh", "--at", "2",
                                         "--horizon", "0.1,0.5")
        self.assertEqual([h["seconds"] for h in prediction["horizons"]], [0.1, 0.5])
        self.assertEqual(len(prediction["horizons"][0]["marker_positions"]), 3 * 34)
        self.assertNotIn(prediction["state"]["node_id"],
                         [n["node_id"] for n in prediction["next_nodes"]])
        series = self.server.ask("predict", "demo", f"{MODELS}/01_01.bvh", "--every", "1")
        self.assertGreater(len(series), 15)
        times = [p["at_seconds"] for p in series]
        self.assertEqual(times, sorted(times))

    def test_find_similar_parts(self):
        self.begin_with_clips("01_01", "01_03", "Boxing_Toes")
        own = self.server.ask_one("find", "demo", "--clip", "Boxing_Toes@3.1-4.35", "--top", "3")["matches"]
        self.assertEqual(len(own), 3)
        self.assertTrue(own[0]["clip"].endswith("/Boxing_Toes"))
        self.assertAlmostEqual(own[0]["start_seconds"], 3.1, delta=0.01)
        self.assertAlmostEqual(own[0]["end_seconds"], 4.35, delta=0.01)
        self.assertAlmostEqual(own[0]["score"], 1, places=3)
        scores = [match["score"] for match in own]
        self.assertEqual(scores, sorted(scores, reverse=True))

        seen = self.server.ask_one("find", "demo", f"{MODELS}/01_01.bvh", "--from", "2", "--to", "3")["matches"]
        self.assertEqual(len(seen), 10)
        self.assertTrue(seen[0]["clip"].endswith("/01_01"))
        self.assertAlmostEqual(seen[0]["start_seconds"], 2, delta=0.05)
        self.assertAlmostEqual(seen[0]["end_seconds"], 3, delta=0.05)
        self.assertGreater(seen[0]["score"], 0.9)
        masked = self.server.ask_one("find", "demo", f"{MODELS}/01_01.bvh", "--filter", 'name != "01_01"')["matches"]
        self.assertEqual([m for m in masked if m["clip"].endswith("/01_01")], [])
        self.assertIn("SCORE", self.server.run("find", "demo", f"{MODELS}/01_01.bvh").stdout)
        lost = self.server.run("find", "demo", "--clip", "Boxing_Toe@1-2")
        self.assertIn("did you mean 'Boxing_Toes'?", lost.stderr)
        self.assertEqual(lost.returncode, 1)

    def test_observe_replays_a_motion(self):
        self.begin_with_clips("01_01", "01_03", "Boxing_Toes")
        boxing = f"{MODELS}/Boxing_Toes.bvh"
        answers = self.server.ask("observe", "demo", boxing, "--frames-per-message", "4",
                                  "--horizon", "0.1")
        frames = [int(answer["frame"]) for answer in answers]
        self.assertAlmostEqual(frames[-1], 4 * len(answers), delta=6, msg="4 frames a message")
        self.assertEqual(frames, sorted(frames))
        named = [answer["labels"][0]["label"] for answer in answers]
        self.assertEqual(len(set(named)), 1)
        for answer in answers:
            self.assertEqual(answer["model_version"], 1)
            self.assertGreater(answer["state"]["probability"], 0)
            self.assertEqual(len(answer["horizons"][0]["marker_positions"]), 3 * 34)

        began = time.monotonic()
        replayed = self.server.run("observe", "demo", boxing, "--realtime", "--rate-multiplier", "20")
        took = time.monotonic() - began
        self.assertEqual(replayed.returncode, 0, replayed.stderr)
        self.assertGreater(took, frames[-1] / 100 / 20, "twenty times its own rate")
        self.assertIn("(longest)", replayed.stdout)

    def test_a_restart_reads_the_stored_model(self):
        self.begin_with_clips("01_01", "Boxing_Toes")
        before = self.server.ask_one("recognize", "demo", f"{MODELS}/01_03.bvh")
        self.assertEqual(self.server.stop(), 0, "SIGTERM drains and exits with 0")
        self.server = Server(self.store)
        self.assertEqual(self.server.ask_one("describe", "demo")["model_version"], 1)
        self.assertEqual(self.server.ask_one("recognize", "demo", f"{MODELS}/01_03.bvh"), before)

    def test_acknowledged_changes_survive_sigkill(self):
        self.ingest("01_01")
        self.server.stop(signal.SIGKILL)
        self.server = Server(self.store)
        clips = self.server.ask("list", "demo")
        self.assertEqual([clip["name"] for clip in clips], ["databases/demo/clips/01_01"])

    def test_export_returns_the_original_file(self):
        self.begin_with_clips("01_01", "Boxing_Toes")
        self.server.ask("export", "demo", "01_01", "--out", self.folder.name)
        with open(f"{MODELS}/01_01.bvh", "rb") as original, open(self.path("01_01.bvh"), "rb") as back:
            self.assertEqual(original.read(), back.read())

    def test_a_bad_file_is_named_and_the_others_are_stored(self):
        with open(f"{MODELS}/01_03.bvh", "rb") as file:
            whole = file.read()
        with open(self.path("cut.bvh"), "wb") as file:
            file.write(whole[:len(whole) // 2])
        self.server.ask_one("create", "demo")
        result = self.server.run("ingest", "demo", self.path("cut.bvh"), f"{MODELS}/01_01.bvh")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("cut.bvh", result.stderr)
        self.assertEqual(len(self.server.ask("list", "demo")), 1)

    def test_deleting_rebuilds(self):
        self.begin_with_clips("01_01", "Boxing_Toes")
        self.server.ask("delete", "demo", "01_01")
        described = self.server.ask_one("describe", "demo")
        self.assertEqual((described["clip_count"], described["model_version"]), (1, 2))
        self.server.ask("delete", "demo", "Boxing_Toes")
        result = self.server.run("estimate", "demo", f"{MODELS}/01_01.bvh")
        self.assertNotEqual(result.returncode, 0)
        self.assertIn("ingest", result.stderr)

    def test_source_markers(self):
        self.server.ask_one("create", "own", "--marker-set", "source")
        self.server.ask("ingest", "own", f"{MODELS}/01_01.bvh")
        described = self.server.ask_one("describe", "own")
        self.assertEqual(described["dimension_count"], 6 * 31)
        result = self.server.run("ingest", "own", f"{MODELS}/Boxing_Toes.bvh")
        self.assertNotEqual(result.returncode, 0, "another skeleton lacks the first one's joints")

    def test_a_custom_marker_set(self):
        with open(self.path("legs.markers"), "w", encoding="utf-8") as file:
            file.write("""motiondb-marker-set 1
name legs
marker LHip
marker RHip
marker LKnee
marker RKnee
marker LFoot
marker RFoot
mapping cmu
LHip = LeftUpLeg
RHip = RightUpLeg
LKnee = LeftLeg
RKnee = RightLeg
LFoot = 0.5 LeftFoot + 0.5 LeftToeBase
RFoot = RightFoot offset RightFoot 0 0 0.1
""")
        created = self.server.ask_one("create", "legs", "--marker-set", self.path("legs.markers"))
        self.assertEqual(created["database"]["marker_names"][-1], "RFoot")
        self.server.ask("ingest", "legs", f"{MODELS}/01_01.bvh")
        self.assertEqual(self.server.ask_one("describe", "legs")["dimension_count"], 36)
        result = self.server.run("ingest", "legs", f"{MODELS}/Boxing_Toes.bvh")
        self.assertIn("LeftFoot", result.stderr)

    def test_dump_opens_in_numpy(self):
        self.begin_with_clips("01_01", "Boxing_Toes")
        self.server.ask("dump", "demo", self.path("dump"))
        load = lambda name: numpy.load(self.path("dump/" + name))
        described = self.server.ask_one("describe", "demo")
        states = load("states.npy")
        self.assertEqual(states.dtype, numpy.float32)
        self.assertEqual(states.shape, (described["frame_count"], 204))
        clip_of_frame = load("clip_of_frame.npy")
        above = numpy.zeros(len(states), int)
        for layer in range(1, described["layer_count"] + 1):
            folder = f"layers/{layer:02d}/"
            node_of_frame = load(folder + "node_of_frame.npy")
            mean = load(folder + "mean.npy")
            count = described["nodes_per_layer"][layer - 1]
            self.assertEqual(mean.shape, (count, 204))
            self.assertEqual(load(folder + "variance.npy").shape, (count, 204))
            self.assertEqual(sorted(set(node_of_frame)), list(range(count)))
            if layer > 1:
                numpy.testing.assert_array_equal(load(folder + "parent.npy")[node_of_frame], above)
            above = node_of_frame
            for node in range(count):
                numpy.testing.assert_allclose(states[node_of_frame == node].mean(axis=0), mean[node],
                                              atol=1e-3)
            same_clip = clip_of_frame[1:] == clip_of_frame[:-1]
            expected = {}
            for pair in zip(node_of_frame[:-1][same_clip], node_of_frame[1:][same_clip]):
                expected[pair] = expected.get(pair, 0) + 1
            dumped = {(f, t): c for f, t, c in load(folder + "transitions.npy").tolist()}
            self.assertEqual(dumped, {(int(f), int(t)): c for (f, t), c in expected.items()})
        with open(self.path("dump/model.json"), encoding="utf-8") as file:
            json.load(file)


if __name__ == "__main__":
    main()
