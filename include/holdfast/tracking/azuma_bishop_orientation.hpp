/// Azuma & Bishop's orientation estimator as published (001 section 5.2.1): an extended Kalman filter of ten numbers.
///
///   X = (qw qx qy qz, w0 w1 w2, w0' w1' w2')     Q = q_WB, w = w_WB_B ("omega in head space"), and its derivative
///   Q' = Q (0, w) / 2,  w' its derivative,  w'' = 0;   X' = a(X),  P' = A P + P A^T + E,  A = da/dX         (1)
///   h(X) = (Q / |Q|, w),  K = P H^T (H P H^T + R)^-1,  X += K (Z - h(X)),  P = (I - K H) P                 (2)
/// X and P are carried on together by Runge and Kutta's fourth-order method; after each update Q is made of unit length.
/// E and R are diagonal. So Z's numbers are taken one after the other, with H of before the first: the same as (2) without
/// an inverse. That also gives the filter without inertial sensors, which takes the first four alone, and one that goes on
/// without a gyro that failed: a rate that is not a number is left out.
/// Departures, which 001 does not speak of: the measured quaternion takes the sign of Q; a Runge-Kutta step is at most
/// longest_step; the filter starts anew after a longer gap than longest_gap, and when a correction makes Q half or twice as
/// long: the linear h then no longer holds. P rises by `rounding_floor` in each update.
/// 001's noise was tuned for small prediction errors, not to say how large they are: do not take P for more.
/// Units: rad/s, rad/s^2; E's are per second. Nothing here allocates, locks or throws.
/// Bad input: a quaternion that is not finite or not near unit length, or a time not after the last, is refused.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/timing/clock.hpp>
#include <holdfast/tracking/advance.hpp>

namespace holdfast {

/// 001's values. What is a variance a second of E and what a variance of R follows from (1) and (2).
struct AzumaBishopOrientationNoise {
  double quaternion_drift = 0.004452;  ///< E, first four
  double rate_drift = 0.004452;        ///< E, next three, (rad/s)^2 / s
  double acceleration_drift = 351.0;   ///< E, last three, (rad/s^2)^2 / s
  double quaternion = 1e-4;            ///< R, first four
  double rate = 0.005921;              ///< R, last three, (rad/s)^2
  double initial_quaternion = 1.0;     ///< P at the start
  double initial_rate = 50.0;          ///< P at the start, rates and their derivatives
};

enum class AzumaBishopStatus {
  started,
  updated,
  updated_in_part,  ///< without some or all of the inertial numbers, which were no numbers
  refused
};

class AzumaBishopOrientation {
 public:
  using State = VectorOf<double, 10>;
  using Covariance = MatrixOf<double, 10>;
  static constexpr Duration longest_step = std::chrono::milliseconds(20);

  explicit AzumaBishopOrientation(const AzumaBishopOrientationNoise& noise = {},
                                  Duration longest_gap = std::chrono::milliseconds(250))
      : noise_(noise), longest_gap_(longest_gap) {
    HOLDFAST_ASSERT(noise.quaternion > 0.0 && noise.rate > 0.0, "a measurement without noise");
  }

  /// Tracker alone: Z = Q_m.
  AzumaBishopStatus update(HostTime t, const Quaternion& q_WB) {
    const Vector3 none = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
    return advance_and_correct(t, q_WB, none, false);
  }

  /// Tracker and gyros: Z = (Q_m, W_m).
  AzumaBishopStatus update(HostTime t, const Quaternion& q_WB, const Vector3& w_WB_B) {
    return advance_and_correct(t, q_WB, w_WB_B, true);
  }

  /// (1) alone; the time stays. `update` does this and then (2).
  void time_update(double seconds) {
    const double steps = std::ceil(seconds / to_seconds(longest_step));
    const double dt = seconds / steps;
    for (int i = 0; i < static_cast<int>(steps); ++i) {
      const State k1 = derivative(X_);
      const Covariance c1 = covariance_rate(X_, P_);
      const State X2 = X_ + 0.5 * dt * k1, k2 = derivative(X2);
      const Covariance c2 = covariance_rate(X2, P_ + 0.5 * dt * c1);
      const State X3 = X_ + 0.5 * dt * k2, k3 = derivative(X3);
      const Covariance c3 = covariance_rate(X3, P_ + 0.5 * dt * c2);
      const State X4 = X_ + dt * k3, k4 = derivative(X4);
      const Covariance c4 = covariance_rate(X4, P_ + dt * c3);
      X_ += dt / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
      P_ += dt / 6.0 * (c1 + 2.0 * c2 + 2.0 * c3 + c4);
    }
  }

  /// (2) alone, with a unit quaternion; of the rate what is a number. False when the correction is no small one any more.
  [[nodiscard]] bool measurement_update(const Quaternion& measured, const Vector3& rate) {
    Vector4 Q_m(measured.w(), measured.x(), measured.y(), measured.z());
    const Vector4 Q = X_.head<4>();
    if (Q_m.dot(Q) < 0.0) Q_m = -Q_m;
    const Matrix4 H = normalize_jacobian(Q);
    const Vector4 innovation = Q_m - Q.normalized();
    const VectorOf<double, 10> variance = P_.diagonal();
    State d = State::Zero();  // the correction so far
    for (int i = 0; i < 4; ++i) {
      State h = State::Zero();
      h.head<4>() = H.row(i).transpose();
      take(h, innovation[i], noise_.quaternion, d);
    }
    const Vector3 rate_innovation = rate - X_.segment<3>(4);
    for (int i = 0; i < 3; ++i) {
      if (std::isfinite(rate_innovation[i])) take(State::Unit(4 + i), rate_innovation[i], noise_.rate, d);
    }
    X_ += d;
    const double n2 = X_.head<4>().squaredNorm();
    if (!(n2 > 0.25 && n2 < 4.0) || !X_.allFinite() || !P_.allFinite()) return false;
    X_.head<4>().normalize();
    P_.diagonal() += rounding_floor * variance;
    return true;
  }

  [[nodiscard]] bool is_started() const { return started_; }
  [[nodiscard]] HostTime t() const { return t_; }
  [[nodiscard]] Quaternion q_WB() const { return quaternion_of(X_); }
  [[nodiscard]] Vector3 w_WB_B() const { return X_.segment<3>(4); }
  [[nodiscard]] Vector3 alpha_WB_B() const { return X_.tail<3>(); }
  [[nodiscard]] const State& X() const { return X_; }
  [[nodiscard]] const Covariance& P() const { return P_; }

  /// Covariance of (dphi, dw, dalpha), with R_true = R exp(dphi).
  [[nodiscard]] MatrixOf<double, 9> error_covariance() const {
    MatrixOf<double, 9, 10> J = MatrixOf<double, 9, 10>::Zero();
    J.block<3, 4>(0, 0) = 4.0 * product_matrix(q_WB()).transpose();  // dphi = 2 Im(~q dq)
    J.block<6, 6>(3, 4).setIdentity();
    const MatrixOf<double, 9, 10> JP = J.lazyProduct(P_);
    return JP.lazyProduct(J.transpose());
  }

  /// a(X).
  [[nodiscard]] static State derivative(const State& X) {
    State rate;
    rate.head<4>() = product_matrix(quaternion_of(X)) * X.segment<3>(4);
    rate.segment<3>(4) = X.tail<3>();
    rate.tail<3>().setZero();
    return rate;
  }

  /// A = da/dX.
  [[nodiscard]] static Covariance derivative_jacobian(const State& X) {
    Covariance A = Covariance::Zero();
    const Vector3 w = 0.5 * X.segment<3>(4);
    A.block<4, 4>(0, 0) << 0.0, -w.x(), -w.y(), -w.z(),  //
        w.x(), 0.0, w.z(), -w.y(),                       //
        w.y(), -w.z(), 0.0, w.x(),                       //
        w.z(), w.y(), -w.x(), 0.0;
    A.block<4, 3>(0, 4) = product_matrix(quaternion_of(X));
    A.block<3, 3>(4, 7).setIdentity();
    return A;
  }

  /// dh/dX's first four rows and columns: of Q / |Q|.
  [[nodiscard]] static Matrix4 normalize_jacobian(const Vector4& Q) {
    const double length = Q.norm();
    const Vector4 unit = Q / length;
    return (Matrix4::Identity() - unit * unit.transpose()) / length;
  }

 private:
  [[nodiscard]] static Quaternion quaternion_of(const State& X) { return Quaternion(X[0], X[1], X[2], X[3]); }

  /// The matrix B(Q) with Q (0, w) / 2 = B(Q) w.
  [[nodiscard]] static MatrixOf<double, 4, 3> product_matrix(const Quaternion& q) {
    MatrixOf<double, 4, 3> B;
    B << -q.x(), -q.y(), -q.z(),  //
        q.w(), -q.z(), q.y(),     //
        q.z(), q.w(), -q.x(),     //
        -q.y(), q.x(), q.w();
    return 0.5 * B;
  }

  AzumaBishopStatus advance_and_correct(HostTime t, const Quaternion& measured, const Vector3& rate, bool has_gyros) {
    const double n2 = measured.squaredNorm();
    if (!(n2 > 0.25 && n2 < 4.0) || (started_ && t <= t_)) return AzumaBishopStatus::refused;
    if (!started_ || t - t_ > longest_gap_) {
      start(t, measured.normalized());
      return AzumaBishopStatus::started;
    }
    time_update(to_seconds(t - t_));
    t_ = t;
    if (!measurement_update(measured.normalized(), rate)) {
      start(t, measured.normalized());
      return AzumaBishopStatus::started;
    }
    return has_gyros && !rate.allFinite() ? AzumaBishopStatus::updated_in_part : AzumaBishopStatus::updated;
  }

  void start(HostTime t, const Quaternion& q) {
    X_ << q.w(), q.x(), q.y(), q.z(), 0.0, 0.0, 0.0, 0.0, 0.0, 0.0;
    P_.setZero();
    P_.diagonal() << Vector4::Constant(noise_.initial_quaternion), Vector6::Constant(noise_.initial_rate);
    t_ = t;
    started_ = true;
  }

  /// P' of (1). A's last three rows are zero, and three more only copy.
  [[nodiscard]] Covariance covariance_rate(const State& X, const Covariance& P) const {
    const Covariance A = derivative_jacobian(X);
    Covariance AP;
    AP.topRows<4>() = A.topLeftCorner<4, 7>().lazyProduct(P.topRows<7>());
    AP.middleRows<3>(4) = P.bottomRows<3>();
    AP.bottomRows<3>().setZero();
    Covariance rate = AP + AP.transpose();
    rate.diagonal().head<4>().array() += noise_.quaternion_drift;
    rate.diagonal().segment<3>(4).array() += noise_.rate_drift;
    rate.diagonal().tail<3>().array() += noise_.acceleration_drift;
    return rate;
  }

  /// One number with the row h of H: innovation is that before any correction.
  void take(const State& h, double innovation, double variance, State& d) {
    const State c = P_.lazyProduct(h);
    const double s = h.dot(c) + variance;
    d += c * ((innovation - h.dot(d)) / s);
    P_ -= c * c.transpose() / s;
  }

  AzumaBishopOrientationNoise noise_;
  Duration longest_gap_;
  State X_ = State::Zero();
  Covariance P_ = Covariance::Identity();
  HostTime t_;
  bool started_ = false;
};

}  // namespace holdfast
