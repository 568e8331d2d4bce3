"""Tests `swimlab track hiball` from outside: exit codes and messages, the JSON contract, and that methods rank as they should."""

import pathlib
import sys

import outside
from outside import Case, strict_json, swimlab

RECORDINGS = sys.argv[2] if len(sys.argv) > 2 else ""


class BadUse(Case):
    def test_options_are_named_with_value_and_expectation(self):
        for option, value, *expected in [
                ("--scenario", "exciting", "typical, still"), ("--methods", "scat", "scaat_autocal"),
                ("--methods", "scaat,,mcaat3", "single commas"), ("--seconds", "0", "2 to 3600"), ("--seconds", "soon", "2 to 3600"),
                ("--seed", "-1", "whole number"), ("--up", "w", "x, y or z"), ("--start-mm", "0", "0.001 to 1000")]:
            with self.subTest(option=option, value=value):
                self.refused(["track", "hiball", f"{option}={value}", "--json", "t.json"], option, value, *expected)

    def test_methods_that_cannot_do_it(self):
        self.refused(["track", "hiball", "--scenario", "blocked", "--methods", "mcaat3"], "--methods", "mcaat3", "scaat_autocal")

    def test_motions(self):
        (self.dir / "bad.tum").write_text("0 0 0 0 0 0 0 1\n1 0 0 0 0 0 0 1\n2 0 oops 0 0 0 0 1\n")
        (self.dir / "short.tum").write_text("0 0 0 0 0 0 0 1\n0.1 0 0 0 0 0 0 1\n")
        self.refused(["track", "hiball", "--trajectory", "bad.tum"], "bad.tum:3", "oops")
        self.refused(["track", "hiball", "--trajectory", "short.tum"], "short.tum", "too short")
        self.refused(["track", "hiball", "--trajectory", "none.tum"], "none.tum")
        self.refused(["track", "hiball", "--scenario", "still", "--trajectory", "short.tum"], "--trajectory", "nothing moves")

    def test_places(self):
        (self.dir / "mine").mkdir()
        (self.dir / "mine/thesis.txt").write_text("years of work")
        self.refused(["track", "hiball", "--seconds", "2", "--out", "mine"], "--out", "thesis.txt")
        self.refused(["track", "hiball", "--seconds", "2", "--json", "none/t.json"], "--json", "no folder")
        self.refused(["track"], "subcommand")

    def test_help_lists_the_scenarios(self):
        answer = swimlab("track", "hiball", "--help")
        self.assertEqual(answer.returncode, 0)
        for word in ["Example", "cold-start", "collinearity10", "ordering"]:
            self.assertIn(word, answer.stdout)


class Track(Case):
    def rows(self, *options):
        self.done("track", "hiball", *options, "--json", "t.json")
        result = strict_json((self.dir / "t.json").read_text())
        self.assertEqual(result["schema"], "holdfast/track/1")
        for row in result["rows"]:
            self.check_row(row)
        return result, {(row["method"], row["case"]): row for row in result["rows"]}

    def check_row(self, row):
        for key in ["three_point_mm", "position_mm", "angle_deg"]:
            self.assertLessEqual(row[key]["rms"], row[key]["peak"])
        for key in ["updates", "accepted", "gated", "sightings"]:
            self.assertGreaterEqual(row[key], 0)
        self.assertGreater(row["microseconds_per_update"], 0)
        learns = row["method"] not in ["scaat", "collinearity10"]
        if learns and row["beacon_error_mm"]:
            self.assertAlmostEqual(row["beacon_error_mm"]["before"], 1.73, delta=0.3)
        self.assertTrue(learns or row["beacon_error_mm"] is None)

    def test_typical_ranks_the_methods(self):
        result, rows = self.rows("--seconds", "10", "--out", "o")
        self.assertEqual(result["scenario"], "typical")
        self.assertEqual(strict_json((self.dir / "o/track.json").read_text()), result)
        names = ["scaat", "scaat_autocal", "scaat_autocal_2", "mcaat3", "mcaat10", "collinearity10"]
        self.assertEqual([row["method"] for row in result["rows"]], names)
        rms = {method: row["three_point_mm"]["rms"] for (method, _), row in rows.items()}
        for better, worse in [("scaat_autocal_2", "scaat_autocal"), ("scaat_autocal", "mcaat3"), ("mcaat3", "mcaat10"),
                              ("mcaat10", "collinearity10")]:
            self.assertLess(rms[better], rms[worse])
        again, _ = self.rows("--seconds", "10", "--methods", "scaat_autocal")
        for key in ["three_point_mm", "updates", "gated", "beacon_error_mm"]:
            self.assertEqual(again["rows"][0][key], rows["scaat_autocal", None][key])

    def test_still(self):
        _, rows = self.rows("--scenario", "still", "--seconds", "4", "--methods", "scaat_autocal")
        still, moving = rows["scaat_autocal", "still tuning"], rows["scaat_autocal", "moving tuning"]
        self.assertEqual(still["updates"] + still["gated"], 8001)
        # What is left is the LEDs' common error, as far as the start does not hold it off: below their own 1.7 mm.
        for row in [still, moving]:
            self.assertLess(row["three_point_mm"]["rms"], 1.7)
            self.assertGreater(row["last_tenth_mm"], 0)

    def test_low_rates(self):
        _, rows = self.rows("--scenario", "low-rate", "--seconds", "6", "--methods", "scaat_autocal")
        self.assertEqual([case for _, case in rows], ["1000 Hz", "100 Hz", "20 Hz", "10 Hz"])

    def test_lost_and_found(self):
        for scenario in ["cold-start", "blocked"]:
            _, rows = self.rows("--scenario", scenario, "--seconds", "10")
            found = rows["scaat_autocal", "search"]
            self.assertGreaterEqual(found["within_50_ms_pct"], 95)
            self.assertGreaterEqual(found["trials"], 2)

    def test_orders_and_noise(self):
        _, rows = self.rows("--scenario", "ordering", "--seconds", "4")
        self.assertEqual([case for _, case in rows], ["round-robin", "random", "least recently used"])
        _, rows = self.rows("--scenario", "spectra", "--seconds", "4", "--methods", "scaat_autocal,collinearity10")
        scaat, collinearity = rows["scaat_autocal", None], rows["collinearity10", None]
        self.assertLess(scaat["held_noise_above_100_hz_mm"], 0.1 * collinearity["held_noise_above_100_hz_mm"])

    def test_simultaneous_and_wrong_sightings(self):
        _, rows = self.rows("--scenario", "simultaneous", "--seconds", "3", "--methods", "scaat_autocal,mcaat10")
        self.assertEqual(len(rows), 6)
        _, rows = self.rows("--scenario", "faults", "--seconds", "5")
        self.assertGreaterEqual(rows["scaat_autocal", "20 % wrong"]["wrong_gated_pct"], 99)

    def test_a_recording(self):
        head = pathlib.Path(RECORDINGS) / "head/optitrack_head_120hz.tum"
        if not head.exists():
            self.skipTest("recordings are not here")
        result, rows = self.rows("--trajectory", head, "--seconds", "10", "--methods", "scaat_autocal")
        self.assertEqual(result["motion"], "optitrack_head_120hz.tum")
        self.assertLess(rows["scaat_autocal", None]["three_point_mm"]["rms"], 1.0)


if __name__ == "__main__":
    outside.main()
