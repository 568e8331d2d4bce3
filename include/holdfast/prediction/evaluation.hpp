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
/// and the result is compared with the truth at t_i + interval: by default the recording itself, interpolated (linear,
/// constant rate), or a truth of your own, such as its non-causal 10 Hz low-pass (001 appendix B).
///   angle error     angle of R_true^-1 R_predicted, degrees (001 section 5.3 prints 2 cos(qw) for 2 acos(|qw|))
///   position error  |p_predicted - p_true|, millimetres
///   inside_95       how many errors lie inside the ellipsoid that should hold 95 % of them, %; the filters' ellipsoids
/// by the
///                   noise of the truth larger
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

#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/motion/sampled_trajectory.hpp>
#include <holdfast/prediction/error_statistics.hpp>
#include <holdfast/prediction/inertial_predictor.hpp>
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
  Spectrum angle_spectrum;              ///< of the orientation error, 0.5 to 15 Hz, rad^2/Hz
  std::optional<double> inside_95_pct;  ///< nothing where no covariance is predicted
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

/// Finds, for times that mostly increase, the pose of a recording; remembers where it was.
class Walker {
 public:
  explicit Walker(std::span<const TimedPose> samples) : samples_(samples) {}

  /// Precondition: t within the samples' times. Quick where it is near the last one asked.
  [[nodiscard]] Rigid at(HostTime t) {
    while (next_ + 1 < samples_.size() && samples_[next_].t < t) ++next_;
    while (next_ > 1 && samples_[next_ - 1].t > t) --next_;
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

/// Collects one row.
struct RowRecorder {
  PredictorRow row;
  std::vector<Vector3> error_vectors;
  std::size_t judged = 0, inside = 0;

  void add(const PredictionResult& predicted, const Rigid& X_WB_true, const PoseNoise& truth = {0.0, 0.0}) {
    row.errors.push_back(error_of(predicted, X_WB_true));
    const Vector3 turned = so3::log<double>(predicted.X_WB.q().conjugate() * X_WB_true.q());
    error_vectors.push_back(turned);
    Matrix6 covariance = predicted.covariance;
    add_isotropic(covariance, truth.position_m, truth.orientation_rad);
    Matrix6 L;
    if (!cholesky<6>(covariance, L)) return;
    Vector6 error;
    error << X_WB_true.p() - predicted.X_WB.p(), turned;
    ++judged;
    inside += squared_distance<6>(L, error) < 12.592 ? 1 : 0;  // 95 % of chi-squared with 6 degrees of freedom
  }

  [[nodiscard]] PredictorRow finish(double rate_hz) && {
    std::vector<double> series(row.errors.size());
    std::ranges::transform(row.errors, series.begin(), &PredictionError::angle_deg);
    row.angle_deg = statistics_of(series);
    std::ranges::transform(row.errors, series.begin(), &PredictionError::position_mm);
    row.position_mm = statistics_of(series);
    const std::optional<double> jitter_rad = band_rms<3>(error_vectors, rate_hz);
    row.angle_spectrum = power_spectrum<3>(error_vectors, rate_hz, FrequencyBand{0.5, 15.0});
    if (jitter_rad) row.jitter_arcmin = radians(*jitter_rad).arcmin();
    if (judged > 0) row.inside_95_pct = 100.0 * static_cast<double>(inside) / static_cast<double>(judged);
    return std::move(row);
  }
};

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
  detail::Walker known(samples), known_before(samples), future(truth);
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
    const Rigid X_WB_true = future.at(target);
    for (std::size_t k = 0; k < predictors.size(); ++k) {
      rows[k].add(predict(predictors[k], estimate, target, settings.limits), X_WB_true);
    }
    const StatePredictionLimits limits{settings.limits.maximum_interval};
    rows[2].add(predict_state(filter.state(), filter.model(), target, limits), X_WB_true,
                settings.truth_noise.value_or(settings.filter.noise));
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
    rows[6].add(predicted, X_WB_true, settings.truth_noise.value_or(inertial->predictor().filter().pose_noise()));
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
