#!/usr/bin/python3
"""Tests plans of the real programs on recorded motion: the paper's goals, obstacles, robots and
mistakes.

    plan_test.py MOTIONDBD MOTIONDB DATA_FOLDER

Skips tests that need the data folder if it is missing.
"""

import csv
import json
import math
import os
import tempfile
import time
import unittest
import xml.etree.ElementTree

import numpy

from programs import DATA, SLOWNESS, Server, main, needs_data

SVG = "{http://www.w3.org/2000/svg}"
FOOT_SLIDE_LIMIT_CM_PER_S = 20  # visible foot skating is faster


MAX_ACCELERATION = 50  # rad/s^2


def joint_limits(urdf):
    """Returns {joint: (lower, upper, velocity)} of the moving joints."""
    limits = {}
    for joint in xml.etree.ElementTree.parse(urdf).getroot().iter("joint"):
        limit = joint.find("limit")
        if joint.get("type") == "revolute" and limit is not None:
            limits[joint.get("name")] = tuple(float(limit.get(name))
                                              for name in ("lower", "upper", "velocity"))
    return limits


class PaperDatabase(unittest.TestCase):
    """Queries database 2, which is ingested once."""

    @classmethod
    def setUpClass(cls):
        needs_data()
        cls.folder = tempfile.TemporaryDirectory()
        cls.server = Server(os.path.join(cls.folder.name, "motion.db"))
        cls.server.ask_one("create", "two")
        cls.server.ask("ingest", "two", "--list", f"{DATA}/sets/database2.tsv")

    @classmethod
    def tearDownClass(cls):
        cls.server.stop()
        cls.folder.cleanup()

    def path(self, name):
        return os.path.join(self.folder.name, name)

    def plan(self, goal, *options):
        return self.server.ask_one("plan", "two", "--goal", goal, *options)

    def assert_exact(self, plan, tolerance_m=0.1, tolerance_rad=0.1):
        self.assertEqual(plan["outcome"], "EXACT", plan["missing"])
        quality = plan["motion"]["quality"]
        self.assertLessEqual(quality["position_error_m"], tolerance_m)
        self.assertLessEqual(quality["heading_error_rad"], tolerance_rad)
        self.assertLessEqual(quality["correction_m"], 0.05 * quality["length_m"] + 1e-9)
        self.assertLess(100 * quality["foot_slide_m_per_s"], FOOT_SLIDE_LIMIT_CM_PER_S)

    def test_the_papers_goals(self):
        for heading in (0, 1):
            with self.subTest(heading=heading):
                bvh, svg = self.path(f"to{heading}.bvh"), self.path(f"to{heading}.svg")
                plan = self.plan(f"2,1,{heading}", "--out", bvh, "--plot", svg)
                self.assert_exact(plan)
                end = plan["motion"]["root"][-1]
                self.assertLessEqual(math.hypot(end["x_m"] - 2, end["y_m"] - 1), 0.1)
                self.assertLessEqual(abs(math.remainder(end["heading_rad"] - heading, math.tau)),
                                     0.1)
                quality, effort = plan["motion"]["quality"], plan["effort"]
                print(f"\n2,1,{heading}: {quality['duration_seconds']:.2f} s,"
                      f" {quality['length_m']:.2f} m, ends {quality['position_error_m']:.3f} m and"
                      f" {quality['heading_error_rad']:.3f} rad off, searched"
                      f" {1000 * effort['search_seconds']:.0f} ms of"
                      f" {1000 * effort['total_seconds']:.0f} ms")
                drawn = xml.etree.ElementTree.parse(svg).getroot()
                self.assertEqual(drawn.tag, SVG + "svg")
                poses = drawn.findall(f".//{SVG}circle[@class='pose']")
                self.assertGreaterEqual(len(poses), int(6 * quality["duration_seconds"]))

    def test_a_plan_is_recognized_as_its_label(self):
        bvh = self.path("walk.bvh")
        self.assert_exact(self.plan("2,1,0", "--label", "walk", "--out", bvh))
        windows = self.server.ask_one("recognize", "two", bvh)["windows"]
        walks = sum(window["labels"][0]["label"] == "walk" for window in windows)
        self.assertGreater(walks, 0.8 * len(windows))

    def test_a_plan_can_be_ingested(self):
        bvh = self.path("back.bvh")
        plan = self.plan("2,1,0", "--out", bvh)
        self.server.ask_one("create", "back")
        self.server.ask("ingest", "back", bvh, "--label", "walk")
        described = self.server.ask_one("describe", "back")
        self.assertEqual(described["frame_count"], plan["motion"]["frame_count"])

    def test_the_same_request_gives_the_same_plan(self):
        first, second = (self.plan("1.5,-0.5,-1", "--seed", "3") for _ in range(2))
        for plan in (first, second):
            del plan["effort"]["search_seconds"], plan["effort"]["total_seconds"]
        self.assertEqual(first, second)

    def test_alternatives(self):
        plan = self.plan("2,1,0", "--alternatives", "2", "--out", self.path("many.bvh"),
                         "--plot", self.path("many.svg"))
        self.assert_exact(plan)
        self.assertGreaterEqual(len(plan["alternatives"]), 1)
        self.assertNotEqual(plan["motion"]["segments"], plan["alternatives"][0]["segments"])
        for number in range(2, 2 + len(plan["alternatives"])):
            self.assertTrue(os.path.exists(self.path(f"many-{number}.bvh")))

    def test_from_a_moment_of_a_clip(self):
        plan = self.plan("2,0.3,0.2", "--start", "16_15@1")
        self.assert_exact(plan)
        self.assertTrue(plan["motion"]["segments"][0]["clip"].endswith("/16_15"))
        self.assertAlmostEqual(plan["motion"]["segments"][0]["start_seconds"], 1, delta=0.02)

    def test_from_an_observation(self):
        plan = self.plan("2,0,0", "--observation", f"{DATA}/cmu/16/16_21.amc")
        self.assertIn(plan["outcome"], ("EXACT", "APPROXIMATE"))
        self.assertGreater(plan["motion"]["frame_count"], 1)

    def test_only_clips_with_a_label(self):
        plan = self.plan("1,0.2,0", "--label", "navigate")
        for segment in plan.get("motion", {}).get("segments", []):
            self.assertTrue(segment["clip"].endswith("/09_12"), segment)

    def test_around_obstacles(self):
        plan = self.plan("3,0.5,0.3", "--disc", "1.5,-0.3,0.2", "--polygon",
                         "1,1.5,2,1.5,2,2,1,2", "--search-seconds", "9",
                         "--plot", self.path("obstacles.svg"))
        self.assert_exact(plan)
        clearance = plan["motion"]["quality"]["smallest_clearance_m"]
        nearest = min(math.hypot(p["x_m"] - 1.5, p["y_m"] + 0.3) for p in plan["motion"]["root"])
        self.assertGreaterEqual(clearance, 0.3 - 1e-6)
        self.assertGreaterEqual(nearest - 0.2, clearance - 1e-6)

    def test_unreachable_goals(self):
        for options in (("100,0,0", "--max-duration", "5"), ("2,0,0", "--disc", "2,0.1,0.5")):
            with self.subTest(options=options):
                began = time.monotonic()
                result = self.server.run("--json", "plan", "two", "--goal", *options)
                self.assertLess(time.monotonic() - began, 3)
                self.assertEqual(result.returncode, 3, result.stderr)
                plan = json.loads(result.stdout)
                self.assertEqual(plan["outcome"], "UNREACHABLE")
                self.assertTrue(plan["missing"])
        result = self.server.run("plan", "two", "--goal", "2,0,0", "--disc", "2,0.1,0.5", "--plot",
                                 self.path("inside.svg"))
        self.assertEqual(result.returncode, 3, result.stderr)
        self.assertTrue(result.stdout.startswith("UNREACHABLE: "))
        self.assertTrue(result.stderr.startswith("motiondb: the goal cannot be reached: "))
        xml.etree.ElementTree.parse(self.path("inside.svg"))

    def test_a_deadline_returns_the_best_plan_so_far(self):
        # No search ends within a micrometre: without a deadline this one would continue.
        deadline = 4 * SLOWNESS
        began = time.monotonic()
        plan = self.plan("6,3,2", "--tolerance", "0.000001,0.000001", "--search-seconds", "60",
                         "--method", "random", "--timeout", str(deadline))
        self.assertLess(time.monotonic() - began, deadline + 0.5)
        self.assertIn(plan["outcome"], ("DEADLINE", "APPROXIMATE"))
        self.assertGreater(plan["motion"]["frame_count"], 1)

    def test_robots(self):
        for name, joint in (("g1_29dof_rev_1_0", "left_hip_pitch_joint"),
                            ("h1", "left_hip_pitch_joint")):
            with self.subTest(robot=name):
                table = self.path(f"{name}.csv")
                plan = self.plan("1.5,0,0", "--skeleton", f"{DATA}/robots/{name}.urdf",
                                 "--out", table, "--frame-rate", "50")
                self.assert_exact(plan)
                self.assertLess(plan["leg_length_m"], 0.9)
                names, values = self.read_table(table)
                self.assertEqual(names[0], "time_s")
                self.assertIn(joint, names)
                self.assertEqual(len(values), plan["motion"]["frame_count"])
                self.assertTrue(numpy.isfinite(values).all())
                numpy.testing.assert_allclose(numpy.diff(values[:, 0]), 1 / 50, atol=1e-6)
                self.assertEqual(plan["motion"]["quality"]["joint_limit_violations"], 0)

    def read_table(self, path):
        """Returns the names of the columns and the values, frames x columns."""
        with open(path, encoding="utf-8", newline="") as file:
            rows = list(csv.reader(file))
        return rows[0], numpy.array(rows[1:], float)

    def assert_within_limits(self, table, urdf, scale=1):
        """Checks positions, and differences times the frame rate, as a user would."""
        names, values = self.read_table(table)
        rate = 1 / (values[1, 0] - values[0, 0])
        for joint, (lower, upper, velocity) in joint_limits(urdf).items():
            angles = values[:, names.index(joint)]
            self.assertGreaterEqual(angles.min(), lower - 1e-6, joint)
            self.assertLessEqual(angles.max(), upper + 1e-6, joint)
            speeds = rate * numpy.abs(numpy.diff(angles))
            self.assertLessEqual(speeds.max(), scale * velocity, joint)
            accelerations = rate**2 * numpy.abs(numpy.diff(angles, 2))
            self.assertLessEqual(accelerations.max(), MAX_ACCELERATION, joint)

    def test_robots_stay_within_their_limits(self):
        for name in ("nao", "simple_humanoid"):
            with self.subTest(robot=name):
                urdf = f"{DATA}/robots/{name}.urdf"
                table = self.path(f"{name}.csv")
                free = self.plan("1.5,0.2,0", "--skeleton", urdf, "--ignore-joint-limits")
                plan = self.plan("1.5,0.2,0", "--skeleton", urdf, "--out", table,
                                 "--speed-limit-scale", "0.8",
                                 "--max-joint-acceleration", str(MAX_ACCELERATION))
                self.assert_within_limits(table, urdf, 0.8)
                self.assertGreater(free["motion"]["quality"]["joint_speed_violations"], 0)
                motion = plan["motion"]
                for kind in ("position", "speed", "acceleration"):
                    field = "joint_limit_violations" if kind == "position" else \
                        f"joint_{kind}_violations"
                    self.assertEqual(motion["quality"][field], 0)
                self.assertGreater(motion["quality"]["duration_seconds"],
                                   motion["quality"]["stored_duration_seconds"])
                self.assertEqual({part["limit"] for part in motion["slowed_parts"]},
                                 {"JOINT_LIMIT_SPEED", "JOINT_LIMIT_ACCELERATION"})
                for part in motion["slowed_parts"]:
                    self.assertIn(part["dof_name"], motion["dof_names"])
                    self.assertLess(part["start_seconds"], part["end_seconds"])
                    self.assertGreater(part["factor"], 1)
                self.assertEqual(len(motion["joint_efforts"]), len(motion["dof_names"]) - 6)
                self.assertLess(motion["balance"]["outside_seconds"],
                                motion["balance"]["supported_seconds"])

    def test_a_stored_robot_has_the_limits_of_its_urdf(self):
        urdf = f"{DATA}/robots/simple_humanoid.urdf"
        table = self.path("walk.csv")
        self.plan("2,0,0", "--skeleton", urdf, "--out", table)
        self.server.ask_one("create", "robots")
        self.server.ask("ingest", "robots", table, "--skeleton", urdf, "--label", "walk")
        again = self.path("again.csv")
        plan = self.server.ask_one("plan", "robots", "--goal", "1,0,0", "--tolerance", "1,1",
                                   "--out", again, "--max-joint-acceleration",
                                   str(MAX_ACCELERATION))
        self.assertTrue(plan["skeleton"])
        self.assert_within_limits(again, urdf)
        self.assertTrue(plan["motion"]["joint_efforts"])

    def test_errors_name_the_wrong_field(self):
        wrong = {
            "goal": ("--goal", "nan,0,0"),
            "tolerance": ("--tolerance", "-1,0.1"),
            "labels[0]": ("--label", "flying"),
            "skeleton": ("--skeleton", "nobody"),
            "polygon": ("--polygon", "0,0,1,1"),
            "obstacles.polygons[0].corners": ("--polygon", "1,0,2,1,2,0,1,1"),
            "clip_start.clip": ("--start", "99_99@1"),
            "clip_start.seconds": ("--start", "16_11@1000"),
            "coarse_layer": ("--layer", "500"),
            "max_duration_seconds": ("--max-duration", "121"),
            "frame_rate_hz": ("--frame-rate", "2000"),
            "speed_limit_scale": ("--speed-limit-scale", "1.5"),
            "max_joint_acceleration": ("--max-joint-acceleration", "1e9"),
            "broken.urdf:2": ("--skeleton", self.path("broken.urdf")),
        }
        with open(self.path("broken.urdf"), "w", encoding="utf-8") as file:
            file.write("<robot>\n<joint/>\n</robot>\n")
        for field, options in wrong.items():
            with self.subTest(field=field):
                goal = () if options[0] == "--goal" else ("--goal", "1,0,0")
                result = self.server.run("plan", "two", *goal, *options)
                self.assertNotEqual(result.returncode, 0)
                self.assertEqual(result.stdout, "")
                self.assertIn(field, result.stderr)
        result = self.server.run("plan", "two", "--goal", "1,0,0", "--out", self.path("plan.fbx"))
        self.assertNotEqual(result.returncode, 0)
        self.assertFalse(os.path.exists(self.path("plan.fbx")))


if __name__ == "__main__":
    main()
