/// Autocalibration of inertial sensors from any recording of tracker poses and inertial readings (001 section 5.2.3, appendix C).
///
///     const InertialCalibration found = calibrate_inertial(poses, readings);
///     if (!found.problem.empty()) ...                        // says why nothing could be found
///     found.gyro, found.gyro_fit.deviation(i), found.gyro_fit.unobserved, found.notes;
///     calibrated(reading, found.gyro, found.accelerometer);  // along the body's axes, by the tracker's clock
/// The wearer moves about as usual. Both of the paper's methods are there for gyros (differentiating_calibration.hpp,
/// integrating_calibration.hpp); accelerometers are calibrated by integrating, once the gyros are.
/// Nothing is tuned to a recording: noise is measured in it, and the covariances follow. What it does not tell (a still head tells no
/// orientation, scale or time) stays nominal, keeps its prior deviation, and is named in `unobserved`.
/// Covariances are those of white noise; the first three numbers are a turn about the sensors' own axes.
/// Bad input: see inertial_check.hpp; a gyro whose turning is not the poses' is refused; a clock that jumps is noted.
#pragma once

#include <numbers>

#include <holdfast/calibration/accelerometer_calibration.hpp>
#include <holdfast/calibration/differentiating_calibration.hpp>
#include <holdfast/calibration/inertial_check.hpp>

namespace holdfast {

enum class CalibrationMethod { differentiating, integrating };

[[nodiscard]] constexpr const char* name_of(CalibrationMethod method) {
  return method == CalibrationMethod::differentiating ? "differentiating" : "integrating";
}

struct InertialCalibrationSettings {
  CalibrationMethod method = CalibrationMethod::integrating;
  GyroPrior gyro;
  AccelerometerPrior accelerometer;
  double rate_window_s = 0.05;     ///< over which poses are differentiated
  double prediction_s = 0.1;       ///< over which readings are integrated: 001's 100 ms
  double longest_offset_s = 0.25;  ///< either way from the nominal one
};

struct InertialCalibration {
  std::string problem;                ///< why the gyros could not be calibrated; empty: they were
  std::string accelerometer_problem;  ///< the same of the accelerometers
  std::vector<std::string> notes;     ///< what was left out, and what looks odd
  GyroParameters gyro;
  ParameterFit gyro_fit;
  AccelerometerParameters accelerometer;
  ParameterFit accelerometer_fit;
  double turning = 0.0;    ///< by the gyros, RMS, rad/s
  double agreement = 0.0;  ///< of the gyros' turning with the poses', before calibration: 1 is all
};

namespace detail {

/// From rotation vectors, as the fit has them, to turns about the sensors' axes.
inline void express_turn_about_sensor(ParameterFit& fit) {
  Eigen::MatrixXd T = Eigen::MatrixXd::Identity(fit.x.size(), fit.x.size());
  T.topLeftCorner<3, 3>() = so3::right_jacobian<double>(fit.x.head<3>());
  fit.covariance = T * fit.covariance * T.transpose();
}

class InertialCalibrator {
 public:
  InertialCalibrator(std::span<const TimedPose> poses, std::span<const InertialReading> readings,
                     const InertialCalibrationSettings& settings)
      : settings_(settings), checked_(check_recording(poses, readings)) {}

  InertialCalibration run() {
    found_.gyro = settings_.gyro.nominal;
    found_.accelerometer = settings_.accelerometer.nominal;
    found_.problem = checked_.problem;
    found_.notes = checked_.notes;
    if (found_.problem.empty()) calibrate_gyro();
    found_.accelerometer_problem = checked_.problem;
    if (found_.accelerometer_problem.empty()) calibrate_accelerometer();
    return std::move(found_);
  }

 private:
  void calibrate_gyro() {
    if (!checked_.gyro.any()) return refuse("no gyro says anything");
    if (!checked_.gyro.complete() && settings_.method == CalibrationMethod::integrating) {
      return refuse("integrating needs all three gyros; differentiating does with fewer");
    }
    const std::vector<char> all(checked_.readings.size(), 1);
    const auto signal = signal_of(checked_, &InertialReading::rate_B, checked_.gyro, all);
    if (!signal) return refuse("too few readings");
    const PoseArrays poses(checked_.poses, checked_.poses.front().t);
    const double width = std::max(settings_.rate_window_s, 2.01 * to_seconds(median_interval(checked_.poses)));
    const double length = std::max(settings_.prediction_s, to_seconds(median_interval(checked_.poses)));
    std::optional<GyroStart> start = start_of_gyro(poses, *signal, settings_.gyro, width, settings_.longest_offset_s);
    if (!start) return refuse("too short: poses and readings have too little time in common without gaps");
    found_.turning = start->turning;
    found_.agreement = start->agreement;
    if (!(start->agreement > least_agreement)) {
      if (start->turning > 2.0 * least_turning) {
        return refuse(said("the gyros' turning is not the poses' within %.0f ms: they agree by %.2f, of 1 at most",
                           1e3 * settings_.longest_offset_s, start->agreement));
      }
      start = start_at(turn_rates(poses, *signal, width, settings_.gyro.nominal.time_offset_s, 0.0), poses, *signal,
                       settings_.gyro, settings_.gyro.nominal.time_offset_s);
      start->gyro.q_BS = settings_.gyro.nominal.q_BS;
      start->turning_axes_S.setZero();
    }
    const double ratio = start->turning / start->by_poses;
    if (start->agreement > least_agreement && !(ratio > 0.2 && ratio < 5.0)) {
      return refuse(said("the gyros turn %.3g times as much as the poses: another unit than rad/s?", ratio));
    }
    if (!checked_.gyro.complete()) start->turning_axes_S.setIdentity();
    turning_axes_S_ = start->turning_axes_S;
    const double axes = turning_axes_S_.trace();
    if (axes < 0.5) found_.notes.push_back("there is next to no rotation");
    if (axes > 0.5 && axes < 2.5) {
      found_.notes.push_back(axes < 1.5 ? "there is rotation about one axis alone"
                                        : "there is next to no rotation about one axis");
    }
    const Eigen::VectorXd x = to_vector(start->gyro, settings_.gyro.nominal.q_BS);
    if (settings_.method == CalibrationMethod::differentiating) {
      DifferentiatingModel model(poses, *signal, settings_.gyro, checked_.gyro.has_axis, width, *start);
      fit_gyro(model, x, poses);
    } else {
      IntegratingModel model(poses, *signal, settings_.gyro, length, *start);
      fit_gyro(model, x, poses);
    }
    if (found_.problem.empty()) note_clock_jumps(poses, *signal, width);
  }

  void fit_gyro(FitModel& model, const Eigen::VectorXd& start, const PoseArrays& poses) {
    ParameterFit fit = fit_parameters(model, start, poses.t);
    if (fit.comparisons < ParameterFit::least_comparisons) {
      return refuse(said("too short: %zu comparisons of poses and gyros", fit.comparisons));
    }
    if (!fit.ok) return refuse("the search for the gyros' parameters did not end");
    found_.gyro = gyro_of(fit.x, settings_.gyro.nominal.q_BS);
    express_turn_about_sensor(fit);
    found_.gyro_fit = std::move(fit);
  }

  /// Whether stretches of the recording agree better at another time offset.
  void note_clock_jumps(const PoseArrays& poses, const SensorSignal& signal, double width) {
    const double offset = found_.gyro.time_offset_s, longest = settings_.longest_offset_s, step = 0.005;
    const std::vector<TurnRate> rates = turn_rates(poses, signal, width, offset, 0.0);
    if (poses.t.back() - poses.t.front() < 2.0) return;
    const double stretch = std::clamp(0.1 * (poses.t.back() - poses.t.front()), 1.0, 10.0);
    const auto stretches = static_cast<std::size_t>((poses.t.back() - poses.t.front()) / stretch + 1e-9);
    const int steps = static_cast<int>(longest / step);
    std::vector<std::vector<double>> squares(stretches, std::vector<double>(static_cast<std::size_t>(2 * steps + 1)));
    std::vector<double> turning(stretches, 0.0);
    for (int k = -steps; k <= steps; ++k) {
      const SignalAtPoses at_poses(signal, poses, offset + k * step);
      for (const TurnRate& rate : rates) {
        const auto s =
            std::min(stretches - 1, static_cast<std::size_t>((poses.t[rate.window.first] - poses.t.front()) / stretch));
        const Vector3 unbiased =
            (averaged(at_poses.integral, rate.window) - found_.gyro.bias).cwiseQuotient(found_.gyro.scale);
        Vector3 difference = found_.gyro.q_BS.conjugate() * rate.rate_B - unbiased;
        for (int axis = 0; axis < 3; ++axis) {
          if (!checked_.gyro.has_axis[static_cast<std::size_t>(axis)]) difference[axis] = 0.0;
        }
        squares[s][static_cast<std::size_t>(k + steps)] += difference.squaredNorm();
        if (k == 0) turning[s] += rate.rate_B.squaredNorm();
      }
    }
    for (std::size_t s = 0; s < stretches; ++s) {
      const auto best = std::ranges::min_element(squares[s]) - squares[s].begin();
      const double at_offset = squares[s][static_cast<std::size_t>(steps)];
      // A tenth of the turning must be unexplained, and most of that by the time alone.
      if (std::abs(best - steps) < 2 || at_offset < 0.1 * turning[s]) continue;
      if (squares[s][static_cast<std::size_t>(best)] > 0.3 * at_offset) continue;
      found_.notes.push_back(said("the clocks jump: from %.1f to %.1f s readings lag by another %+.0f ms",
                                  stretch * static_cast<double>(s),
                                  std::min(stretch * static_cast<double>(s + 1), poses.t.back() - poses.t.front()),
                                  1e3 * step * static_cast<double>(best - steps)));
    }
  }

  void calibrate_accelerometer() {
    std::string& problem = found_.accelerometer_problem;
    if (!checked_.accelerometer.complete()) problem = "integrating needs all three accelerometers";
    if (!checked_.gyro.complete()) problem = "accelerometers need all three gyros";
    if (!found_.problem.empty() && problem.empty()) problem = "accelerometers need calibrated gyros";
    if (problem.empty() && turning_axes_S_.trace() < 0.5) {
      problem = "without rotation gravity cannot be told from biases and orientation";
    }
    if (!problem.empty()) return;
    const auto gyro = signal_of(checked_, &InertialReading::rate_B, checked_.gyro, checked_.accelerometer.usable);
    const auto force = signal_of(checked_, &InertialReading::force_B, checked_.accelerometer, checked_.gyro.usable);
    if (!gyro || !force) {
      problem = "too few readings";
      return;
    }
    const PoseArrays poses(checked_.poses, checked_.poses.front().t);
    const double length = std::max(settings_.prediction_s, to_seconds(median_interval(checked_.poses)));
    AccelerometerPrior prior = settings_.accelerometer;
    prior.nominal.q_BA = found_.gyro.q_BS;
    AccelerometerParameters sensors = start_of_accelerometer(poses, *force, found_.gyro.time_offset_s, prior);
    ParameterFit fit;
    for (int round = 0; round < 2; ++round) {  // of separate ones, the places' effect depends on the axes
      AccelerometerModel model(poses, *gyro, *force, found_.gyro, turning_axes_S_, prior, sensors.q_BA,
                               sensors.gravity_W, length);
      fit = fit_parameters(model, model.to_vector(sensors), poses.t);
      if (!fit.ok) break;
      sensors = model.parameters_of(fit.x);
      if (!prior.separate) break;
    }
    if (!fit.ok) {
      problem = fit.comparisons < ParameterFit::least_comparisons
                    ? said("too short: %zu comparisons of poses and accelerometers", fit.comparisons)
                    : "the search for the accelerometers' parameters did not end";
      return;
    }
    found_.accelerometer = sensors;
    express_turn_about_sensor(fit);
    found_.accelerometer_fit = std::move(fit);
  }

  void refuse(std::string problem) { found_.problem = std::move(problem); }

  static constexpr double least_agreement = 0.6;  ///< below, poses and gyros speak of different motions

  InertialCalibrationSettings settings_;
  CheckedRecording checked_;
  InertialCalibration found_;
  Matrix3 turning_axes_S_ = Matrix3::Zero();
};

}  // namespace detail

[[nodiscard]] inline InertialCalibration calibrate_inertial(std::span<const TimedPose> poses,
                                                            std::span<const InertialReading> readings,
                                                            const InertialCalibrationSettings& settings = {}) {
  return detail::InertialCalibrator(poses, readings, settings).run();
}

}  // namespace holdfast
