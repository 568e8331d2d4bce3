"""Tests `swimlab lens` from outside: exit codes and messages, the JSON contract, meshes and pictures that belong together."""

import json
import math
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest
import xml.etree.ElementTree

import outside
from outside import SWIMLAB, Case, strict_json, swimlab

SOURCE = pathlib.Path(sys.argv[2]).resolve()
RECORDINGS = sys.argv[3] if len(sys.argv) > 3 else ""

HEADSETS = ["azuma_see_through", "cardboard_v1", "flight_helmet", "osvr_hdk_2_0", "rift_dk1", "rift_dk2", "wide_canted_90hz"]
VIEWER = SOURCE / "fuzz/corpus/cardboard/v1.uri"
PHONE = ["--phone-mm", "110x62", "--phone-px", "1920x1080"]


def lines_of(path):
    """The points of an SVG path that holds M, l and Z alone."""
    lines = []
    for line in path.replace("Z", "").split("M")[1:]:
        steps = [tuple(map(float, step.split())) for step in line.split("l")]
        lines.append([(sum(x for x, _ in steps[:i + 1]), sum(y for _, y in steps[:i + 1])) for i in range(len(steps))])
    return lines


def area(ring):
    """Positive if it runs counter-clockwise (Y up)."""
    return sum(a[0] * b[1] - a[1] * b[0] for a, b in zip(ring, ring[1:] + ring[:1])) / 2


class Lens(Case):
    def lens(self, *arguments):
        return self.done("lens", *arguments)

    def lens_refused(self, arguments, *words):
        self.refused(["lens", *arguments], *words)

    def result(self, folder="o"):
        return strict_json((self.dir / folder / "lens.json").read_text())

    def write_with(self, name, path, value, headset="flight_helmet"):
        """A descriptor of ours with one value changed."""
        descriptor = json.loads((SOURCE / f"assets/hmds/{headset}.json").read_text())
        inner = descriptor
        for key in path[:-1]:
            inner = inner[key]
        inner[path[-1]] = value
        (self.dir / name).write_text(json.dumps(descriptor, indent=1))

    def check_files(self, folder, result, row):
        """Mesh and pictures of a row's eye."""
        eye = row["eye"]
        files = [f"{eye}_{name}" for name in ["drawn.svg", "seen.svg", "mesh.svg", "mesh.json", "mesh.obj"]]
        self.assertEqual([e["files"] for e in result["eyes"] if e["eye"] == eye], [files])
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
                words = self.lens(SOURCE / f"assets/hmds/{name}.json", "--eye", "both", "--max-error-px", "0.5", "--out", name,
                                  "--json", "copy.json")
                result = strict_json((self.dir / "copy.json").read_text())
                self.assertEqual(result, self.result(name))
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
                self.check_files(self.dir / name, result, result["rows"][0])
                self.check_files(self.dir / name, result, result["rows"][-1])

    def test_a_fold_is_told_with_its_place(self):
        words = self.lens(SOURCE / "assets/hmds/osvr_hdk_2_0.json", "--max-error-px", "0.5", "--out", "o")
        self.assertIn("ends inside the panel", words)
        row = self.result()["rows"][0]
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
        self.lens(descriptor, "--budget-deg", "0,0,0", "--out", "o")
        eye = self.result()["eyes"][0]
        self.assertEqual(eye["overfill"]["size_px"], [640, 512])
        self.lens(descriptor, "--budget-deg", "5,0,0", "--out", "o")
        wide = self.result()["eyes"][0]
        self.assertAlmostEqual(wide["overfill"]["right_deg"], eye["overfill"]["right_deg"] + 5, delta=1e-4)
        words = self.lens(SOURCE / "assets/hmds/rift_dk1.json", "--limit-deg", "40", "--max-error-px", "0.5", "--out", "o")
        eye = self.result()["eyes"][0]
        for edge in ["left_deg", "right_deg", "down_deg", "up_deg"]:
            self.assertAlmostEqual(abs(eye["seen_to_corners"][edge]), 40, delta=0.1)
        self.assertIn("within --limit-deg", words)
        self.assertNotIn("seen to", words)  # what the whole panel shows is called unlimited

    def test_a_fixed_grid(self):
        self.lens(SOURCE / "assets/hmds/flight_helmet.json", "--grid", "20", "--out", "o")
        row = self.result()["rows"][0]
        self.assertEqual(row["vertices"], 441)
        self.assertEqual(row["triangles"], 800)
        self.assertEqual(self.result()["eyes"][0]["mesh_verdict"], "none")  # no bound was asked for

    def test_bad_use_is_named(self):
        good = SOURCE / "assets/hmds/flight_helmet.json"
        (self.dir / "bad.json").write_text('{"schema": "holdfast/hmd/1"')
        (self.dir / "file").write_text("x")
        self.lens_refused(["nothing.json"], "nothing.json")
        self.lens_refused(["bad.json"], "bad.json")
        self.lens_refused([], "HMD")
        self.lens_refused([self.dir], "is a folder")
        os.mkfifo(self.dir / "pipe")
        self.lens_refused(["pipe"], "pipe", "named pipe")
        self.lens_refused(["/dev/zero"], "/dev/zero", "device")
        for path, value, words in [(["name"], "", ["name", "empty"]), (["ipd_m"], float("nan"), ["JSON"]),
                                   (["eyes", "left", "resolution_px"], [0, 480], ["eyes.left.resolution_px[0]", "0", "1 to 32768"])]:
            with self.subTest(key=path):
                self.write_with("bad.json", path, value)
                self.lens_refused(["bad.json"], "bad.json:", *words)
        self.lens_refused([good, "--grid", "4", "--max-error-px", "1"], "--grid", "--max-error-px")
        for option, value, expected in [("--max-error-px", "0", "0.005"), ("--max-error-px", "soon", "pixels"), ("--grid", "0", "1 to 1024"),
                                        ("--grid", "2.5", "whole"), ("--eye", "third", "left, right, both"),
                                        ("--budget-deg", "1,2", "three angles"), ("--budget-deg", "6,,4,3", "single commas"),
                                        ("--budget-deg", "6,4,3,", "single commas"), ("--budget-deg", "1,2,99", "45"),
                                        ("--limit-deg", "90", "85"), ("--json", "none/x.json", "no folder")]:
            with self.subTest(option=option, value=value):
                self.lens_refused([good, f"{option}={value}", "--out", "o"], option, expected)
        self.lens_refused([good, "--out", "file"], "--out", "file", "is a file")
        self.lens_refused([good, "--out", "file/o"], "--out", "file")

    def test_folders_are_replaced_as_a_whole(self):
        good = SOURCE / "assets/hmds/flight_helmet.json"
        self.lens(good, "--eye", "both", "--grid", "4", "--out", "o")
        self.lens(good, "--grid", "4", "--out", "o")
        self.assertEqual(len(list((self.dir / "o").iterdir())), 6)  # nothing of the right eye is left
        (self.dir / "o/thesis.txt").write_text("years of work")
        self.lens_refused([good, "--out", "o"], "--out", "thesis.txt")
        self.assertEqual([path.name for path in self.dir.iterdir()], ["o"])

    def test_interrupted_it_leaves_nothing(self):
        # Seconds of work: 32768 x 32768 pixels, and the finest bound.
        self.write_with("large.json", ["eyes", "left", "resolution_px"], [32768, 32768])
        process = subprocess.Popen([SWIMLAB, "lens", "large.json", "--eye", "both", "--max-error-px", "0.1", "--out", "o"], cwd=self.dir,
                                   stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                   preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL))
        while process.poll() is None and not list(self.dir.glob("o.unfinished-*")):
            time.sleep(0.01)
        process.send_signal(signal.SIGINT)
        _, words = process.communicate(timeout=120)
        self.assertEqual(process.returncode, 128 + signal.SIGINT, words)
        self.assertIn("interrupted", words)
        self.assertEqual([path.name for path in self.dir.iterdir()], ["large.json"])

    def test_a_mesh_that_misses_its_bound_fails_the_check(self):
        # Single precision on 32768 pixels: half an ulp is 0.002 px, and more where tangents are large.
        self.write_with("large.json", ["eyes", "right", "resolution_px"], [32768, 32768], "azuma_see_through")
        answer = swimlab("lens", "large.json", "--max-error-px", "0.005", "--out", "o", cwd=self.dir)
        self.assertEqual(answer.returncode, 1, answer.stderr + answer.stdout)
        self.assertIn("MISSES the bound of 0.005 px", answer.stdout)
        eye = self.result()["eyes"][0]
        self.assertEqual(eye["mesh_verdict"], "fail")
        self.assertEqual(eye["mesh_bound_px"], 0.005)
        self.assertGreater(eye["mesh_error_px"], 0.005)

    def test_a_large_mesh_is_written_once(self):
        descriptor = SOURCE / "assets/hmds/flight_helmet.json"
        words = self.lens(descriptor, "--grid", "360", "--out", "o")  # 259200 triangles
        self.assertIn("left_mesh.obj is left out", words)
        self.assertFalse((self.dir / "o/left_mesh.obj").exists())
        self.assertNotIn("left_mesh.obj", self.result()["eyes"][0]["files"])
        self.assertLess((self.dir / "o/left_mesh.svg").stat().st_size, 1e6)
        self.lens(descriptor, "--grid", "360", "--obj", "--out", "o")
        self.check_files(self.dir / "o", self.result(), self.result()["rows"][0])

    def test_a_cardboard_viewer_in_a_phone(self):
        self.lens_refused([VIEWER], "v1.uri", "Cardboard", "--phone-mm 110x62 --phone-px 1920x1080")
        self.lens_refused([VIEWER, *PHONE[:2]], "--phone-px", "is missing")
        self.lens_refused([VIEWER, "--phone-hz", "60"], "--phone-mm", "is missing")
        self.lens_refused([VIEWER, *PHONE[2:], "--phone-mm", "110"], "--phone-mm", "not a size", "110x62")
        self.lens_refused([VIEWER, *PHONE[:3], "1921x1080"], "--phone-px", "1921x1080", "even")
        self.lens_refused([VIEWER, *PHONE[2:], "--phone-mm", "30x62"], "v1.uri", "inter_lens_distance")
        self.lens_refused([SOURCE / "assets/hmds/cardboard_v1.json", *PHONE], "--phone-mm", "display of its own")
        words = self.lens(VIEWER, *PHONE, "--max-error-px", "0.5", "--out", "o")
        self.assertIn("on a phone of 110 x 62 mm", words)
        self.assertEqual(self.result()["eyes"][0]["resolution_px"], [960, 1080])
        self.check_files(self.dir / "o", self.result(), self.result()["rows"][0])

    def test_a_pipe_of_the_shell_is_read(self):
        text = (SOURCE / "assets/hmds/flight_helmet.json").read_text()
        answer = subprocess.run([SWIMLAB, "lens", "/dev/stdin", "--grid", "4", "--out", "o"], cwd=self.dir, input=text,
                                capture_output=True, text=True, timeout=60)
        self.assertEqual(answer.returncode, 0, answer.stderr)

    def test_grid_lines_are_seen_up_to_the_border(self):
        folder = pathlib.Path(RECORDINGS) / "hmd"
        if not folder.exists():
            self.skipTest("descriptors are not here")
        self.lens(folder / "OSVR_HDK_1_3_with_mesh.json", "--out", "o")
        svg = xml.etree.ElementTree.parse(self.dir / "o/left_seen.svg").getroot()
        panel = next(e for e in svg.iter() if e.tag.endswith("rect") and e.get("fill") == "black")
        top = float(panel.get("y"))
        grid = next(e for e in svg.iter() if e.get("stroke") == "#e8f1ff").get("d")
        reached = {round(x) for line in lines_of(grid) for x, y in line if abs(y - top) < 0.15}
        # The lines of -20, -10, 0, 10 and 20 degrees; the wider ones end at the lens's slanted edge.
        self.assertEqual(len(reached), 5, reached)

    def test_the_outline_goes_round_the_whole_mesh(self):
        folder = pathlib.Path(RECORDINGS) / "hmd"
        if not folder.exists():
            self.skipTest("descriptors are not here")
        # What its folds leave of this mesh has holes and tongues that touch in single vertices.
        self.lens(folder / "OSVR_HDK_2_0.json", "--eye", "right", "--out", "o")
        mesh = strict_json((self.dir / "o/right_mesh.json").read_text())
        corners = mesh["vertices"]
        whole = sum(area([corners[i][:2] for i in triangle]) for triangle in mesh["triangles"])
        svg = xml.etree.ElementTree.parse(self.dir / "o/right_drawn.svg").getroot()
        panel = next(e for e in svg.iter() if e.tag.endswith("rect") and e.get("fill") == "black")
        shown = next(e for e in svg.iter() if e.get("fill") == "#1b232d").get("d")
        drawn = sum(area(ring) for ring in lines_of(shown)) / (float(panel.get("width")) * float(panel.get("height")))
        self.assertAlmostEqual(abs(drawn), whole, delta=1e-3)  # places are rounded to 0.1 px of 880

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
                words = self.lens(folder / f"{name}.json", "--max-error-px", "0.5", "--out", name)
                row = self.result(name)["rows"][0]
                self.assertLess(row["residual_px"]["max"], 1e-6)
                self.check_files(self.dir / name, self.result(name), row)
                result = self.result(name)
                self.assertTrue(any("63 mm" in note for note in result["notes"]))
                self.assertIn("63 mm and 90 Hz are assumed", " ".join(words.split()))
                if name == "OSVR_HDK_2_0":
                    self.assertEqual((row["samples"]["samples"], row["samples"]["left_out"]), (1581, 52))
                    self.assertIn("52 are left out", words)
                else:
                    self.assertEqual(row["samples"] and row["samples"]["left_out"], 0 if row["model"] == "point_mesh" else None)
                if row["model"] == "point_mesh":
                    self.assertLess(row["mesh_error_px"], 0.001)  # drawn by its own triangles


if __name__ == "__main__":
    outside.main()
