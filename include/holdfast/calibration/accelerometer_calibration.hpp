/// Calibrates accelerometers by integrating (001 appendix C, the second method), with gyros that are calibrated.
///
/// A window is three poses, a, m and b, h1 and h2 apart (about 100 ms each). The first stretch gives the velocity at m that no
/// tracker measures, the second is predicted:
///   p_b = p_m + h2/h1 (p_m - p_a) + h2 (h1 + h2)/2 g + h2 R_a (dv_am - dp_am / h1) + R_m dp_mb
/// with dv, dp the single and double integral of the specific force of B's origin, as seen from B at the stretch's begin:
///   f_B = R_BA (z - b) / k - sum_i u_i u_i^T (w' x l_i + w x (w x l_i)),   u_i the i-th column of R_BA      (001 appendix A)
/// R and w are the gyros' within a stretch and the tracker's at its begin, so that drift has 100 ms to grow. All but u_i enters by
/// straight lines: each window is integrated once, and not again while the parameters change.
/// x = (rotation vector from nominal, bias, scale, |g|, tilt of g about two axes, l: three numbers of a triad, or nine).
/// |g| is known to 0.03 m/s^2 anywhere on earth; a scale is known no better, but for what the tracker says of motion.
#pragma once

#include <holdfast/calibration/accelerometer_start.hpp>
#include <holdfast/calibration/integrating_calibration.hpp>

namespace holdfast {

namespace detail {

[[nodiscard]] inline std::vector<FitParameter> accelerometer_fit_parameters(const AccelerometerPrior& prior) {
  std::vector<FitParameter> parameters;
  const std::string xyz = "xyz";
  for (const char axis : xyz) {
    parameters.push_back({std::string("accelerometer orientation ") + axis, "rad", 0.0, prior.orientation_rad});
  }
  const AccelerometerParameters& nominal = prior.nominal;
  for (int i = 0; i < 3; ++i) {
    parameters.push_back({std::string("accelerometer bias ") + xyz[i], "m/s^2", nominal.bias[i], prior.bias});
  }
  for (int i = 0; i < 3; ++i) {
    parameters.push_back({std::string("accelerometer scale ") + xyz[i], "1", nominal.scale[i], prior.scale});
  }
  parameters.push_back({"gravity", "m/s^2", nominal.gravity_W.norm(), prior.gravity});
  parameters.push_back({"gravity tilt 1", "rad", 0.0, prior.gravity_tilt_rad});
  parameters.push_back({"gravity tilt 2", "rad", 0.0, prior.gravity_tilt_rad});
  for (std::size_t i = 0; i < (prior.separate ? 3u : 1u); ++i) {
    for (int j = 0; j < 3; ++j) {
      std::string name = "accelerometer place ";
      if (prior.separate) name += xyz[i] + std::string(" along ");
      parameters.push_back({name + xyz[j], "m", nominal.places_B[i][j], prior.place_m});
    }
  }
  return parameters;
}

}  // namespace detail

class AccelerometerModel : public FitModel {
 public:
  /// What is integrated: R e_i z_j (3 j + i), R (9 + i), R u_i u_i^T times the places' effect (12 + 3 i + j).
  using Basis = Eigen::Matrix<double, 3, 21, Eigen::DontAlign>;

  /// `down_W`: where gravity is sought from, its tilt being nil. `q_BA`: u_i. The signals share their times. Turning about
  /// other axes than `turning_axes_S` is noise: it moves no sensor that sits off the origin.
  AccelerometerModel(const PoseArrays& poses, const SensorSignal& gyro, const SensorSignal& accelerometer,
                     const GyroParameters& turns, const Matrix3& turning_axes_S, const AccelerometerPrior& prior,
                     const Quaternion& q_BA, const Vector3& down_W, double length)
      : turning_axes_B_(turns.q_BS.toRotationMatrix() * turning_axes_S * turns.q_BS.toRotationMatrix().transpose()),
        nominal_(prior.nominal.q_BA),
        down_W_(down_W.normalized()),
        separate_(prior.separate) {
    parameters_ = detail::accelerometer_fit_parameters(prior);
    int least = 0;
    down_W_.cwiseAbs().minCoeff(&least);
    tilt_axes_.col(0) = down_W_.cross(Vector3(Vector3::Unit(least))).normalized();
    tilt_axes_.col(1) = down_W_.cross(Vector3(tilt_axes_.col(0)));
    add_windows(poses, gyro, accelerometer, turns, q_BA.toRotationMatrix(), length);
  }

  [[nodiscard]] const std::vector<FitParameter>& parameters() const override { return parameters_; }
  [[nodiscard]] const std::vector<PoseWindow>& windows() const override { return windows_; }
  [[nodiscard]] int sensor_sums() const override { return 2; }

  [[nodiscard]] AccelerometerParameters parameters_of(const Eigen::VectorXd& x) const {
    AccelerometerParameters sensors;
    sensors.q_BA = (nominal_ * so3::exp<double>(x.head<3>())).normalized();
    sensors.bias = x.segment<3>(3);
    sensors.scale = x.segment<3>(6);
    const Vector3 tilt = tilt_axes_ * x.segment<2>(10);
    sensors.gravity_W = x[9] * (so3::exp<double>(tilt) * down_W_);
    for (std::size_t i = 0; i < 3; ++i) sensors.places_B[i] = x.segment<3>(12 + (separate_ ? 3 * int(i) : 0));
    return sensors;
  }
  [[nodiscard]] Eigen::VectorXd to_vector(const AccelerometerParameters& sensors) const {
    Eigen::VectorXd x(static_cast<Eigen::Index>(parameters_.size()));
    x.setZero();
    x.head<3>() = so3::log<double>(nominal_.conjugate() * sensors.q_BA);
    x.segment<3>(3) = sensors.bias;
    x.segment<3>(6) = sensors.scale;
    x[9] = sensors.gravity_W.norm();
    for (std::size_t i = 0; i < (separate_ ? 3u : 1u); ++i) x.segment<3>(12 + 3 * int(i)) = sensors.places_B[i];
    return x;
  }

  void prepare(const Eigen::VectorXd& x) override {
    const AccelerometerParameters sensors = parameters_of(x);
    const Matrix3 R = sensors.q_BA.toRotationMatrix(), turn = so3::right_jacobian<double>(x.head<3>());
    const Vector3 inverse = sensors.scale.cwiseInverse();
    const Matrix3 M = R * inverse.asDiagonal();
    factors_.setZero(21);
    d_factors_.setZero(21, static_cast<Eigen::Index>(parameters_.size()));
    set_matrix(M, sensors.bias, factors_);
    d_factors_.block<3, 3>(9, 3) = -M;
    for (int c = 0; c < 3; ++c) {
      const Vector3 about = turn.col(c);
      set_matrix(R * so3::hat<double>(about) * inverse.asDiagonal(), sensors.bias, d_factors_.col(c));
      Matrix3 d_scale = Matrix3::Zero();
      d_scale.col(c) = -M.col(c) * inverse[c];
      set_matrix(d_scale, sensors.bias, d_factors_.col(6 + c));
    }
    for (int i = 0; i < 3; ++i) {
      factors_.segment<3>(12 + 3 * i) = sensors.places_B[static_cast<std::size_t>(i)];
      d_factors_.block<3, 3>(12 + 3 * i, 12 + (separate_ ? 3 * i : 0)) += Matrix3::Identity();
    }
    gravity_W_ = sensors.gravity_W;
    d_gravity_.col(0) = gravity_W_ / x[9];
    const Vector3 tilt = tilt_axes_ * x.segment<2>(10);
    d_gravity_.rightCols<2>() = -so3::hat<double>(gravity_W_) * so3::left_jacobian<double>(tilt) * tilt_axes_;
  }

  void compare(std::size_t i, Vector3& r, Jacobian& J) const override {
    const Integrated& window = integrated_[i];
    r = window.seen_W - window.by_gravity * gravity_W_ - window.basis * factors_;
    J.noalias() = -window.basis.lazyProduct(d_factors_);
    J.middleCols<3>(9) -= window.by_gravity * d_gravity_;
  }

 private:
  struct Integrated {
    Vector3 seen_W;     ///< p_b - p_m - h2/h1 (p_m - p_a)
    double by_gravity;  ///< h2 (h1 + h2) / 2
    Basis basis;
  };
  /// Since the first pose: B's turn, and integrals as seen from B then.
  struct Sum {
    Quaternion q = Quaternion::Identity();
    Basis once = Basis::Zero(), twice = Basis::Zero();
  };

  /// (z - b) / k turned: M z - M b.
  template <typename Column>
  static void set_matrix(const Matrix3& M, const Vector3& bias, Column&& column) {
    for (int j = 0; j < 3; ++j) column.template segment<3>(3 * j) = M.col(j);
    column.template segment<3>(9) = -(M * bias);
  }

  void integrate(const SensorSignal& gyro, const SensorSignal& accelerometer, const GyroParameters& turns,
                 const Matrix3& R_BA, double from, double to, Sum& sum) const {
    gyro.for_pieces(from, to, [&](double begin, double end) {
      const double dt = end - begin, middle = 0.5 * (begin + end);
      const Vector3 turned = gyro.integral(end) - gyro.integral(begin);
      const Vector3 turn = dt * turns.rate_B(turned / dt);
      const Vector3 z = (accelerometer.integral(end) - accelerometer.integral(begin)) / dt;
      const Vector3 w = turning_axes_B_ * turn / dt;
      const Vector3 w_rate = turning_axes_B_ * (turns.q_BS * gyro.derivative(middle).cwiseQuotient(turns.scale));
      const Matrix3 R = (sum.q * so3::exp<double>(0.5 * turn)).toRotationMatrix();
      const Matrix3 swing = so3::hat<double>(w_rate) + so3::hat<double>(w) * so3::hat<double>(w);
      Basis felt;
      for (int j = 0; j < 3; ++j) felt.middleCols<3>(3 * j) = z[j] * R;
      felt.middleCols<3>(9) = R;
      for (int i = 0; i < 3; ++i) {
        const Vector3 u = R_BA.col(i);
        felt.middleCols<3>(12 + 3 * i) = -(R * u) * (u.transpose() * swing);
      }
      sum.twice += dt * sum.once + 0.5 * dt * dt * felt;
      sum.once += dt * felt;
      sum.q = (sum.q * so3::exp<double>(turn)).normalized();
    });
  }

  void add_windows(const PoseArrays& poses, const SensorSignal& gyro, const SensorSignal& accelerometer,
                   const GyroParameters& turns, const Matrix3& R_BA, double length) {
    const double offset = turns.time_offset_s;
    std::vector<Sum> sums(poses.size());
    for (std::size_t i = 1; i < poses.size(); ++i) {
      sums[i] = sums[i - 1];
      integrate(gyro, accelerometer, turns, R_BA, poses.t[i - 1] + offset, poses.t[i] + offset, sums[i]);
    }
    const std::vector<PoseWindow> halves = prediction_windows(poses, gyro, length, offset, 0.0);
    for (std::size_t i = 0, next = 0; i < halves.size(); ++i) {
      const std::size_t a = halves[i].first, m = halves[i].last();
      while (next < halves.size() && halves[next].first < m) ++next;
      if (next == halves.size()) break;
      if (halves[next].first != m) continue;  // nothing known after the middle
      const std::size_t b = halves[next].last();
      const double h1 = poses.t[m] - poses.t[a], h2 = poses.t[b] - poses.t[m], ratio = h2 / h1;
      PoseWindow window{a, std::vector<double>(b - a + 1, 0.0)};
      window.weights.front() = ratio;
      window.weights[m - a] = -(1.0 + ratio);
      window.weights.back() = 1.0;
      windows_.push_back(std::move(window));

      const Matrix3 to_W_a = (poses.q_WB[a] * sums[a].q.conjugate()).toRotationMatrix();
      const Matrix3 to_W_m = (poses.q_WB[m] * sums[m].q.conjugate()).toRotationMatrix();
      const Basis velocity = sums[m].once - sums[a].once;
      const Basis first = sums[m].twice - sums[a].twice - h1 * sums[a].once;
      const Basis second = sums[b].twice - sums[m].twice - h2 * sums[m].once;
      Integrated integrated;
      integrated.seen_W = poses.p_WB[b] - poses.p_WB[m] - ratio * (poses.p_WB[m] - poses.p_WB[a]);
      integrated.by_gravity = 0.5 * h2 * (h1 + h2);
      integrated.basis = to_W_a * (h2 * velocity - ratio * first) + to_W_m * second;
      integrated_.push_back(integrated);
    }
  }

  Matrix3 turning_axes_B_;
  Quaternion nominal_;
  Vector3 down_W_;
  Eigen::Matrix<double, 3, 2, Eigen::DontAlign> tilt_axes_;
  bool separate_;
  std::vector<FitParameter> parameters_;
  std::vector<PoseWindow> windows_;
  std::vector<Integrated> integrated_;
  Eigen::VectorXd factors_;
  Eigen::Matrix<double, 21, Eigen::Dynamic> d_factors_;
  Vector3 gravity_W_ = Vector3::Zero();
  Matrix3 d_gravity_ = Matrix3::Zero();
};

}  // namespace holdfast
