#!/usr/bin/python3
"""Tests the real programs on the recorded motion beside the project: the paper's database 1 and
unknown motion.

    recorded_databases_test.py MOTIONDBD MOTIONDB DATA_FOLDER
"""

import csv
import glob
import os
import xml.etree.ElementTree

from programs import DATA, WithServer, main, needs_data

SVG = "{http://www.w3.org/2000/svg}"


def sum_of_probabilities(window):
    return (sum(label["probability"] for label in window["labels"])
            + window.get("unknown_probability", 0))


class PaperDatabases(WithServer):
    """Uses the recorded motion beside the project."""

    def setUp(self):
        needs_data()
        super().setUp()  # last: tearDown does not run for a skipped test

    def test_database_1_windows(self):
        self.server.ask_one("create", "one")
        self.server.ask("ingest", "one", "--list", f"{DATA}/sets/database1.train.tsv")
        with open(f"{DATA}/sets/database1.test.tsv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file, delimiter="\t"))
        right = total = 0
        for row in rows:
            path = os.path.join(DATA, "sets", row["path"])
            for window in self.server.ask_one("recognize", "one", path, "--top", "1")["windows"]:
                right += window["labels"][0]["label"] == row["label"]
                total += 1
        print(f"database 1: {right} of {total} windows recognized correctly ({100 * right / total:.1f} %)")
        self.assertGreaterEqual(right, 0.93 * total)

    def test_database_1_plot(self):
        self.server.ask_one("create", "one")
        self.server.ask("ingest", "one", "--list", f"{DATA}/sets/database1.train.tsv")
        walk = f"{DATA}/cmu/07/07_06.amc"
        picture = self.path("walk.svg")
        profile = self.path("profile.svg")
        answer = self.server.ask_one("recognize", "one", walk, "--plot", picture,
                                     "--plot-profile", profile)
        self.assertEqual(answer, self.server.ask_one("recognize", "one", walk))
        windows = len(answer["windows"])
        root = xml.etree.ElementTree.parse(picture).getroot()
        texts = ["".join(text.itertext()) for text in root.iter(f"{SVG}text")]
        self.assertIn("Recognition: 07_06.amc in one", texts)
        self.assertIn(f"walk: {windows} windows", texts)
        self.assertIn(answer["windows"][0]["clips"][0]["clip"].rsplit("/", 1)[1], texts)
        titles = [title.text for title in root.iter(f"{SVG}title")]
        self.assertEqual(sum("; familiarity " in title for title in titles), windows)

        root = xml.etree.ElementTree.parse(profile).getroot()
        texts = ["".join(text.itertext()) for text in root.iter(f"{SVG}text")]
        bottom = self.server.ask_one("describe", "one")["layer_count"]
        for layer in (f"{bottom}, the bottom of the tree", (bottom + 1) // 2, bottom // 4):
            self.assertIn(f"Layer {layer}", texts)
        for entry in ("jog: 5 clips", "kick: 4 clips", "walk: 5 clips"):
            self.assertIn(entry, texts)
        lines = [path.find(f"{SVG}title").text for path in root.iter(f"{SVG}path")]
        self.assertEqual(len(lines), 3 * 19, "a line for each clip and layer")
        self.assertEqual(lines.count("07_01 (walk)"), 3)
        names = [text for text in root.iter(f"{SVG}text")
                 if text.get("class").startswith("winner-name")]
        self.assertEqual(names[0].text, "walk")

        self.server.ask_one("recognize", "one", walk, "--layer", "5", "--method", "paper",
                            "--plot-profile", profile)
        root = xml.etree.ElementTree.parse(profile).getroot()
        self.assertEqual(len(list(root.iter(f"{SVG}path"))), 19, "that layer alone")

    def ingest_hdm05(self, database, labels):
        """Three clips of each label by each of two subjects."""
        with open(self.path("clips.tsv"), "w", encoding="utf-8") as file:
            file.write("path\tlabel\tsubject\n")
            for subject in ("bd", "bk"):
                for label in labels:
                    names = sorted(glob.glob(f"{DATA}/hdm05/HDM_{subject}_{label}_*.amc"))
                    file.writelines(f"{name}\t{label}\t{subject}\n" for name in names[:3])
        self.server.ask_one("create", database)
        self.server.ask("ingest", database, "--list", self.path("clips.tsv"))

    def test_unknown_motion(self):
        labels = ("kickLFront1Reps", "squat1Reps", "grabHighR")
        self.ingest_hdm05("three", labels)
        self.assertEqual(self.server.ask_one("describe", "three")["calibration"], "CALIBRATION_OWN")
        for label in labels:
            stored = sorted(glob.glob(f"{DATA}/hdm05/HDM_bd_{label}_*.amc"))[0]
            for window in self.server.ask_one("recognize", "three", stored)["windows"]:
                self.assertGreater(window["familiarity"], 0.9, "stored motion is familiar")
                self.assertLess(window["unknown_probability"], 0.5)
        of_third = f"{DATA}/hdm05/HDM_dg_"  # a subject that is not in the database
        for clip in ("kickLFront1Reps_013", "squat1Reps_025", "grabHighR_011"):
            path = f"{of_third}{clip}_120.amc"
            for window in self.server.ask_one("recognize", "three", path)["windows"]:
                self.assertAlmostEqual(sum_of_probabilities(window), 1, places=6)
            printed = self.server.run("recognize", "three", path).stdout
            label, percent = printed.splitlines()[-1].split(" ")[:2]
            self.assertEqual(label, clip[:-4], "the summary begins with the most frequent answer")
            self.assertGreaterEqual(int(percent), 80)
            predicted = self.server.ask_one("predict", "three", path, "--at", "0.6")
            self.assertLess(predicted["unknown_probability"], 0.5)
            self.assertFalse(any(frame.get("extrapolated") for frame in predicted["horizons"]))
        for clip in ("hopBothLegs1hops_022", "rotateArmsBothBackward1Reps_009"):
            path = f"{of_third}{clip}_120.amc"
            printed = self.server.run("recognize", "three", path).stdout.splitlines()
            label, percent = printed[-1].split(" ")[:2]
            self.assertEqual(label, "unknown")
            self.assertGreaterEqual(int(percent), 80)
            certain = self.server.run("recognize", "three", path, "--unknown-threshold", "1").stdout
            self.assertNotIn("unknown", certain.splitlines()[-1])
            window, = self.server.ask_one("recognize", "three", path, "--window", "all")["windows"]
            self.assertGreater(window["unknown_probability"], 0.5)
            paper, = self.server.ask_one("recognize", "three", path, "--window", "all",
                                         "--method", "paper")["windows"]
            self.assertNotIn("unknown_probability", paper)
            answers = self.server.ask("observe", "three", path)
            self.assertAlmostEqual(sum_of_probabilities(answers[-1]), 1, places=6)
            self.assertGreater(answers[-1]["unknown_probability"], 0.5)
            predicted = self.server.run("predict", "three", path, "--horizon", "0.4,30").stdout
            self.assertIn(": the motion before that time is unlike the stored motion", predicted)
            self.assertIn("extrapolated from 30.00 s: ", predicted)
            observed = self.server.run("observe", "three", path).stdout.splitlines()
            self.assertIn(" s  unknown 0.", observed[-2])  # then the statistics of the replay

    def test_one_label_has_no_probability_of_unknown_motion(self):
        self.ingest_hdm05("one", ["squat1Reps"])
        note = "no probability of unknown motion: all clips have the same label"
        path = f"{DATA}/hdm05/HDM_dg_hopBothLegs1hops_022_120.amc"
        answer = self.server.ask_one("recognize", "one", path)
        self.assertEqual(answer["calibration"], "CALIBRATION_ONE_LABEL")
        for window in answer["windows"] + self.server.ask("observe", "one", path):
            self.assertNotIn("unknown_probability", window)
        for command in (["recognize", "one", path], ["observe", "one", path], ["describe", "one"]):
            self.assertIn(note, self.server.run(*command).stdout)
        for command in (["recognize", "one", path, "--method", "paper"], ["predict", "one", path]):
            self.assertNotIn(note, self.server.run(*command).stdout)

    def test_database_2_table_1(self):
        self.server.ask_one("create", "two", "--frame-rate", "120")
        self.server.ask("ingest", "two", "--list", f"{DATA}/sets/database2.tsv")
        described = self.server.ask_one("describe", "two")
        print("Table I, database 2       ours   paper")
        for name, paper in (("frame_count", 11456), ("layer_count", 16), ("node_count", 1527),
                            ("bottom_node_count", 205)):
            print(f"  {name:20} {described[name]:7} {paper:7}")
        self.assertEqual(described["frame_count"], 11969)
        self.assertEqual(described["clip_count"], 27)


if __name__ == "__main__":
    main()
