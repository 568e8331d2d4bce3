/// swimlab track constellation: an inertial navigator corrected by ranges to simulated beacons (Foxlin and others 1998).
#include "track_constellation.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include <holdfast/io/trajectory.hpp>
#include <holdfast/motion/generators.hpp>
#include <holdfast/motion/spline_trajectory.hpp>
#include <holdfast/registration/effective_latency.hpp>
#include <holdfast/simulation/inertial_faults.hpp>

#include "exit_code.hpp"
#include "interruption.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "report_page.hpp"
#include "text.hpp"
#include "track_command.hpp"
#include "track_motion.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

struct ConstellationWords {
  std::string scenario = "typical", motion, trajectory, up = "y", seconds, seed = "1", rate, trials, json, out;
  bool lenient = false;
};

struct ConstellationOptions {
  std::string scenario, motion, command;
  std::filesystem::path trajectory, json, out;  ///< empty: none
  Vector3 up_R = Vector3::UnitY();
  double seconds = 30.0;
  int rate_hz = 500, trials = 0;
  std::uint64_t seed = 1;
  bool lenient = false;
};

struct NamedMotion {
  std::string name;
  std::unique_ptr<Motion> motion;
};

/// A recording with its up along W's y, and its middle 1.5 m below the beacons.
NamedMotion recorded(const ConstellationOptions& o) {
  std::vector<TimedPose> samples =
      io::read_trajectory(o.trajectory, o.lenient ? io::ReadMode::lenient : io::ReadMode::strict).samples;
  std::erase_if(samples, [end = samples.front().t + from_seconds(o.seconds)](const TimedPose& p) { return p.t > end; });
  if (samples.size() < 20 || samples.back().t - samples.front().t < std::chrono::seconds(4)) {
    throw io::InputError({.file = o.trajectory.string(),
                          .problem = "too short to judge a tracker",
                          .expected = "four seconds of motion or more"});
  }
  const Quaternion q_WR = Quaternion::FromTwoVectors(o.up_R, Vector3::UnitY());
  Vector3 mean_R = Vector3::Zero();
  for (const TimedPose& pose : samples) mean_R += pose.X_WB.p() / static_cast<double>(samples.size());
  const Rigid X_WR(q_WR, -(q_WR * mean_R));
  for (TimedPose& pose : samples) pose.X_WB = X_WR * pose.X_WB;
  return {o.trajectory.filename().string(), std::make_unique<SplineTrajectory>(samples)};
}

NamedMotion true_motion(const ConstellationOptions& o) {
  if (!o.trajectory.empty()) return recorded(o);
  const Duration duration = from_seconds(o.seconds);
  if (o.motion == "still") return {o.motion, make_still(duration)};
  if (o.motion == "rotation") return {o.motion, make_rotation(o.seed, duration)};
  if (o.motion == "swing") return {o.motion, make_swing(o.seed, duration)};
  return {o.motion, make_walk_around(o.seed, duration)};
}

ConstellationCase bench_case(const ConstellationOptions& o, const char* name) {
  ConstellationCase c;
  c.name = name;
  c.rig = {bench_constellation(), head_receivers()};
  c.errors = table_1_errors();
  c.unit.X_BS = Rigid::translation(Vector3(0.0, 0.05, -0.08));
  c.unit.interval = from_seconds(1.0 / o.rate_hz);
  c.seed = o.seed;
  return c;
}

constexpr RangingFaults three_in_ten{0.1, 0.1, 0.1};

std::vector<ConstellationCase> typical_cases(const ConstellationOptions& o) {
  std::vector<ConstellationCase> cases;
  cases.push_back(bench_case(o, "table 1"));
  cases.push_back(bench_case(o, "30 % lost or wrong"));
  cases.back().ranging.faults = three_in_ten;
  cases.push_back(bench_case(o, "improved compensation"));
  cases.back().errors = improved_compensation_errors();
  cases.push_back(bench_case(o, "noise alone"));
  cases.back().errors = {};
  cases.push_back(bench_case(o, "endless array"));
  cases.back().rig.beacons = infinite_constellation();
  for (CodedBeacon& beacon : cases.back().rig.beacons) beacon.p_W.y() -= 1.7;  // the head's height
  cases.push_back(bench_case(o, "ranges alone"));
  cases.back().has_inertial = false;
  return cases;
}

/// A fault of the unit in the middle third.
std::vector<ConstellationCase> fault_cases(const ConstellationOptions& o, const Motion& motion) {
  const TimeSpan span{motion.begin() + motion.duration() / 3, motion.end() - motion.duration() / 3};
  static constexpr std::array one_gyro{1}, one_accelerometer{4};
  using Readings = std::vector<InertialReading>;
  std::vector<ConstellationCase> cases{bench_case(o, "none")};
  const auto add = [&](const char* name, std::function<void(Readings&)> spoil) {
    cases.push_back(bench_case(o, name));
    cases.back().spoil = std::move(spoil);
  };
  add("dead gyro", [=](Readings& r) { make_dead(r, span, gyro_channels); });
  add("stuck unit", [=](Readings& r) { make_stuck(r, span, inertial_channels); });
  add("one gyro missing", [=](Readings& r) { lose(r, span, one_gyro); });
  add("disconnected", [=](Readings& r) { disconnect(r, span); });
  add("dead accelerometer", [=](Readings& r) { make_dead(r, span, accelerometer_channels); });
  add("one accelerometer missing", [=](Readings& r) { lose(r, span, one_accelerometer); });
  add("force in units of g", [](Readings& r) {
    for (InertialReading& reading : r) reading.force_B /= standard_gravity;
  });
  add("gyro saturated at 17 deg/s", {});
  cases.back().unit.gyro.range = 0.3;
  add("readings' clock set back by 1 s", {});
  cases.back().clock_jump = {span.begin, -std::chrono::seconds(1)};
  add("30 % of ranges lost or wrong", {});
  cases.back().ranging.faults = three_in_ten;
  return cases;
}

ConstellationTrack tracked(const ConstellationCase& c, const Motion& motion, const InterruptionWatch& interruption) {
  ConstellationTrack track;
  track.has_inertial = c.has_inertial;
  const HostTime from = motion.begin() + c.settle;
  constexpr double bin_s = 0.05;
  track.row = run_constellation(c, motion, [&](const ConstellationMoment& moment) {
    const TimedPose pose = moment.tracker.pose();
    const double t_s = to_seconds(pose.t - motion.begin());
    const auto bin = static_cast<std::size_t>(std::max(0.0, t_s) / bin_s);
    while (track.errors.size() <= bin) {
      interruption.check();
      track.errors.push_back({bin_s * static_cast<double>(track.errors.size()), 0.0});
    }
    double& largest = track.errors[bin].position_mm;
    largest = std::max(largest, 1e3 * (pose.X_WB.p() - moment.X_WB.p()).norm());
    if (pose.t < from || !c.has_inertial) return;
    const RangeAidedInsStatus status = moment.tracker.status();
    if (track.gyro.empty() && status.gyro != SensorFault::none) track.gyro = to_string(status.gyro);
    if (track.accelerometer.empty() && status.accelerometer != SensorFault::none) {
      track.accelerometer = to_string(status.accelerometer);
    }
  });
  LatencyOptions options;
  options.frames = FrameRelation::same;
  track.latency = estimate_latency(motion, track.row.shown, options);
  return track;
}

/// Mean errors of a head that rests at 27 places under the eight beacons: smallest, mean and largest, mm.
Vector3 errors_at_places(const ConstellationOptions& o, const InterruptionWatch& interruption) {
  const auto still = make_still(std::chrono::seconds(5));
  Vector3 found(1e9, 0.0, 0.0);
  for (int i = 0; i < 27; ++i) {
    interruption.check();
    ConstellationCase c = bench_case(o, "place");
    const Vector3 place_W(0.3 * (i % 3 - 1), 0.2 * (i / 9), 0.3 * (i / 3 % 3 - 1));
    for (CodedBeacon& beacon : c.rig.beacons) beacon.p_W -= place_W;
    const double error = 1e3 * run_constellation(c, *still).mean_error_W.norm();
    found = Vector3(std::min(found[0], error), found[1] + error / 27.0, std::max(found[2], error));
  }
  return found;
}

std::vector<ConstellationFigure> figures_of(const std::vector<ConstellationTrack>& tracks, const Vector3& at_places) {
  const ConstellationTrack &table_1 = tracks[0], &bad = tracks[1], &array = tracks[4];
  return {{"8 beacons, at rest, position error", "1 to 8 mm",
           text_of("%.1f to %.1f mm, mean %.1f", at_places[0], at_places[2], at_places[1])},
          {"61 cm array, position error", "2.3 to 4.7 mm", text_of("%.1f mm RMS", 1e3 * array.row.position.rms())},
          {"Effective latency", "about 2.5 ms",
           table_1.latency.has_latency() ? text_of("%.2f ms", table_1.latency.effective_latency_ms) : "at rest: none"},
          {"30 % of ranges lost or wrong", "little",
           text_of("%.2f times the error", bad.row.position.rms() / table_1.row.position.rms())},
          {"Wrong ranges kept out", "over 90 %",
           text_of("%.1f %%", 100.0 - 100.0 * static_cast<double>(bad.row.corrupt_accepted) /
                                          std::max(1.0, static_cast<double>(bad.row.corrupt)))}};
}

ResultJson row_json(const ConstellationTrack& track) {
  const ConstellationRow& row = track.row;
  const auto both = [](const RmsAndPeak& errors, double scale) -> ResultJson {
    return {{"rms", io::number_or_null(scale * errors.rms())}, {"peak", io::number_or_null(scale * errors.peak())}};
  };
  ResultJson json;
  json["method"] = track.has_inertial ? "range_aided_ins" : "ranges_alone";
  json["case"] = row.name;
  json["three_point_mm"] = {{"rms", io::number_or_null(1e3 * row.three_point.rms())},
                            {"peak", io::number_or_null(1e3 * row.three_point.peak())}};
  json["position_mm"] = both(row.position, 1e3);
  json["angle_deg"] = both(row.angle, degrees_per_rad);
  json["updates"] = row.readings > 0 ? row.readings : row.ranges;
  json["ranges"] = row.ranges;
  json["accepted"] = row.accepted;
  json["gated"] = row.gated;
  json["gated_by_cause"] = {
      {"good", row.turned_away.good}, {"echo", row.turned_away.echo}, {"early", row.turned_away.early}};
  json["wrong"] = row.corrupt;
  json["wrong_accepted"] = row.corrupt_accepted;
  json["microseconds_per_update"] = row.readings > 0 ? 1e-3 * row.reading_nanoseconds : row.range_microseconds;
  json["microseconds_per_range"] = row.range_microseconds;
  json["beacon_error_mm"] = nullptr;
  json["effective_latency_ms"] =
      track.latency.has_latency() ? io::number_or_null(track.latency.effective_latency_ms) : ResultJson(nullptr);
  json["nees"] = io::number_or_null(row.nees);
  json["nis"] = io::number_or_null(row.nis);
  json["named"] = {
      {"gyro", track.gyro.empty() ? ResultJson(nullptr) : ResultJson(track.gyro)},
      {"accelerometer", track.accelerometer.empty() ? ResultJson(nullptr) : ResultJson(track.accelerometer)}};
  return json;
}

ResultJson figures_json(const std::vector<ConstellationFigure>& figures) {
  ResultJson json = ResultJson::array();
  for (const ConstellationFigure& figure : figures) {
    json.push_back({{"what", figure.what}, {"paper", figure.paper}, {"ours", figure.ours}});
  }
  return json;
}

ResultJson track_json(const ConstellationOptions& o, const NamedMotion& truth,
                      const std::vector<ConstellationTrack>& tracks, const std::vector<ConstellationFigure>& figures) {
  ResultJson json;
  json["schema"] = "holdfast/track/1";
  json["scenario"] = o.scenario;
  json["motion"] = truth.name;
  json["seconds"] = to_seconds(truth.motion->duration());
  json["seed"] = o.seed;
  json["readings_hz"] = o.rate_hz;
  json["rows"] = ResultJson::array();
  for (const ConstellationTrack& track : tracks) json["rows"].push_back(row_json(track));
  json["paper"] = figures_json(figures);
  return json;
}

void print_figures(const std::vector<ConstellationFigure>& figures) {
  if (figures.empty()) return;
  std::printf("\n  %-46s %-34s %s\n", "", "paper", "here");
  for (const ConstellationFigure& f : figures) {
    std::printf("  %-46s %-34s %s\n", f.what.c_str(), f.paper.c_str(), f.ours.c_str());
  }
}

void print_table(const ConstellationOptions& o, const NamedMotion& truth, const std::vector<ConstellationTrack>& tracks,
                 const std::vector<ConstellationFigure>& figures) {
  std::printf("constellation, %s: %s, %.1f s, %d readings a second, seed %llu\n\n", o.scenario.c_str(),
              truth.name.c_str(), to_seconds(truth.motion->duration()), o.rate_hz,
              static_cast<unsigned long long>(o.seed));
  std::printf("  %-32s %15s %15s %9s %7s %23s %11s %13s\n", "", "position mm", "angle deg", "latency", "ranges",
              "turned away", "wrong let", "consistency");
  std::printf("  %-32s %7s %7s %7s %7s %9s %7s %7s %7s %7s %11s %6s %6s  %s\n", "case", "rms", "peak", "rms", "peak",
              "ms", "heard", "echoes", "early", "good", "in of", "NEES", "NIS", "named");
  for (const ConstellationTrack& track : tracks) {
    const ConstellationRow& row = track.row;
    const std::string latency =
        track.latency.has_latency() ? text_of("%9.2f", track.latency.effective_latency_ms) : text_of("%9s", "-");
    std::printf("  %-32s %7.2f %7.2f %7.3f %7.3f %s %7ld %7ld %7ld %7ld %5ld %5ld %6.2f %6.2f", row.name.c_str(),
                1e3 * row.position.rms(), 1e3 * row.position.peak(), degrees_per_rad * row.angle.rms(),
                degrees_per_rad * row.angle.peak(), latency.c_str(), row.ranges, row.turned_away.echo,
                row.turned_away.early, row.turned_away.good, row.corrupt_accepted, row.corrupt, row.nees, row.nis);
    if (!track.gyro.empty()) std::printf("  gyro %s", track.gyro.c_str());
    if (!track.accelerometer.empty()) std::printf("  accelerometer %s", track.accelerometer.c_str());
    std::printf("\n");
  }
  print_figures(figures);
}

void print_study(const ConstellationOptions& o, const ConstellationStudy& study) {
  std::printf("constellation, %s: %s\n\n ", o.scenario.c_str(), study.about.c_str());
  for (const auto& c : study.columns) std::printf(c.unit.empty() ? " %-*s" : " %*s", c.width, c.name.c_str());
  std::printf("\n ");
  for (const auto& c : study.columns) std::printf(" %*s", c.width, c.unit.c_str());
  for (const auto& line : study.cells) {
    std::printf("\n ");
    for (std::size_t i = 0; i < line.size(); ++i) {
      const ConstellationStudy::Column& c = study.columns[i];
      if (c.unit.empty()) {
        std::printf(" %-*s", c.width, line[i].get<std::string>().c_str());
      } else if (line[i].is_null()) {
        std::printf(" %*s", c.width, "-");
      } else {
        std::printf(" %*.*f", c.width, c.digits, line[i].get<double>());
      }
    }
  }
  std::printf("\n");
  print_figures(study.figures);
}

void open_folder(std::optional<OutputFolder>& folder, const ConstellationOptions& o) {
  if (o.out.empty()) return;
  folder.emplace(o.out, OutputKind{.command = "swimlab track constellation",
                                   .summary = "track.json",
                                   .schema = "\"holdfast/track/1\"",
                                   .files = {"report.html"}});
}

void write_results(std::optional<OutputFolder>& folder, const std::filesystem::path& json_file, const ResultJson& json,
                   const ResultJson& page, const InterruptionWatch& interruption) {
  const std::string text = io::json_text(json);
  if (folder) {
    io::write_whole_file(folder->path() / "track.json", text);
    io::write_whole_file(folder->path() / "report.html", report_page(page));
    interruption.check();
    folder->commit();
  }
  if (!json_file.empty()) io::write_whole_file(json_file, text);
}

struct NamedStudy {
  const char* scenario;
  ConstellationStudy (*run)(const StudyOptions&, const InterruptionWatch&);
  int trials;  ///< as a default
};
constexpr std::array studies{NamedStudy{"sensitivity", study_sensitivity, 50},
                             NamedStudy{"acquisition", study_acquisition, 40}, NamedStudy{"mapping", study_mapping, 5}};

const NamedStudy* study_named(const std::string& scenario) {
  const auto found = std::ranges::find(studies, scenario, &NamedStudy::scenario);
  return found == studies.end() ? nullptr : &*found;
}

int study(const ConstellationOptions& o, const NamedStudy& named) {
  const std::filesystem::path json_file = checked_json_file(o.json);
  std::optional<OutputFolder> folder;
  open_folder(folder, o);
  const InterruptionWatch interruption;
  const ConstellationStudy study = named.run({o.seed, o.trials, o.seconds, o.rate_hz}, interruption);
  ResultJson json = {{"schema", "holdfast/track/1"}, {"scenario", o.scenario}, {"seed", o.seed}, {"trials", o.trials}};
  json["rows"] = study.rows;
  json["paper"] = figures_json(study.figures);
  write_results(folder, json_file, json, constellation_page({o.scenario, "", o.command, o.seconds}, study),
                interruption);
  print_study(o, study);
  return done;
}

int track(const ConstellationOptions& o) {
  const std::filesystem::path json_file = checked_json_file(o.json);
  const NamedMotion truth = true_motion(o);
  std::optional<OutputFolder> folder;
  open_folder(folder, o);
  const InterruptionWatch interruption;
  const bool typical = o.scenario == "typical";
  const std::vector<ConstellationCase> cases = typical ? typical_cases(o) : fault_cases(o, *truth.motion);
  std::vector<ConstellationTrack> tracks;
  std::vector<ConstellationFigure> figures;
  {
    Progress progress("track", cases.size() + (typical ? 1 : 0));
    for (const ConstellationCase& c : cases) {
      progress.show(tracks.size(), c.name);
      tracks.push_back(tracked(c, *truth.motion, interruption));
    }
    if (typical) {
      progress.show(tracks.size(), "places");
      figures = figures_of(tracks, errors_at_places(o, interruption));
    }
  }
  const ConstellationFacts facts{o.scenario, truth.name, o.command, to_seconds(truth.motion->duration())};
  write_results(folder, json_file, track_json(o, truth, tracks, figures), constellation_page(facts, tracks, figures),
                interruption);
  print_table(o, truth, tracks, figures);
  return done;
}

/// Options of a scenario in which they would change nothing are refused.
void refuse_unused(const ConstellationWords& words) {
  const bool is_study = study_named(words.scenario) != nullptr, walks = words.scenario == "mapping";
  const auto unused = [](const char* option, const std::string& value, const char* why) {
    if (!value.empty()) refuse(option, "changes nothing", value, why);
  };
  if (is_study) {
    const char* own =
        walks ? "typical or faults: who maps has a walk of its own" : "typical or faults: nothing moves here";
    unused("--motion", words.motion, own);
    unused("--trajectory", words.trajectory, own);
  } else {
    unused("--trials", words.trials, "sensitivity, acquisition or mapping");
  }
  if (!is_study || walks) return;
  unused("--seconds", words.seconds, "typical, faults or mapping");
  unused("--rate", words.rate, "typical, faults or mapping");
}

ConstellationOptions checked(const ConstellationWords& words) {
  ConstellationOptions o;
  const NamedStudy* study = study_named(words.scenario);
  if (words.scenario != "typical" && words.scenario != "faults" && study == nullptr) {
    refuse("--scenario", "unknown", words.scenario, "typical, faults, sensitivity, acquisition or mapping");
  }
  const auto or_else = [](const std::string& word, const char* otherwise) { return word.empty() ? otherwise : word; };
  o.motion = or_else(words.motion, "walk-around");
  constexpr std::array motions{"still", "walk-around", "rotation", "swing"};
  if (std::ranges::find(motions, o.motion) == motions.end()) {
    refuse("--motion", "unknown", o.motion, "still, walk-around, rotation or swing");
  }
  refuse_unused(words);
  const bool walks = words.scenario == "mapping";
  const std::string seconds = or_else(words.seconds, walks ? "120" : "30"), rate = or_else(words.rate, "500");
  o.scenario = words.scenario;
  o.seconds = walks ? number_of("--seconds", seconds, 20.0, 600.0, "seconds, 20 to 600")
                    : number_of("--seconds", seconds, 4.0, 600.0, "seconds, 4 to 600");
  o.rate_hz = static_cast<int>(number_of("--rate", rate, 100.0, 2000.0, "readings a second, 100 to 2000"));
  o.seed = seed_of(words.seed);
  o.up_R = up_axis(words.up);
  o.trajectory = words.trajectory;
  o.json = words.json;
  o.out = words.out;
  o.lenient = words.lenient;
  o.command = "swimlab track constellation --scenario " + words.scenario;
  if (study != nullptr) {
    const std::string trials = or_else(words.trials, std::to_string(study->trials).c_str());
    o.trials = static_cast<int>(number_of("--trials", trials, 1.0, 1000.0, "1 to 1000"));
    o.command += " --trials " + trials;
  } else {
    o.command +=
        words.trajectory.empty() ? " --motion " + o.motion : " --trajectory " + words.trajectory + " --up " + words.up;
    if (words.lenient) o.command += " --lenient";
  }
  if (study == nullptr || walks) o.command += " --seconds " + seconds;
  o.command += " --seed " + words.seed;
  if (study == nullptr || walks) o.command += " --rate " + rate;
  return o;
}

}  // namespace

void add_track_constellation_command(CLI::App& track_app, int& exit_code) {
  CLI::App& app = *track_app.add_subcommand(
      "constellation",
      "Inertial sensors corrected by ultrasonic ranges to beacons, simulated (Foxlin and others, 1998)");
  const auto words = std::make_shared<ConstellationWords>();
  app.add_option(
         "--scenario", words->scenario,
         "typical: errors of the paper's table 1, and 30 % of ranges wrong; faults: what happens to the "
         "inertial unit; sensitivity: what each error does to a position; acquisition: poses from ranges alone; "
         "mapping: beacons found by walking about; default typical")
      ->type_name("WORD");
  app.add_option("--motion", words->motion, "still, walk-around, rotation or swing; default walk-around")
      ->type_name("WORD");
  app.add_option("--trajectory", words->trajectory, "Recorded motion in place of it: TUM, EuRoC or CSV")
      ->type_name("FILE");
  app.add_option("--up", words->up, "The recording's axis that points up: x, y or z; default y");
  app.add_option("--seconds", words->seconds, "At most so much of the motion; default 30, mapping 120");
  app.add_option("--seed", words->seed, "Of beacons, noise and generated motion; default 1")->type_name("N");
  app.add_option("--rate", words->rate, "Inertial readings a second; default 500")->type_name("HZ");
  app.add_option(
         "--trials", words->trials,
         "Installations of sensitivity (default 50), tries of acquisition for each of five seeds (40), rooms of "
         "mapping (5)")
      ->type_name("N");
  app.add_option("--json", words->json, "Write the results also to this file")->type_name("FILE");
  app.add_option("--out", words->out, "Folder for report.html and track.json")->type_name("DIR");
  app.add_flag("--lenient", words->lenient, "Drop and count bad rows of a recording instead of stopping");
  app.footer(
      "Examples:\n  swimlab track constellation --motion swing --json track.json\n"
      "  swimlab track constellation --scenario mapping --out out/mapping\n"
      "Exit code: 0 done, 2 wrong use or unreadable input.");
  app.callback([words, &exit_code] {
    const ConstellationOptions o = checked(*words);
    const NamedStudy* named = study_named(o.scenario);
    exit_code = named != nullptr ? study(o, *named) : track(o);
  });
}

}  // namespace swimlab
