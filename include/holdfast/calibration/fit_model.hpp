/// What is fitted: parameters with a nominal value each, and comparisons that should be zero; and what a fit finds.
///
/// Each comparison gives three numbers r_i(x) and J_i = dr_i/dx. It reaches over a window of the tracker's poses, by whose weights
/// their noise enters r_i. parameter_fit.hpp does the fitting.
#pragma once

#include <cmath>
#include <string>
#include <vector>

#include <Eigen/Core>

#include <holdfast/calibration/inertial_signal.hpp>

namespace holdfast {

struct FitParameter {
  std::string name, unit;
  double nominal = 0.0, deviation = 1.0;
};

class FitModel {
 public:
  using Jacobian = Eigen::Matrix<double, 3, Eigen::Dynamic>;

  virtual ~FitModel() = default;
  [[nodiscard]] virtual const std::vector<FitParameter>& parameters() const = 0;
  [[nodiscard]] virtual const std::vector<PoseWindow>& windows() const = 0;
  /// Called before `compare` for each new x.
  virtual void prepare(const Eigen::VectorXd& x) = 0;
  virtual void compare(std::size_t i, Vector3& r, Jacobian& J) const = 0;
  /// Whether J is to be made of motion that surely is one, and not of what may be noise: it says then what can be found at all.
  virtual void count_sure_motion_alone(bool) {}
  [[nodiscard]] virtual int used_axes() const { return 3; }    ///< numbers of r that are not always zero
  [[nodiscard]] virtual int sensor_sums() const { return 1; }  ///< 1 a rate, 2 an acceleration
};

struct ParameterFit {
  static constexpr std::size_t least_comparisons = 20;

  bool ok = false;
  Eigen::VectorXd x;
  Eigen::MatrixXd covariance;
  std::vector<FitParameter> parameters;
  std::vector<std::string> unobserved;  ///< directions that the recording does not tell, in words
  double rms = 0.0;                     ///< of a residual's numbers, in their unit
  double pose_noise = 0.0;              ///< deviation, for each number of a pose
  double sensor_noise = 0.0;            ///< density, of the sensor
  double excess = 1.0;                  ///< deviation of what the tenths of the recording say, by that of white noise
  std::size_t comparisons = 0, outliers = 0;
  int iterations = 0;

  [[nodiscard]] double deviation(int i) const { return std::sqrt(covariance(i, i)); }
  /// Whether the recording tells it at least twice as well as it was known before.
  [[nodiscard]] bool observed(int i) const {
    return deviation(i) < 0.5 * parameters[static_cast<std::size_t>(i)].deviation;
  }
};

}  // namespace holdfast
