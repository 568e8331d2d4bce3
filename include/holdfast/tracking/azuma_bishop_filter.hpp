/// Azuma & Bishop's whole tracker (001 section 5.2): poses of an optical tracker with the inertial readings of the same
/// moments in, the head's state out.
///
///     AzumaBishopFilter filter(settings);
///     filter.update({t, X_WB}, reading);                                     // or filter.update({t, X_WB}) without
///     predict_state(filter.state(), filter.model(), t_display).X_WB;         // prediction/state_prediction.hpp
/// Each reading is freed of scale and bias and turned into B. The gyros go to the orientation's filter. The accelerometers
/// become the world acceleration of B's origin (001 appendix A: linear_acceleration.hpp) by the tracker's orientation and
/// the filter's w and w', and go to the three position filters. That prediction is 001's closed form
/// (azuma_bishop_prediction.hpp).
/// The reading should be of the pose's time; it is taken as if it were.
/// Bad input: a pose that is not finite, beyond farthest_m, or not later than the last is refused, the state stays. Gyro
/// numbers that are not finite or absurd are left out one by one, accelerometers' all together: updated_in_part.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <optional>

#include <holdfast/motion/timed_pose.hpp>
#include <holdfast/tracking/azuma_bishop_orientation.hpp>
#include <holdfast/tracking/azuma_bishop_position.hpp>
#include <holdfast/tracking/linear_acceleration.hpp>
#include <holdfast/tracking/target_state.hpp>

namespace holdfast {

struct AzumaBishopSettings {
  AzumaBishopOrientationNoise orientation;
  AzumaBishopPositionNoise position;
  Rigid X_BS;  ///< where the inertial unit sits
  std::array<Vector3, 3> accelerometers_S{Vector3::Zero(), Vector3::Zero(), Vector3::Zero()};
  Vector3 gravity_W = -standard_gravity * Vector3::UnitY();
  // Of the unit: what it says is scale times what is, plus bias.
  Vector3 rate_bias = Vector3::Zero(), rate_scale = Vector3::Ones();
  Vector3 force_bias = Vector3::Zero(), force_scale = Vector3::Ones();
  Duration longest_gap = std::chrono::milliseconds(250);
};

class AzumaBishopFilter {
 public:
  static constexpr double farthest_m = 1e12;  ///< numbers stay finite below that, and below an InertialReading's limits

  explicit AzumaBishopFilter(const AzumaBishopSettings& settings = {})
      : settings_(settings),
        sensors_(accelerometers_on_body(settings.X_BS, settings.accelerometers_S)),
        orientation_(settings.orientation, settings.longest_gap) {}

  /// The same without inertial sensors.
  AzumaBishopStatus update(const TimedPose& measured) {
    if (is_absurd(measured)) return AzumaBishopStatus::refused;
    const HostTime before = orientation_.t();
    const AzumaBishopStatus status = orientation_.update(measured.t, measured.X_WB.q());
    carry_position(status, before, measured, std::nullopt);
    return status;
  }

  AzumaBishopStatus update(const TimedPose& measured, const InertialReading& reading) {
    if (is_absurd(measured)) return AzumaBishopStatus::refused;
    Vector3 rate_S = (reading.rate_B - settings_.rate_bias).cwiseQuotient(settings_.rate_scale);
    for (double& rate : rate_S) {
      if (!(std::abs(rate) < fastest_rad_s)) rate = std::numeric_limits<double>::quiet_NaN();
    }
    const Vector3 force_S = (reading.force_B - settings_.force_bias).cwiseQuotient(settings_.force_scale);
    const HostTime before = orientation_.t();
    AzumaBishopStatus status = orientation_.update(measured.t, measured.X_WB.q(), rate_on_body(rate_S));
    std::optional<Vector3> acceleration;
    if (force_S.cwiseAbs().maxCoeff() < hardest_m_s2 && force_S.allFinite()) {
      const TurningState turning{measured.X_WB.q(), orientation_.w_WB_B(), orientation_.alpha_WB_B()};
      acceleration = linear_acceleration(sensors_, force_S, turning, settings_.gravity_W);
    } else if (status == AzumaBishopStatus::updated) {
      status = AzumaBishopStatus::updated_in_part;
    }
    carry_position(status, before, measured, acceleration);
    return status;
  }

  [[nodiscard]] bool is_started() const { return orientation_.is_started(); }
  [[nodiscard]] const AzumaBishopOrientation& orientation() const { return orientation_; }
  [[nodiscard]] const AzumaBishopPosition& position(int axis) const {
    return position_[static_cast<std::size_t>(axis)];
  }

  /// After the last update. Between position and orientation, and among x, y and z, it knows no covariance.
  [[nodiscard]] TargetState<3> state() const {
    TargetState<3> state;
    state.t = orientation_.t();
    Vector3 p;
    state.P.setZero();
    for (int i = 0; i < 3; ++i) {
      const AzumaBishopPosition& axis = position(i);
      p[i] = axis.X()[0];
      state.velocity.v_WB[i] = axis.X()[1];
      state.acceleration.a_WB[i] = axis.X()[2];
      for (int k = 0; k < 3; ++k) {
        for (int l = 0; l < 3; ++l) state.P(6 * k + i, 6 * l + i) = axis.P()(k, l);
      }
    }
    if (is_started()) state.X_WB = Rigid(orientation_.q_WB(), p);
    state.velocity.w_WB_B = orientation_.w_WB_B();
    state.acceleration.alpha_WB_B = orientation_.alpha_WB_B();
    const MatrixOf<double, 9> P = orientation_.error_covariance();
    for (int k = 0; k < 3; ++k) {
      for (int l = 0; l < 3; ++l) state.P.block<3, 3>(6 * k + 3, 6 * l + 3) = P.block<3, 3>(3 * k, 3 * l);
    }
    return state;
  }

  /// Constant acceleration with 001's noise of it; the small noise of the lower numbers has no place in it.
  [[nodiscard]] PvaModel model() const {
    PvaModel model;
    model.intensity << Vector3::Constant(settings_.position.drift[2]),
        Vector3::Constant(settings_.orientation.acceleration_drift);
    return model;
  }

 private:
  [[nodiscard]] static bool is_absurd(const TimedPose& measured) {
    return !(measured.X_WB.p().squaredNorm() < farthest_m * farthest_m) || !measured.X_WB.is_finite();
  }

  /// A number that is missing takes only the axes of B with it that it is part of.
  [[nodiscard]] Vector3 rate_on_body(const Vector3& rate_S) const {
    const Matrix3 R_BS = settings_.X_BS.R();
    Vector3 rate_B = Vector3::Zero();
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) {
        if (R_BS(i, j) != 0.0) rate_B[i] += R_BS(i, j) * rate_S[j];
      }
    }
    return rate_B;
  }

  void carry_position(AzumaBishopStatus status, HostTime before, const TimedPose& measured,
                      const std::optional<Vector3>& acceleration) {
    if (status == AzumaBishopStatus::refused) return;
    for (int i = 0; i < 3; ++i) {
      AzumaBishopPosition& axis = position_[static_cast<std::size_t>(i)];
      if (status == AzumaBishopStatus::started) {
        axis = AzumaBishopPosition(measured.X_WB.p()[i], settings_.position);
        continue;
      }
      axis.advance(to_seconds(measured.t - before));
      axis.correct(measured.X_WB.p()[i], acceleration ? std::optional((*acceleration)[i]) : std::nullopt);
    }
  }

  AzumaBishopSettings settings_;
  SeparateAccelerometers sensors_;
  AzumaBishopOrientation orientation_;
  std::array<AzumaBishopPosition, 3> position_;
};

}  // namespace holdfast
