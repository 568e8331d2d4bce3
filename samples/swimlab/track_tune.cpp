/// swimlab track tune: searches the settings of methods that cost least (002 section E.4), beside what 002 found.
#include <algorithm>
#include <cstdio>
#include <deque>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include <holdfast/calibration/filter_tuning.hpp>
#include <holdfast/io/result_json.hpp>
#include <holdfast/registration/track_tuning.hpp>
#include <holdfast/simulation/ceiling_motion.hpp>
#include <holdfast/simulation/sighting_stream.hpp>

#include "exit_code.hpp"
#include "interruption.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "track_command.hpp"
#include "track_motion.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

struct TuneOptions {
  std::vector<TrackMethod> methods;
  std::vector<RecordedMotion> recordings;  ///< empty: generated walks
  std::uint64_t seed = 101;
  int seeds = 1;
  double seconds = 60.0, rate_hz = 1000.0;
  bool still = false, exact_leds = false;
  TuningSettings search;
  std::filesystem::path json;  ///< empty: none
};

/// A motion, and what a HiBall sees on it.
struct Training {
  TrueMotion truth;
  HiBallRig rig;
  std::vector<BeaconSighting> stream;

  Training(TrueMotion motion, const TuneOptions& o, std::uint64_t seed) : truth(std::move(motion)) {
    HiBallOptions options;
    options.seed = seed;
    if (o.exact_leds) options.beacon_error_m = 0.0;
    rig = hiball_rig(options);
    stream = sighting_stream(HiBallSimulator(rig, truth.motion, seed), {.interval = from_seconds(1.0 / o.rate_hz)});
  }
};

/// Each of other beacons and noise, and other walks: seeds count up.
std::deque<Training> trainings(const TuneOptions& o) {
  std::deque<Training> all;
  std::uint64_t seed = o.seed;
  const auto add = [&](TrueMotion motion) { all.emplace_back(std::move(motion), o, seed++); };
  for (int i = 0; i < o.seeds; ++i) {
    if (o.still) add({"at rest", still_hiball(from_seconds(o.seconds))});
    if (!o.still && o.recordings.empty()) add(generated_walk(seed, o.seconds));
    for (const RecordedMotion& recorded : o.recordings) add(recorded_motion(recorded, o.seconds));
  }
  return all;
}

struct TuneRow {
  TrackMethod method = TrackMethod::scaat;
  std::vector<TunedParameter> parameters;
  TuningResult tuned;
  std::optional<TrackParameters> dissertation;
  double dissertation_cost = 0.0;  ///< m
};

/// 002's value of a parameter, or nothing: it has no residual, and without learning no initial variance.
std::optional<double> dissertation_value(const TuneRow& row, std::size_t i) {
  if (!row.dissertation || row.parameters[i].name == "residual") return std::nullopt;
  const Vector6& mu = row.dissertation->process.intensity;
  const double values[]{mu[0], mu[2], mu[3], mu[4], mu[5], 0.0, row.dissertation->beacons.initial_variance[0]};
  return values[i];
}

/// What 002 has a table for, of what is asked for.
std::optional<TrackParameters> dissertation_of(TrackMethod method, const TuneOptions& o) {
  using enum DissertationCase;
  if (o.still) return o.exact_leds || o.rate_hz != 2000.0 ? std::nullopt : dissertation_parameters(method, still);
  if (o.exact_leds) return o.rate_hz == 1000.0 ? dissertation_parameters(method, exact_beacons) : std::nullopt;
  if (o.rate_hz == 1000.0) return dissertation_parameters(method, typical);
  if (o.rate_hz == 100.0) return dissertation_parameters(method, hz_100);
  if (o.rate_hz == 10.0) return dissertation_parameters(method, hz_10);
  return std::nullopt;
}

TuneRow tune_method(TrackMethod method, const TuneOptions& o, std::span<const TrainingRun> runs,
                    const InterruptionWatch& interruption) {
  TuneRow row;
  row.method = method;
  const TrackParameters start = track_parameters(method, o.still ? TrackTuning::still : TrackTuning::moving);
  row.parameters = tuned_parameters(method, start);
  Progress progress("tune", static_cast<std::size_t>(o.search.max_evaluations));
  std::size_t step = 0;
  row.tuned = tune(
      row.parameters,
      [&](std::span<const double> values) {
        interruption.check();
        progress.show(step++, std::string(name_of(method)));
        return tuning_cost(method, with_tuned(start, values), runs);
      },
      o.search);
  if (row.tuned.found.empty()) throw std::runtime_error("track tune: " + row.tuned.problem);
  row.dissertation = dissertation_of(method, o);
  if (row.dissertation) row.dissertation_cost = tuning_cost(method, *row.dissertation, runs);
  return row;
}

ResultJson row_json(const TuneRow& row) {
  ResultJson json;
  json["method"] = name_of(row.method);
  json["start_cost_mm"] = io::number_or_null(1e3 * row.tuned.start_cost);
  json["cost_mm"] = io::number_or_null(1e3 * row.tuned.cost);
  json["dissertation_cost_mm"] = row.dissertation ? io::number_or_null(1e3 * row.dissertation_cost) : ResultJson();
  json["evaluations"] = row.tuned.evaluations;
  json["stop"] = describe(row.tuned.stop);
  json["parameters"] = ResultJson::array();
  for (std::size_t i = 0; i < row.parameters.size(); ++i) {
    const TunedParameter& p = row.parameters[i];
    const std::optional<double> theirs = dissertation_value(row, i);
    json["parameters"].push_back({{"name", p.name},
                                  {"unit", p.unit},
                                  {"start", p.start},
                                  {"found", row.tuned.found[i]},
                                  {"lower", p.lower},
                                  {"upper", p.upper},
                                  {"dissertation", theirs ? ResultJson(*theirs) : ResultJson()}});
  }
  return json;
}

ResultJson tune_json(const TuneOptions& o, const std::deque<Training>& data, const std::vector<TuneRow>& rows) {
  ResultJson json;
  json["schema"] = "holdfast/tune/1";
  json["optimiser"] = o.search.method == TuningMethod::bobyqa ? "bobyqa" : "praxis";
  json["seed"] = o.seed;
  json["rate_hz"] = o.rate_hz;
  json["exact_leds"] = o.exact_leds;
  json["motions"] = ResultJson::array();
  for (const Training& training : data) {
    json["motions"].push_back(
        {{"motion", training.truth.name}, {"seconds", to_seconds(training.truth.motion.duration())}});
  }
  json["rows"] = ResultJson::array();
  for (const TuneRow& row : rows) json["rows"].push_back(row_json(row));
  return json;
}

void print_row(const TuneRow& row) {
  std::printf("%s: %.4f mm with the settings it has, %.4f mm with those found (%d evaluations, %s)\n",
              std::string(name_of(row.method)).c_str(), 1e3 * row.tuned.start_cost, 1e3 * row.tuned.cost,
              row.tuned.evaluations, describe(row.tuned.stop));
  if (row.dissertation) {
    std::printf("  %.4f mm with the dissertation's (its LEDs' variance gains %.3g m^2 with each sighting)\n",
                1e3 * row.dissertation_cost, row.dissertation->beacons.wander[0]);
  }
  std::printf("  %-9s %-9s %10s %10s %13s\n", "", "", "start", "found", "dissertation");
  for (std::size_t i = 0; i < row.parameters.size(); ++i) {
    const TunedParameter& p = row.parameters[i];
    std::printf("  %-9s %-9s %10.3g %10.3g", p.name.c_str(), p.unit.c_str(), p.start, row.tuned.found[i]);
    if (const std::optional<double> theirs = dissertation_value(row, i)) {
      std::printf(" %13.3g\n", *theirs);
    } else {
      std::printf(" %13s\n", "-");
    }
  }
  std::printf("\n");
}

int tune_methods(const TuneOptions& o) {
  const std::filesystem::path json_file = checked_json_file(o.json);
  const std::deque<Training> data = trainings(o);
  std::vector<TrainingRun> runs;
  for (const Training& training : data) runs.push_back({&training.rig, &training.truth.motion, training.stream});
  const InterruptionWatch interruption;
  std::vector<TuneRow> rows;
  for (const TrackMethod method : o.methods) rows.push_back(tune_method(method, o, runs, interruption));
  if (!json_file.empty()) io::write_whole_file(json_file, io::json_text(tune_json(o, data, rows)));
  for (const TuneRow& row : rows) print_row(row);
  std::printf("Cost: mean distance of three points 1 m ahead of the HiBall (002 E.4), over %zu runs.\n", runs.size());
  return done;
}

struct TuneWords {
  Words methods, trajectories, up;
  std::string seconds = "60", rate, seed = "101", seeds = "1", evaluations = "400", optimiser = "bobyqa", json;
  bool lenient = false, still = false, exact_leds = false;
};

std::vector<TrackMethod> methods_of(const Words& words) {
  std::string names;
  for (const TrackMethod method : track_methods) {
    if (method != TrackMethod::collinearity10) names += (names.empty() ? "" : ", ") + std::string(name_of(method));
  }
  std::vector<TrackMethod> methods;
  for (const std::string& word : words) {
    const std::optional<TrackMethod> method = parse_track_method(word);
    if (!method) refuse("--methods", "unknown", word, "some of " + names);
    if (method == TrackMethod::collinearity10) refuse("--methods", "has nothing to tune", word, "some of " + names);
    if (std::ranges::find(methods, *method) == methods.end()) methods.push_back(*method);
  }
  return methods;
}

std::vector<RecordedMotion> recordings_of(const TuneWords& words) {
  if (words.trajectories.empty() && !words.up.empty()) {
    refuse("--up", "no recording has that axis", words.up.front(), "--trajectory with it, or no --up");
  }
  if (words.trajectories.empty() && words.lenient) {
    refuse("--lenient", "there is no recording to be lenient with", "", "--trajectory with it, or no --lenient");
  }
  if (!words.up.empty() && words.up.size() != 1 && words.up.size() != words.trajectories.size()) {
    refuse("--up", "as many axes as recordings are needed, or one", std::to_string(words.up.size()),
           "1 or " + std::to_string(words.trajectories.size()));
  }
  std::vector<RecordedMotion> recordings;
  for (std::size_t i = 0; i < words.trajectories.size(); ++i) {
    const std::string up = words.up.empty() ? "y" : words.up[words.up.size() == 1 ? 0 : i];
    recordings.push_back({words.trajectories[i], up_axis(up), words.lenient});
  }
  return recordings;
}

TuneOptions checked(const TuneWords& words) {
  TuneOptions o;
  o.methods = words.methods.empty() ? std::vector{TrackMethod::scaat, TrackMethod::scaat_autocal, TrackMethod::joint,
                                                  TrackMethod::mcaat3, TrackMethod::mcaat10}
                                    : methods_of(words.methods);
  o.recordings = recordings_of(words);
  o.seconds = number_of("--seconds", words.seconds, 2.0, 3600.0, "seconds, 2 to 3600");
  o.still = words.still;
  o.exact_leds = words.exact_leds;
  if (o.still && !o.recordings.empty()) {
    refuse("--still", "nothing moves with it", words.trajectories.front(), "no --trajectory, or no --still");
  }
  if (o.still) o.rate_hz = 2000.0;  // 002 6.2.10
  if (!words.rate.empty()) o.rate_hz = number_of("--rate", words.rate, 1.0, 10000.0, "sightings a second, 1 to 10000");
  const auto whole = [](const std::string& option, const std::string& word, int most) {
    const std::string expected = "a whole number, 1 to " + std::to_string(most);
    const double value = number_of(option, word, 1, most, expected.c_str());
    if (value != static_cast<double>(static_cast<int>(value))) refuse(option, "not whole", word, expected);
    return static_cast<int>(value);
  };
  o.seeds = whole("--seeds", words.seeds, 100);
  o.search.max_evaluations = whole("--evaluations", words.evaluations, 100000);
  o.seed = seed_of(words.seed);
  if (words.optimiser != "bobyqa" && words.optimiser != "praxis") {
    refuse("--optimiser", "unknown", words.optimiser, "bobyqa or praxis");
  }
  o.search.method = words.optimiser == "bobyqa" ? TuningMethod::bobyqa : TuningMethod::praxis;
  o.json = words.json;
  return o;
}

}  // namespace

void add_track_tune_command(CLI::App& track_app, int& exit_code) {
  CLI::App& app = *track_app.add_subcommand(
      "tune", "Search the settings with which methods of `track hiball` err least (Welch's dissertation, E.4)");
  const auto words = std::make_shared<TuneWords>();
  add_words(
      app, "--methods", words->methods,
      "Some of the methods of `track hiball` but collinearity10; default scaat,scaat_autocal,joint,mcaat3,mcaat10");
  add_words(app, "--trajectory", words->trajectories,
            "Recordings to train with: TUM, EuRoC or CSV; default a generated walk-around");
  add_words(app, "--up", words->up, "The recordings' axes that point up, or one for all: x, y or z; default y");
  app.add_option("--seconds", words->seconds, "At most so much of each motion; default 60");
  app.add_flag("--still", words->still, "A HiBall at rest, from the settings for it, in place of motions (table 6.8)");
  app.add_option("--rate", words->rate, "Sightings a second; default 1000, at rest 2000 (100 and 10: table 6.7)")
      ->type_name("HZ");
  app.add_flag("--exact-leds", words->exact_leds, "LEDs hang where design puts them (table 6.4)");
  app.add_option("--seed", words->seed, "Of the first run's LEDs, noise and walk; they count up; default 101")
      ->type_name("N");
  app.add_option("--seeds", words->seeds, "How often each motion is run, each time with others; default 1")
      ->type_name("N");
  app.add_option("--evaluations", words->evaluations, "At most so many for each method; default 400")->type_name("N");
  app.add_option("--optimiser", words->optimiser, "bobyqa or praxis; default bobyqa")->type_name("WORD");
  app.add_option("--json", words->json, "Write the results also to this file")->type_name("FILE");
  app.add_flag("--lenient", words->lenient, "Drop and count bad rows of a recording instead of stopping");
  app.footer(
      "Judge what is found with other motions and seeds than it was found with; what we found and kept:\n"
      "  swimlab track hiball --settings found\n\n"
      "Example:\n  swimlab track tune --trajectory walk.tum,sit.tum --up z --seeds 2 --methods scaat_autocal --json "
      "t.json\n"
      "Exit code: 0 done, 2 wrong use or unreadable input.");
  app.callback([words, &exit_code] { exit_code = tune_methods(checked(*words)); });
}

}  // namespace swimlab
