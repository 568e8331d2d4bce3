#include "charts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <map>
#include <numbers>

#include <Eigen/Cholesky>

#include <holdfast/motion/generators.hpp>
#include <holdfast/prediction/predictor_theory.hpp>
#include <holdfast/registration/error_budget.hpp>
#include <holdfast/registration/expected_values.hpp>
#include <holdfast/registration/experiment.hpp>
#include <holdfast/registration/pipeline_pose.hpp>

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

ResultJson axis(const char* label, const char* unit, bool log = false) {
  ResultJson json = {{"label", label}, {"unit", unit}};
  if (log) json["log"] = true;
  return json;
}

/// Name and style of a variant's line. P6 is dashed: it may lie on P5's; so is one of two wrong intervals.
ResultJson variant_series(Pipeline pipeline, const std::string& name, double interval_error_ms) {
  const std::string id(holdfast::name_of(pipeline));
  const bool own = name == id;
  ResultJson series = {{"name", own ? id + ' ' + std::string(describe(pipeline)) : name},
                       {"style", own ? id : "ablation"}};
  if (pipeline == Pipeline::p6 || interval_error_ms < 0.0) series["dashed"] = true;
  return series;
}

ResultJson time_chart(const std::vector<TimeSeries>& series, std::optional<double> FrameSample::*member) {
  ResultJson json;
  json["x"] = axis("time", "s");
  json["series"] = ResultJson::array();
  for (const TimeSeries& s : series) {
    json["series"].push_back(variant_series(s.row.pipeline, variant_name(s.row), s.row.interval_error_ms));
  }
  ResultJson rows = ResultJson::array();
  for (std::size_t i = 0; !series.empty() && i < series.front().samples.size(); ++i) {
    ResultJson row = {rounded(series.front().samples[i].t_s)};
    for (const TimeSeries& s : series) {
      row.push_back(i < s.samples.size() ? rounded(s.samples[i].*member) : ResultJson(nullptr));
    }
    rows.push_back(std::move(row));
  }
  json["rows"] = std::move(rows);
  return json;
}

}  // namespace

ResultJson rounded(std::optional<double> value) {
  if (!value || !std::isfinite(*value)) return nullptr;
  char digits[40];
  std::snprintf(digits, sizeof digits, "%.5g", *value);
  return std::strtod(digits, nullptr);
}

std::string variant_name(const ExperimentRow& row) {
  std::string name(holdfast::name_of(row.pipeline));
  if (row.deflection != deflection_of(row.pipeline)) name += ' ' + std::string(holdfast::name_of(row.deflection));
  if (row.interval_error_ms == 0.0) return name;
  char words[48];
  std::snprintf(words, sizeof words, " %g ms too %s", std::abs(row.interval_error_ms),
                row.interval_error_ms > 0.0 ? "far" : "short");
  return name + words;
}
std::string variant_name(const ExperimentSettings& settings) {
  ExperimentRow row;
  row.pipeline = settings.pipeline;
  row.deflection = deflection_of(settings).kind;
  row.interval_error_ms = to_milliseconds(settings.interval_error);
  return variant_name(row);
}
std::string variant_title(const ExperimentRow& row) {
  return is_ablation(row) ? variant_name(row) : variant_name(row) + ", " + std::string(describe(row.pipeline));
}

ResultJson error_chart(const std::vector<TimeSeries>& series) {
  ResultJson json = time_chart(series, &FrameSample::rms_px);
  json["id"] = "error";
  json["title"] = "Registration error";
  json["caption"] =
      "How far the virtual discs stand from the real ones in the picture: root mean square over the discs in view, "
      "frame by "
      "frame.";
  json["y"] = axis("error", "px");
  json["logToggle"] = true;
  return json;
}

ResultJson swim_chart(const std::vector<TimeSeries>& series) {
  ResultJson json = time_chart(series, &FrameSample::swim_deg_s);
  json["id"] = "swim";
  json["title"] = "Swim velocity";
  json["caption"] = "How fast that error changes: the speed at which virtual discs slide over the real ones.";
  json["y"] = axis("swim", "\u00b0/s");
  json["logToggle"] = true;
  return json;
}

namespace {

/// RMS error of all discs over at most 100 of the motion's frames: only the errors are computed.
std::optional<double> rms_error_px(const Motion& motion, const ExperimentSettings& settings,
                                   const RegistrationScene& scene) {
  double squares = 0.0;
  std::size_t count = 0;
  const std::size_t frames = frames_of(motion, settings);
  const std::size_t stride = std::max<std::size_t>(1, frames / 100);
  const holdfast::detail::FramePlanOfExperiment plan = holdfast::detail::plan_frames(motion, settings);
  holdfast::detail::ExperimentRun run(motion, settings, scene, holdfast::detail::Measures::errors);
  for (std::size_t i = 0; i < frames; i += stride) {
    run.frame(i, plan.middle_of(i), [&](const FrameRecord& frame) {
      for (const FiducialRecord& f : frame.fiducials) {
        if (!f.visible) continue;
        squares += f.error_px.squaredNorm();
        ++count;
      }
    });
  }
  if (count == 0) return std::nullopt;
  return std::sqrt(squares / static_cast<double>(count));
}

}  // namespace

ResultJson latency_chart(const Motion& motion, std::span<const ExperimentSettings> variants,
                         const RegistrationScene& scene) {
  ResultJson json;
  json["id"] = "latency";
  json["title"] = "Error against latency";
  json["caption"] =
      "Root mean square of all discs and frames, when the pose is older or has to be predicted further (as figure 7 of "
      "Azuma and Bishop 1994). The late pose of P4 to P6 keeps its age.";
  json["x"] = axis("latency", "ms");
  json["y"] = axis("RMS error", "px");
  json["logToggle"] = true;
  json["series"] = ResultJson::array();
  for (const ExperimentSettings& variant : variants) {
    json["series"].push_back(
        variant_series(variant.pipeline, variant_name(variant), to_milliseconds(variant.interval_error)));
  }
  json["rows"] = ResultJson::array();
  for (int latency_ms = 0; latency_ms <= 120; latency_ms += 10) {
    ResultJson row = {latency_ms};
    for (ExperimentSettings at : variants) {
      at.latency = from_milliseconds(latency_ms);
      row.push_back(rounded(rms_error_px(motion, at, scene)));
    }
    json["rows"].push_back(std::move(row));
  }
  return json;
}

ResultJson budget_chart(const Motion& motion, const ExperimentSettings& settings, Pipeline pipeline,
                        const RegistrationScene& scene) {
  const bool predicts = prediction_of(pipeline) != PosePrediction::none;
  const std::string id(holdfast::name_of(pipeline));
  ResultJson json;
  json["id"] = predicts ? "budget-" + id : "budget";
  json["title"] = "Error budget, " + std::string(describe(pipeline));
  json["caption"] =
      "What each source of error does when it acts alone, stacked (root mean squares), " +
      std::string(predicts ? "with " : "without prediction (") + id + (predicts ? "" : ")") +
      ". A third of the latency is the tracker's, the rest graphics and display; static is a tracker 2 mm off; " +
      (predicts ? "interval is a prediction 10 ms too far, and all have the sensors' noise; " : "") +
      "lines scan out over 11.1 ms; the lens is corrected by the cubic of the course; viewing is an eye distance "
      "believed 2 mm too large.";
  json["x"] = axis("latency", "ms");
  json["y"] = axis("error", "arcmin");
  json["stacked"] = true;
  json["series"] = ResultJson::array();
  json["rows"] = ResultJson::array();
  const std::map<std::string_view, const char*> styles = {
      {"static", "c"},   {"tracker delay", "a"}, {"graphics delay", "b"}, {"interval", "P3"},
      {"scan-out", "d"}, {"lens", "e"},          {"viewing", "f"}};
  for (int latency_ms = 0; latency_ms <= 100; latency_ms += 20) {
    BudgetSettings budget_settings;
    budget_settings.experiment = settings;
    budget_settings.experiment.pipeline = pipeline;
    budget_settings.experiment.deflection.reset();
    if (predicts) budget_settings.interval_error = std::chrono::milliseconds(10);
    budget_settings.experiment.lens = LensMode::cubic;
    DisplayTiming& timing = budget_settings.experiment.hmd.timing;
    timing.scan_out = ScanOut::rolling;
    timing.scan_duration = std::min<Duration>(std::chrono::microseconds(11100), frame_period(timing));
    budget_settings.experiment.frames = 120;
    budget_settings.tracker_delay = from_milliseconds(latency_ms / 3.0);
    budget_settings.graphics_delay = from_milliseconds(latency_ms * 2.0 / 3.0);
    const RegistrationBudget budget = registration_budget(motion, budget_settings, scene);
    ResultJson row = {latency_ms};
    for (std::size_t i = 0; i < budget.parts.size(); ++i) {
      row.push_back(rounded(budget.parts[i].rms_arcmin));
      if (latency_ms > 0) continue;
      json["series"].push_back(
          {{"name", budget.parts[i].source}, {"style", styles.at(budget.parts[i].source)}, {"area", true}});
    }
    json["rows"].push_back(std::move(row));
  }
  return json;
}

Response response_at(double hz, double refresh_hz, const std::function<Rigid(const Motion&, HostTime)>& displayed) {
  constexpr double amplitude_deg = 1.0;
  const double seconds = std::max(2.0, 3.0 / hz);
  const auto motion = make_yaw_sine(hz, degrees(amplitude_deg), from_seconds(seconds + 0.5));
  Matrix2 normal = Matrix2::Zero();
  Vector2 moment = Vector2::Zero();
  for (double t = 0.3; t < 0.3 + seconds; t += 1.0 / refresh_hz) {
    const double yaw = so3::log<double>(displayed(*motion, time_at(t)).q()).y();
    const double angle = 2.0 * std::numbers::pi * hz * t;
    const Vector2 basis(std::sin(angle), std::cos(angle));
    normal += basis * basis.transpose();
    moment += basis * yaw;
  }
  const Vector2 fit = normal.ldlt().solve(moment);  // b sin + c cos
  return {fit.norm() / degrees(amplitude_deg).radians(), std::atan2(fit.y(), fit.x())};
}

namespace {

Response response_of(ExperimentSettings settings, double hz) {
  settings.known_poses.reset();  // of another motion
  std::optional<PipelinePoses> poses;
  return response_at(hz, settings.hmd.timing.refresh_hz, [&](const Motion& motion, HostTime t) {
    if (!poses) poses.emplace(motion, settings);
    return poses->displayed(t);
  });
}

/// Variants that show the same orientation: one predictor, one interval.
struct Alike {
  ExperimentSettings settings;
  std::string name;
  bool late = false;
  Pipeline first, last;

  /// With a closed form, if any.
  [[nodiscard]] std::optional<theory::Order> order() const {
    if (settings.interval_error != Duration{0}) return std::nullopt;
    return holdfast::detail::order_of(settings.pipeline);
  }
  [[nodiscard]] bool is_like(const ExperimentSettings& other) const {
    return prediction_of(other.pipeline) == prediction_of(settings.pipeline) &&
           prediction_interval(other) == prediction_interval(settings) &&
           other.interval_error == settings.interval_error;
  }
};

std::vector<Alike> alike(std::span<const ExperimentSettings> variants) {
  std::vector<Alike> all;
  for (const ExperimentSettings& variant : variants) {
    const auto like = std::find_if(all.begin(), all.end(), [&](const Alike& a) { return a.is_like(variant); });
    const bool late = deflection_of(variant).kind != DeflectionKind::none;
    if (like == all.end()) {
      all.push_back({variant, std::string(describe(variant.pipeline)), late, variant.pipeline, variant.pipeline});
    } else {
      like->last = std::max(like->last, variant.pipeline);
      like->first = std::min(like->first, variant.pipeline);
    }
  }
  for (Alike& a : all) {
    const std::string first(holdfast::name_of(a.first)), last(holdfast::name_of(a.last));
    if (a.late) a.name = "late pose";
    a.name = (a.first == a.last ? first : first + " to " + last) + ' ' + a.name;
    if (a.settings.interval_error != Duration{0}) a.name = variant_name(a.settings);
  }
  return all;
}

}  // namespace

std::vector<ResultJson> frequency_charts(std::span<const ExperimentSettings> variants) {
  const std::vector<Alike> responses = alike(variants);
  ResultJson gain, lag;
  for (ResultJson* chart : {&gain, &lag}) {
    (*chart)["x"] = axis("frequency", "Hz", true);
    (*chart)["series"] = ResultJson::array();
    (*chart)["rows"] = ResultJson::array();
    for (const Alike& r : responses) {
      const bool ablation = r.settings.interval_error != Duration{0};
      const std::string_view style = ablation ? "ablation" : holdfast::name_of(r.first);
      (*chart)["series"].push_back({{"name", r.name}, {"style", style}, {"points", true}});
      if (!r.order()) continue;
      (*chart)["series"].push_back({{"name", r.name + ", theory"}, {"style", style}, {"dashed", true}});
    }
  }
  gain["id"] = "gain";
  gain["title"] = "Gain per frequency";
  gain["caption"] =
      "Amplitude of the displayed motion over that of the head, for a small yaw of each frequency. Points are "
      "measured, lines are the closed forms: prediction exaggerates fast motion. A filter's answer depends on its "
      "settings "
      "and has no such form. A late pose is predicted over a few milliseconds only.";
  gain["y"] = axis("gain", "times");
  lag["id"] = "phase";
  lag["title"] = "Phase per frequency";
  lag["caption"] =
      "How far the displayed motion trails the head's, as an angle of the oscillation; zero would be in step.";
  lag["y"] = axis("phase", "\u00b0");
  lag["includeZero"] = true;
  constexpr int points = 40;
  for (int i = 0; i <= points; ++i) {
    const double hz = 0.2 * std::pow(50.0, static_cast<double>(i) / points);  // 0.2 to 10 Hz
    ResultJson gain_row = {rounded(hz)}, lag_row = {rounded(hz)};
    for (const Alike& r : responses) {
      const std::optional<theory::Order> order = r.order();
      const double interval_s = to_seconds(prediction_interval(r.settings));
      // Without a closed form the phase is taken near that of the same interval at constant velocity.
      const double phase_theory =
          std::arg(theory::response(order.value_or(theory::Order::constant_velocity), hz, interval_s)) -
          2.0 * std::numbers::pi * hz * interval_s;
      const bool shown = i % 2 == 0;
      Response response;
      if (shown) response = response_of(r.settings, hz);
      // The same turn as theory's: a phase is known up to whole turns.
      const double phase = phase_theory + std::remainder(response.phase_rad - phase_theory, 2.0 * std::numbers::pi);
      gain_row.push_back(shown ? rounded(response.gain) : ResultJson(nullptr));
      lag_row.push_back(shown ? rounded(radians(phase).degrees()) : ResultJson(nullptr));
      if (!order) continue;
      gain_row.push_back(rounded(theory::gain(*order, hz, interval_s)));
      lag_row.push_back(rounded(radians(phase_theory).degrees()));
    }
    gain["rows"].push_back(std::move(gain_row));
    lag["rows"].push_back(std::move(lag_row));
  }
  return {gain, lag};
}

}  // namespace swimlab
