#include "charts.hpp"

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include <Eigen/Cholesky>

#include <holdfast/motion/generators.hpp>
#include <holdfast/prediction/predictor_theory.hpp>
#include <holdfast/registration/error_budget.hpp>
#include <holdfast/registration/experiment.hpp>
#include <holdfast/registration/pipeline_pose.hpp>

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

const char* title_of(Pipeline pipeline) {
  return pipeline == Pipeline::p0 ? "P0 no prediction" : "P1 constant velocity";
}

ResultJson axis(const char* label, const char* unit, bool log = false) {
  ResultJson json = {{"label", label}, {"unit", unit}};
  if (log) json["log"] = true;
  return json;
}

/// Amplitude and phase of a signal's component at a known frequency, by least squares: b sin + c cos.
struct Phasor {
  double gain = 0.0, phase_rad = 0.0;
};

/// Displayed over true yaw of a sine of frequency `hz`, as the pipeline shows it at the display's frames.
Phasor measured_response(const ExperimentSettings& settings, double hz) {
  constexpr double amplitude_deg = 1.0;
  const double seconds = std::max(2.0, 3.0 / hz);
  const auto motion = make_yaw_sine(hz, degrees(amplitude_deg), from_seconds(seconds + 0.5));
  Matrix2 normal = Matrix2::Zero();
  Vector2 moment = Vector2::Zero();
  const double period_s = 1.0 / settings.hmd.timing.refresh_hz;
  for (double t = 0.3; t < 0.3 + seconds; t += period_s) {
    const Rigid displayed = displayed_pose(*motion, settings, time_at(t));
    const double yaw = so3::log<double>(displayed.q()).y();
    const double angle = 2.0 * std::numbers::pi * hz * t;
    const Vector2 basis(std::sin(angle), std::cos(angle));
    normal += basis * basis.transpose();
    moment += basis * yaw;
  }
  const Vector2 fit = normal.ldlt().solve(moment);
  return {fit.norm() / degrees(amplitude_deg).radians(), std::atan2(fit.y(), fit.x())};
}

ResultJson time_chart(const std::vector<TimeSeries>& series, std::optional<double> FrameSample::*member) {
  ResultJson json;
  json["x"] = axis("time", "s");
  json["series"] = ResultJson::array();
  for (const TimeSeries& s : series) json["series"].push_back(pipeline_series(s.pipeline));
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

ResultJson pipeline_series(Pipeline pipeline) {
  return {{"name", title_of(pipeline)}, {"style", holdfast::name_of(pipeline)}};
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
  return json;
}

ResultJson swim_chart(const std::vector<TimeSeries>& series) {
  ResultJson json = time_chart(series, &FrameSample::swim_deg_s);
  json["id"] = "swim";
  json["title"] = "Swim velocity";
  json["caption"] = "How fast that error changes: the speed at which virtual discs slide over the real ones.";
  json["y"] = axis("swim", "\u00b0/s");
  return json;
}

ResultJson latency_chart(const Motion& motion, const ExperimentSettings& settings, std::span<const Pipeline> pipelines,
                         const RegistrationScene& scene) {
  ResultJson json;
  json["id"] = "latency";
  json["title"] = "Error against latency";
  json["caption"] =
      "Root mean square of all discs and frames, when the pose is older or has to be predicted further (as figure 7 of "
      "Azuma "
      "and Bishop 1994).";
  json["x"] = axis("latency", "ms");
  json["y"] = axis("RMS error", "px");
  json["series"] = ResultJson::array();
  for (const Pipeline pipeline : pipelines) json["series"].push_back(pipeline_series(pipeline));
  json["rows"] = ResultJson::array();
  for (int latency_ms = 0; latency_ms <= 120; latency_ms += 10) {
    ResultJson row = {latency_ms};
    for (const Pipeline pipeline : pipelines) {
      ExperimentSettings at = settings;
      at.pipeline = pipeline;
      at.latency = from_milliseconds(latency_ms);
      // The frames' errors are all that is needed here, not the row's other columns.
      double squares = 0.0;
      std::size_t count = 0;
      const std::size_t frames = frames_of(motion, at);
      const std::size_t stride = std::max<std::size_t>(1, frames / 300);
      const detail::FramePlanOfExperiment plan = detail::plan_frames(motion, at);
      detail::ExperimentRun run(motion, at, scene);
      for (std::size_t i = 0; i < frames; i += stride) {
        run.frame(i, plan.middle_of(i), [&](const FrameRecord& frame) {
          for (const FiducialRecord& f : frame.fiducials) {
            if (!f.visible) continue;
            squares += f.error_px.squaredNorm();
            ++count;
          }
        });
      }
      row.push_back(count == 0 ? ResultJson(nullptr) : rounded(std::sqrt(squares / static_cast<double>(count))));
    }
    json["rows"].push_back(std::move(row));
  }
  return json;
}

ResultJson budget_chart(const Motion& motion, const ExperimentSettings& settings, const RegistrationScene& scene) {
  ResultJson json;
  json["id"] = "budget";
  json["title"] = "Error budget";
  json["caption"] =
      "What each source of error does when it acts alone, without prediction, stacked (root mean squares). A third of "
      "the "
      "latency is the tracker's, the rest graphics and display; static is a tracker 2 mm off; lines scan out over 11.1 "
      "ms; the "
      "lens is corrected by the cubic of the course; viewing is an eye distance believed 2 mm too large.";
  json["x"] = axis("latency", "ms");
  json["y"] = axis("error", "arcmin");
  json["stacked"] = true;
  json["series"] = ResultJson::array();
  json["rows"] = ResultJson::array();
  constexpr const char* styles[] = {"c", "a", "b", "d", "e", "f"};
  for (int latency_ms = 0; latency_ms <= 100; latency_ms += 20) {
    BudgetSettings budget_settings;
    budget_settings.experiment = settings;
    budget_settings.experiment.pipeline = Pipeline::p0;
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
          {{"name", budget.parts[i].source}, {"style", styles[i % std::size(styles)]}, {"area", true}});
    }
    json["rows"].push_back(std::move(row));
  }
  return json;
}

std::vector<ResultJson> frequency_charts(const ExperimentSettings& settings, std::span<const Pipeline> pipelines) {
  const double interval_s = to_seconds(settings.latency);
  ResultJson gain, lag;
  for (ResultJson* chart : {&gain, &lag}) {
    (*chart)["x"] = axis("frequency", "Hz", true);
    (*chart)["series"] = ResultJson::array();
    (*chart)["rows"] = ResultJson::array();
    for (const Pipeline pipeline : pipelines) {
      ResultJson series = pipeline_series(pipeline);
      series["points"] = true;
      (*chart)["series"].push_back(series);
      (*chart)["series"].push_back({{"name", std::string(holdfast::name_of(pipeline)) + " by theory"},
                                    {"style", holdfast::name_of(pipeline)},
                                    {"dashed", true}});
    }
  }
  gain["id"] = "gain";
  gain["title"] = "Gain per frequency";
  gain["caption"] =
      "Amplitude of the displayed motion over that of the head, for a small yaw of each frequency. Points are "
      "measured, "
      "lines are the closed forms: prediction exaggerates fast motion.";
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
    for (const Pipeline pipeline : pipelines) {
      ExperimentSettings at = settings;
      at.pipeline = pipeline;
      const theory::Order order = pipeline == Pipeline::p0 ? theory::Order::none : theory::Order::constant_velocity;
      const double phase_theory =
          std::arg(theory::response(order, hz, interval_s)) - 2.0 * std::numbers::pi * hz * interval_s;
      const bool shown = i % 2 == 0;
      Phasor phasor;
      if (shown) phasor = measured_response(at, hz);
      // The same turn as theory's: a phase is known up to whole turns.
      const double phase = phase_theory + std::remainder(phasor.phase_rad - phase_theory, 2.0 * std::numbers::pi);
      gain_row.push_back(shown ? rounded(phasor.gain) : ResultJson(nullptr));
      gain_row.push_back(rounded(theory::gain(order, hz, interval_s)));
      lag_row.push_back(shown ? rounded(radians(phase).degrees()) : ResultJson(nullptr));
      lag_row.push_back(rounded(radians(phase_theory).degrees()));
    }
    gain["rows"].push_back(std::move(gain_row));
    lag["rows"].push_back(std::move(lag_row));
  }
  return {gain, lag};
}

}  // namespace swimlab
