#!/usr/bin/python3
"""Writes a BVH file of a walking figure: walk.py SECONDS SPEED > walk.bvh"""

import math
import sys

HIERARCHY = """\
HIERARCHY
ROOT Hips
{
  OFFSET 0 0 0
  CHANNELS 6 Xposition Yposition Zposition Zrotation Xrotation Yrotation
  JOINT LeftUpLeg
  {
    OFFSET 0.1 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT LeftLeg
    {
      OFFSET 0 -0.45 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 -0.45 0
      }
    }
  }
  JOINT RightUpLeg
  {
    OFFSET -0.1 0 0
    CHANNELS 3 Zrotation Xrotation Yrotation
    JOINT RightLeg
    {
      OFFSET 0 -0.45 0
      CHANNELS 3 Zrotation Xrotation Yrotation
      End Site
      {
        OFFSET 0 -0.45 0
      }
    }
  }
}
"""
RATE = 60


def main():
    seconds, speed = float(sys.argv[1]), float(sys.argv[2])
    frames = int(seconds * RATE)
    print(HIERARCHY, end="")
    print(f"MOTION\nFrames: {frames}\nFrame Time: {1 / RATE:.6f}")
    for frame in range(frames):
        time = frame / RATE
        phase = 2 * math.pi * speed * time
        swing, knee = 25 * math.sin(phase), 20 * (1 - math.cos(phase))
        root = [0, 0.9 + 0.02 * math.sin(2 * phase), 0.8 * speed * time, 0, 0, 3 * math.sin(phase)]
        numbers = root + [0, swing, 0, 0, knee, 0, 0, -swing, 0, 0, 40 - knee, 0]
        print(" ".join(f"{number:.5f}" for number in numbers))


main()
