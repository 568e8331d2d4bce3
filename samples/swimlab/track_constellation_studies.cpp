/// swimlab track constellation: what simulated installations show of errors, acquisition and auto-mapping.
#include <array>
#include <cmath>
#include <limits>

#include <holdfast/registration/acquisition_experiment.hpp>
#include <holdfast/registration/mapping_experiment.hpp>
#include <holdfast/registration/metrics.hpp>
#include <holdfast/registration/range_sensitivity.hpp>

#include "progress.hpp"
#include "text.hpp"
#include "track_constellation.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

constexpr int seeds = 5;

ResultJson rounded(double value, double step = 0.001) {
  return io::number_or_null(step * std::round(value / step));
}

/// A row with what every row of the contract has; numbers that do not apply are null.
ResultJson row_of(const char* method, const std::string& name) {
  const ResultJson none = {{"rms", nullptr}, {"peak", nullptr}};
  return {{"method", method},
          {"case", name},
          {"three_point_mm", none},
          {"position_mm", none},
          {"angle_deg", none},
          {"updates", 0},
          {"accepted", 0},
          {"gated", 0},
          {"microseconds_per_update", nullptr},
          {"beacon_error_mm", nullptr}};
}

ResultJson curves(const char* id, const char* title, const char* caption, const char* label) {
  return {{"id", id},
          {"title", title},
          {"caption", caption},
          {"x", {{"label", "height above the floor"}, {"unit", "m"}}},
          {"y", {{"label", label}, {"unit", "mm"}}},
          {"series", ResultJson::array()},
          {"rows", ResultJson::array()}};
}

void add_series(ResultJson& chart, const std::string& name, const char* style, bool dashed = false) {
  chart["series"].push_back({{"name", name}, {"style", style}, {"dashed", dashed}});
}

ResultJson bars(const char* id, const char* title, const char* caption, const char* label, const char* unit) {
  return {{"id", id},
          {"title", title},
          {"caption", caption},
          {"bars", true},
          {"x", {{"label", label}, {"unit", unit}}},
          {"series", ResultJson::array()},
          {"rows", ResultJson::array()}};
}

// ---- sensitivity

struct Source {
  std::string name, words;
  const char* style;
  UltrasonicErrors errors;
  std::vector<SensitivityRow> rows;
};

std::vector<Source> error_sources() {
  const std::array words{"Beacons' places", "Temperature", "Beacons' delays", "Receivers' delays",
                         "Transducers' angles"};
  const std::array styles{"c", "d", "e", "P3", "f"};
  std::vector<Source> sources{
      {"table_1", "All of table 1", "b", table_1_errors(), {}},
      {"improved_compensation", "Improved compensation", "a", improved_compensation_errors(), {}}};
  const auto alone = each_alone(table_1_errors());
  for (std::size_t i = 0; i < alone.size(); ++i) {
    sources.push_back({std::string(alone[i].name), words[i], styles[i], alone[i].errors, {}});
  }
  return sources;
}

ResultJson sensitivity_row(const Source& source, const SensitivityRow& row) {
  ResultJson json = row_of("least_squares", source.name);
  json["height_m"] = row.height_m;
  json["position_mm"] = {{"rms", io::number_or_null(row.rms_mm)},
                         {"peak", io::number_or_null(row.worst_mm)},
                         {"mean", io::number_or_null(row.error_mm)}};
  json["updates"] = json["accepted"] = row.positions;
  json["lost"] = row.lost;
  json["resolution_mm"] = io::number_or_null(row.resolution_mm);
  json["gdop"] = io::number_or_null(row.gdop);
  json["horizontal_dop"] = io::number_or_null(row.horizontal_dop);
  json["vertical_dop"] = io::number_or_null(row.vertical_dop);
  json["beacons"] = io::number_or_null(row.beacons);
  return json;
}

/// The least and the largest of a number, over the heights.
std::string span_of(const Source& source, double SensitivityRow::*value, const char* format) {
  double least = source.rows.front().*value, most = least;
  for (const SensitivityRow& row : source.rows) {
    least = std::min(least, row.*value);
    most = std::max(most, row.*value);
  }
  return text_of(format, least, most);
}

void draw(ConstellationStudy& study, const std::vector<Source>& sources) {
  ResultJson all = curves("errors", "Position error by height (the paper's figure 7)",
                          "Mean over places, angles and installations, under an endless array at 3 m. Dashed: the "
                          "paper's range for all of table 1 together.",
                          "error");
  ResultJson improved =
      curves("improved", "Improved compensation (figure 9)",
             "Angles compensated to 1 mm a radian, receivers to nothing. Temperature alone costs more than the paper's "
             "1 mm near the floor.",
             "error");
  ResultJson resolution = curves("resolution", "Resolution (figure 8)",
                                 "What the ranges' noise of 1 mm a metre leaves. Dashed: the paper's 0.7 to 1.5 mm in "
                                 "most of the volume, 2.5 mm near the floor.",
                                 "resolution");
  improved["half"] = resolution["half"] = true;
  for (const Source& source : sources) add_series(all, source.words, source.style);
  for (const char* name : {"Paper, least", "Paper, most"}) add_series(all, name, "theory", true);
  add_series(improved, "Improved compensation", "a");
  add_series(improved, "Temperature alone", "d");
  add_series(improved, "Paper, about", "theory", true);
  add_series(resolution, "Here", "b");
  for (const char* name : {"Paper, least", "Paper, most", "Paper, floor"}) add_series(resolution, name, "theory", true);
  for (std::size_t i = 0; i < sources.front().rows.size(); ++i) {
    const double height_m = sources.front().rows[i].height_m;
    ResultJson line = ResultJson::array({height_m});
    for (const Source& source : sources) line.push_back(rounded(source.rows[i].error_mm));
    line.push_back(2.3);
    line.push_back(4.7);
    all["rows"].push_back(std::move(line));
    improved["rows"].push_back(
        {height_m, rounded(sources[1].rows[i].error_mm), rounded(sources[3].rows[i].error_mm), 1.0});
    resolution["rows"].push_back({height_m, rounded(sources[0].rows[i].resolution_mm), 0.7, 1.5, 2.5});
  }
  study.charts = ResultJson::array({all, improved, resolution});
}

}  // namespace

ConstellationStudy study_sensitivity(const StudyOptions& o, const InterruptionWatch& interruption) {
  constexpr int heights = 11;
  SensitivitySettings settings;
  settings.seed = o.seed;
  settings.trials = o.trials;
  std::vector<Source> sources = error_sources();
  ConstellationStudy study;
  study.columns = {{"Errors", "", 24}};
  for (int i = 0; i < heights; i += 2) study.columns.push_back({text_of("%.1f m", 0.25 * i), "mm", 7});
  study.columns.push_back({"Mean", "mm", 7});
  Progress progress("sensitivity", sources.size() * heights);
  for (std::size_t k = 0; k < sources.size(); ++k) {
    Source& source = sources[k];
    std::vector<ResultJson> line{source.words};
    double mean_mm = 0.0;
    for (int i = 0; i < heights; ++i) {
      interruption.check();
      progress.show(k * heights + static_cast<std::size_t>(i), source.name);
      source.rows.push_back(range_sensitivity(source.errors, 0.25 * i, settings));
      study.rows.push_back(sensitivity_row(source, source.rows.back()));
      if (i % 2 == 0) line.push_back(rounded(source.rows.back().error_mm));
      mean_mm += source.rows.back().error_mm / heights;
    }
    line.push_back(rounded(mean_mm));
    study.cells.push_back(std::move(line));
  }
  std::vector<ResultJson> resolution{"Noise (resolution)"};
  double mean_mm = 0.0;
  for (int i = 0; i < heights; ++i) {
    const double mm = sources[0].rows[static_cast<std::size_t>(i)].resolution_mm;
    if (i % 2 == 0) resolution.push_back(rounded(mm));
    mean_mm += mm / heights;
  }
  resolution.push_back(rounded(mean_mm));
  study.cells.push_back(std::move(resolution));
  study.figures = {{"Figure 7: table 1's errors together", "2.3 to 4.7 mm",
                    span_of(sources[0], &SensitivityRow::error_mm, "%.1f to %.1f mm")},
                   {"Figure 8: resolution", "0.7 to 1.5 mm, 2.5 near the floor",
                    span_of(sources[0], &SensitivityRow::resolution_mm, "%.1f to %.1f mm")},
                   {"Figure 9: improved compensation", "about 1 mm",
                    span_of(sources[1], &SensitivityRow::error_mm, "%.1f to %.1f mm")},
                   {"Of that, temperature alone, 0.2 deg C", "not given",
                    span_of(sources[3], &SensitivityRow::error_mm, "%.1f to %.1f mm")}};
  draw(study, sources);
  study.title =
      "Table 1's errors put a receiver off by " + span_of(sources[0], &SensitivityRow::error_mm, "%.1f to %.1f mm");
  study.about =
      text_of("%d installations, seed %llu; mean error by height", o.trials, static_cast<unsigned long long>(o.seed));
  study.paragraphs = {
      "Beacons hang some millimetres beside their places, the air is warmer than believed, transducers answer late, "
      "and "
      "later the further one looks at them from the side. None of that averages out. How far does it put a receiver "
      "off, at each height under a ceiling of beacons?",
      "The simulation of the paper's figure 6: an array 2 feet wide at 3 m, all beacons in reach, least squares. " +
          text_of("%d installations are drawn; every second one is colder instead of warmer.", o.trials)};
  return study;
}

// ---- acquisition

ConstellationStudy study_acquisition(const StudyOptions& o, const InterruptionWatch& interruption) {
  ConstellationStudy study;
  study.columns = {
      {"Codes", "", 8},         {"Ranges wrong", "%", 14, 0}, {"Right", "%", 8, 1},         {"Ambiguous", "%", 11, 1},
      {"No pose", "%", 9, 1},   {"False", "%", 8, 1},         {"Position, mean", "mm", 16}, {"Angle, mean", "deg", 13},
      {"Tuples", "mean", 8, 1}, {"Time", "ms", 8, 1}};
  ResultJson outcome = bars("outcome", "What came of it", "A pose is false if it is more than 5 cm or 5 deg off.",
                            "share of the tries", "%");
  ResultJson effort = bars("effort", "How long it took",
                           "A tuple is four codes, tried wherever they hang together. With wrong ranges several are "
                           "needed.",
                           "time", "ms");
  effort["half"] = outcome["half"] = true;
  add_series(outcome, "Right", "b");
  add_series(outcome, "Ambiguous", "c");
  add_series(outcome, "No pose", "a");
  add_series(outcome, "False", "d");
  add_series(effort, "Time", "e");
  effort["x"]["log"] = true;
  constexpr std::array codes{16, 8};
  constexpr std::array wrong{0.0, 0.15, 0.3};
  int false_poses = 0, tries = 0;
  std::array<double, 2> clean_share{}, clean_ms{};
  Progress progress("acquisition", codes.size() * wrong.size() * seeds);
  for (std::size_t c = 0; c < codes.size(); ++c) {
    for (std::size_t w = 0; w < wrong.size(); ++w) {
      const std::string name = text_of("%d codes, %.0f %% wrong", codes[c], 100.0 * wrong[w]);
      AcquisitionRow sum;
      double position_mm = 0.0, angle_deg = 0.0, square_mm2 = 0.0, square_deg2 = 0.0, peak_mm = 0.0, peak_deg = 0.0;
      for (int s = 0; s < seeds; ++s) {
        interruption.check();
        progress.show((c * wrong.size() + w) * seeds + static_cast<std::size_t>(s), name);
        AcquisitionTrials trials;
        trials.codes = codes[c];
        trials.wrong = wrong[w];
        trials.trials = o.trials;
        trials.seed = o.seed + static_cast<std::uint64_t>(s);
        const AcquisitionRow row = acquire_at_random(trials);
        sum.trials += row.trials;
        sum.acquired += row.acquired;
        sum.ambiguous += row.ambiguous;
        sum.no_pose += row.no_pose;
        sum.false_poses += row.false_poses;
        sum.ranges += row.ranges / seeds;
        sum.tuples += row.tuples / seeds;
        sum.milliseconds += row.milliseconds / seeds;
        const double right = row.acquired - row.false_poses;
        position_mm += right * row.position_mm;
        angle_deg += right * row.angle_deg;
        square_mm2 += right * std::pow(1e3 * row.position.rms(), 2);
        square_deg2 += right * std::pow(degrees_per_rad * row.angle.rms(), 2);
        peak_mm = std::max(peak_mm, 1e3 * row.position.peak());
        peak_deg = std::max(peak_deg, degrees_per_rad * row.angle.peak());
      }
      const int right = sum.acquired - sum.false_poses;
      // Of none there is no error.
      const double n = right > 0 ? right : std::numeric_limits<double>::quiet_NaN();
      const auto percent = [&](int count) { return 100.0 * count / sum.trials; };
      tries += sum.trials;
      false_poses += sum.false_poses;
      if (w == 0) {
        clean_share[c] = percent(right);
        clean_ms[c] = sum.milliseconds;
      }
      ResultJson json = row_of("range_acquisition", name);
      json["codes"] = codes[c];
      json["wrong_pct"] = 100.0 * wrong[w];
      json["position_mm"] = {{"rms", io::number_or_null(std::sqrt(square_mm2 / n))},
                             {"peak", io::number_or_null(right > 0 ? peak_mm : n)},
                             {"mean", io::number_or_null(position_mm / n)}};
      json["angle_deg"] = {{"rms", io::number_or_null(std::sqrt(square_deg2 / n))},
                           {"peak", io::number_or_null(right > 0 ? peak_deg : n)},
                           {"mean", io::number_or_null(angle_deg / n)}};
      json["updates"] = sum.trials;
      json["accepted"] = sum.acquired;
      json["gated"] = sum.trials - sum.acquired;
      json["ambiguous"] = sum.ambiguous;
      json["no_pose"] = sum.no_pose;
      json["false_poses"] = sum.false_poses;
      json["ranges_heard"] = sum.ranges;
      json["tuples"] = sum.tuples;
      json["microseconds_per_update"] = 1e3 * sum.milliseconds;
      study.rows.push_back(std::move(json));
      study.cells.push_back({std::to_string(codes[c]), 100.0 * wrong[w], rounded(percent(right), 0.1),
                             rounded(percent(sum.ambiguous), 0.1), rounded(percent(sum.no_pose), 0.1),
                             rounded(percent(sum.false_poses), 0.1), rounded(position_mm / n, 0.01),
                             rounded(angle_deg / n, 0.01), rounded(sum.tuples, 0.1), rounded(sum.milliseconds, 0.1)});
      const std::string group = text_of("%d codes", codes[c]), label = text_of("%.0f %% wrong", 100.0 * wrong[w]);
      outcome["rows"].push_back({{"group", group},
                                 {"label", label},
                                 {"values",
                                  {rounded(percent(right), 0.1), rounded(percent(sum.ambiguous), 0.1),
                                   rounded(percent(sum.no_pose), 0.1), rounded(percent(sum.false_poses), 0.1)}}});
      effort["rows"].push_back({{"group", group}, {"label", label}, {"values", {rounded(sum.milliseconds, 0.1)}}});
    }
  }
  study.charts = ResultJson::array({outcome, effort});
  study.figures = {{"Section 2.2: eight codes in a large constellation", "many repetitions",
                    text_of("%.1f %% right, %.0f ms", clean_share[1], clean_ms[1])},
                   {"Sixteen codes, as it planned", "1820 4-tuples",
                    text_of("%.1f %% right, %.0f ms", clean_share[0], clean_ms[0])}};
  study.title = false_poses == 0 ? text_of("Of %d tries none gave a false pose", tries)
                                 : text_of("Of %d tries %d gave a false pose", tries, false_poses);
  study.about = text_of("%d tries of each of %d seeds from %llu, under 289 beacons", o.trials, seeds,
                        static_cast<unsigned long long>(o.seed));
  study.paragraphs = {
      "A tracker that was just switched on hears codes, and knows nothing. Codes repeat all over a large room. Where "
      "do four "
      "of them hang together so that their ranges fit, and do all the others agree?",
      "At random places under 289 beacons at 3 m, 2 feet apart, with table 1's errors, in an installation that is new "
      "for each try; wrong ranges are echoes and early pulses. The vertical is known to half a degree."};
  return study;
}

// ---- auto-mapping

namespace {

struct Room {
  std::string name, words;
  UltrasonicErrors errors;
  RangingFaults faults;
};

std::vector<Room> rooms() {
  const MappingCase as_planned;
  UltrasonicErrors table_1 = table_1_errors();
  table_1.beacon_horizontal_m = table_1.beacon_vertical_m = 0.0;  // the seed defines the frame
  return {{"noise", "Noise alone", {}, {}},
          {"improved_compensation", "Improved compensation", as_planned.errors, {}},
          {"table_1", "Table 1, uncompensated", table_1, {}},
          {"three_in_ten_wrong", "Improved, 30 % lost or wrong", as_planned.errors, {0.1, 0.1, 0.1}}};
}

ResultJson mapping_row(const Room& kind, std::uint64_t seed, const MappingRow& row, double first_mm) {
  ResultJson json = row_of("beacon_mapping", kind.name);
  json["seed"] = seed;
  json["position_mm"]["rms"] = io::number_or_null(row.position_mm);
  json["updates"] = row.ranges;
  json["accepted"] = row.ranges - row.gated;
  json["gated"] = row.gated;
  json["beacon_error_mm"] = {{"before", io::number_or_null(first_mm)},
                             {"after", row.installed > 0 ? io::number_or_null(row.mean_mm) : ResultJson(nullptr)}};
  json["worst_mm"] = io::number_or_null(row.worst_mm);
  json["installed"] = row.installed;
  json["nees"] = io::number_or_null(row.nees);
  json["beacons"] = ResultJson::array();
  for (const MappedBeaconError& b : row.beacons) {
    json["beacons"].push_back({{"code", b.code},
                               {"installed_s", io::number_or_null(b.installed_s)},
                               {"first_mm", io::number_or_null(b.first_mm)},
                               {"error_mm", io::number_or_null(b.error_mm)},
                               {"stated_mm", io::number_or_null(b.stated_mm)},
                               {"ranges", b.ranges}});
  }
  return json;
}

}  // namespace

ConstellationStudy study_mapping(const StudyOptions& o, const InterruptionWatch& interruption) {
  constexpr int others = 9;
  ConstellationStudy study;
  study.columns = {{"Ranging system", "", 30},   {"Room", "seed", 6, 0},    {"Found", "of 9", 7, 0},
                   {"Start, mean", "mm", 13, 1}, {"worst", "mm", 8, 1},     {"End, mean", "mm", 11},
                   {"worst", "mm", 8},           {"Tracker RMS", "mm", 13}, {"NEES", "per number", 12}};
  ResultJson chart = bars("beacons", "Errors of the new beacons' places",
                          "When a beacon is installed, and after the walk. Its place is refined by each of its ranges.",
                          "error", "mm");
  chart["x"]["log"] = true;
  add_series(chart, "Installed, mean", "a");
  add_series(chart, "At the end, mean", "b");
  add_series(chart, "At the end, worst", "c");
  const std::vector<Room> kinds = rooms();
  Progress progress("mapping", kinds.size() * static_cast<std::size_t>(o.trials));
  double worst_mm = 0.0, worst_first_mm = 0.0;
  int found = 0;
  for (std::size_t k = 0; k < kinds.size(); ++k) {
    for (int i = 0; i < o.trials; ++i) {
      interruption.check();
      progress.show(k * static_cast<std::size_t>(o.trials) + static_cast<std::size_t>(i), kinds[k].name);
      const std::uint64_t seed = o.seed + static_cast<std::uint64_t>(i);
      MappingCase room = MappingCase::random(others, seed);
      room.errors = kinds[k].errors;
      room.ranging.faults = kinds[k].faults;
      room.duration = from_seconds(o.seconds);
      room.unit.interval = from_seconds(1.0 / o.rate_hz);
      const MappingRow row = map_beacons(room);
      double first_mm = 0.0, first_worst_mm = 0.0;
      for (const MappedBeaconError& b : row.beacons) {
        if (std::isnan(b.installed_s)) continue;
        first_mm += b.first_mm / row.installed;
        first_worst_mm = std::max(first_worst_mm, b.first_mm);
      }
      found += row.installed;
      worst_mm = std::max(worst_mm, row.worst_mm);
      worst_first_mm = std::max(worst_first_mm, first_worst_mm);
      study.rows.push_back(mapping_row(kinds[k], seed, row, first_mm));
      study.cells.push_back({kinds[k].words, seed, row.installed, rounded(first_mm, 0.1), rounded(first_worst_mm, 0.1),
                             rounded(row.mean_mm, 0.01), rounded(row.worst_mm, 0.01), rounded(row.position_mm, 0.01),
                             rounded(row.nees, 0.01)});
      chart["rows"].push_back(
          {{"group", kinds[k].words},
           {"label", text_of("room %llu", static_cast<unsigned long long>(seed))},
           {"values", {rounded(first_mm, 0.01), rounded(row.mean_mm, 0.01), rounded(row.worst_mm, 0.01)}}});
    }
  }
  const int all = others * o.trials * static_cast<int>(kinds.size());
  study.charts = ResultJson::array({chart});
  study.figures = {{"Section 5: new beacons from a seed of three", "planned", text_of("%d of %d found", found, all)},
                   {"Approximate positions at first", "not given", text_of("%.0f mm off at most", worst_first_mm)},
                   {"After refinement", "feasible, it says", text_of("%.1f mm off at most", worst_mm)}};
  study.title = text_of("New beacons end within %.1f mm of where they hang", worst_mm);
  study.about = text_of("9 new beacons, a seed of three, a walk of %.0f s, %d rooms from seed %llu", o.seconds,
                        o.trials, static_cast<unsigned long long>(o.seed));
  study.paragraphs = {
      "Three beacons are measured, all others are hung anywhere. Whoever walks about beneath them finds out where: "
      "ranges "
      "of an unknown beacon gather until they say where it must be. From then on it helps to track, and each of its "
      "ranges refines it.",
      text_of(
          "Nine beacons over 4 m by 4 m, 2.2 to 3 m high; a walk of %.0f s. NEES is the squared error over what the "
          "mapper believes: 1 is honest, above is too sure.",
          o.seconds)};
  return study;
}

}  // namespace swimlab
