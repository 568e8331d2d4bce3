"""Tests `swimlab lens` from outside: exit codes and messages, the JSON contract, meshes and pictures that belong together."""

import json
import math
import os
import pathlib
import subprocess
import sys
import tempfile
import unittest
import xml.etree.ElementTree

SWIMLAB = None
SOURCE = None
RECORDINGS = None

HEADSETS = ["azuma_see_through", "cardboard_v1", "flight_helmet", "osvr_hdk_2_0", "rift_dk1", "rift_dk2", "wide_canted_90hz"]


def swimlab(*arguments, cwd=None):
    return subprocess.run([SWIMLAB, *map(str, arguments)], capture_output=True, text=True, cwd=cwd, timeout=600)


def strict_json(text):
    def refuse(name):
        raise ValueError("not finite: " + name)
    return json.loads(text, parse_constant=refuse)


class Lens(unittest.TestCase):
    def setUp(self):
        self.scratch = tempfile.TemporaryDirectory(prefix="holdfast-lens-")
        self.dir = pathlib.Path(self.scratch.name)

    def tearDown(self):
        self.scratch.cleanup()

    def done(self, *arguments):
        answer = swimlab("lens", *arguments, cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr + answer.stdout)
        return answer.stdout

    def refused(self, arguments, *words):
        before = sorted(self.dir.rglob("*"))
        answer = swimlab("lens", *arguments, cwd=self.dir)
        self.assertEqual(answer.returncode, 2, answer.stderr + answer.stdout)
        for word in words:
            self.assertIn(word, answer.stderr)
        self.assertEqual(sorted(self.dir.rglob("*")), before, "something was left behind")

    def check_files(self, folder, row):
        """Mesh and pictures of a row's eye."""
        eye = row["eye"]
        mesh = strict_json((folder / f"{eye}_mesh.json").read_text())
        self.assertEqual(mesh["schema"], "holdfast/mesh/1")
        self.assertEqual(len(mesh["vertices"]), row["vertices"])
        self.assertEqual(len(mesh["triangles"]), row["triangles"])
        self.assertEqual(mesh["max_error_px"], row["mesh_error_px"])
        numbers = 8 if mesh["per_color"] else 4
        for vertex in mesh["vertices"][::97]:
            self.assertEqual(len(vertex), numbers)
            self.assertTrue(0 <= vertex[0] <= 1 and 0 <= vertex[1] <= 1)
        self.assertLess(max(max(t) for t in mesh["triangles"]), len(mesh["vertices"]))
        lines = (folder / f"{eye}_mesh.obj").read_text().splitlines()
        self.assertEqual(sum(line.startswith("v ") for line in lines), row["vertices"])
        self.assertEqual(sum(line.startswith("f ") for line in lines), row["triangles"] * (3 if mesh["per_color"] else 1))
        for picture in ["drawn", "seen", "mesh"]:
            svg = xml.etree.ElementTree.parse(folder / f"{eye}_{picture}.svg").getroot()
            self.assertTrue(svg.tag.endswith("svg"))
            words = " ".join(text.text or "" for text in svg.iter() if text.tag.endswith("text"))
            self.assertIn(eye + " eye", words)

    def test_every_headset(self):
        for name in HEADSETS:
            with self.subTest(headset=name):
                # A bound that is quick to reach; the default's is tested in tests/optics.
                words = self.done(SOURCE / f"assets/hmds/{name}.json", "--eye", "both", "--max-error-px", "0.5", "--out", name,
                                  "--json", "copy.json")
                result = strict_json((self.dir / "copy.json").read_text())
                self.assertEqual(result, strict_json((self.dir / name / "lens.json").read_text()))
                self.assertEqual(result["schema"], "holdfast/lens/1")
                self.assertIn(result["hmd"], words)
                for row in result["rows"]:
                    for key in ["eye", "color", "model", "valid_radius_px", "residual_px", "vertices", "mesh_error_px"]:
                        self.assertIn(key, row)
                    self.assertLess(row["residual_px"]["max"], 1e-6)
                    self.assertLessEqual(row["residual_px"]["rms"], row["residual_px"]["max"])
                    self.assertEqual(row["unanswered"], 0)
                    self.assertLessEqual(row["mesh_error_px"], 0.5)
                    self.assertEqual(row["dark_pct"] > 0, row["first_end"] is not None)
                colors = [row["color"] for row in result["rows"] if row["eye"] == "left"]
                self.assertEqual(colors, ["red", "green", "blue"] if name.startswith("rift") else ["all"])
                left, right = result["eyes"]
                self.assertAlmostEqual(left["seen_to_corners"]["left_deg"], -right["seen_to_corners"]["right_deg"], places=4)
                self.check_files(self.dir / name, result["rows"][0])
                self.check_files(self.dir / name, result["rows"][-1])

    def test_a_fold_is_told_with_its_place(self):
        words = self.done(SOURCE / "assets/hmds/osvr_hdk_2_0.json", "--max-error-px", "0.5", "--out", "o")
        self.assertIn("ends inside the panel", words)
        row = strict_json((self.dir / "o/lens.json").read_text())["rows"][0]
        # r (1 + k1 r^2 + k2 r^4 + k3 r^6) with the descriptor's numbers: the slope's first zero.
        k, low, high = (0.2245325534, 0.6660516744, -0.5227698227), 0.5, 2.0
        slope = lambda r: 1 + 3 * k[0] * r**2 + 5 * k[1] * r**4 + 7 * k[2] * r**6
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if slope(middle) > 0 else (low, middle)
        px_per_tangent = 1200 / (2 * 0.8742396535)
        self.assertAlmostEqual(row["first_end"]["radius_px"], low * 0.8742396535 * px_per_tangent, delta=0.01)
        seen = low * (1 + k[0] * low**2 + k[1] * low**4 + k[2] * low**6) * 0.8742396535
        self.assertAlmostEqual(row["first_end"]["seen_deg"], math.degrees(math.atan(seen)), delta=0.01)

    def test_overfill_and_limit(self):
        descriptor = SOURCE / "assets/hmds/azuma_see_through.json"
        self.done(descriptor, "--budget-deg", "0,0,0", "--out", "o")
        eye = strict_json((self.dir / "o/lens.json").read_text())["eyes"][0]
        self.assertEqual(eye["overfill"]["size_px"], [640, 512])
        self.done(descriptor, "--budget-deg", "5,0,0", "--out", "o")
        wide = strict_json((self.dir / "o/lens.json").read_text())["eyes"][0]
        self.assertAlmostEqual(wide["overfill"]["right_deg"], eye["overfill"]["right_deg"] + 5, delta=1e-4)
        self.done(SOURCE / "assets/hmds/rift_dk1.json", "--limit-deg", "40", "--max-error-px", "0.5", "--out", "o")
        eye = strict_json((self.dir / "o/lens.json").read_text())["eyes"][0]
        for edge in ["left_deg", "right_deg", "down_deg", "up_deg"]:
            self.assertAlmostEqual(abs(eye["seen_to_corners"][edge]), 40, delta=0.1)

    def test_a_fixed_grid(self):
        self.done(SOURCE / "assets/hmds/flight_helmet.json", "--grid", "20", "--out", "o")
        row = strict_json((self.dir / "o/lens.json").read_text())["rows"][0]
        self.assertEqual(row["vertices"], 441)
        self.assertEqual(row["triangles"], 800)

    def test_bad_use_is_named(self):
        good = SOURCE / "assets/hmds/flight_helmet.json"
        (self.dir / "bad.json").write_text('{"schema": "holdfast/hmd/1"')
        (self.dir / "file").write_text("x")
        self.refused(["nothing.json"], "nothing.json")
        self.refused(["bad.json"], "bad.json")
        self.refused([], "HMD")
        for option, value, expected in [("--max-error-px", "0", "0.005"), ("--max-error-px", "soon", "pixels"), ("--grid", "0", "1 to 1024"),
                                        ("--grid", "2.5", "whole"), ("--eye", "third", "left, right, both"),
                                        ("--budget-deg", "1,2", "three angles"), ("--budget-deg", "6,,4,3", "single commas"),
                                        ("--budget-deg", "6,4,3,", "single commas"), ("--budget-deg", "1,2,99", "45"),
                                        ("--limit-deg", "90", "85"), ("--json", "none/x.json", "no folder")]:
            with self.subTest(option=option, value=value):
                self.refused([good, f"{option}={value}", "--out", "o"], option, expected)
        self.refused([good, "--out", "file"], "--out", "file", "no folder")
        self.refused([good, "--out", "file/o"], "--out", "file")

    def test_help_has_an_example(self):
        answer = swimlab("lens", "--help")
        self.assertEqual(answer.returncode, 0)
        self.assertIn("Example", answer.stdout)
        self.assertIn("swimlab lens", answer.stdout)

    def test_osvr_descriptors(self):
        folder = pathlib.Path(RECORDINGS) / "hmd"
        if not folder.exists():
            self.skipTest("descriptors are not here")
        for name in ["OSVR_HDK_1_3_with_mesh", "OSVR_HDK_2_0", "OSVR_HDK_1_1"]:
            with self.subTest(headset=name):
                self.done(folder / f"{name}.json", "--max-error-px", "0.5", "--out", name)
                row = strict_json((self.dir / name / "lens.json").read_text())["rows"][0]
                self.assertLess(row["residual_px"]["max"], 1e-6)
                self.check_files(self.dir / name, row)
                if row["model"] == "point_mesh":
                    self.assertLess(row["mesh_error_px"], 0.001)  # drawn by its own triangles


if __name__ == "__main__":
    SWIMLAB = os.path.abspath(sys.argv[1])
    SOURCE = pathlib.Path(sys.argv[2]).resolve()
    RECORDINGS = sys.argv[3] if len(sys.argv) > 3 else ""
    unittest.main(argv=[sys.argv[0]], verbosity=2)
