/// How well predictors would have done on a recording: 001's figure 6 on any samples.
///
/// At every sample i the tracker knows samples 0..i. Each predictor extrapolates over the interval:
///   none, constant_velocity   the velocity is the backward difference of sample i and the recording 16.7 ms earlier
///                             (interpolated between known samples; where samples are rarer, the sample before)
///   kalman                    a filter of all samples since the last gap (pose_filter.hpp), carried on by its model
///   constant_acceleration     that velocity, and the difference to the one of the window before it
/// and, where inertial readings are given, stamped by the samples' clock (and coming when that says so; found to be
/// stamped too early, as much later),
///   gyro                      the orientation turns on at the newest reading's rate, the place moves at that velocity
///   gyro_acceleration         and at the difference of the two newest rates
///   kalman_inertial           InertialPredictor, of all samples and readings
/// and the result is compared with the truth at t_i + interval: by default the recording itself, between its samples as
/// in recorded_truth.hpp, or a truth of your own, such as its non-causal 10 Hz low-pass (001 appendix B).
///   angle error     angle of R_true^-1 R_predicted, degrees (001 section 5.3 prints 2 cos(qw) for 2 acos(|qw|))
///   position error  |p_predicted - p_true|, millimetres
///   inside_95       how many errors lie inside the ellipsoid that should hold 95 % of them, %; the filters' ellipsoids
///                   by the noise of the truth larger
///
/// A sample is left out when a gap (an interval longer than five medians) lies between its velocity's start and its
/// truth, or when the recording ends before: counted in `skipped`. All rows speak of the same samples, in the order
/// above.
/// Precondition: samples' times strictly increase. Bad input: fewer samples than one evaluation needs gives rows of
/// zero samples.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/prediction/error_recorder.hpp>
#include <holdfast/prediction/inertial_predictor.hpp>
#include <holdfast/prediction/predictor.hpp>
#include <holdfast/prediction/recorded_truth.hpp>
#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/tracking/backward_difference.hpp>
#include <holdfast/tracking/pose_filter.hpp>

namespace holdfast {

struct EvaluationSettings {
  Duration interval = std::chrono::milliseconds(60);
  Duration velocity_window = std::chrono::microseconds(16700);
  /// An evaluation shall show what a long interval does, not the clamp.
  PredictionLimits limits{std::chrono::hours(1)};
  // Of the Kalman filter.
  PvaModel model = head_model();
  PoseFilterSettings filter;
  /// In the order of their times; none: no rows of inertial predictors.
  std::span<const InertialReading> inertial;
  /// Of the truth, independent of the samples'. Nothing: it is measured as they are, as noisy as a filter takes them
  /// for.
  std::optional<PoseNoise> truth_noise;
};

/// Names of the rows, in their order; the last three only with inertial readings.
inline constexpr std::array<std::string_view, 7> evaluated_predictors{to_string(Predictor::none),
                                                                      to_string(Predictor::constant_velocity),
                                                                      "kalman",
                                                                      "constant_acceleration",
                                                                      "gyro",
                                                                      "gyro_acceleration",
                                                                      "kalman_inertial"};
inline constexpr std::size_t inertial_predictors = 3;

struct PredictorEvaluation {
  Duration interval{0};
  std::size_t skipped = 0;  ///< samples without truth or across a gap
  std::vector<PredictorRow> rows;
  /// Of kalman_inertial, at the end: what it found out about the sensors, and how many predictions it left to the
  /// poses.
  InertialState sensors;
  std::size_t by_poses = 0;
};

namespace detail {

/// A predicted pose without covariance.
[[nodiscard]] inline PredictionResult bare_prediction(const Rigid& X_WB, HostTime t) {
  PredictionResult result;
  result.t = t;
  result.X_WB = X_WB;
  return result;
}

/// From velocity and acceleration: p + v T + a T^2 / 2, R exp(w T + alpha T^2 / 2).
[[nodiscard]] inline PredictionResult extrapolated(const PoseEstimate& estimate, const Twist& velocity,
                                                   const TwistRate& acceleration, HostTime t) {
  const double T = to_seconds(t - estimate.t), half = 0.5 * T * T;
  const Vector3 turn = T * velocity.w_WB_B + half * acceleration.alpha_WB_B;
  return bare_prediction(Rigid(estimate.X_WB.q() * so3::exp<double>(turn),
                               estimate.X_WB.p() + T * velocity.v_WB + half * acceleration.a_WB),
                         t);
}

/// `earlier` is the velocity of a window that ends where the newer one's begins, `window` seconds before.
[[nodiscard]] inline PredictionResult predict_constant_acceleration(const PoseEstimate& newer, const Twist& earlier,
                                                                    double window, HostTime t) {
  const TwistRate rate{(newer.velocity->v_WB - earlier.v_WB) / window,
                       (newer.velocity->w_WB_B - earlier.w_WB_B) / window};
  const Twist at_end{newer.velocity->v_WB + 0.5 * window * rate.a_WB,
                     newer.velocity->w_WB_B + 0.5 * window * rate.alpha_WB_B};
  return extrapolated(newer, at_end, rate, t);
}

/// The two newest readings that have a rate, and the predictor that has all until then.
class InertialFollower {
 public:
  InertialFollower(std::span<const InertialReading> readings, const EvaluationSettings& settings)
      : readings_(readings), predictor_(predictor_settings(settings)) {}

  void follow(const TimedPose& pose) {
    const HostTime until = pose.t + ahead();
    for (; next_ < readings_.size() && readings_[next_].t <= until; ++next_) {
      const InertialReading& reading = readings_[next_];
      predictor_.update(reading);
      if (!reading.has_rate() || !is_usual(reading.t)) continue;
      before_ = has_rate_ ? newest_ : reading;
      newest_ = reading;
      has_rate_ = true;
    }
    predictor_.update(pose);
  }
  [[nodiscard]] const Vector3& rate() const { return newest_.rate_B; }
  [[nodiscard]] Vector3 raw_acceleration() const {
    if (newest_.t <= before_.t) return Vector3::Zero();
    return (newest_.rate_B - before_.rate_B) / to_seconds(newest_.t - before_.t);
  }
  [[nodiscard]] const InertialPredictor& predictor() const { return predictor_; }

 private:
  /// A clock that is behind stamps what has not happened yet by the poses': such readings come later.
  [[nodiscard]] Duration ahead() const {
    const Duration offset = predictor_.filter().time_offset();
    return offset < -std::chrono::microseconds(500) ? offset : Duration{0};
  }
  static InertialPredictorSettings predictor_settings(const EvaluationSettings& settings) {
    InertialPredictorSettings inertial;
    inertial.model = settings.model;
    inertial.poses = settings.filter;
    inertial.limits.future = settings.limits.maximum_interval;
    return inertial;
  }

  std::span<const InertialReading> readings_;
  InertialPredictor predictor_;
  std::size_t next_ = 0;
  InertialReading before_, newest_;
  bool has_rate_ = false;
};

}  // namespace detail

/// Evaluates every predictor on `samples` against `truth`, whose times must cover the samples'.
[[nodiscard]] inline PredictorEvaluation evaluate_predictors(std::span<const TimedPose> samples,
                                                             std::span<const TimedPose> truth,
                                                             const EvaluationSettings& settings = {}) {
  PredictorEvaluation evaluation;
  evaluation.interval = settings.interval;
  const std::size_t count = evaluated_predictors.size() - (settings.inertial.empty() ? inertial_predictors : 0);
  std::vector<detail::RowRecorder> rows(count);
  for (std::size_t k = 0; k < count; ++k) {
    rows[k].row.predictor = evaluated_predictors[k];
    rows[k].row.errors.reserve(samples.size());
  }
  const auto finish = [&](double rate_hz) {
    for (detail::RowRecorder& row : rows) evaluation.rows.push_back(std::move(row).finish(rate_hz));
    return evaluation;
  };
  if (samples.empty() || truth.size() < 2) {
    evaluation.skipped = samples.size();
    return finish(0.0);
  }
  evaluation.skipped = 1;  // the first sample has no velocity
  const Duration usual = median_interval(samples);
  const detail::Stretches stretches(samples, 5 * usual);
  detail::Walker known(samples), known_before(samples);
  detail::RecordedTruth future(truth);
  PoseFilter<3> filter(settings.model, settings.filter);
  filter.start(samples[0]);
  std::optional<detail::InertialFollower> inertial;
  if (!settings.inertial.empty()) inertial.emplace(settings.inertial, settings).follow(samples[0]);
  for (std::size_t i = 1; i < samples.size(); ++i) {
    if (stretches.first[i] == samples[i].t) {
      filter.start(samples[i]);
    } else {
      filter.update(samples[i]);
    }
    if (inertial) inertial->follow(samples[i]);
    const HostTime t = samples[i].t, target = t + settings.interval;
    const HostTime earlier = std::min(t - settings.velocity_window, samples[i - 1].t);
    if (earlier < stretches.first[i] || target > stretches.last[i] || target > truth.back().t) {
      ++evaluation.skipped;
      continue;
    }
    const TimedPose before{earlier, known.at(earlier)};
    const PoseEstimate estimate = backward_difference(before, samples[i]);
    const detail::TrueMoment true_moment = future.at(target);
    const Rigid& X_WB_true = true_moment.X_WB;
    for (std::size_t k = 0; k < predictors.size(); ++k) {
      rows[k].add(predict(predictors[k], estimate, target, settings.limits), X_WB_true);
    }
    const StatePredictionLimits limits{settings.limits.maximum_interval};
    rows[2].add(predict_state(filter.state(), filter.model(), target, limits), X_WB_true,
                true_moment.noisy(settings.truth_noise.value_or(settings.filter.noise)));
    // A window earlier; where the stretch begins later, the velocity is taken for constant.
    const HostTime earliest = std::max(earlier - (t - earlier), stretches.first[i]);
    const Twist velocity_before = earliest < earlier
                                      ? *backward_difference({earliest, known_before.at(earliest)}, before).velocity
                                      : *estimate.velocity;
    rows[3].add(detail::predict_constant_acceleration(estimate, velocity_before, to_seconds(t - earlier), target),
                X_WB_true);
    if (!inertial) continue;
    const Twist by_gyro{estimate.velocity->v_WB, inertial->rate()};
    rows[4].add(detail::extrapolated(estimate, by_gyro, {}, target), X_WB_true);
    rows[5].add(detail::extrapolated(estimate, by_gyro, {Vector3::Zero(), inertial->raw_acceleration()}, target),
                X_WB_true);
    const InertialPrediction predicted = inertial->predictor().predict(target);
    rows[6].add(predicted, X_WB_true,
                true_moment.noisy(settings.truth_noise.value_or(inertial->predictor().filter().pose_noise())));
    evaluation.by_poses += predicted.by == PredictedBy::inertial ? 0 : 1;
  }
  if (inertial) evaluation.sensors = inertial->predictor().filter().state();
  return finish(usual > Duration{0} ? 1.0 / to_seconds(usual) : 0.0);
}

/// The same with the recording itself as the truth.
[[nodiscard]] inline PredictorEvaluation evaluate_predictors(std::span<const TimedPose> samples,
                                                             const EvaluationSettings& settings = {}) {
  return evaluate_predictors(samples, samples, settings);
}

}  // namespace holdfast
