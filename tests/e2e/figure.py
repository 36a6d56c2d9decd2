"""Small synthetic motion files: a figure of seven joints that steps or sits down."""

import math


def write_bvh(path, seed, frames=48):
    """Writes a BVH file; each seed gives another file."""
    lines = ["HIERARCHY", "ROOT Hips", "{", "OFFSET 0 0 0",
             "CHANNELS 6 Xposition Yposition Zposition Zrotation Yrotation Xrotation"]
    for side, x in (("Left", 10), ("Right", -10)):
        for joint, offset in (("UpLeg", f"{x} 0 0"), ("Leg", "0 -45 0"), ("Foot", "0 -45 0")):
            lines += [f"JOINT {side}{joint}", "{", f"OFFSET {offset}",
                      "CHANNELS 3 Zrotation Yrotation Xrotation"]
        lines += ["End Site", "{", "OFFSET 0 -5 15", "}", "}", "}", "}"]
    lines += ["}", "MOTION", f"Frames: {frames}", "Frame Time: 0.0166667"]
    steps = seed % 2 == 0
    for i in range(frames):
        angle = 2 * math.pi * (0.8 + 0.1 * (seed % 5)) * i / 60 + 0.37 * seed
        row = [0, 95 if steps else 80 + 15 * math.cos(angle), 1.7 * i if steps else 0, 0, 0, 0]
        for sign in (1, -1):
            swing = sign * math.sin(angle) if steps else math.cos(angle)
            row += [0, 0, 30 * swing, 0, 0, 20 + 20 * swing, 0, 0, 5 * swing]
        lines.append(" ".join(f"{value:.4f}" for value in row))
    with open(path, "w", encoding="ascii") as file:
        file.write("\n".join(lines) + "\n")
