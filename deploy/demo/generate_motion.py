#!/usr/bin/env python3
"""Generates motion for the quickstart: walk, run, turn and wave of different bodies, as BVH files.

    generate_motion.py FOLDER

Writes FOLDER/LABEL-PERSON-TAKE.bvh and FOLDER/clips.tsv (path, label, subject). The motion is
generated, not recorded: joints follow sums of a few sine waves, and the body moves so that the
standing foot stays in place. Size, proportions, style, tempo and a slow random sway depend on the
person and the take, by seeded random numbers, so each call writes the same files.
"""

import math
import os
import random
import sys

RATE_HZ = 60
SECONDS = 5
PEOPLE = ("ada", "ben", "cleo", "dan", "eve")
TAKES = 2
LABELS = ("walk", "run", "turn", "wave")

# Joint, parent, offset from the parent at zero angles (leg lengths): x left, y up, z front.
JOINTS = (
    ("Hips", None, (0, 0, 0)),
    ("Spine", "Hips", (0, 0.12, 0)),
    ("Chest", "Spine", (0, 0.22, 0)),
    ("Neck", "Chest", (0, 0.24, 0)),
    ("Head", "Neck", (0, 0.1, 0.01)),
    ("LeftShoulder", "Chest", (0.03, 0.2, 0)),
    ("LeftArm", "LeftShoulder", (0.18, 0, 0)),
    ("LeftForeArm", "LeftArm", (0, -0.33, 0)),
    ("LeftHand", "LeftForeArm", (0, -0.29, 0)),
    ("RightShoulder", "Chest", (-0.03, 0.2, 0)),
    ("RightArm", "RightShoulder", (-0.18, 0, 0)),
    ("RightForeArm", "RightArm", (0, -0.33, 0)),
    ("RightHand", "RightForeArm", (0, -0.29, 0)),
    ("LeftUpLeg", "Hips", (0.11, -0.03, 0)),
    ("LeftLeg", "LeftUpLeg", (0, -0.5, 0)),
    ("LeftFoot", "LeftLeg", (0, -0.5, 0)),
    ("LeftToeBase", "LeftFoot", (0, -0.08, 0.17)),
    ("RightUpLeg", "Hips", (-0.11, -0.03, 0)),
    ("RightLeg", "RightUpLeg", (0, -0.5, 0)),
    ("RightFoot", "RightLeg", (0, -0.5, 0)),
    ("RightToeBase", "RightFoot", (0, -0.08, 0.17)),
)
ENDS = {"Head": (0, 0.16, 0), "LeftHand": (0, -0.11, 0), "RightHand": (0, -0.11, 0),
        "LeftToeBase": (0, 0, 0.07), "RightToeBase": (0, 0, 0.07)}
CHILDREN = {name: [child for child, parent, _ in JOINTS if parent == name] for name, _, _ in JOINTS}


class Sway:
    """A slow random angle (degrees) for each joint and axis."""

    def __init__(self, dice, size):
        self.dice, self.size, self.waves = dice, size, {}

    def __call__(self, joint, axis, seconds):
        waves = self.waves.setdefault((joint, axis), [
            (self.dice.uniform(0.1, 0.6), self.dice.uniform(0, 2 * math.pi)) for _ in range(2)])
        return self.size * sum(math.sin(2 * math.pi * hz * seconds + phase) for hz, phase in waves)


class Person:
    """Body and style: the same in all takes."""

    def __init__(self, name):
        dice = random.Random(f"person {name}")
        self.leg_cm = dice.uniform(78, 98)
        longer = {part: dice.uniform(0.93, 1.07) for part in ("spine", "arm", "width")}
        self.offsets = {}
        for joint, _, (x, y, z) in JOINTS:
            part = ("spine" if joint in ("Spine", "Chest", "Neck", "Head") else
                    "arm" if "Arm" in joint or "Hand" in joint else "width")
            stretch = longer[part] if not joint.endswith(("Leg", "Foot", "ToeBase")) else 1
            self.offsets[joint] = (x * longer["width"], y * stretch, z)
        self.tempo = dice.uniform(0.92, 1.08)
        self.size = dice.uniform(0.88, 1.12)
        self.lean = dice.uniform(-1, 4)
        self.arms_out = dice.uniform(5, 11)
        self.elbows = dice.uniform(12, 25)
        self.name = name


def leg_angles(hip, knee):
    """Rotations about x of thigh, shank and foot: the sole stays near the floor."""
    return -hip, knee, hip - knee


def locomotion(angle, person, phase, seconds, stride, knees, arms, elbows, lean):
    """A step cycle: legs in opposition, arms against them."""
    for side, lead in (("Left", 0), ("Right", math.pi)):
        cycle = phase + lead
        hip = 4 + stride * math.sin(cycle)
        swing = max(0.0, math.cos(cycle))  # the leg moves to the front
        thigh, shank, foot = leg_angles(hip, 6 + knees * swing ** 1.5)
        angle[f"{side}UpLeg"][0] += thigh
        angle[f"{side}Leg"][0] += shank
        angle[f"{side}Foot"][0] += 0.7 * foot
        angle[f"{side}Arm"][0] += arms * math.sin(cycle)
        angle[f"{side}ForeArm"][0] -= elbows + 0.3 * arms * max(0.0, math.sin(cycle + math.pi))
    angle["Spine"][0] += lean
    angle["Spine"][1] += 0.3 * stride * math.sin(phase)
    angle["Hips"][1] -= 0.25 * stride * math.sin(phase)
    angle["Hips"][2] += 2 * math.sin(phase + 0.5)


def pose(label, person, dice, sway, seconds):
    """Rotations (degrees, about x, y, z) of each joint; those of the hips without the heading.
    Returns them with the heading's change per second."""
    angle = {joint: [sway(joint, axis, seconds) for axis in range(3)] for joint, _, _ in JOINTS}
    for side, sign in (("Left", 1), ("Right", -1)):
        angle[f"{side}Arm"][2] += sign * person.arms_out
    tempo = 2 * math.pi * person.tempo * dice["tempo"]
    size = person.size * dice["size"]
    start = dice["phase"]
    turn = 0.0
    if label == "walk":
        locomotion(angle, person, start + 0.92 * tempo * seconds, seconds, 24 * size, 52 * size,
                   20 * size, person.elbows, person.lean)
        turn = dice["turn"]
    elif label == "run":
        locomotion(angle, person, start + 1.4 * tempo * seconds, seconds, 38 * size, 92 * size,
                   36 * size, 75 + person.elbows, 8 + person.lean)
        turn = dice["turn"]
    elif label == "turn":
        locomotion(angle, person, start + 0.85 * tempo * seconds, seconds, 8 * size, 34 * size,
                   9 * size, person.elbows, person.lean)
        turn = dice["side"] * (95 + 25 * dice["turn"] / 8)
    else:
        wave = start + 1.7 * tempo * seconds
        arm, sign = ("LeftArm", 1) if dice["side"] > 0 else ("RightArm", -1)
        angle[arm][2] += sign * (118 + 8 * size * math.sin(wave))
        angle[arm.replace("Arm", "ForeArm")][2] += sign * (35 + 32 * size * math.sin(wave + 0.4))
        for side in ("Left", "Right"):
            thigh, shank, foot = leg_angles(3, 5)
            angle[f"{side}UpLeg"][0] += thigh
            angle[f"{side}Leg"][0] += shank
            angle[f"{side}Foot"][0] += foot
    return angle, turn


def toes(person, angle):
    """Returns the positions of both toes below the hips (leg lengths): front and up."""
    points = []
    for side in ("Left", "Right"):
        front = up = bend = 0.0
        for joint in (f"{side}UpLeg", f"{side}Leg", f"{side}Foot", f"{side}ToeBase"):
            _, y, z = person.offsets[joint]
            front += math.cos(bend) * z - math.sin(-bend) * y
            up += math.cos(bend) * y + math.sin(-bend) * z
            bend += math.radians(angle[joint][0])
        points.append((front, up))
    return points


def frames_of(label, person, take):
    """Yields the values of each frame: root position (cm), then the angles in the order of JOINTS."""
    dice = random.Random(f"{label} {person.name} {take}")
    sway = Sway(dice, 1.2)
    style = {"tempo": dice.uniform(0.95, 1.05), "size": dice.uniform(0.93, 1.07),
             "phase": dice.uniform(0, 2 * math.pi), "turn": dice.uniform(-8, 8),
             "side": dice.choice((-1, 1))}
    left = front = 0.0
    heading = dice.uniform(-math.pi, math.pi)
    speed = 0.0  # leg lengths per frame
    before = None
    for frame in range(RATE_HZ * SECONDS):
        angle, turn = pose(label, person, style, sway, frame / RATE_HZ)
        feet = toes(person, angle)
        standing = min((0, 1), key=lambda foot: feet[foot][1])
        if before is not None and label != "wave":
            speed += 0.25 * (before[standing][0] - feet[standing][0] - speed)
            left += speed * math.sin(heading)
            front += speed * math.cos(heading)
        heading += math.radians(turn) / RATE_HZ
        before = feet
        height = -feet[standing][1] + 0.02
        if label == "run":  # a flight after each step
            height += 0.03 * abs(math.sin(2 * math.pi * 1.4 * person.tempo * frame / RATE_HZ))
        cm = person.leg_cm
        yield [left * cm, height * cm, front * cm], angle, math.degrees(heading)


def hierarchy(person, joint="Hips", depth=0):
    """Returns the lines of a joint and all below it."""
    indent = "  " * depth
    x, y, z = (person.leg_cm * value for value in person.offsets[joint])
    lines = [f"{indent}{'ROOT' if depth == 0 else 'JOINT'} {joint}", indent + "{",
             f"{indent}  OFFSET {x:.3f} {y:.3f} {z:.3f}",
             f"{indent}  CHANNELS " + ("6 Xposition Yposition Zposition Yrotation Xrotation Zrotation"
                                       if depth == 0 else "3 Zrotation Yrotation Xrotation")]
    for child in CHILDREN[joint]:
        lines += hierarchy(person, child, depth + 1)
    if joint in ENDS:
        x, y, z = (person.leg_cm * value for value in ENDS[joint])
        lines += [f"{indent}  End Site", indent + "  {",
                  f"{indent}    OFFSET {x:.3f} {y:.3f} {z:.3f}", indent + "  }"]
    return lines + [indent + "}"]


def order(joint="Hips"):
    """Joints in the order of the hierarchy."""
    return [joint] + [name for child in CHILDREN[joint] for name in order(child)]


def write_bvh(path, label, person, take):
    with open(path, "w", encoding="utf-8") as file:
        file.write("HIERARCHY\n" + "\n".join(hierarchy(person)) + "\nMOTION\n")
        file.write(f"Frames: {RATE_HZ * SECONDS}\nFrame Time: {1 / RATE_HZ:.8f}\n")
        for root, angle, heading in frames_of(label, person, take):
            values = list(root)
            for joint in order():
                x, y, z = angle[joint]
                values += [heading + y, x, z] if joint == "Hips" else [z, y, x]
            file.write(" ".join(f"{value:.4f}" for value in values) + "\n")


def main():
    if len(sys.argv) != 2 or sys.argv[1].startswith("-"):
        print(__doc__)
        return 0 if sys.argv[1:] == ["--help"] else 2
    folder = sys.argv[1]
    os.makedirs(folder, exist_ok=True)
    with open(os.path.join(folder, "clips.tsv"), "w", encoding="utf-8") as clips:
        clips.write("path\tlabel\tsubject\n")
        for name in PEOPLE:
            person = Person(name)
            for label in LABELS:
                for take in range(1, TAKES + 1):
                    file_name = f"{label}-{name}-{take}.bvh"
                    write_bvh(os.path.join(folder, file_name), label, person, take)
                    clips.write(f"{file_name}\t{label}\t{name}\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
