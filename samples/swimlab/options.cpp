#include "options.hpp"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <memory>

#include <holdfast/io/input_error.hpp>
#include <holdfast/motion/generators.hpp>

namespace swimlab {

using namespace holdfast;

void refuse(const std::string& option, const std::string& problem, const std::string& value,
            const std::string& expected) {
  throw io::InputError({.key = option, .problem = problem, .value = value, .expected = expected});
}

std::uint64_t seed_of(const std::string& word) {
  std::uint64_t seed = 0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), seed);
  if (error != std::errc() || end != word.data() + word.size()) {
    refuse("--seed", "not a seed", word, "a whole number, 0 or more");
  }
  return seed;
}

namespace {

/// Adds the words of `text`, which commas separate.
void add_cut(const std::string& option, const std::string& text, Words& words) {
  for (std::size_t begin = 0; begin <= text.size();) {
    const std::size_t end = std::min(text.find(',', begin), text.size());
    if (end == begin) refuse(option, "a word is missing between commas", text, "words separated by single commas");
    words.push_back(text.substr(begin, end - begin));
    begin = end + 1;
  }
}

/// Each word as one of the choices' values.
template <typename Value>
std::vector<Value> chosen(const std::string& option, const Words& words,
                          std::initializer_list<std::pair<const char*, Value>> choices) {
  std::string names;
  for (const auto& choice : choices) names += (names.empty() ? "" : ", ") + std::string(choice.first);
  std::vector<Value> values;
  for (const std::string& word : words) {
    bool known = false;
    for (const auto& [name, value] : choices) {
      if (word != name) continue;
      known = true;
      values.push_back(value);
    }
    if (!known) refuse(option, "unknown", word, "one of " + names);
  }
  return values;
}

void choose_pipelines(const Words& words, RunOptions& o) {
  for (const std::string& word : words) {
    const std::optional<Pipeline> asked = parse_pipeline(word);
    if (!asked && word != "all") refuse("--pipeline", "unknown pipeline", word, "P0 to P6, or all");
    for (const Pipeline pipeline : pipelines) {
      const bool is_new = std::find(o.pipelines.begin(), o.pipelines.end(), pipeline) == o.pipelines.end();
      if (is_new && (!asked || *asked == pipeline)) o.pipelines.push_back(pipeline);
    }
  }
}

std::string known_deflections() {
  std::string names = "own";
  for (const DeflectionKind kind : deflection_kinds) names += ", " + std::string(name_of(kind));
  return names;
}

void choose_deflections(const Words& words, RunOptions& o) {
  for (const std::string& word : words) {
    const auto kind = std::find_if(deflection_kinds.begin(), deflection_kinds.end(),
                                   [&](DeflectionKind k) { return word == name_of(k); });
    if (word != "own" && kind == deflection_kinds.end()) {
      refuse("--deflection", "unknown", word, "one of " + known_deflections());
    }
    o.deflections.push_back(word == "own" ? std::nullopt : std::optional(*kind));
  }
  const bool any = std::any_of(o.pipelines.begin(), o.pipelines.end(),
                               [](Pipeline p) { return deflection_of(p) != DeflectionKind::none; });
  if (!any) {
    refuse("--deflection", "none of the pipelines deflects", words.front(), "P4, P5 or P6 among --pipeline");
  }
}

PixelSize size_of(const std::string& word) {
  const std::string expected = "WIDTHxHEIGHT in pixels, each 64 to 8192, for example 1280x720";
  PixelSize size;
  const char* const end = word.data() + word.size();
  const auto width = std::from_chars(word.data(), end, size.width);
  if (width.ec != std::errc() || width.ptr == end || *width.ptr != 'x') refuse("--size", "not a size", word, expected);
  const auto height = std::from_chars(width.ptr + 1, end, size.height);
  if (height.ec != std::errc() || height.ptr != end) refuse("--size", "not a size", word, expected);
  for (const int side : {size.width, size.height}) {
    if (side < 64 || side > 8192) refuse("--size", "out of range", word, expected);
  }
  return size;
}

/// The text of the options of `run`, before they are checked.
struct RunWords {
  Words motions, pipelines, deflections, interval_errors, latencies, eyes, lenses, displays;
  std::string late, plane_distance = "2", low_pass = "10", size, seed = "1", backend, hmd, model, out = "out/swimlab",
                    json;
  bool full = false, lenient = false;
};

RunOptions checked(const RunWords& words, const std::string& command_line) {
  const auto or_else = [](const Words& given, Words usual) { return given.empty() ? usual : given; };
  RunOptions o;
  o.full = words.full;
  o.lenient = words.lenient;
  o.motions = or_else(words.motions, words.full ? Words{"M0", "M1", "M2", "M3", "M4", "M5", "M6", "M7", "M8"}
                                                : Words{"M6", "M1", "M3", "M4", "M7"});
  if (words.motions.empty() && words.displays.empty() && words.hmd.empty() && !words.full) o.rolling_motion = "M6";
  choose_pipelines(or_else(words.pipelines, {"all"}), o);
  const bool ablation = words.full && words.pipelines.empty();
  if (ablation || !words.deflections.empty()) choose_deflections(or_else(words.deflections, {"own", "shift"}), o);
  if (o.deflections.empty()) o.deflections.emplace_back(std::nullopt);
  o.interval_errors_ms =
      numbers_of("--interval-error-ms", or_else(words.interval_errors, ablation ? Words{"-10", "10"} : Words{"0"}),
                 -100.0, 100.0, "milliseconds, -100 to 100");
  o.plane_distance_m =
      number_of("--plane-distance-m", words.plane_distance, 0.05, 1000.0, "metres before the eye, 0.05 to 1000");
  o.latencies_ms =
      numbers_of("--latency-ms", or_else(words.latencies, words.full ? Words{"2", "20", "60", "100"} : Words{"60"}),
                 0.0, 1000.0, "milliseconds, 0 to 1000");
  for (const std::string& word : or_else(words.eyes, words.full ? Words{"both"} : Words{"left"})) {
    if (word == "both") {
      o.eyes.insert(o.eyes.end(), {EyeSide::left, EyeSide::right});
    } else {
      o.eyes.push_back(chosen<EyeSide>("--eye", {word},
                                       {{"left", EyeSide::left}, {"right", EyeSide::right}, {"both", EyeSide::left}})
                           .front());
    }
  }
  o.lenses = chosen<LensMode>(
      "--lens",
      or_else(words.lenses, words.full ? Words{"none", "exact", "cubic", "uncorrected"} : Words{"none", "exact"}),
      {{"none", LensMode::none},
       {"exact", LensMode::exact},
       {"cubic", LensMode::cubic},
       {"uncorrected", LensMode::uncorrected}});
  for (const ScanOut scan_out :
       chosen<ScanOut>("--display", words.full ? or_else(words.displays, {"global", "rolling"}) : words.displays,
                       {{"global", ScanOut::global}, {"rolling", ScanOut::rolling}})) {
    o.displays.emplace_back(scan_out);
  }
  if (o.displays.empty()) o.displays.emplace_back(std::nullopt);
  const double shortest = *std::min_element(o.latencies_ms.begin(), o.latencies_ms.end());
  if (!words.late.empty()) {
    o.late_ms = number_of("--late-ms", words.late, 0.0, 1000.0, "milliseconds, 0 to 1000");
    if (o.late_ms > shortest) {
      refuse("--late-ms", "the late pose would be older than the one drawn for", words.late,
             "at most the shortest --latency-ms");
    }
  }
  o.low_pass_hz = number_of("--low-pass-hz", words.low_pass, 0.0, 1000.0, "hertz, 0 (off) to 1000");
  if (!words.size.empty()) o.size = size_of(words.size);
  o.seed = seed_of(words.seed);
  if (!words.backend.empty()) {
    o.backend = rendering::parse_backend(words.backend);
    if (!o.backend) refuse("--backend", "unknown", words.backend, "one of " + rendering::built_backend_names());
  }
  o.hmd = words.hmd;
  o.model = words.model;
  o.out = words.out;
  o.json = words.json;
  o.command = command_line;
  return o;
}

}  // namespace

void add_json(CLI::App& command, std::string& json) {
  command.add_option("--json", json, "Write the results also to this file")->type_name("FILE");
}

CLI::Option* add_words(CLI::App& command, const std::string& name, Words& words, const std::string& help) {
  // Cut at commas here: the command-line library would drop empty words, and with them a mistyped value.
  const auto read = [&words, name](const CLI::results_t& given) {
    words.clear();
    for (const std::string& text : given) add_cut(name, text, words);
    return true;
  };
  return command.add_option(name, read, help)->type_name("WORD,...")->take_all()->allow_extra_args(false);
}

double number_of(const std::string& option, const std::string& word, double least, double most,
                 const std::string& expected) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), value);
  if (error != std::errc() || end != word.data() + word.size() || !std::isfinite(value)) {
    refuse(option, "not a number", word, expected);
  }
  if (value < least || value > most) refuse(option, "out of range", word, expected);
  return value;
}

std::vector<double> numbers_of(const std::string& option, const Words& words, double least, double most,
                               const std::string& expected) {
  std::vector<double> values;
  for (const std::string& word : words) values.push_back(number_of(option, word, least, most, expected));
  return values;
}

void add_run_command(CLI::App& app, const std::string& command_line, int& exit_code) {
  CLI::App& run_app = *app.add_subcommand("run", "Run registration experiments and write a report");
  const auto words = std::make_shared<RunWords>();
  std::string names;
  for (const MotionName& name : motion_names()) names += "\n  " + std::string(name.id) + "  " + std::string(name.title);
  add_words(run_app, "--motion", words->motions,
            "Motions: M0 to M8 (below) or recordings (TUM, EuRoC, CSV); default M6 on a rolling display with its lens "
            "corrected, and M1,M3,M4,M7 as the other options say");
  add_words(
      run_app, "--pipeline", words->pipelines,
      "P0 no prediction, P1 constant velocity, P2 Kalman filter of poses, P3 Kalman filter with inertial sensors "
      "(simulated), P4 = P3 and late rotation, P5 = P3 and late depth warp, P6 = P5 line by line, all; default all");
  add_words(run_app, "--deflection", words->deflections,
            "What P4 to P6 do to the finished picture: own, or instead of it none, shift, shift_roll, rotation, plane, "
            "depth; several make several rows; default own (--full: own,shift)");
  add_words(
      run_app, "--interval-error-ms", words->interval_errors,
      "Rows also of P3 (without it, of all that predict) predicting so much too far (negative: too short); several "
      "with commas; default none (--full: -10,10)");
  run_app.add_option("--plane-distance-m", words->plane_distance, "Of --deflection plane; default 2");
  add_words(run_app, "--latency-ms", words->latencies,
            "From the tracker's measurement to the middle of scan-out; default 60");
  add_words(run_app, "--eye", words->eyes, "left, right or both; default left");
  add_words(run_app, "--lens", words->lenses, "none, exact, cubic, uncorrected; default none,exact");
  add_words(run_app, "--display", words->displays, "global or rolling; default as the headset says");
  run_app.add_option("--late-ms", words->late, "Age of the late pose of P4 to P6 when scan-out starts; default 3");
  run_app.add_option("--low-pass-hz", words->low_pass,
                     "Recordings: what is faster is noise, not the head (zero phase; 0: keep all); default 10");
  run_app.add_option("--hmd", words->hmd, "Headset descriptor (assets/hmds/*.json)")->type_name("FILE");
  run_app.add_option("--model", words->model, "Draw this model too: anything assimp reads")->type_name("FILE");
  run_app.add_option("--size", words->size, "Pixels of one eye's picture; default 1280x720")->type_name("WxH");
  run_app.add_flag("--full", words->full, "Every motion, eye, lens, latency and display: minutes, not seconds");
  run_app.add_option("--seed", words->seed, "Of the random motions M4 to M6; default 1")->type_name("N");
  run_app.add_option("--backend", words->backend, "OpenGL without a window: " + rendering::built_backend_names());
  run_app.add_option("--out", words->out, "Folder for the report; default out/swimlab")->type_name("DIR");
  run_app.add_flag("--lenient", words->lenient, "Drop and count bad rows of a recording instead of stopping");
  add_json(run_app, words->json);
  run_app.footer("Motions:" + names +
                 "\n\nExample:\n  swimlab run --motion M1,head.tum --latency-ms 20,60 --out out/report\n"
                 "Exit code: 0 done, 1 a value that theory demands was missed, 2 wrong use or unreadable input.");
  run_app.callback([words, command_line, &exit_code] { exit_code = run(checked(*words, command_line)); });
}

void add_predict_command(CLI::App& app, const std::string& command_line, int& exit_code) {
  struct Given {
    std::string trajectory, imu, json, out, noise_mm, noise_deg, pose_hz;
    Words intervals;
    bool lenient = false;
  };
  CLI::App& predict_app = *app.add_subcommand("predict", "Predict a recorded motion and say how far off it is");
  const auto given = std::make_shared<Given>();
  predict_app.add_option("TRAJECTORY", given->trajectory, "Recorded poses: TUM, EuRoC or CSV")->required();
  predict_app
      .add_option("--imu", given->imu,
                  "Recorded inertial readings (CSV: t, gyr_x.., acc_x.., or EuRoC; rad/s, m/s2); without it they are "
                  "simulated")
      ->type_name("FILE");
  predict_app.add_option("--pose-hz", given->pose_hz,
                         "Measure about so many poses a second (every so many-th), the others are truth alone; default "
                         "all");
  add_words(predict_app, "--interval-ms", given->intervals, "How far ahead; default 60");
  predict_app.add_option("--noise-mm", given->noise_mm, "Noise of the recorded positions, for kalman; default 0.05");
  predict_app.add_option("--noise-deg", given->noise_deg,
                         "Noise of the recorded orientations, for kalman; default 0.0172 (0.3 mrad)");
  predict_app.add_flag("--lenient", given->lenient, "Drop and count bad rows instead of stopping");
  predict_app.add_option("--out", given->out, "Folder for report.html and predict.json")->type_name("DIR");
  add_json(predict_app, given->json);
  predict_app.footer(
      "Example:\n  swimlab predict head.tum --interval-ms 20,60,100 --json predict.json\n"
      "  swimlab predict recording.csv --imu recording.csv --pose-hz 95 --out out/predict");
  predict_app.callback([given, command_line, &exit_code] {
    PredictOptions o;
    o.trajectory = given->trajectory;
    o.imu = given->imu;
    o.json = given->json;
    o.out = given->out;
    o.command = command_line;
    o.lenient = given->lenient;
    o.intervals_ms = numbers_of("--interval-ms", given->intervals.empty() ? Words{"60"} : given->intervals, 0.0, 1000.0,
                                "milliseconds, 0 to 1000");
    if (!given->noise_mm.empty()) {
      o.noise.position_m =
          1e-3 * number_of("--noise-mm", given->noise_mm, 1e-4, 1e3, "millimetres, 0.0001 to 1000: standard deviation");
    }
    if (!given->noise_deg.empty()) {
      o.noise.orientation_rad =
          degrees(number_of("--noise-deg", given->noise_deg, 1e-5, 90.0, "degrees, 0.00001 to 90: standard deviation"))
              .radians();
    }
    if (!given->pose_hz.empty())
      o.pose_hz = number_of("--pose-hz", given->pose_hz, 1.0, 1e4, "poses a second, 1 to 10000");
    exit_code = predict(o);
  });
}

void add_latency_command(CLI::App& app, int& exit_code) {
  struct Given {
    std::string reference, observed, json;
    bool same_frames = false, lenient = false;
  };
  CLI::App& latency_app =
      *app.add_subcommand("latency", "Effective latency and errors of one recording against another");
  const auto given = std::make_shared<Given>();
  latency_app.add_option("REFERENCE", given->reference, "What is true: TUM, EuRoC or CSV")->required();
  latency_app.add_option("OBSERVED", given->observed, "What was displayed or tracked, on the same clock")->required();
  latency_app.add_flag("--same-frames", given->same_frames,
                       "Both speak of one world and one body: do not estimate the rigid transform between them");
  latency_app.add_flag("--lenient", given->lenient, "Drop and count bad rows instead of stopping");
  add_json(latency_app, given->json);
  latency_app.footer("Example:\n  swimlab latency robot_truth.tum headset.tum --json latency.json");
  latency_app.callback([given, &exit_code] {
    LatencyCommandOptions o;
    o.reference = given->reference;
    o.observed = given->observed;
    o.json = given->json;
    o.same_frames = given->same_frames;
    o.lenient = given->lenient;
    exit_code = latency(o);
  });
}

}  // namespace swimlab
