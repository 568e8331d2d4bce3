"""Tests `swimlab track` from outside: exit codes and messages, the JSON contract, and that methods rank as they should."""

import pathlib
import sys

import outside
from outside import Case, page_of, strict_json, swimlab

RECORDINGS = sys.argv[2] if len(sys.argv) > 2 else ""


class BadUse(Case):
    def test_options_are_named_with_value_and_expectation(self):
        for option, value, *expected in [
                ("--scenario", "exciting", "typical, still"), ("--methods", "scat", "scaat_autocal"),
                ("--methods", "scaat,,mcaat3", "single commas"), ("--seconds", "0", "2 to 3600"), ("--seconds", "soon", "2 to 3600"),
                ("--seed", "-1", "whole number"), ("--up", "w", "x, y or z"), ("--start-mm", "0", "0.001 to 1000"),
                ("--views", "7", "26 with the secondary")]:
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

    def page(self, *options):
        """The report's page, complete and without broken values; its charts by their ids."""
        self.done("track", "hiball", *options, "--out", "page")
        page = page_of(self.dir / "page/report.html")
        texts = [page["title"], page["command"], *page["paragraphs"]]
        for row in page["table"]["rows"]:
            self.assertEqual(len(row), len(page["table"]["columns"]))
        for chart in page["charts"]:
            with self.subTest(chart=chart["id"]):
                texts += [chart[key] for key in ["title", "caption"]]
                texts += [axis[key] for axis in [chart["x"], chart.get("y", chart["x"])] for key in ["label", "unit"]]
                self.check_bars(chart) if "bars" in chart else self.check_curves(chart)
        for text in texts:
            self.assertNotEqual(text, "")
            self.assertNotRegex(text, r"\b(nan|inf|null|undefined)\b|- mm|- %")
        charts = {chart["id"]: chart for chart in page["charts"]}
        self.assertEqual(len(charts), len(page["charts"]))
        return page, charts

    def check_bars(self, chart):
        self.assertTrue(chart["rows"])
        for row in chart["rows"]:
            self.assertTrue(row["label"])
            self.assertEqual(len(row["values"]), len(chart["series"]))
            for value in row["values"]:
                self.assertTrue(value is None or value >= 0)

    def check_curves(self, chart):
        self.assertTrue(2 <= len(chart["rows"]) <= 700)
        xs = [row[0] for row in chart["rows"]]
        self.assertEqual(xs, sorted(xs))
        for i, series in enumerate(chart["series"], 1):
            values = [row[i] for row in chart["rows"] if row[i] is not None]
            self.assertTrue(values, series)
            self.assertGreater(min(values), 0)
        for row in chart["rows"]:
            self.assertEqual(len(row), len(chart["series"]) + 1)

    def test_pages_have_what_the_scenario_has(self):
        learner = ["--methods", "scaat_autocal", "--seconds"]
        errors = {"three_points", "position", "angle", "leds"}
        for scenario, seconds, expected in [
                ("typical", 3, errors | {"error"}),
                ("spectra", 3, errors | {"error", "noise", "held_noise", "noise_above"}),
                ("ordering", 3, errors | {"error-scaat_autocal", "noise-scaat_autocal", "noise_above"}),
                ("low-rate", 7, errors | {"error-scaat_autocal", "noise-scaat_autocal"}),
                ("still", 3, errors | {"error-scaat_autocal", "noise-scaat_autocal", "drift"}),
                ("simultaneous", 3, errors | {"error-scaat_autocal"}),
                ("faults", 3, errors | {"error-scaat_autocal", "gate"}),
                ("blocked", 8, {"recovered", "recovery-scaat_autocal", "error-scaat_autocal", "leds"}),
                ("cold-start", 3, {"recovered", "recovery-scaat_autocal"})]:
            with self.subTest(scenario=scenario):
                page, charts = self.page("--scenario", scenario, *learner, seconds)
                self.assertEqual(set(charts), expected)
                self.assertIn(f"--scenario {scenario} --methods scaat_autocal --seconds {seconds} ", page["command"])

    def test_a_page_says_what_the_json_says(self):
        page, charts = self.page("--seconds", "4", "--methods", "scaat_autocal,collinearity10")
        rows = strict_json((self.dir / "page/track.json").read_text())["rows"]
        for row, shown, table in zip(rows, charts["three_points"]["rows"], page["table"]["rows"], strict=True):
            for value, key in zip(shown["values"], ["rms", "peak"], strict=True):
                self.assertAlmostEqual(value / row["three_point_mm"][key], 1, delta=1e-3)  # four digits
            self.assertEqual(table[:2], [shown["label"], shown["values"][0]])
        self.assertTrue(charts["three_points"]["x"]["log"])  # they differ by more than ten times
        rms = [row["three_point_mm"]["rms"] for row in rows]
        self.assertEqual(charts["error"]["y"]["log"], max(rms) >= 10 * min(rms))
        self.assertEqual([row["label"] for row in charts["leds"]["rows"]], ["SCAAT, learns LEDs"])
        # The worst estimate of all is in some bin. A peak is of one point, a bin's error the RMS of the estimate's three.
        for i, row in enumerate(rows, 1):
            worst = max(line[i] or 0 for line in charts["error"]["rows"])
            self.assertLessEqual(worst, row["three_point_mm"]["peak"] * 1.001)
            self.assertGreaterEqual(worst, 0.999 * row["three_point_mm"]["peak"] / 3 ** 0.5)

    def test_typical_ranks_the_methods(self):
        result, rows = self.rows("--seconds", "10", "--out", "o")
        self.assertEqual(result["scenario"], "typical")
        self.assertEqual(strict_json((self.dir / "o/track.json").read_text()), result)
        names = ["scaat", "scaat_autocal", "scaat_autocal_2", "joint", "joint_2", "joint_models", "mcaat3", "mcaat10",
                 "collinearity10"]
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
        self.assertEqual(list(rows), [(method, case) for case in ["round-robin", "random", "least recently used", "weakest direction"]
                                      for method in ["scaat_autocal", "joint"]])
        _, rows = self.rows("--scenario", "spectra", "--seconds", "4", "--methods", "scaat_autocal,collinearity10")
        scaat, collinearity = rows["scaat_autocal", None], rows["collinearity10", None]
        self.assertLess(scaat["held_noise_above_100_hz_mm"], 0.1 * collinearity["held_noise_above_100_hz_mm"])

    def test_simultaneous_and_wrong_sightings(self):
        _, rows = self.rows("--scenario", "simultaneous", "--seconds", "3", "--methods", "scaat_autocal,mcaat10")
        self.assertEqual(len(rows), 6)
        _, rows = self.rows("--scenario", "faults", "--seconds", "5")
        for method in ["scaat_autocal", "joint"]:
            wrong, none_renamed = rows[method, "20 % wrong"], rows[method, "20 %, none renamed"]
            self.assertGreaterEqual(wrong["wrong_gated_pct"], 99)
            self.assertGreaterEqual(wrong["renamed_pct"], 99)
            self.assertEqual(none_renamed["renamed_pct"], 0)
            good = rows[method, "no faults"]["three_point_mm"]["rms"]
            self.assertLess(wrong["three_point_mm"]["rms"], 1.2 * good)

    def test_26_views(self):
        result, rows = self.rows("--seconds", "3", "--methods", "scaat_autocal", "--views", "26")
        self.assertEqual(result["views"], 26)
        six, rows_of_six = self.rows("--seconds", "3", "--methods", "scaat_autocal")
        self.assertEqual(six["views"], 6)
        rms = rows["scaat_autocal", None]["three_point_mm"]["rms"]
        self.assertNotEqual(rms, rows_of_six["scaat_autocal", None]["three_point_mm"]["rms"])
        self.assertLess(rms, 1.5)

    def test_settings_that_were_tuned(self):
        rms = {}
        for settings in ["own", "found", "dissertation"]:
            result, rows = self.rows("--seconds", "3", "--methods", "scaat,mcaat10", "--settings", settings)
            self.assertEqual(result["settings"], settings)
            rms[settings] = rows["mcaat10", None]["three_point_mm"]["rms"]
        self.assertEqual(len(set(rms.values())), 3)
        self.assertLess(rms["found"], rms["dissertation"])
        self.refused(["track", "hiball", "--settings", "theirs"], "--settings", "own, found or dissertation")
        self.refused(["track", "hiball", "--settings", "found", "--methods", "joint"], "--settings", "joint has none", "mcaat3")
        self.refused(["track", "hiball", "--settings", "found", "--scenario", "still", "--methods", "scaat"], "--settings", "motion")

    def test_a_recording(self):
        head = pathlib.Path(RECORDINGS) / "head/optitrack_head_120hz.tum"
        if not head.exists():
            self.skipTest("recordings are not here")
        result, rows = self.rows("--trajectory", head, "--seconds", "10", "--methods", "scaat_autocal")
        self.assertEqual(result["motion"], "optitrack_head_120hz.tum")
        self.assertLess(rows["scaat_autocal", None]["three_point_mm"]["rms"], 1.0)


class Tune(Case):
    def setUp(self):
        super().setUp()
        if swimlab("track", "tune", "--help").returncode != 0:
            self.skipTest("this swimlab was built without NLopt")

    def test_options_are_named_with_value_and_expectation(self):
        for option, value, *expected in [
                ("--methods", "collinearity10", "nothing to tune", "scaat_autocal"), ("--methods", "scat", "scaat_autocal"),
                ("--evaluations", "0", "whole number"), ("--evaluations", "1.5", "whole number"), ("--seeds", "many", "1 to 100"), ("--seeds", "200", "1 to 100"),
                ("--seed", "-1", "whole number"), ("--seconds", "1", "2 to 3600"), ("--optimiser", "powell", "bobyqa or praxis"),
                ("--up", "y,z", "--trajectory"), ("--rate", "0", "1 to 10000"), ("--json", "none/t.json", "no folder")]:
            with self.subTest(option=option, value=value):
                self.refused(["track", "tune", f"{option}={value}"], option, *expected)
        self.refused(["track", "tune", "--trajectory", "none.tum"], "none.tum")
        self.refused(["track", "tune", "--trajectory", "a.tum,b.tum,c.tum", "--up", "y,z"], "--up", "1 or 3")
        self.refused(["track", "tune", "--lenient"], "--lenient", "--trajectory")
        self.refused(["track", "tune", "--trajectory", "none.tum", "--still"], "--still", "none.tum")

    def test_each_table_of_the_dissertation_has_its_options(self):
        for method, lateral, *options in [("scaat", 0.505, "--exact-leds"), ("scaat_autocal", 0.307, "--rate", "100"),
                                          ("scaat_autocal", 0.274, "--rate", "10"), ("scaat_autocal", 4.14e-6, "--still"),
                                          ("mcaat3", None, "--still"), ("scaat_autocal", None, "--rate", "50")]:
            with self.subTest(options=options):
                self.done("track", "tune", "--methods", method, "--seconds", "2", "--evaluations", "1", *options, "--json", "t.json")
                row, = strict_json((self.dir / "t.json").read_text())["rows"]
                self.assertEqual(row["parameters"][0]["dissertation"], lateral)
                self.assertEqual(row["cost_mm"], row["start_cost_mm"])

    def test_settings_found_cost_less_within_their_bounds(self):
        results = []
        for optimiser in ["bobyqa", "praxis", "bobyqa"]:
            told = self.done("track", "tune", "--methods", "scaat_autocal,mcaat10", "--seconds", "3", "--evaluations", "12",
                             "--optimiser", optimiser, "--json", "t.json")
            results.append(strict_json((self.dir / "t.json").read_text()))
        self.assertEqual(results[0], results[2])
        for result in results:
            self.assertEqual(result["schema"], "holdfast/tune/1")
            self.assertEqual(result["motions"], [{"motion": "walk-around", "seconds": 3}])
            self.assertEqual([row["method"] for row in result["rows"]], ["scaat_autocal", "mcaat10"])
            for row in result["rows"]:
                self.assertLess(row["cost_mm"], row["start_cost_mm"])
                self.assertGreater(row["dissertation_cost_mm"], 0)
                self.assertEqual(row["evaluations"], 12)
                self.assertEqual([p["name"] for p in row["parameters"]],
                                 ["lateral", "height", "turn_x", "turn_y", "turn_z", "residual", "initial"])
                for p in row["parameters"]:
                    self.assertTrue(p["lower"] <= p["found"] <= p["upper"])
        table_6_6 = [p["dissertation"] for p in results[0]["rows"][0]["parameters"]]
        self.assertEqual(table_6_6, [0.395, 0.107, 0.518, 1.14, 0.589, None, 2.41e-6])
        for part in ["scaat_autocal", "with those found", "with the dissertation's", "rad^2/s^3"]:
            self.assertIn(part, told)

    def test_motions_and_seeds_count_up(self):
        self.done("track", "tune", "--methods", "scaat", "--seconds", "2", "--evaluations", "2", "--seeds", "3", "--json", "t.json")
        self.assertEqual(len(strict_json((self.dir / "t.json").read_text())["motions"]), 3)


class Constellation(Case):
    def test_typical(self):
        told = self.done("track", "constellation", "--motion", "swing", "--seconds", "8", "--rate", "400", "--json", "c.json", "--out", "out")
        result = strict_json((self.dir / "c.json").read_text())
        self.assertEqual((result["schema"], result["scenario"], result["readings_hz"]), ("holdfast/track/1", "typical", 400))
        self.assertEqual((self.dir / "out" / "track.json").read_text(), (self.dir / "c.json").read_text())
        rows = {row["case"]: row for row in result["rows"]}
        good, bad = rows["table 1"], rows["30 % lost or wrong"]
        self.assertEqual(good["updates"], 3201)
        self.assertLess(good["position_mm"]["rms"], 8)
        self.assertLess(bad["position_mm"]["rms"], 1.5 * good["position_mm"]["rms"])
        self.assertLess(bad["wrong_accepted"], 0.05 * bad["wrong"])
        for row in rows.values():
            self.assertEqual(sum(row["gated_by_cause"].values()), row["gated"])
        away = bad["gated_by_cause"]
        self.assertEqual(away["echo"] + away["early"], bad["wrong"] - bad["wrong_accepted"])
        self.assertLess(bad["nis"], 1.2)  # of what the gate let in
        self.assertLess(good["effective_latency_ms"], 2.5)
        self.assertEqual(rows["ranges alone"]["method"], "ranges_alone")
        self.assertEqual(good["named"], {"gyro": None, "accelerometer": None})
        self.assertIn("1 to 8 mm", [figure["paper"] for figure in result["paper"]])
        for part in ["here", "about 2.5 ms", "times the error"]:
            self.assertIn(part, told)
        page = (self.dir / "out" / "report.html").read_text()
        self.assertIn("swimlab track constellation --scenario typical --motion swing --seconds 8 --seed 1 --rate 400", page)

    def test_faults(self):
        self.done("track", "constellation", "--scenario", "faults", "--seconds", "9", "--json", "f.json")
        rows = {row["case"]: row for row in strict_json((self.dir / "f.json").read_text())["rows"]}
        named = {case: (row["named"]["gyro"], row["named"]["accelerometer"]) for case, row in rows.items()}
        self.assertEqual(named["none"], (None, None))
        self.assertEqual(named["dead gyro"], ("dead", None))
        self.assertEqual(named["one accelerometer missing"], (None, "not_finite"))
        self.assertEqual(named["force in units of g"], (None, "wrong_gravity"))
        self.assertEqual(named["readings' clock set back by 1 s"][0], "time_backwards")
        for row in rows.values():
            self.assertLess(row["position_mm"]["peak"], 60)

    def test_refusals(self):
        self.refused(["track", "constellation", "--motion", "hop"], "--motion", "hop", "still, walk-around")
        self.refused(["track", "constellation", "--scenario", "all"], "--scenario", "typical, faults, sensitivity, acquisition or mapping")
        self.refused(["track", "constellation", "--scenario", "sensitivity", "--motion", "swing"], "--motion", "nothing moves here")
        self.refused(["track", "constellation", "--scenario", "acquisition", "--rate", "400"], "--rate", "typical, faults or mapping")
        self.refused(["track", "constellation", "--scenario", "mapping", "--trajectory", "a.tum"], "--trajectory", "a walk of its own")
        self.refused(["track", "constellation", "--trials", "3"], "--trials", "sensitivity, acquisition or mapping")
        self.refused(["track", "constellation", "--scenario", "mapping", "--trials", "0"], "--trials", "1 to 1000")
        self.refused(["track", "constellation", "--rate", "5"], "--rate", "100 to 2000")
        self.refused(["track", "constellation", "--trajectory", "no.tum"], "no.tum")


class ConstellationStudies(Case):
    def study(self, scenario, *options):
        told = self.done("track", "constellation", "--scenario", scenario, *options, "--out", "out")
        result = strict_json((self.dir / "out/track.json").read_text())
        self.assertEqual((result["schema"], result["scenario"]), ("holdfast/track/1", scenario))
        self.assertIn(f"constellation, {scenario}:", told)
        for row in result["rows"]:
            for key in ["method", "case", "three_point_mm", "position_mm", "angle_deg", "updates", "accepted", "gated",
                        "microseconds_per_update", "beacon_error_mm"]:
                self.assertIn(key, row)
        for figure in result["paper"]:
            self.assertIn(figure["ours"], told)
        page = page_of(self.dir / "out/report.html")
        self.assertIn(f"--scenario {scenario} --trials", page["command"])
        self.assertEqual([row[2] for row in page["tables"][0]["rows"]], [figure["ours"] for figure in result["paper"]])
        for row in page["table"]["rows"]:
            self.assertEqual(len(row), len(page["table"]["columns"]))
        for chart in page["charts"]:
            for row in chart["rows"]:
                self.assertEqual(len(row["values"] if "bars" in chart else row[1:]), len(chart["series"]))
            for text in [chart["title"], chart["caption"], chart["x"]["label"], chart["x"]["unit"]]:
                self.assertTrue(text)
        return result["rows"], page

    def test_sensitivity_is_the_papers_figure_7(self):
        rows, page = self.study("sensitivity", "--trials", "10")
        mean = {(row["case"], row["height_m"]): row["position_mm"]["mean"] for row in rows}
        self.assertEqual(len(mean), 7 * 11)
        for height in [0, 0.5, 1, 1.5, 2, 2.5]:
            self.assertTrue(2 <= mean["table_1", height] <= 5)
            self.assertLess(mean["improved_compensation", height], mean["table_1", height])
        self.assertLess(sum(mean["improved_compensation", h / 4] for h in range(11)) / 11, 2)
        self.assertEqual([chart["id"] for chart in page["charts"]], ["errors", "improved", "resolution"])

    def test_acquisition_is_not_false_while_few_ranges_are_wrong(self):
        rows, page = self.study("acquisition", "--trials", "3", "--seed", "3")
        self.assertEqual([(row["codes"], row["wrong_pct"]) for row in rows],
                         [(codes, wrong) for codes in [16, 8] for wrong in [0, 15, 30]])
        for row in rows:
            self.assertEqual(row["updates"], 15)
            self.assertEqual(row["accepted"] + row["ambiguous"] + row["no_pose"], 15)
            if row["wrong_pct"] <= 15:
                self.assertEqual(row["false_poses"], 0)
            if row["wrong_pct"] == 0:
                self.assertGreaterEqual(row["accepted"], 14)
                self.assertLess(row["position_mm"]["peak"], 50)

    def test_mapping_ends_within_5_mm(self):
        rows, page = self.study("mapping", "--trials", "1", "--seconds", "60")
        self.assertEqual([row["case"] for row in rows], ["noise", "improved_compensation", "table_1", "three_in_ten_wrong"])
        for row in rows:
            self.assertEqual(row["installed"], 9)
            self.assertLess(row["worst_mm"], 5)
            self.assertLess(row["beacon_error_mm"]["after"], row["beacon_error_mm"]["before"])
            self.assertEqual(len(row["beacons"]), 9)


class Ranges(Case):
    """A body at rest at (0, 0, 1), in a room with an anchor in each corner; exact ranges, 80 a second, for 3 s."""

    def setUp(self):
        super().setUp()
        anchors = [(k, 3 if k & 1 else -3, 4 if k & 2 else -4, 2.5 if k & 4 else 0) for k in range(8)]
        ranges = [(i / 80, i % 8, sum((a - b) ** 2 for a, b in zip(anchors[i % 8][1:], (0, 0, 1))) ** 0.5) for i in range(1, 240)]
        self.write("anchors.csv", "id,x_m,y_m,z_m", anchors)
        self.write("ranges.csv", "t_s,anchor_id,range_m", ranges)
        self.write("imu.csv", "t_s,gx_rad_s,gy,gz,ax_m_s2,ay,az", [(i / 100, 0, 0, 0, 0, 0, 9.80665) for i in range(300)])
        self.write("truth.csv", "t_s,px_m,py,pz,qx,qy,qz,qw", [(i / 50, 0, 0, 1, 0, 0, 0, 1) for i in range(160)])

    def write(self, name, header, rows):
        (self.dir / name).write_text("\n".join([header] + [",".join(map(str, row)) for row in rows]) + "\n")

    def command(self, **files):
        given = {"ranges": "ranges.csv", "anchors": "anchors.csv", "imu": "imu.csv", "truth": "truth.csv"} | files
        return ["track", "ranges"] + [word for option, file in given.items() for word in (f"--{option}", str(file))]

    def rows(self, result):
        self.assertEqual(result["schema"], "holdfast/track/1")
        self.assertEqual(result["scenario"], "ranges")
        self.assertEqual([row["method"] for row in result["rows"]], ["neither", "gate", "bias", "bias_and_gate"])
        for row in result["rows"]:
            for key in ["three_point_mm", "position_mm", "angle_deg", "horizontal_mm", "height_mm"]:
                self.assertLessEqual(row[key]["rms"], row[key]["peak"])
            self.assertEqual(row["accepted"] + row["gated"], row["ranges"])
            self.assertEqual(row["updates"], row["accepted"])
            self.assertEqual(row["refused"], 0)
            self.assertGreater(row["microseconds_per_update"], 0)
            self.assertIsNone(row["beacon_error_mm"])
            self.assertEqual(len(row["biases"]), 8 if "bias" in row["method"] else 0)
        return {row["method"]: row for row in result["rows"]}

    def test_exact_ranges(self):
        self.done(*self.command(), "--antenna=0,0,0", "--json", "t.json", "--out", "o")
        result = strict_json((self.dir / "t.json").read_text())
        self.assertEqual(strict_json((self.dir / "o/track.json").read_text()), result)
        for row in self.rows(result).values():
            self.assertEqual(row["ranges"], 239)
            self.assertLess(row["position_mm"]["peak"], 1.0)
        page = (self.dir / "o/report.html").read_text()
        for part in ["Range by range", "swimlab track ranges --ranges ranges.csv", "the path from above"]:
            self.assertIn(part.lower(), page.lower())
        # The antenna of the default stands 9 cm too high for these ranges.
        self.done(*self.command(), "--json", "t.json")
        self.assertGreater(self.rows(strict_json((self.dir / "t.json").read_text()))["neither"]["height_mm"]["peak"], 40)

    def test_files_are_named_with_line_column_and_value(self):
        for option, text, *expected in [
                ("ranges", "t_s,anchor_id,range_m\n0.1,0,2\n0.2,9,2\n", "bad.csv:3", "anchor_id", "'9'", "one of 0, 1, 2"),
                ("ranges", "t_s,anchor_id,range_m\n0.1,0,far\n", "bad.csv:2", "range_m", "'far'", "finite number"),
                ("ranges", "t_s,anchor_id,range_m\n0.2,0,2\n0.1,0,2\n", "bad.csv:3", "t_s", "back in time"),
                ("anchors", "id,x,y\n0,1,2\n", "bad.csv:1", "z", "id,x_m,y_m,z_m"),
                ("imu", "t_s,gx_deg_s,gy,gz,ax,ay,az\n0,0,0,0,0,0,0\n", "bad.csv:1", "gx_deg_s", "not in rad/s"),
                ("imu", "t_s,gx,gy,gz,ax,ay,az\n0,0,0,0,0,0\n", "bad.csv:2", "6 cells"),
                ("truth", "0 0 0 1 0 0 0 1\n1 0 oops 1 0 0 0 1\n", "bad.csv:2", "oops"),
                ("truth", "90 0 0 1 0 0 0 1\n91 0 0 1 0 0 0 1\n", "bad.csv", "shares no time")]:
            with self.subTest(option=option, text=text):
                (self.dir / "bad.csv").write_text(text)
                self.refused(self.command(**{option: "bad.csv"}), *expected)
        self.refused(self.command(imu="none.csv"), "none.csv")

    def test_options(self):
        self.refused(["track", "ranges", "--ranges", "ranges.csv"], "--anchors", "required")
        for option, value, *expected in [("--antenna", "1,2", "three numbers"), ("--antenna", "1,2,up", "three numbers"),
                                         ("--up", "w", "x, y or z"), ("--start-mm", "0", "0.1 to 10000"),
                                         ("--json", "none/t.json", "no folder")]:
            with self.subTest(option=option, value=value):
                self.refused(self.command() + [f"{option}={value}"], option, *expected)

    def test_the_recording(self):
        folder = pathlib.Path(RECORDINGS) / "range"
        if not folder.exists():
            self.skipTest("recordings are not here")
        self.done(*self.command(ranges=folder / "0607_twr_obs1_range.csv", anchors=folder / "anchor_0607_positions.csv",
                                imu=folder / "0607_twr_obs1_imu.csv", truth=folder / "0607_twr_obs1_pose.csv"), "--json", "t.json")
        rows = self.rows(strict_json((self.dir / "t.json").read_text()))
        rms = {method: row["position_mm"]["rms"] for method, row in rows.items()}
        self.assertLess(rms["bias_and_gate"], 110)  # issue 4: 150, aim 110; at most 0.65 of the others
        for other in ["neither", "gate", "bias"]:
            self.assertLess(rms["bias_and_gate"], 0.65 * rms[other])


if __name__ == "__main__":
    outside.main()
