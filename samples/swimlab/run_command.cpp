/// swimlab run: rows of experiments, the values that theory demands, pictures and the report.
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <tuple>

#include <holdfast/io/hmd.hpp>
#include <holdfast/io/input_error.hpp>
#include <holdfast/io/results.hpp>
#include <holdfast/registration/pipeline_pose.hpp>

#include "charts.hpp"
#include "checks.hpp"
#include "exit_code.hpp"
#include "interruption.hpp"
#include "motions.hpp"
#include "options.hpp"
#include "output_folder.hpp"
#include "progress.hpp"
#include "report.hpp"
#include "row_runner.hpp"
#include "stopwatch.hpp"
#include "studio.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

HmdModel headset(const RunOptions& options) {
  if (options.hmd.empty()) return default_hmd(options.size.value_or(PixelSize{1280, 720}));
  HmdModel hmd = io::read_hmd(options.hmd);
  return options.size ? with_resolution(hmd, *options.size) : hmd;
}

HmdModel with_display(HmdModel hmd, std::optional<ScanOut> scan_out) {
  if (!scan_out) return hmd;
  hmd.timing.scan_out = *scan_out;
  if (*scan_out == ScanOut::rolling && hmd.timing.scan_duration <= Duration{0}) {
    hmd.timing.scan_duration = std::min<Duration>(std::chrono::microseconds(11100), frame_period(hmd.timing));
  }
  return hmd;
}

/// A row to be run: which motion, with which settings.
struct Task {
  const ChosenMotion* motion;
  ExperimentSettings settings;
};

/// A pipeline, how it deflects, and how wrong its interval is.
struct Variant {
  Pipeline pipeline;
  std::optional<DeflectionKind> deflection;
  double interval_error_ms = 0.0;
};

/// Each pipeline with each way of deflecting; P0 to P3 do not. What would do the same as another is left out, such as
/// P5 with a shift beside P4 with a shift. Wrong intervals are P3's, or, without it, of all that predict.
std::vector<Variant> variants_of(const RunOptions& options, bool rolling) {
  std::vector<Variant> variants;
  std::vector<std::tuple<PosePrediction, DeflectionKind, bool>> seen;
  const bool with_p3 =
      std::find(options.pipelines.begin(), options.pipelines.end(), Pipeline::p3) != options.pipelines.end();
  for (const Pipeline pipeline : options.pipelines) {
    const DeflectionKind own = deflection_of(pipeline);
    for (const std::optional<DeflectionKind>& asked : options.deflections) {
      const bool is_own = !asked || own == DeflectionKind::none || *asked == own;
      const std::tuple what(prediction_of(pipeline), is_own ? own : *asked, pipeline == Pipeline::p6 && rolling);
      const bool known = std::find(seen.begin(), seen.end(), what) != seen.end();
      const bool listed = std::any_of(variants.begin(), variants.end(), [&](const Variant& v) {
        return v.pipeline == pipeline && v.deflection == (is_own ? std::nullopt : asked);
      });
      if (listed || (known && !is_own)) continue;
      seen.push_back(what);
      variants.push_back({pipeline, is_own ? std::nullopt : asked});
    }
    const bool wanted = with_p3 ? pipeline == Pipeline::p3 : prediction_of(pipeline) != PosePrediction::none;
    for (const double error_ms : options.interval_errors_ms) {
      if (wanted && error_ms != 0.0) variants.push_back({pipeline, std::nullopt, error_ms});
    }
  }
  return variants;
}

Task checked_task(const ChosenMotion& motion, ExperimentSettings s) {
  if (const auto problem = problem_of(s)) throw io::InputError({.key = "settings", .problem = *problem});
  if (frames_of(*motion.motion, s) < 3) {
    throw io::InputError(
        {.key = "--motion " + motion.id,
         .problem = "too short for a latency of " + std::to_string(std::lround(to_milliseconds(s.latency))) + " ms",
         .expected = "a motion that lasts some frames longer than the start-up of 0.2 s or more"});
  }
  return {&motion, std::move(s)};
}

std::vector<Task> tasks_of(const RunOptions& options, const std::vector<ChosenMotion>& motions, const HmdModel& hmd) {
  std::vector<Task> tasks;
  for (const ChosenMotion& motion : motions) {
    const auto known_poses = std::make_shared<KnownPoses>();
    const bool rolls = motion.id == options.rolling_motion;
    const auto displays = rolls ? std::vector<std::optional<ScanOut>>{ScanOut::rolling} : options.displays;
    const auto lenses = rolls ? std::vector<LensMode>{options.lenses.back()} : options.lenses;
    for (const auto& display : displays) {
      ExperimentSettings s;
      s.motion_name = motion.id;
      s.hmd = with_display(hmd, display);
      s.velocity = motion.recorded ? VelocitySource::backward_difference : VelocitySource::exact;
      s.late = from_milliseconds(options.late_ms);
      s.plane_distance_m = options.plane_distance_m;
      s.inertial_seed = options.seed;
      s.known_poses = known_poses;
      const std::vector<Variant> variants = variants_of(options, s.hmd.timing.scan_out == ScanOut::rolling);
      for (const EyeSide eye : options.eyes) {
        for (const LensMode lens : lenses) {
          for (const double latency_ms : options.latencies_ms) {
            for (const Variant& variant : variants) {
              s.pipeline = variant.pipeline;
              s.deflection = variant.deflection;
              s.interval_error = from_milliseconds(variant.interval_error_ms);
              s.eye = eye;
              s.lens = lens;
              s.latency = from_milliseconds(latency_ms);
              tasks.push_back(checked_task(motion, s));
            }
          }
        }
      }
    }
  }
  return tasks;
}

std::string cell(const char* format, std::optional<double> value) {
  if (!value) return "-";
  char text[48];
  std::snprintf(text, sizeof text, format, *value);
  return text;
}

/// Theory beside measurement, as far as a row of text has room: the expectation of the peak yaw error or of the like.
std::string theory_of(const ExperimentRow& row) {
  if (row.expected.empty()) return "-";
  const ExpectedValue& first = row.expected.front();
  const std::size_t dot = first.name.find('.');
  const std::string name = dot == std::string::npos ? first.name : first.name.substr(dot + 1);
  return name + " " + cell("%.4g", first.measured) + " / " + cell("%.4g", first.expected);
}

/// Columns as wide as their widest cell; numbers to the right.
void print_table(const std::vector<std::vector<std::string>>& rows, std::size_t left_columns) {
  std::vector<std::size_t> widths(rows.front().size(), 0);
  for (const auto& row : rows) {
    for (std::size_t i = 0; i < row.size(); ++i) widths[i] = std::max(widths[i], row[i].size());
  }
  for (const auto& row : rows) {
    std::string line;
    for (std::size_t i = 0; i < row.size(); ++i) {
      const std::string blanks(widths[i] - row[i].size(), ' ');
      const bool left = i < left_columns || i + 2 >= row.size();
      line += (i == 0 ? "" : "  ") + (left ? row[i] + blanks : blanks + row[i]);
    }
    line.erase(line.find_last_not_of(' ') + 1);
    std::printf("%s\n", line.c_str());
  }
}

void print_rows(const std::vector<RowResult>& results) {
  std::vector<std::vector<std::string>> table = {
      {"motion", "pipeline", "eye", "lens", "display", "ms", "RMS px", "peak px", "peak arcmin", "swim RMS deg/s",
       "peak", "eff. ms", "missing %", "revealed %", "picture px", "measured / theory", "verdict"}};
  for (const RowResult& result : results) {
    const ExperimentRow& r = result.row;
    const auto reg = [&](double RegistrationSummary::*m) {
      return r.registration ? std::optional((*r.registration).*m) : std::nullopt;
    };
    const auto swim = [&](double SwimSummary::*m) { return r.swim ? std::optional((*r.swim).*m) : std::nullopt; };
    table.push_back({r.motion, variant_name(r), std::string(name_of(r.eye)), std::string(name_of(r.lens)),
                     std::string(name_of(r.display)), cell("%g", r.latency_ms),
                     cell("%.2f", reg(&RegistrationSummary::rms_px)), cell("%.2f", reg(&RegistrationSummary::peak_px)),
                     cell("%.1f", reg(&RegistrationSummary::peak_arcmin)), cell("%.2f", swim(&SwimSummary::rms_deg_s)),
                     cell("%.2f", swim(&SwimSummary::peak_deg_s)), cell("%.2f", r.effective_latency_ms),
                     cell("%.2f", r.coverage_missing_pct), cell("%.2f", r.disocclusion_pct),
                     cell("%.4f", r.picture_vs_theory_px), theory_of(r), std::string(holdfast::name_of(r.verdict))});
  }
  print_table(table, 5);
}

const char* verdict_of(const Check& check) {
  return check.holds() ? "pass" : check.only_warns ? "warn" : "FAIL";
}

/// The few signs of the checks' words that are not ASCII are kept: terminals read UTF-8.
void print_checks(const std::vector<Check>& checks) {
  std::printf("\nWhat theory demands (the values of the evaluation plan):\n");
  for (const Check& check : checks) {
    std::printf("  %2d  %-4s %10.4g %-6s %s %.4g%s  %s\n", check.value, verdict_of(check), check.measured,
                check.unit.c_str(), check.at_most ? "at most" : "expected", check.expected,
                check.at_most ? "" : (" +-" + cell("%.2g", check.tolerance)).c_str(), check.what.c_str());
  }
}

bool is_rolling(const ExperimentSettings& s) {
  return s.hmd.timing.scan_out == ScanOut::rolling;
}

/// Alike in all but the pipeline.
bool is_like(const Task& a, const Task& b) {
  return a.motion == b.motion && a.settings.eye == b.settings.eye && a.settings.lens == b.settings.lens &&
         a.settings.latency == b.settings.latency && is_rolling(a.settings) == is_rolling(b.settings);
}

/// A motion's first task; on a rolling display if there is one, which tells line by line (P6) from all at once (P5).
const Task& shown_task(const std::vector<Task>& tasks, const ChosenMotion& motion) {
  const auto is_of = [&](const Task& task) { return task.motion == &motion; };
  const auto rolls = [&](const Task& task) { return is_of(task) && is_rolling(task.settings); };
  const auto rolling = std::find_if(tasks.begin(), tasks.end(), rolls);
  return rolling != tasks.end() ? *rolling : *std::find_if(tasks.begin(), tasks.end(), is_of);
}

/// Whether the page shows it: the motion's pipelines under one choice of everything else.
bool is_shown(const std::vector<Task>& tasks, const Task& task) {
  return is_like(task, shown_task(tasks, *task.motion));
}

/// Where all lines light at once, deflecting line by line is deflecting: the same task without, if it was before.
std::optional<std::size_t> same_task_before(const std::vector<Task>& tasks, std::size_t i) {
  const ExperimentSettings& s = tasks[i].settings;
  if (s.pipeline != Pipeline::p6 || is_rolling(s)) return std::nullopt;
  for (std::size_t k = 0; k < i; ++k) {
    const ExperimentSettings& other = tasks[k].settings;
    const bool same = other.pipeline == Pipeline::p5 && deflection_of(other).kind == deflection_of(s).kind &&
                      other.interval_error == s.interval_error;
    if (same && is_like(tasks[k], tasks[i])) return k;
  }
  return std::nullopt;
}

/// The row of P6, from that of P5 where both do the same; without pictures of its own.
RowResult repeated(const RowResult& result, const ExperimentSettings& settings) {
  RowResult copy;
  copy.row = result.row;
  copy.row.pipeline = settings.pipeline;
  copy.row.per_scanline = deflection_of(settings).per_scanline;
  copy.is_repeated = true;
  return copy;
}

/// The motion that headlines speak of: the first that moves.
const ChosenMotion& headline_motion(const std::vector<Task>& tasks, const std::vector<RowResult>& results) {
  for (std::size_t i = 0; i < results.size(); ++i) {
    if (results[i].row.motion != "M0" && results[i].row.registration) return *tasks[i].motion;
  }
  return *tasks.front().motion;
}

/// What the page shows of a motion, in words.
std::string shown_words(const ExperimentSettings& s) {
  const DisplayTiming& timing = s.hmd.timing;
  std::string words = "Shown is the " + std::string(name_of(s.eye)) + " eye, at " +
                      cell("%g", to_milliseconds(s.latency)) + " ms of latency, on a display that lights ";
  words += is_rolling(s) ? "line after line over " + cell("%g", to_milliseconds(timing.scan_duration)) + " ms"
                         : std::string("all lines at once");
  switch (s.lens) {
    case LensMode::none:
      return words + ", without a lens.";
    case LensMode::exact:
      return words + ", through a lens that is corrected exactly.";
    case LensMode::cubic:
      return words + ", through a lens that is corrected by the cubic of the course.";
    case LensMode::uncorrected:
      break;
  }
  return words + ", through a lens that is not corrected.";
}

/// The page's data beyond the summary.
ResultJson report_data(const ResultJson& summary, const std::vector<Task>& tasks, const std::vector<RowResult>& results,
                       const std::vector<ChosenMotion>& motions, const RegistrationScene& scene) {
  const ChosenMotion& head = headline_motion(tasks, results);
  ResultJson data;
  data["summary"] = summary;
  data["motions"] = ResultJson::object();
  data["heroes"] = ResultJson::array();
  for (const ChosenMotion& motion : motions) {
    std::vector<TimeSeries> series;
    std::vector<const RowResult*> rows;
    std::vector<ExperimentSettings> variants;
    const Task& shown = shown_task(tasks, motion);
    bool has_repeated = false;
    for (std::size_t i = 0; i < results.size(); ++i) {
      if (!is_like(tasks[i], shown)) continue;
      has_repeated = has_repeated || results[i].is_repeated;
      if (results[i].is_repeated) continue;
      series.push_back({results[i].row, results[i].samples});
      rows.push_back(&results[i]);
      variants.push_back(tasks[i].settings);
    }
    if (variants.empty()) continue;
    ResultJson& page = data["motions"][motion.id];
    page["tab"] = motion.title;
    page["about"] = motion.about;
    page["shown"] = shown_words(shown.settings) +
                    (has_repeated ? " P6 is not drawn: where all lines light at once it is the same as P5." : "");
    page["charts"] = {error_chart(series), swim_chart(series), latency_chart(*motion.motion, variants, scene),
                      budget_chart(*motion.motion, variants.front(), Pipeline::p0, scene)};
    const auto is_p3 = [](const RowResult* row) { return row->row.pipeline == Pipeline::p3; };
    if (std::any_of(rows.begin(), rows.end(), is_p3)) {
      page["charts"].push_back(budget_chart(*motion.motion, variants.front(), Pipeline::p3, scene));
    }
    page["sheet"] = contact_sheet(rows);
    if (&motion != &head) continue;
    for (const RowResult* row : rows) {
      if (row->worst) data["heroes"].push_back(worst_picture(*row));
    }
    data["headline"] = {{"motion", motion.id},
                        {"motion_title", motion.title},
                        {"latency_ms", to_milliseconds(shown.settings.latency)},
                        {"lens", name_of(shown.settings.lens)},
                        {"eye", name_of(shown.settings.eye)},
                        {"display", name_of(shown.settings.hmd.timing.scan_out)},
                        {"shown", shown_words(shown.settings)},
                        {"peak_head_deg_s", rounded(peak_head_speed_deg_s(*motion.motion))}};
    data["sweeps"] = frequency_charts(variants);
  }
  return data;
}

/// What the inertial sensors of P3 to P6 are; null when none was run.
ResultJson inertial_json(const std::vector<Task>& tasks) {
  for (const Task& task : tasks) {
    const ExperimentSettings& s = task.settings;
    if (prediction_of(s.pipeline) != PosePrediction::kalman_inertial) continue;
    const double readings_hz = 1.0 / to_seconds(s.inertial.interval), per_reading = std::sqrt(readings_hz);
    const double rate_noise = s.inertial.gyro.noise_density * per_reading;
    const double force_noise = s.inertial.accelerometer.noise_density * per_reading;
    return {
        {"readings", "simulated along the motion: " + cell("%g", readings_hz) + " Hz, noise " + cell("%g", rate_noise) +
                         " rad/s and " + cell("%g", force_noise) + " m/s2 a reading, and biases"},
        {"readings_hz", readings_hz},
        {"gyro_noise_rad_s", rate_noise},
        {"gyro_bias_rad_s", s.inertial.gyro.bias.norm()},
        {"accelerometer_noise_m_s2", force_noise},
        {"accelerometer_bias_m_s2", s.inertial.accelerometer.bias.norm()},
        {"seed", s.inertial_seed}};
  }
  return nullptr;
}

ResultJson environment_json(const Studio& studio, const HmdModel& hmd) {
  const PixelSize size = hmd.left.resolution;
  return {{"backend", rendering::backend_name(studio.info().backend)},
          {"gl_version", studio.info().gl_version},
          {"gl_renderer", studio.info().gl_renderer},
          {"hmd", hmd.name},
          {"display", hmd.name + ", " + std::to_string(size.width) + " x " + std::to_string(size.height) +
                          " px per eye, " + cell("%g", hmd.timing.refresh_hz) + " Hz"},
          {"model", studio.model_name().empty() ? ResultJson(nullptr) : ResultJson(studio.model_name())},
          {"scene", studio.model_name().empty() ? "discs, frame corner, edge and checkerboard"
                                                : "discs, frame corner, edge, checkerboard and " + studio.model_name()},
          {"holdfast_version", HOLDFAST_VERSION}};
}

}  // namespace

int run(const RunOptions& options) {
  const std::filesystem::path json_file = checked_json_file(options.json);
  const HmdModel hmd = headset(options);
  const std::vector<ChosenMotion> motions = load_motions(options);
  const std::vector<Task> tasks = tasks_of(options, motions, hmd);
  OutputFolder folder(options.out);
  const InterruptionWatch interruption;
  const RegistrationScene scene = default_registration_scene();
  Studio studio(options.backend, scene, options.model);
  RowRunner runner(studio, scene);

  Progress progress("swimlab run", tasks.size() + 2);
  progress.show(0, "what theory demands");
  const std::vector<Check> checks = run_checks(studio, scene);
  const double checks_draw_ms = studio.draw_readback_ms(), checks_setup_ms = studio.setup_ms();
  const std::size_t checks_pictures = studio.pictures();

  std::vector<RowResult> results;
  double encode_ms = 0.0;
  for (std::size_t i = 0; i < tasks.size(); ++i) {
    interruption.check();
    const Task& task = tasks[i];
    progress.show(i + 1, task.motion->id + ' ' + variant_name(task.settings));
    if (const auto before = same_task_before(tasks, i)) {
      results.push_back(repeated(results[*before], task.settings));
      continue;
    }
    PicturePlan plan;
    if (options.full) plan.measured = 5;
    if (options.full && !is_shown(tasks, task)) plan.contact = 0;
    results.push_back(runner.run(*task.motion->motion, task.settings, plan));
    const Stopwatch encoding;
    write_pictures(folder.path() / "pictures", results.back());
    encode_ms += encoding.milliseconds();
  }
  const double draw_ms = studio.draw_readback_ms() - checks_draw_ms;
  const std::size_t pictures = studio.pictures() - checks_pictures;
  const double frame_loop_ms = runner.timing().frame_loop_ms - (studio.setup_ms() - checks_setup_ms);
  encode_ms += runner.timing().encode_ms;

  std::vector<ExperimentRow> rows;
  for (const RowResult& result : results) rows.push_back(result.row);
  ResultJson summary;
  summary["schema"] = "holdfast/run/1";
  summary["seed"] = options.seed;
  summary["environment"] = environment_json(studio, hmd);
  summary["rows"] = ResultJson::array();
  for (const ExperimentRow& row : rows) summary["rows"].push_back(io::row_json(row));
  summary["checks"] = checks_json(checks);
  summary["command"] = options.command;
  summary["late_ms"] = options.late_ms;
  summary["inertial"] = inertial_json(tasks);

  progress.show(tasks.size() + 1, "report");
  const Stopwatch reporting;
  summary["timing"] = {{"draw_readback_ms", io::number_or_null(draw_ms)},
                       {"frame_loop_ms", io::number_or_null(frame_loop_ms)},
                       {"ratio", io::number_or_null(frame_loop_ms / draw_ms)},
                       {"setup_ms", io::number_or_null(studio.setup_ms())},
                       {"encode_ms", io::number_or_null(encode_ms)},
                       {"metrics_ms", io::number_or_null(runner.timing().metrics_ms)},
                       {"pictures", pictures}};
  const ResultJson data = report_data(summary, tasks, results, motions, scene);
  io::write_whole_file(folder.path() / "report.html", report_page(data));
  const double report_ms = reporting.milliseconds();
  summary["timing"]["report_ms"] = report_ms;
  io::write_whole_file(folder.path() / "rows.csv", io::rows_csv(rows));
  io::write_whole_file(folder.path() / "summary.json", io::json_text(summary));
  interruption.check();
  folder.commit();
  if (!json_file.empty()) io::write_whole_file(json_file, io::json_text(summary));
  progress.finish();

  print_rows(results);
  if (summary["inertial"].is_object()) {
    std::printf("inertial sensors of P3 to P6: %s\n", summary["inertial"]["readings"].get<std::string>().c_str());
  }
  print_checks(checks);
  std::printf("\n%zu pictures: bare draw and readback %.0f ms, whole frame loop %.0f ms, ratio %.3f (at most 1.25)\n",
              pictures, draw_ms, frame_loop_ms, frame_loop_ms / draw_ms);
  std::printf(
      "apart from that: metrics of all frames %.0f ms, lens tables and meshes %.0f ms, encoding pictures %.0f ms, "
      "charts and report %.0f ms\n",
      runner.timing().metrics_ms, studio.setup_ms(), encode_ms, report_ms);
  std::printf("report: %s\n", (folder.target() / "report.html").string().c_str());
  const bool rows_hold =
      std::none_of(rows.begin(), rows.end(), [](const auto& r) { return r.verdict == Verdict::fail; });
  const bool checks_hold =
      std::all_of(checks.begin(), checks.end(), [](const Check& c) { return c.holds() || c.only_warns; });
  std::fflush(stdout);
  if (rows_hold && checks_hold) return done;
  std::fprintf(stderr, "swimlab: something is not as theory demands; see FAIL above\n");
  return check_failed;
}

}  // namespace swimlab
