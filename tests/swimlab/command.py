"""Tests the command from outside: exit codes and messages of bad use, files whole or absent, JSON as the contract says."""

import csv
import math
import os
import pathlib
import signal
import subprocess
import sys
import time
import unittest

import outside
from outside import SWIMLAB, Case, strict_json, swimlab

RECORDINGS = sys.argv[2] if len(sys.argv) > 2 else ""


def quaternion(ax, ay, az):
    """Unit quaternion (x, y, z, w) of the rotation vector (rad)."""
    angle = math.sqrt(ax * ax + ay * ay + az * az)
    if angle < 1e-12:
        return 0.0, 0.0, 0.0, 1.0
    s = math.sin(angle / 2) / angle
    return ax * s, ay * s, az * s, math.cos(angle / 2)


def conjugate(q):
    return -q[0], -q[1], -q[2], q[3]


def times(a, b):
    """Of two quaternions (x, y, z, w)."""
    ax, ay, az, aw = a
    bx, by, bz, bw = b
    return (aw * bx + ax * bw + ay * bz - az * by, aw * by - ax * bz + ay * bw + az * bx,
            aw * bz + ax * by - ay * bx + az * bw, aw * bw - ax * bx - ay * by - az * bz)


def motion_at(m):
    """Orientation and place of a head that moves about several axes."""
    q = quaternion(0.15 * math.sin(2.1 * m), 0.26 * math.sin(2 * math.pi * m), 0.08 * math.sin(3.3 * m + 1))
    return q, (0.1 * math.sin(1.7 * m), 1.6 + 0.03 * math.sin(2.9 * m), 0.08 * math.cos(1.3 * m))


def write_motion(path, shift_s=0.0, rate_hz=120.0, seconds=12.0):
    """A smooth head motion about several axes, sampled at `rate_hz`, shown `shift_s` late."""
    lines = []
    for i in range(int(seconds * rate_hz)):
        t = i / rate_hz
        q, p = motion_at(t - shift_s)
        lines.append("%.9f %.12g %.12g %.12g %.12g %.12g %.12g %.12g" % (100 + t, *p, *q))
    path.write_text("\n".join(lines) + "\n")


class BadUse(Case):
    def test_options_are_named_with_value_and_expectation(self):
        for option, value, expected in [
                ("--latency-ms", "-5", "0 to 1000"), ("--latency-ms", "nan", "0 to 1000"), ("--latency-ms", "1e9", "0 to 1000"),
                ("--latency-ms", "soon", "milliseconds"), ("--size", "0x0", "1280x720"), ("--size", "1280", "1280x720"),
                ("--size", "-3x4", "1280x720"), ("--eye", "middle", "left, right, both"), ("--lens", "thick", "uncorrected"),
                ("--display", "sideways", "global, rolling"), ("--pipeline", "P9", "P0"), ("--seed", "-1", "whole number"),
                ("--backend", "glide", "osmesa"), ("--late-ms", "-1", "0 to 1000"), ("--late-ms", "inf", "0 to 1000"),
                ("--late-ms", "61", "latency-ms"),
                ("--deflection", "bend", "shift_roll"), ("--plane-distance-m", "0", "0.05 to 1000"),
                ("--plane-distance-m", "far", "metres"), ("--interval-error-ms", "101", "-100 to 100"),
                ("--interval-error-ms", "early", "milliseconds"), ("--latency-ms", "20,,30", "single commas"),
                ("--motion", "M1,", "single commas")]:
            with self.subTest(option=option, value=value):
                self.refused(["run", f"{option}={value}", "--out", "r"], option, value, expected)

    def test_a_deflection_needs_a_pipeline_that_deflects(self):
        self.refused(["run", "--pipeline", "P0,P1", "--deflection", "shift", "--out", "r"], "--deflection", "shift", "P4")

    def test_no_value_is_lost_between_commas(self):
        write_motion(self.dir / "m.tum")
        self.refused(["predict", "m.tum", "--interval-ms", "20,,30"], "--interval-ms", "20,,30", "single commas")

    def test_unknown_motion_lists_the_known_and_says_no_file(self):
        self.refused(["run", "--motion", "M77", "--out", "r"], "M77", "M0", "M8", "file")

    def test_unreadable_files_are_named(self):
        (self.dir / "bad.tum").write_text("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n2 0 oops 0 0 0 0 1\n")
        (self.dir / "bad.json").write_text('{"schema": "holdfast/hmd/1"')
        self.refused(["run", "--motion", "bad.tum", "--out", "r"], "bad.tum:3", "oops", "a number")
        self.refused(["predict", "bad.tum"], "bad.tum:3", "oops")
        self.refused(["latency", "bad.tum", "bad.tum"], "bad.tum:3", "oops")
        self.refused(["predict", "nothing.tum"], "nothing.tum")
        self.refused(["run", "--hmd", "bad.json", "--out", "r"], "bad.json")
        self.refused(["run", "--model", "bad.tum", "--out", "r"], "bad.tum")

    def test_too_short_a_motion(self):
        (self.dir / "short.tum").write_text("0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n")
        self.refused(["run", "--motion", "short.tum", "--out", "r"], "short.tum", "too short")
        self.refused(["latency", "short.tum", "short.tum"], "20 samples")

    def test_no_subcommand_and_unknown_options(self):
        self.refused([], "subcommand")
        self.refused(["run", "--colour", "red"], "--colour")
        self.refused(["latency", "one.tum"], "OBSERVED")
        self.refused(["fly"], "fly")

    def test_a_folder_of_others_is_left_alone(self):
        other = self.dir / "mine"
        other.mkdir()
        (other / "thesis.txt").write_text("years of work")
        self.refused(["run", "--motion", "M0", "--out", "mine"], "--out", "thesis.txt")
        (self.dir / "file").write_text("x")
        self.refused(["run", "--motion", "M0", "--out", "file"], "--out", "is a file")
        self.assertEqual((other / "thesis.txt").read_text(), "years of work")

    def test_a_bad_place_for_json_is_told_before_the_work(self):
        write_motion(self.dir / "m.tum")
        (self.dir / "lost").symlink_to("nowhere")
        os.mkfifo(self.dir / "pipe")
        for command in [["run", "--motion", "M0", "--out", "r"], ["predict", "m.tum"], ["latency", "m.tum", "m.tum"]]:
            for place, problem in [("none/x.json", "no folder"), (".", "is a folder"), ("pipe", "a pipe"),
                                   ("lost", "leads nowhere"), ("m.tum/x.json", "")]:
                with self.subTest(command=command[0], place=place):
                    self.refused([*command, "--json", place], "--json", place, problem)
        self.assertTrue((self.dir / "pipe").is_fifo())

    def test_links_are_followed_not_replaced(self):
        write_motion(self.dir / "m.tum")
        (self.dir / "real.json").write_text("old")
        (self.dir / "link.json").symlink_to("real.json")
        answer = swimlab("predict", "m.tum", "--json", "link.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertTrue((self.dir / "link.json").is_symlink())
        self.assertIn("holdfast/predict/1", (self.dir / "real.json").read_text())
        (self.dir / "report").mkdir()
        (self.dir / "latest").symlink_to("report")
        answer = swimlab("run", "--motion", "M0", "--size", "64x64", "--out", "latest", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertTrue((self.dir / "latest").is_symlink())
        self.assertTrue((self.dir / "report/report.html").exists())

    def test_an_interrupted_run_leaves_nothing(self):
        for asked in [signal.SIGINT, signal.SIGTERM]:
            with self.subTest(signal=asked.name):
                process = subprocess.Popen([SWIMLAB, "run", "--full", "--size", "320x180", "--out", "r"], cwd=self.dir,
                                           stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True,
                                           # A test started in the background ignores SIGINT, and its children do too.
                                           preexec_fn=lambda: signal.signal(asked, signal.SIG_DFL))
                while process.poll() is None and not list(self.dir.glob("r.unfinished-*/pictures/*")):
                    time.sleep(0.05)
                process.send_signal(asked)
                _, words = process.communicate(timeout=60)
                self.assertEqual(process.returncode, 128 + asked, words)
                self.assertIn("interrupted", words)
                self.assertEqual(list(self.dir.iterdir()), [])

    @unittest.skipUnless(os.path.exists("/dev/full"), "no /dev/full here")
    def test_words_that_cannot_be_written_are_not_done(self):
        write_motion(self.dir / "m.tum")
        with open("/dev/full", "w") as full:
            answer = subprocess.run([SWIMLAB, "predict", self.dir / "m.tum"], stdout=full, stderr=subprocess.PIPE, text=True)
        self.assertEqual(answer.returncode, 2)
        self.assertIn("standard output", answer.stderr)

    def test_help_has_an_example(self):
        for command in ["run", "predict", "latency"]:
            answer = swimlab(command, "--help")
            self.assertEqual(answer.returncode, 0)
            self.assertIn("Example", answer.stdout)
            self.assertIn("swimlab " + command, answer.stdout)


class Run(Case):
    def test_contract_files_and_checks(self):
        answer = swimlab("run", "--motion", "M1,M0", "--size", "640x360", "--latency-ms", "60", "--out", "r", "--json",
                         "copy.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        self.assertNotIn("\r", answer.stderr)  # no progress bar into a pipe
        summary = strict_json((self.dir / "r/summary.json").read_text())
        self.assertEqual(summary, strict_json((self.dir / "copy.json").read_text()))
        self.assertEqual(summary["schema"], "holdfast/run/1")
        self.assertEqual(summary["seed"], 1)
        for key in ["backend", "gl_version", "gl_renderer"]:
            self.assertTrue(summary["environment"][key])
        self.assertEqual(len(summary["rows"]), 2 * 2 * 7)  # motions, lenses none and exact, pipelines P0 to P6
        self.assertIn("simulated", summary["inertial"]["readings"])
        self.assertIn("simulated", answer.stdout)
        self.assertIn("simulated", (self.dir / "r/report.html").read_text())
        for row in summary["rows"]:
            self.check_row(row)
        self.assertEqual({check["value"] for check in summary["checks"]}, set(range(1, 14)))
        for check in summary["checks"]:
            # Of value 13 a miss warns: motions are not those of 1994.
            self.assertIn(check["verdict"], ["pass", "warn"] if check["value"] == 13 else ["pass"], check)
            for key in ["what", "expected", "measured", "tolerance", "unit"]:
                self.assertIn(key, check)
        self.assertGreater(summary["timing"]["ratio"], 1.0)
        with open(self.dir / "r/rows.csv", newline="") as file:
            lines = list(csv.DictReader(file))
        self.assertEqual(len(lines), len(summary["rows"]))
        self.assertAlmostEqual(float(lines[0]["registration.rms_px"]), summary["rows"][0]["registration"]["rms_px"])
        page = (self.dir / "r/report.html").read_text()
        self.assertNotIn("{{", page[:2000])
        for outside in ['src="http', 'href="http', "@import", "url(http"]:
            self.assertNotIn(outside, page)
        self.assertTrue(list((self.dir / "r/pictures").glob("M1_P0_left_none_60ms_global*.png")))
        self.assertEqual([p.name for p in self.dir.glob("*unfinished*")], [])
        # The same again: replaced as a whole, and the same numbers.
        again = swimlab("run", "--motion", "M1,M0", "--size", "640x360", "--out", "r", cwd=self.dir)
        self.assertEqual(again.returncode, 0, again.stderr)
        self.assertEqual(strict_json((self.dir / "r/summary.json").read_text())["rows"], summary["rows"])

    def test_the_default_run_shows_what_each_pipeline_gains(self):
        answer = swimlab("run", "--lens", "exact", "--size", "160x90", "--out", "r", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        rows = strict_json((self.dir / "r/summary.json").read_text())["rows"]
        self.assertEqual([(row["motion"], row["display"]) for row in rows[::7]],
                         [("M6", "rolling"), ("M1", "global"), ("M3", "global"), ("M4", "global"), ("M7", "global")])
        # Each leaves less than the one before. From P3 on a rolling scan-out is what is left, until P6 removes it.
        swing = {row["pipeline"]: row["registration"]["rms_px"] for row in rows[:7]}
        self.assertLess(swing["P1"], 0.6 * swing["P0"])
        self.assertLess(swing["P2"], swing["P1"])
        self.assertLess(swing["P3"], 0.6 * swing["P2"])
        self.assertLess(swing["P4"], swing["P3"])
        self.assertLess(swing["P5"], 1.02 * swing["P4"])
        self.assertLess(swing["P6"], 0.2 * swing["P5"])
        # All lines at once: P6 is P5, told as a row but not drawn again.
        for p5, p6 in zip(rows[12::7], rows[13::7]):
            self.assertEqual((p5["pipeline"], p6["pipeline"]), ("P5", "P6"))
            self.assertEqual(p5["registration"], p6["registration"])
            self.assertTrue(p6["per_scanline"])
        self.assertFalse(list((self.dir / "r/pictures").glob("*_P6_*_global*.png")))
        self.assertTrue(list((self.dir / "r/pictures").glob("M6_P6_*_rolling*.png")))

    def test_a_lens_left_uncorrected_is_measured_where_it_is_seen(self):
        answer = swimlab("run", "--motion", "M0", "--lens", "uncorrected", "--eye", "both", "--pipeline", "P0", "--out", "r",
                         cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        for row in strict_json((self.dir / "r/summary.json").read_text())["rows"]:
            # Windows of the size of undistorted discs cut them here: 0.6 px. What is left is the warp's resampling.
            self.assertLess(row["picture_vs_theory_px"], 0.02)

    def test_the_wrong_interval_ablation(self):
        answer = swimlab("run", "--motion", "M4", "--pipeline", "P0,P3,P5", "--interval-error-ms", "-10,10", "--lens", "none",
                         "--size", "160x90", "--out", "r", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        rows = strict_json((self.dir / "r/summary.json").read_text())["rows"]
        named = {(row["pipeline"], row["interval_error_ms"]): row for row in rows}
        # No prediction has no interval that might be wrong.
        self.assertEqual(list(named), [("P0", 0), ("P3", 0), ("P3", -10), ("P3", 10), ("P5", 0)])
        for (pipeline, error), row in named.items():
            self.assertEqual(row["ablation"], error != 0)
            self.assertAlmostEqual(row["effective_latency_ms"], 60 if pipeline == "P0" else -error, delta=0.5)
        self.assertIn("P3 10 ms too far", answer.stdout)
        for name in ["P3-10-ms-too-far", "P3-10-ms-too-short"]:
            self.assertTrue(list((self.dir / "r/pictures").glob(f"M4_{name}_left_none_60ms_global*.png")), name)

    def test_late_correction_and_the_shift_ablation(self):
        answer = swimlab("run", "--motion", "M6", "--pipeline", "P1,P4,P5,P6", "--deflection", "own,shift", "--lens", "exact",
                         "--display", "rolling", "--late-ms", "2", "--size", "640x360", "--out", "r", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        rows = strict_json((self.dir / "r/summary.json").read_text())["rows"]
        named = {(row["pipeline"], row["deflection"]): row for row in rows}
        # P5 with a shift would be P4 with a shift; P6 shifts line by line.
        self.assertEqual(list(named), [("P1", "none"), ("P4", "rotation"), ("P4", "shift"), ("P5", "depth"),
                                       ("P6", "depth"), ("P6", "shift")])
        error = {name: row["registration"]["rms_px"] for name, row in named.items()}
        self.assertLess(error["P4", "rotation"], error["P1", "none"])
        # P3 draws so near the truth that they differ little: the skew of the scan-out is what is left.
        self.assertLess(error["P4", "rotation"], 1.02 * error["P4", "shift"])
        self.assertLess(error["P5", "depth"], 1.02 * error["P4", "rotation"])
        self.assertLess(error["P6", "depth"], 0.5 * error["P5", "depth"])
        for row in rows:
            self.assertEqual(row["ablation"], row["deflection"] == "shift")
            self.assertEqual(row["late_ms"], None if row["deflection"] == "none" else 2)
            self.assertEqual(row["per_scanline"], row["pipeline"] == "P6")
            self.assertEqual(row["disocclusion_pct"] is None, row["deflection"] != "depth")
            self.assertLess(row["coverage_missing_pct"], 0.1)
            # Bands of the real picture, of 4 lines here, against its continuous scan: some hundredths of a pixel.
            self.assertLess(row["picture_vs_theory_px"], 0.15)
        self.assertTrue(list((self.dir / "r/pictures").glob("M6_P4-shift_left_exact_60ms_rolling*.png")))

    def test_the_plane_at_a_distance(self):
        answer = swimlab("run", "--motion", "M7", "--pipeline", "P4", "--deflection", "plane", "--plane-distance-m", "1",
                         "--lens", "none", "--size", "320x180", "--out", "r", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stdout + answer.stderr)
        row, = strict_json((self.dir / "r/summary.json").read_text())["rows"]
        self.assertEqual((row["deflection"], row["ablation"], row["per_scanline"]), ("plane", True, False))

    def check_row(self, row):
        for key in ["deflection", "late_ms", "per_scanline", "ablation", "motion", "pipeline", "eye", "lens", "latency_ms", "display", "frames", "registration", "swim",
                    "effective_latency_ms", "jitter_arcmin", "overshoot_arcmin", "coverage_missing_pct",
                    "disocclusion_pct", "picture_vs_theory_px", "expected", "verdict"]:
            self.assertIn(key, row)
        for key in ["rms_px", "mean_px", "p95_px", "peak_px", "rms_arcmin", "peak_arcmin", "rms_mm"]:
            self.assertIsInstance(row["registration"][key], (int, float))
        for key in ["rms_deg_s", "peak_deg_s"]:
            self.assertIsInstance(row["swim"][key], (int, float))
        self.assertIn(row["verdict"], ["pass", "warn", "fail", "none"])
        # Small discs, of radius 9 px here; a depth warp cuts a disc's soft outline at half a pixel.
        self.assertLess(row["picture_vs_theory_px"], 0.1 if row["deflection"] == "depth" else 0.05)
        if row["motion"] == "M1" and row["pipeline"] == "P0":
            self.assertAlmostEqual(row["effective_latency_ms"], 60.0, delta=0.1)
            self.assertAlmostEqual(row["pose"]["peak_yaw_arcmin"], 132.5, delta=0.4)
        if row["motion"] == "M0":
            # From P3 on the inertial sensors' noise makes the picture tremble.
            self.assertLess(row["registration"]["peak_px"], 1e-6 if row["pipeline"] in ["P0", "P1", "P2"] else 1.0)


class Predict(Case):
    def test_readings_of_another_clock(self):
        write_motion(self.dir / "m.tum")
        rows = ["t,gx,gy,gz,ax,ay,az"] + [f"{5000 + 0.01 * i},0,0,0,0,9.8,0" for i in range(100)]
        (self.dir / "imu.csv").write_text("\n".join(rows) + "\n")
        self.refused(["predict", "m.tum", "--imu", "imu.csv"], "imu.csv", "do not overlap", "5000.000 to 5000.990 s")

    def test_contract(self):
        write_motion(self.dir / "m.tum")
        answer = swimlab("predict", "m.tum", "--interval-ms", "60", "--json", "p.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        result = strict_json((self.dir / "p.json").read_text())
        self.assertEqual(result["schema"], "holdfast/predict/1")
        self.assertEqual(result["interval_ms"], 60)
        self.assertEqual([row["predictor"] for row in result["rows"]],
                         ["none", "constant_velocity", "kalman", "constant_acceleration", "gyro", "kalman_inertial"])
        for row in result["rows"]:
            for key in ["angle_deg", "position_mm", "screen_px"]:
                self.assertLessEqual(row[key]["mean"], row[key]["p95"])
                self.assertLessEqual(row[key]["p95"], row[key]["peak"])
        none, velocity, kalman, acceleration, gyro, inertial = result["rows"]
        # Mostly a yaw of 15 deg at 1 Hz: 2 sin(x/2) and about x^2/2 of the amplitude, x = 0.377.
        self.assertAlmostEqual(none["angle_deg"]["peak"], 15 * 2 * math.sin(0.1885), delta=0.8)
        self.assertLess(velocity["angle_deg"]["mean"], 0.35 * none["angle_deg"]["mean"])
        # It starts without a velocity; once it has one, it also knows how that changes.
        self.assertLess(kalman["angle_deg"]["mean"], 0.9 * velocity["angle_deg"]["mean"])
        # x^3/6 of the amplitude; and who feels the acceleration beats all.
        self.assertLess(acceleration["angle_deg"]["mean"], 0.5 * velocity["angle_deg"]["mean"])
        self.assertLess(gyro["angle_deg"]["mean"], velocity["angle_deg"]["mean"])
        self.assertLess(inertial["angle_deg"]["mean"], 0.5 * kalman["angle_deg"]["mean"])
        self.assertIn("simulated", result["inertial"]["readings"])
        self.assertIn("simulated", answer.stdout)
        self.assertAlmostEqual(result["kalman_noise"]["position_mm"], 0.05)
        # A filter that believes in no pose follows none.
        answer = swimlab("predict", "m.tum", "--noise-mm", "100", "--noise-deg", "30", "--json", "p.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        sluggish = strict_json((self.dir / "p.json").read_text())
        self.assertAlmostEqual(sluggish["kalman_noise"]["orientation_deg"], 30.0)
        self.assertGreater(sluggish["rows"][2]["angle_deg"]["mean"], 3 * kalman["angle_deg"]["mean"])
        self.assertEqual(sluggish["rows"][:2], result["rows"][:2])
        for wrong in ["0", "x", "-1"]:
            self.refused(["predict", "m.tum", "--noise-mm", wrong], "--noise-mm", wrong)

    def test_inertial_readings_of_a_file(self):
        write_motion(self.dir / "m.tum")
        (self.dir / "i.csv").write_text("t,gx,gy,gz,ax,ay\n")
        self.refused(["predict", "m.tum", "--imu", "i.csv"], "i.csv:1", "az")
        (self.dir / "i.csv").write_text("t,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0,oops\n")
        self.refused(["predict", "m.tum", "--imu", "i.csv"], "i.csv:2", "oops")
        # A sensor that says nothing after the first moment is not believed, and that is said.
        (self.dir / "i.csv").write_text("t_s,gyr_x_rad_s,gyr_y,gyr_z,acc_x_m_s2,acc_y,acc_z\n100,0,0,0,0,9.8,0\n")
        answer = swimlab("predict", "m.tum", "--imu", "i.csv", "--json", "p.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertIn("from the poses alone", answer.stdout)
        rows = {row["predictor"]: row for row in strict_json((self.dir / "p.json").read_text())["rows"]}
        self.assertLess(rows["kalman_inertial"]["angle_deg"]["mean"], 1.1 * rows["kalman"]["angle_deg"]["mean"])

    def test_a_page(self):
        write_motion(self.dir / "m.tum")
        rows = ["t_s,gyr_x_rad_s,gyr_y,gyr_z,acc_x_m_s2,acc_y,acc_z", "99.5,0,0,0,0,9.8,0", "99.9,0,oops,0,0,9.8,0", "100,0,0,0,0,9.8,0"]
        (self.dir / "i.csv").write_text("\n".join(rows) + "\n")
        imu = ["--imu", "i.csv", "--interval-ms", "40", "--pose-hz", "50"]
        self.refused(["predict", "m.tum", *imu, "--out", "r"], "i.csv:3", "oops")
        said = self.done("predict", "m.tum", *imu, "--lenient", "--out", "r", "--json", "p.json")
        # Of 120 poses a second each second one.
        self.assertIn("60 a second (asked for 50)", said)
        self.assertIn("1 bad rows dropped", said)
        self.assertEqual(sorted(file.name for file in (self.dir / "r").iterdir()), ["predict.json", "report.html"])
        result = strict_json((self.dir / "r/predict.json").read_text())
        self.assertEqual(strict_json((self.dir / "p.json").read_text()), result)
        self.assertAlmostEqual(result["poses_hz"], 60.0, delta=0.01)
        sweep = {block["interval_ms"]: block for block in result["against_interval"]}
        self.assertEqual([min(sweep), max(sweep)], [10, 200])
        for key in ["angle_deg", "position_mm", "jitter_arcmin"]:  # one interval, asked for and swept
            self.assertEqual([row[key] for row in sweep[40]["rows"]], [row[key] for row in result["rows"]])
        # The error is the motion's: its greatest power is at its 1 Hz, and nothing of it is jitter.
        none = dict(zip(result["spectrum_hz"], result["rows"][0]["spectrum_arcmin2_per_hz"], strict=True))
        self.assertAlmostEqual(max(none, key=none.get), 1.0, delta=0.5)
        self.assertLess(max(power for hz, power in none.items() if hz > 3), 0.01 * max(none.values()))
        page = outside.page_of(self.dir / "r/report.html")
        charts = {chart["id"]: chart for chart in page["charts"]}
        self.assertEqual(list(charts), ["angle", "position", "jitter", "spectrum"])
        for chart in charts.values():
            for axis in ["x", "y"]:
                self.assertTrue(chart[axis]["label"] and chart[axis]["unit"])
            for row in chart["rows"]:
                self.assertEqual(len(row), len(chart["series"]) + 1)
        self.assertEqual([row[0] for row in charts["angle"]["rows"]], list(sweep))
        self.assertEqual(page["pictures"], [])
        self.assertIn("predict m.tum --imu i.csv", page["command"])
        # A folder of ours is replaced, another's is not.
        self.done("predict", "m.tum", "--out", "r")
        (self.dir / "r/thesis.txt").write_text("years of work")
        self.refused(["predict", "m.tum", "--out", "r"], "--out", "thesis.txt")

    def test_real_inertial_recording(self):
        recording = pathlib.Path(RECORDINGS) / "imu/broad_07_fast_rotation.csv"
        if not recording.exists():
            self.skipTest("recordings are not here")
        answer = swimlab("predict", recording, "--imu", recording, "--pose-hz", "95", "--interval-ms", "20,40,60,100",
                         "--json", "p.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        result = strict_json((self.dir / "p.json").read_text())
        self.assertAlmostEqual(result["inertial"]["found"]["time_offset_ms"], 4.0, delta=0.5)
        for block in result["intervals"]:
            rows = {row["predictor"]: row for row in block["rows"] + block["further_rows"]}
            inertial = rows.pop("kalman_inertial")
            rows.pop("kalman")
            for key in ["angle_deg", "position_mm"]:
                self.assertLess(inertial[key]["mean"], 0.9 * min(row[key]["mean"] for row in rows.values()))
            self.assertGreater(inertial["inside_95_pct"], 90)
            self.assertLess(inertial["inside_95_pct"], 98)

    def test_head_recording_is_no_worse_than_a_plain_script(self):
        recording = pathlib.Path(RECORDINGS) / "head/optitrack_head_120hz.tum"
        if not recording.exists():
            self.skipTest("recordings are not here")
        answer = swimlab("predict", recording, "--interval-ms", "58.3", "--json", "p.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        none, velocity, kalman, *_, inertial = strict_json((self.dir / "p.json").read_text())["rows"]
        # The README of the recordings prints 1.12 and 0.33 deg, rounded.
        self.assertLess(none["angle_deg"]["mean"], 1.125)
        self.assertLess(velocity["angle_deg"]["mean"], 0.335)
        self.assertLess(kalman["angle_deg"]["mean"], velocity["angle_deg"]["mean"])
        self.assertLess(kalman["position_mm"]["mean"], 0.8 * velocity["position_mm"]["mean"])
        self.assertLess(4.0 * inertial["angle_deg"]["mean"], none["angle_deg"]["mean"])
        self.assertLess(1.4 * inertial["angle_deg"]["mean"], kalman["angle_deg"]["mean"])
        self.assertLess(5.0 * inertial["position_mm"]["mean"], none["position_mm"]["mean"])
        self.assertLess(2.5 * inertial["position_mm"]["mean"], kalman["position_mm"]["mean"])


class Calibrate(Case):
    def write_readings(self, path, late_s, bias, rate_hz=200.0, seconds=12.0):
        """What exact sensors along the body's axes measure on write_motion's path, but for a bias about x and a late stamp."""
        rows = ["t_s,gx_rad_s,gy,gz,ax_m_s2,ay,az"]
        h = 1e-3
        for i in range(int(seconds * rate_hz)):
            t = i / rate_hz
            (before, p0), (now, p1), (after, p2) = (motion_at(t + d) for d in (-h, 0, h))
            turn = times(conjugate(before), after)
            rate = [x / h for x in turn[:3]]  # twice the vector part, over 2 h
            force = [(a - 2 * b + c) / h ** 2 for a, b, c in zip(p0, p1, p2)]
            force[1] += 9.80665
            force = times(times(conjugate(now), (*force, 0)), now)[:3]
            rows.append(",".join("%.9f" % x for x in (100 + t + late_s, rate[0] + bias, *rate[1:], *force)))
        path.write_text("\n".join(rows) + "\n")

    def command(self, *options, imu="i.csv"):
        return ["calibrate", "inertial", "--poses", "m.tum", "--imu", imu, *options]

    def setUp(self):
        super().setUp()
        write_motion(self.dir / "m.tum")

    def test_what_was_put_in_is_found(self):
        self.write_readings(self.dir / "i.csv", late_s=0.02, bias=0.03)
        said = self.done(*self.command("--json", "c.json"))
        result = strict_json((self.dir / "c.json").read_text())
        self.assertEqual([result[key] for key in ["schema", "sensor", "poses", "imu"]],
                         ["holdfast/calibrate/1", "inertial", "m.tum", "i.csv"])
        self.assertEqual([row["method"] for row in result["rows"]], ["differentiating", "integrating"])
        for row in result["rows"]:
            self.assertIn(row["method"], said)
            self.assertIsNone(row["problem"])
            self.assertIsNone(row["accelerometer_problem"])
            gyro, accelerometer = row["gyro"], row["accelerometer"]
            # Exact poses and readings: what is left are straight lines between readings 5 ms apart.
            self.assertAlmostEqual(gyro["time_offset_ms"], 20, delta=0.1)
            for found, true in zip(gyro["bias_rad_s"], [0.03, 0, 0], strict=True):
                self.assertAlmostEqual(found, true, delta=1e-3)
            for scale in gyro["scale"]:
                self.assertAlmostEqual(scale, 1, delta=0.01)
            self.assertGreater(abs(gyro["orientation_xyzw"][3]), math.cos(math.radians(0.1)))  # within 0.2 deg
            self.assertAlmostEqual(math.dist(accelerometer["gravity_m_s2"], [0, -9.80665, 0]), 0, delta=0.1)
            for sensor in [gyro, accelerometer]:
                self.assertEqual(len({parameter["name"] for parameter in sensor["parameters"]}), len(sensor["parameters"]))
                for parameter in sensor["parameters"]:
                    self.assertGreater(parameter["deviation"], 0)
                    self.assertIn(parameter["observed"], [True, False])

    def test_separate_accelerometers_and_one_method(self):
        self.write_readings(self.dir / "i.csv", late_s=0, bias=0)
        self.done(*self.command("--method", "integrating", "--separate", "--json", "c.json"))
        row, = strict_json((self.dir / "c.json").read_text())["rows"]
        self.assertEqual(row["method"], "integrating")
        self.assertEqual(len(row["accelerometer"]["places_mm"]), 3)

    def test_refusals(self):
        self.refused(["calibrate"], "subcommand")
        self.refused(["calibrate", "inertial", "--poses", "m.tum"], "--imu", "required")
        header = "t_s,gx_rad_s,gy,gz,ax_m_s2,ay,az\n"
        for text, *expected in [(header + "0,0,0,0,0,oops,0\n", "bad.csv:2", "oops"), ("t,gx,gy,gz,ax,ay\n", "bad.csv:1", "az"),
                                (header + "0,0,0,0,0,9.8,0\n1,0,0,0,0,9.8,0\n", "bad.csv", "no sensor can be calibrated")]:
            with self.subTest(text=text):
                (self.dir / "bad.csv").write_text(text)
                self.refused(self.command("--json", "c.json", imu="bad.csv"), *expected)
        for option, value, *expected in [("--method", "guessing", "differentiating or integrating"), ("--prediction-ms", "5", "10 to 1000"),
                                         ("--longest-offset-ms", "soon", "1 to 10000"), ("--json", "none/c.json", "no folder")]:
            with self.subTest(option=option):
                self.refused([*self.command(imu="bad.csv"), f"{option}={value}"], option, *expected)

    def test_bad_rows_are_counted(self):
        self.write_readings(self.dir / "i.csv", late_s=0, bias=0)
        with open(self.dir / "i.csv", "a") as file:
            file.write("500,0,0,oops,0,9.8,0\n")
        self.refused(self.command(), "i.csv:2402", "oops")
        self.assertIn("1 bad rows dropped", self.done(*self.command("--lenient", "--method", "differentiating")))

    def test_real_inertial_recording(self):
        recording = pathlib.Path(RECORDINGS) / "imu/broad_07_fast_rotation.csv"
        if not recording.exists():
            self.skipTest("recordings are not here")
        self.done("calibrate", "inertial", "--poses", recording, "--imu", recording, "--json", "c.json")
        for row in strict_json((self.dir / "c.json").read_text())["rows"]:
            # The offset that kalman_inertial finds on line.
            self.assertAlmostEqual(row["gyro"]["time_offset_ms"], 4.0, delta=0.5)
            self.assertLess(row["gyro"]["time_offset_deviation_ms"], 0.1)
            for scale in row["gyro"]["scale"]:
                self.assertAlmostEqual(scale, 1, delta=0.02)


class Latency(Case):
    def test_a_shift_of_37_3_ms(self):
        write_motion(self.dir / "truth.tum")
        write_motion(self.dir / "late.tum", shift_s=0.0373, rate_hz=90.0)
        answer = swimlab("latency", "truth.tum", "late.tum", "--json", "l.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        self.assertIn("rigid transform", answer.stdout)
        result = strict_json((self.dir / "l.json").read_text())
        self.assertEqual(result["schema"], "holdfast/latency/1")
        self.assertAlmostEqual(result["effective_latency_ms"], 37.3, delta=0.1)
        self.assertLess(result["uncertainty_ms"], 0.1)
        self.assertTrue(result["frames_aligned"])
        for key in ["rms", "p95", "peak"]:
            self.assertLess(result["angle_deg"][key], 0.01)
            self.assertLess(result["position_mm"][key], 0.1)

    def test_recordings_that_do_not_belong_together(self):
        write_motion(self.dir / "truth.tum")
        still = ["%.6f 0 1.6 0 0 0 0 1" % (100 + i / 90) for i in range(1000)]
        (self.dir / "still.tum").write_text("\n".join(still) + "\n")
        lines = (self.dir / "truth.tum").read_text().splitlines()
        later = ["%.9f %s" % (float(line.split(" ", 1)[0]) + 50, line.split(" ", 1)[1]) for line in lines]
        (self.dir / "later.tum").write_text("\n".join(later) + "\n")
        self.refused(["latency", "truth.tum", "later.tum", "--json", "l.json"], "later.tum", "no time in common")
        self.refused(["latency", "truth.tum", "still.tum", "--json", "l.json"], "still.tum", "no latency can be told")
        self.refused(["latency", "still.tum", "truth.tum", "--json", "l.json"], "truth.tum", "no latency can be told")

    def test_real_headset_against_the_robot_that_moved_it(self):
        head = pathlib.Path(RECORDINGS) / "head"
        if not (head / "quest2_traj1_headset_72hz.tum").exists():
            self.skipTest("recordings are not here")
        answer = swimlab("latency", head / "quest2_traj1_robot_truth_30hz.tum", head / "quest2_traj1_headset_72hz.tum",
                         "--json", "l.json", cwd=self.dir)
        self.assertEqual(answer.returncode, 0, answer.stderr)
        result = strict_json((self.dir / "l.json").read_text())
        self.assertLess(result["position_mm"]["rms"], 4.0)  # the recordings' README: 2.3 mm after alignment
        self.assertLess(result["uncertainty_ms"], 5.0)


if __name__ == "__main__":
    outside.main()
