#!/usr/bin/python3
"""Draws every picture from a real server and real motion, as SVG and PNG.

    picture_test.py MOTIONDBD MOTIONDB DATA_FOLDER

Uses the motion of Debian's assimp-testmodels.
"""

import os
import struct
import subprocess
import unittest
import xml.etree.ElementTree
import zlib

from programs import MODELS, MOTIONDB, WithServer, main

SVG = "{http://www.w3.org/2000/svg}"


def png_size(path):
    """Returns width, height and the number of different bytes of the pixels."""
    with open(path, "rb") as file:
        data = file.read()
    assert data[:8] == b"\x89PNG\r\n\x1a\n"
    width, height = struct.unpack(">II", data[16:24])
    at, pixels = 8, b""
    while at < len(data):
        length, kind = struct.unpack(">I4s", data[at:at + 8])
        if kind == b"IDAT":
            pixels += data[at + 8:at + 8 + length]
        at += 12 + length
    return width, height, len(set(zlib.decompress(pixels)))


class Pictures(WithServer):
    def setUp(self):
        if not os.path.isdir(MODELS):
            self.skipTest(f"assimp-testmodels is not installed: {MODELS} is missing")
        super().setUp()
        self.begin_with("demo", self.fill)

    def fill(self):
        self.server.ask_one("create", "demo")
        self.server.ask("ingest", "demo", "--label", "<script>box</script>",
                        f"{MODELS}/Boxing_Toes.bvh")
        self.server.ask("ingest", "demo", f"{MODELS}/01_01.bvh", f"{MODELS}/01_03.bvh")

    def draw(self, *arguments):
        """Draws SVG twice and PNG; returns the elements of the SVG file by their classes."""
        svg, again, png = (self.path(name) for name in ("a.svg", "b.svg", "a.png"))
        for out in (svg, again, png):
            result = self.server.run("picture", *arguments, "--out", out)
            self.assertEqual(result.returncode, 0, result.stderr)
            self.assertEqual(result.stdout, f"wrote {out}\n")
        with open(svg, encoding="utf-8") as first, open(again, encoding="utf-8") as second:
            text = first.read()
            self.assertEqual(text, second.read())
        self.assertNotIn("<script", text)
        root = xml.etree.ElementTree.fromstring(text)
        width, height, shades = png_size(png)
        self.assertLessEqual(abs(width - float(root.get("width"))), 1)
        self.assertLessEqual(abs(height - float(root.get("height"))), 1)
        self.assertGreater(shades, 20, "not blank")
        elements = {}
        for element in root.iter():
            elements.setdefault(element.get("class", ""), []).append(element)
        return elements

    def test_every_picture(self):
        model = self.server.ask_one("describe", "demo")
        bottom = model["bottom_node_count"]
        markers = 34  # of standard34

        elements = self.draw("map", "demo", "--points", "500")
        points = [name for name in elements if name.startswith("point ")]
        self.assertEqual(len(points), 2, "one for the label, one for no label")
        count = sum(len(elements[name]) for name in points)
        self.assertTrue(400 <= count <= 500, count)
        self.assertGreaterEqual(len(elements["node"]), bottom)
        self.assertEqual(len(elements["marker"]), 4 * markers)
        self.assertEqual(len(elements["bone"]), 4 * (markers - 1), "a tree joins the markers")
        self.assertEqual(len(elements["velocity"]), 4 * markers)
        self.draw("map", "demo", "--axes", "1,3", "--colour", "clip")
        self.draw("map", "demo", "--axes", "1,2,3", "--no-poses")

        layer = 4
        elements = self.draw("layer", "demo", "--layer", str(layer))
        ellipses = [e for name in elements if name.startswith("ellipse ") for e in elements[name]]
        self.assertEqual(len(ellipses), model["nodes_per_layer"][layer - 1])
        self.assertGreater(len(elements["transition"]), 3)

        elements = self.draw("clip", "demo", "Boxing_Toes", "--layer", "6", "--poses", "5")
        self.assertEqual(len(elements["marker"]), 5 * markers)
        visited = sum(len(elements[name]) for name in elements if name.startswith("ellipse "))
        self.assertEqual(visited + len(elements["other-node"]) - 1, model["nodes_per_layer"][5])

        elements = self.draw("estimate", "demo", f"{MODELS}/Boxing_Toes.bvh", "--at", "3",
                             "--horizon", "0.1,0.4")
        self.assertEqual(len(elements["path"]), 2, "path and legend")
        self.assertEqual(len(elements["last-node"]), 2)
        self.assertEqual(len(elements["then-marker"]), 2 * markers)

        elements = self.draw("recognize", "demo", f"{MODELS}/01_01.bvh", "--layers", "8,4")
        self.assertEqual(len(elements["panel-title"]), 2)

        elements = self.draw("plan", "demo", "--start", "Boxing_Toes@12", "--goal", "1,0.6,0.5",
                             "--disc", "0.7,-0.2,0.15")
        self.assertEqual(len(elements["path"]), 2)

    def test_errors(self):
        out = self.path("a.png")
        for expected, *arguments in (
                ("absent", "map", "absent"),
                ("layer", "layer", "demo", "--layer", "99"),
                ("missing", "clip", "demo", "missing")):
            result = self.server.run("picture", *arguments, "--out", out)
            self.assertEqual(result.returncode, 1, result.stderr)
            self.assertIn(expected, result.stderr)
            self.assertFalse(os.path.exists(out))

    def test_a_system_without_fonts(self):
        """Text has the built-in font, so a picture has as many shades as with a font."""
        configuration = self.path("fonts.conf")
        with open(configuration, "w", encoding="ascii") as file:
            file.write("<?xml version='1.0'?><!DOCTYPE fontconfig SYSTEM 'fonts.dtd'>"
                       f"<fontconfig><cachedir>{self.path('cache')}</cachedir></fontconfig>")
        out = self.path("font.png")
        result = subprocess.run(
            [MOTIONDB, "--server", self.server.address, "picture", "layer", "demo", "--layer", "1",
             "--out", out], env=dict(os.environ, FONTCONFIG_FILE=configuration),
            capture_output=True, text=True)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertGreater(png_size(out)[2], 20)


if __name__ == "__main__":
    main()
