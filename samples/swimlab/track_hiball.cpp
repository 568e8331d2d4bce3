/// swimlab track hiball: methods of tracking on the sightings of a simulated HiBall (002 chapter 6).
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/io/track_results.hpp>
#include <holdfast/simulation/ceiling_motion.hpp>

#include "exit_code.hpp"
#include "interruption.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "report_page.hpp"
#include "track_command.hpp"
#include "track_motion.hpp"
#include "track_page.hpp"
#include "track_scenarios.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

struct TrackOptions {
  TrackRequest request;
  std::filesystem::path trajectory, json, out;  ///< empty: none
  Vector3 up_R = Vector3::UnitY();
  double seconds = 60.0;
  bool lenient = false;
  std::string command;
};

struct TrackSettingsName {
  TrackSettings settings;
  std::string_view name;
};
constexpr std::array track_settings{TrackSettingsName{TrackSettings::own, "own"},
                                    TrackSettingsName{TrackSettings::found, "found"},
                                    TrackSettingsName{TrackSettings::dissertation, "dissertation"}};

std::string_view name_of_scenario(TrackScenario scenario) {
  const auto found = std::ranges::find(track_scenarios, scenario, &TrackScenarioName::scenario);
  return found->name;
}

TrueMotion true_motion(const TrackOptions& o) {
  if (o.request.scenario == TrackScenario::still) return {"at rest", still_hiball(from_seconds(o.seconds))};
  if (o.trajectory.empty()) return generated_walk(o.request.seed, o.seconds);
  return recorded_motion({o.trajectory, o.up_R, o.lenient}, o.seconds);
}

ResultJson row_json(const TrackCaseRow& row) {
  ResultJson json = io::track_row_json(row.row);
  json["case"] = row.case_name.empty() ? ResultJson(nullptr) : ResultJson(row.case_name);
  for (const auto& [key, value] : row.more) json[key] = io::number_or_null(value);
  return json;
}

ResultJson track_json(const TrackOptions& o, const TrueMotion& truth, const std::vector<TrackCaseRow>& rows) {
  ResultJson json;
  json["schema"] = "holdfast/track/1";
  json["scenario"] = name_of_scenario(o.request.scenario);
  json["motion"] = truth.name;
  json["seconds"] = to_seconds(truth.motion.duration());
  json["seed"] = o.request.seed;
  json["views"] = o.request.all_views ? 26 : 6;
  json["settings"] = std::ranges::find(track_settings, o.request.settings, &TrackSettingsName::settings)->name;
  json["start_mm"] = 1e3 * o.request.start.pose;
  json["rows"] = ResultJson::array();
  for (const TrackCaseRow& row : rows) json["rows"].push_back(row_json(row));
  return json;
}

/// A number in a column, or "-".
std::string cell(double value, int width, int digits) {
  char text[32];
  if (std::isfinite(value)) {
    std::snprintf(text, sizeof text, "%*.*f", width, digits, value);
  } else {
    std::snprintf(text, sizeof text, "%*s", width, "-");
  }
  return text;
}

void print_row(const TrackCaseRow& r) {
  const TrackRow& row = r.row;
  std::printf("  %-16s %-19s %s %s %s %s %s %s %8ld %7ld %s %s", std::string(name_of(row.method)).c_str(),
              r.case_name.c_str(), cell(1e3 * row.three_point.rms(), 8, 3).c_str(),
              cell(1e3 * row.three_point.peak(), 8, 2).c_str(), cell(1e3 * row.position.rms(), 8, 3).c_str(),
              cell(1e3 * row.position.peak(), 8, 2).c_str(), cell(degrees_per_rad * row.angle.rms(), 7, 4).c_str(),
              cell(degrees_per_rad * row.angle.peak(), 7, 3).c_str(), row.updates, row.gated,
              cell(row.nees, 6, 2).c_str(), cell(row.nis, 5, 2).c_str());
  if (row.beacons) {
    const auto& [seen, often] = *row.beacons;
    std::printf("  %5.2f > %4.2f (%d), %4.2f > %4.2f (%d)", 1e3 * seen.before, 1e3 * seen.after, seen.beacons,
                1e3 * often.before, 1e3 * often.after, often.beacons);
  }
  std::printf("\n");
}

void print_more(const std::vector<TrackCaseRow>& rows) {
  if (rows.empty() || rows.front().more.empty()) return;
  std::printf("\n  %-16s %-19s", "method", "");
  for (const auto& [key, value] : rows.front().more) std::printf("  %s", key.c_str());
  std::printf("\n");
  for (const TrackCaseRow& row : rows) {
    std::printf("  %-16s %-19s", std::string(name_of(row.row.method)).c_str(), row.case_name.c_str());
    for (const auto& [key, value] : row.more) {
      std::printf("  %s", cell(value.value_or(std::nan("")), static_cast<int>(key.size()), 3).c_str());
    }
    std::printf("\n");
  }
}

void print_table(const TrackOptions& o, const TrueMotion& truth, const std::vector<TrackCaseRow>& rows) {
  std::printf("%s: %s, %.1f s, seed %llu\n\n", std::string(name_of_scenario(o.request.scenario)).c_str(),
              truth.name.c_str(), to_seconds(truth.motion.duration()), static_cast<unsigned long long>(o.request.seed));
  const bool trials = !rows.empty() && o.request.scenario == TrackScenario::cold_start;
  if (!trials) {
    std::printf("  %-16s %-19s %17s %17s %15s %8s %7s %6s %5s  %s\n", "", "", "three points mm", "position mm",
                "angle deg", "", "", "", "", "beacons mm: all seen (number), seen 20 times");
    std::printf("  %-16s %-19s %8s %8s %8s %8s %7s %7s %8s %7s %6s %5s  %s\n", "method", "", "rms", "peak", "rms",
                "peak", "rms", "peak", "updates", "gated", "NEES", "NIS", "before > after");
    for (const TrackCaseRow& row : rows) print_row(row);
  }
  print_more(rows);
  std::printf(
      "\nThree points: of a triangle 1 m ahead of the HiBall. NEES, NIS: per degree of freedom; 1 is as sure as right, "
      "above "
      "is too sure.\n");
}

OutputKind track_output() {
  return {.command = "swimlab track hiball",
          .summary = "track.json",
          .schema = "\"holdfast/track/1\"",
          .files = {"report.html"}};
}

int track(const TrackOptions& o) {
  const std::filesystem::path json_file = checked_json_file(o.json);
  const TrueMotion truth = true_motion(o);
  std::optional<OutputFolder> folder;
  if (!o.out.empty()) folder.emplace(o.out, track_output());
  const InterruptionWatch interruption;
  std::vector<TrackCaseRow> rows;
  {
    Progress progress("track", 100);
    std::size_t step = 0;
    rows = run_scenario(o.request, truth.motion, [&](const std::string& what) {
      interruption.check();
      progress.show(std::min<std::size_t>(step++, 99), what);
    });
  }
  const std::string json = io::json_text(track_json(o, truth, rows));
  if (folder) {
    io::write_whole_file(folder->path() / "track.json", json);
    const TrackPageFacts facts{o.request.scenario, truth.name, to_seconds(truth.motion.duration()), o.command};
    io::write_whole_file(folder->path() / "report.html", report_page(track_page(facts, rows)));
    interruption.check();
    folder->commit();
  }
  if (!json_file.empty()) io::write_whole_file(json_file, json);
  print_table(o, truth, rows);
  return done;
}

struct TrackWords {
  std::string scenario = "typical", trajectory, up = "y", seconds = "60", seed = "1", start_mm = "0.01", views = "6",
              settings = "own", json, out;
  Words methods;
  bool lenient = false;
};

TrackScenario scenario_of(const std::string& word) {
  std::string names;
  for (const TrackScenarioName& name : track_scenarios) {
    if (word == name.name) return name.scenario;
    names += (names.empty() ? "" : ", ") + std::string(name.name);
  }
  refuse("--scenario", "unknown", word, "one of " + names);
}

std::vector<TrackMethod> methods_of(const Words& words, TrackScenario scenario) {
  std::string names;
  for (const TrackMethod method : track_methods) {
    if (can_show(scenario, method)) names += (names.empty() ? "" : ", ") + std::string(name_of(method));
  }
  std::vector<TrackMethod> methods;
  for (const std::string& word : words) {
    const std::optional<TrackMethod> method = parse_track_method(word);
    if (!method) refuse("--methods", "unknown", word, "some of " + names);
    if (!can_show(scenario, *method)) {
      refuse("--methods", "cannot search for a lost pose", word, "with this scenario " + names);
    }
    if (std::ranges::find(methods, *method) == methods.end()) methods.push_back(*method);
  }
  return methods;
}

void choose_settings(const std::string& word, TrackRequest& request) {
  const auto known = std::ranges::find(track_settings, word, &TrackSettingsName::name);
  if (known == track_settings.end()) refuse("--settings", "unknown", word, "own, found or dissertation");
  request.settings = known->settings;
  if (request.settings == TrackSettings::own) return;
  if (request.scenario == TrackScenario::still) {
    refuse("--settings", "tuned for motion", word, "another --scenario, or own");
  }
  for (const TrackMethod method : request.methods) {
    if (!settings_of(method, request.settings)) {
      refuse("--settings", std::string(name_of(method)) + " has none", word,
             "some of --methods scaat,scaat_autocal,mcaat3,mcaat10");
    }
  }
}

/// As it may be typed again, but for where the results go.
std::string command_of(const TrackWords& words) {
  std::string command = "swimlab track hiball --scenario " + words.scenario;
  for (std::size_t i = 0; i < words.methods.size(); ++i) command += (i == 0 ? " --methods " : ",") + words.methods[i];
  if (!words.trajectory.empty()) command += " --trajectory " + words.trajectory + " --up " + words.up;
  if (words.lenient) command += " --lenient";
  return command + " --seconds " + words.seconds + " --seed " + words.seed + " --start-mm " + words.start_mm +
         (words.views == "6" ? "" : " --views " + words.views) +
         (words.settings == "own" ? "" : " --settings " + words.settings);
}

TrackOptions checked(const TrackWords& words) {
  TrackOptions o;
  o.request.scenario = scenario_of(words.scenario);
  o.request.methods =
      words.methods.empty() ? usual_methods(o.request.scenario) : methods_of(words.methods, o.request.scenario);
  o.seconds = number_of("--seconds", words.seconds, 2.0, 3600.0, "seconds, 2 to 3600");
  o.request.start.pose = 1e-3 * number_of("--start-mm", words.start_mm, 0.001, 1000.0, "millimetres, 0.001 to 1000");
  o.request.start.velocity = 100.0 * o.request.start.pose;
  o.request.seed = seed_of(words.seed);
  o.up_R = up_axis(words.up);
  if (o.request.scenario == TrackScenario::still && !words.trajectory.empty()) {
    refuse("--trajectory", "nothing moves in this scenario", words.trajectory, "another --scenario, or no trajectory");
  }
  if (words.views != "6" && words.views != "26") {
    refuse("--views", "a HiBall has no such number of views", words.views, "6, or 26 with the secondary ones");
  }
  o.request.all_views = words.views == "26";
  choose_settings(words.settings, o.request);
  o.trajectory = words.trajectory;
  o.json = words.json;
  o.out = words.out;
  o.request.curves = !o.out.empty();
  o.lenient = words.lenient;
  o.command = command_of(words);
  return o;
}

}  // namespace

void add_track_hiball_command(CLI::App& track_app, int& exit_code) {
  CLI::App& app = *track_app.add_subcommand(
      "hiball",
      "SCAAT, MCAAT and Collinearity on the sightings of a simulated HiBall (Welch's dissertation, chapter 6)");
  const auto words = std::make_shared<TrackWords>();
  std::string scenarios, methods;
  for (const TrackScenarioName& name : track_scenarios) {
    scenarios += "\n  " + std::string(name.name) + std::string(14 - name.name.size(), ' ') + std::string(name.about);
  }
  for (const TrackMethod method : track_methods) methods += (methods.empty() ? "" : ",") + std::string(name_of(method));
  app.add_option("--scenario", words->scenario, "One of those below; default typical")->type_name("WORD");
  add_words(app, "--methods", words->methods, "Some of " + methods + "; default as fits the scenario");
  app.add_option("--trajectory", words->trajectory,
                 "Recorded motion: TUM, EuRoC or CSV; default a generated walk-around")
      ->type_name("FILE");
  app.add_option("--up", words->up, "The recording's axis that points up: x, y or z; default y");
  app.add_option("--seconds", words->seconds, "At most so much of the motion; default 60");
  app.add_option("--seed", words->seed, "Of beacons, noise and generated motion; default 1")->type_name("N");
  app.add_option("--start-mm", words->start_mm,
                 "How well trackers take their start, the truth, as known (mm and mrad, and 100 times that a second); "
                 "default 0.01");
  app.add_option("--views", words->views, "6, or 26 with those through a neighbour's photodiode; default 6")
      ->type_name("N");
  app.add_option("--settings", words->settings,
                 "Of the methods: own, found by `track tune`, or the dissertation's; default own")
      ->type_name("WORD");
  app.add_option("--json", words->json, "Write the results also to this file")->type_name("FILE");
  app.add_option("--out", words->out, "Folder for report.html and track.json")->type_name("DIR");
  app.add_flag("--lenient", words->lenient, "Drop and count bad rows of a recording instead of stopping");
  app.footer(
      "Scenarios:" + scenarios +
      "\n\nExample:\n  swimlab track hiball --trajectory head.tum --methods scaat_autocal,mcaat3 --json track.json\n"
      "Exit code: 0 done, 2 wrong use or unreadable input.");
  app.callback([words, &exit_code] { exit_code = track(checked(*words)); });
}

}  // namespace swimlab
