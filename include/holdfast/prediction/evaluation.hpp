/// How well predictors would have done on a recording: 001's figure 6 on any samples.
///
/// At every sample i the tracker knows samples 0..i. Each predictor extrapolates over the interval:
///   none, constant_velocity   the velocity is the backward difference of sample i and the recording 16.7 ms earlier
///                             (interpolated between known samples; where samples are rarer, the sample before)
///   kalman                    a filter of all samples since the last gap (pose_filter.hpp), carried on by its model
/// and the result is compared with the truth at t_i + interval: by default the recording itself, interpolated (linear,
/// constant rate), or a truth of your own, such as its non-causal 10 Hz low-pass (001 appendix B).
///   angle error     angle of R_true^-1 R_predicted, degrees (001 section 5.3 prints 2 cos(qw) for 2 acos(|qw|))
///   position error  |p_predicted - p_true|, millimetres
///
/// A sample is left out when a gap (an interval longer than five medians) lies between its velocity's start and its
/// truth, or when the recording ends before: counted in `skipped`. All rows speak of the same samples, in the order above.
/// Precondition: samples' times strictly increase. Bad input: fewer samples than one evaluation needs gives rows of
/// zero samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>
#include <holdfast/prediction/error_statistics.hpp>
#include <holdfast/prediction/jitter.hpp>
#include <holdfast/prediction/predictor.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/tracking/backward_difference.hpp>
#include <holdfast/tracking/pose_filter.hpp>

namespace holdfast {

/// One prediction and its error; with both poses, so that errors on a screen can be had from them too.
struct PredictionError {
  HostTime t;  ///< the time predicted for
  double angle_deg = 0.0;
  double position_mm = 0.0;
  Rigid X_WB_predicted, X_WB_true;
};

struct PredictorRow {
  std::string_view predictor;  ///< its name in results
  ErrorStatistics angle_deg, position_mm;
  /// Orientation error between 3 and 12 Hz, root mean square (jitter.hpp). Errors count as evenly spaced by the median
  /// interval, also across what was skipped. Nothing for less than 1 s of them.
  std::optional<double> jitter_arcmin;
  std::vector<PredictionError> errors;
};

struct EvaluationSettings {
  Duration interval = std::chrono::milliseconds(60);
  Duration velocity_window = std::chrono::microseconds(16700);
  /// An evaluation shall show what a long interval does, not the clamp.
  PredictionLimits limits{std::chrono::hours(1)};
  // Of the Kalman filter.
  PvaModel model = head_model();
  PoseFilterSettings filter;
};

/// Names of the rows, in their order.
inline constexpr std::array<std::string_view, 3> evaluated_predictors{
    to_string(Predictor::none), to_string(Predictor::constant_velocity), "kalman"};

struct PredictorEvaluation {
  Duration interval{0};
  std::size_t skipped = 0;  ///< samples without truth or across a gap
  std::vector<PredictorRow> rows;
};

namespace detail {

/// Finds, for times that only increase, the pose of a recording; remembers where it was.
class Walker {
 public:
  explicit Walker(std::span<const TimedPose> samples) : samples_(samples) {}

  /// Precondition: t within the samples' times, not before the last one asked.
  [[nodiscard]] Rigid at(HostTime t) {
    while (next_ + 1 < samples_.size() && samples_[next_].t < t) ++next_;
    const TimedPose& b = samples_[next_];
    if (b.t == t || next_ == 0) return b.X_WB;
    const TimedPose& a = samples_[next_ - 1];
    return interpolate(a.X_WB, b.X_WB, to_seconds(t - a.t) / to_seconds(b.t - a.t));
  }

 private:
  std::span<const TimedPose> samples_;
  std::size_t next_ = 1;
};

/// For each sample the time at which its stretch without gaps begins and ends.
struct Stretches {
  std::vector<HostTime> first, last;

  Stretches(std::span<const TimedPose> samples, Duration longest) : first(samples.size()), last(samples.size()) {
    const std::size_t n = samples.size();
    for (std::size_t i = 0; i < n; ++i) {
      first[i] = i > 0 && samples[i].t - samples[i - 1].t <= longest ? first[i - 1] : samples[i].t;
    }
    for (std::size_t i = n; i-- > 0;) {
      last[i] = i + 1 < n && samples[i + 1].t - samples[i].t <= longest ? last[i + 1] : samples[i].t;
    }
  }
};

[[nodiscard]] inline PredictionError error_of(const PredictionResult& predicted, const Rigid& X_WB_true) {
  PredictionError error;
  error.t = predicted.t;
  error.angle_deg = radians(so3::angle_between<double>(X_WB_true.q(), predicted.X_WB.q())).degrees();
  error.position_mm = 1e3 * (predicted.X_WB.p() - X_WB_true.p()).norm();
  error.X_WB_predicted = predicted.X_WB;
  error.X_WB_true = X_WB_true;
  return error;
}

}  // namespace detail

/// Evaluates every predictor on `samples` against `truth`, whose times must cover the samples'.
[[nodiscard]] inline PredictorEvaluation evaluate_predictors(std::span<const TimedPose> samples,
                                                             std::span<const TimedPose> truth,
                                                             const EvaluationSettings& settings = {}) {
  PredictorEvaluation evaluation;
  evaluation.interval = settings.interval;
  for (const std::string_view name : evaluated_predictors) {
    evaluation.rows.emplace_back();
    evaluation.rows.back().predictor = name;
    evaluation.rows.back().errors.reserve(samples.size());
  }
  if (samples.empty() || truth.size() < 2) {
    evaluation.skipped = samples.size();
    return evaluation;
  }
  evaluation.skipped = 1;  // the first sample has no velocity
  std::array<std::vector<Vector3>, evaluated_predictors.size()> error_vectors;
  const Duration usual = median_interval(samples);
  const double rate_hz = usual > Duration{0} ? 1.0 / to_seconds(usual) : 0.0;
  const detail::Stretches stretches(samples, 5 * usual);
  detail::Walker known(samples), future(truth);
  PoseFilter<3> filter(settings.model, settings.filter);
  filter.start(samples[0]);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (stretches.first[i] == samples[i].t) {
      filter.start(samples[i]);
    } else {
      filter.update(samples[i]);
    }
    const HostTime target = samples[i].t + settings.interval;
    const HostTime earlier = std::min(samples[i].t - settings.velocity_window, samples[i - 1].t);
    if (earlier < stretches.first[i] || target > stretches.last[i] || target > truth.back().t) {
      ++evaluation.skipped;
      continue;
    }
    const PoseEstimate estimate = backward_difference({earlier, known.at(earlier)}, samples[i]);
    const Rigid X_WB_true = future.at(target);
    const auto add = [&](std::size_t row, const PredictionResult& predicted) {
      evaluation.rows[row].errors.push_back(detail::error_of(predicted, X_WB_true));
      error_vectors[row].push_back(so3::log<double>(X_WB_true.q().conjugate() * predicted.X_WB.q()));
    };
    for (std::size_t k = 0; k < predictors.size(); ++k) {
      add(k, predict(predictors[k], estimate, target, settings.limits));
    }
    const StatePredictionLimits limits{settings.limits.maximum_interval};
    add(predictors.size(), predict_state(filter.state(), filter.model(), target, limits));
  }
  for (std::size_t k = 0; k < evaluation.rows.size(); ++k) {
    PredictorRow& row = evaluation.rows[k];
    std::vector<double> series(row.errors.size());
    std::ranges::transform(row.errors, series.begin(), &PredictionError::angle_deg);
    row.angle_deg = statistics_of(series);
    std::ranges::transform(row.errors, series.begin(), &PredictionError::position_mm);
    row.position_mm = statistics_of(series);
    const std::optional<double> jitter_rad = band_rms<3>(error_vectors[k], rate_hz);
    if (jitter_rad) row.jitter_arcmin = radians(*jitter_rad).arcmin();
  }
  return evaluation;
}

/// The same with the recording itself as the truth.
[[nodiscard]] inline PredictorEvaluation evaluate_predictors(std::span<const TimedPose> samples,
                                                             const EvaluationSettings& settings = {}) {
  return evaluate_predictors(samples, samples, settings);
}

}  // namespace holdfast
