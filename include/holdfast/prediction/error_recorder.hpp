/// Collects the errors of one predictor over a recording, and sums them up.
///
/// Units: of what is summed up, degrees and millimetres (001's). Bad input: precondition finite poses; a prediction without
/// covariance, all zeros, is not judged; one whose covariance is not positive definite counts as outside.
#pragma once

#include <algorithm>
#include <optional>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/geometry/angle.hpp>
#include <holdfast/geometry/cholesky.hpp>
#include <holdfast/prediction/error_statistics.hpp>
#include <holdfast/prediction/jitter.hpp>
#include <holdfast/prediction/predictor.hpp>

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

namespace detail {

[[nodiscard]] inline PredictionError error_of(const PredictionResult& predicted, const Rigid& X_WB_true) {
  PredictionError error;
  error.t = predicted.t;
  error.angle_deg = radians(so3::angle_between<double>(X_WB_true.q(), predicted.X_WB.q())).degrees();
  error.position_mm = 1e3 * (predicted.X_WB.p() - X_WB_true.p()).norm();
  error.X_WB_predicted = predicted.X_WB;
  error.X_WB_true = X_WB_true;
  return error;
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
    if (predicted.covariance.isZero(0.0)) return;
    Vector6 error;
    error << X_WB_true.p() - predicted.X_WB.p(), turned;
    ++judged;                         // a covariance that is none holds nothing
    constexpr double limit = 12.592;  // 95 % of chi-squared with 6 degrees of freedom
    inside += cholesky<6>(covariance, L) && squared_distance<6>(L, error) < limit ? 1 : 0;
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

}  // namespace detail

}  // namespace holdfast
