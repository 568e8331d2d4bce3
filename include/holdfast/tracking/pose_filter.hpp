/// The Kalman tracker without inertial sensors: whole poses in, a state with velocity and acceleration out.
///
///     PoseFilter<3> filter(head_model(), {.noise = {5e-5, 3e-4}});
///     filter.update({t, X_WB});                                        // each pose that the tracker measured
///     predict_state(filter.state(), filter.model(), t_display).X_WB;   // prediction/state_prediction.hpp
/// It is what ScaatFilter makes of PoseMeasurements whose noise is the same on all axes, at a small part of the work: a
/// whole pose tells of each axis by itself, so the six chains of process_model.hpp never mix, and each keeps its own
/// covariance of Order numbers. Of the small turn about B within one step only the state is told, not the covariance
/// between the axes.
/// The first pose starts it, without velocity (PoseFilterStart says how well that is known), and so does one after a gap
/// that no velocity outlives.
/// Source: 002 section 4.2 (model), eqs 4.14 to 4.22 (filter). Units and frames: target_state.hpp.
/// Hot path: nothing here allocates, locks or throws.
/// Bad input: a pose that is not finite or beyond farthest_m, or not later than the one before, is refused and counted;
/// the state stays.
/// Preconditions: the model has no problem, the noise is above zero.
#pragma once

#include <array>
#include <cstdint>

#include <holdfast/assert.hpp>
#include <holdfast/motion/timed_pose.hpp>
#include <holdfast/tracking/advance.hpp>

namespace holdfast {

/// A head: PVA with accelerations that fade within 0.14 s (place) and 0.05 s (orientation), as Singer's model has it.
/// Intensities in m^2/s^5 and rad^2/s^5. docs/prediction.md tells on which motions it was found.
[[nodiscard]] inline PvaModel head_model() {
  PvaModel model;
  model.intensity << 25.0, 25.0, 25.0, 225.0, 225.0, 225.0;
  model.decay << 7.0, 7.0, 7.0, 20.0, 20.0, 20.0;
  return model;
}

/// Standard deviations of what the first pose does not tell: far more than heads do, so that the next poses decide.
struct PoseFilterStart {
  double speed_m_s = 2.0;
  double angular_speed_rad_s = 6.0;
  double acceleration_m_s2 = 10.0;
  double angular_acceleration_rad_s2 = 50.0;
};

struct PoseFilterSettings {
  PoseNoise noise{5e-5, 3e-4};  ///< of each measured pose; what an optical tracker has
  PoseFilterStart start;
  Duration longest_gap = std::chrono::milliseconds(250);
};

enum class PoseFilterStatus { started, updated, refused };

template <int Order>
class PoseFilter {
  static_assert(Order >= 2, "a filter without velocity predicts nothing");

 public:
  static constexpr double farthest_m = 1e12;  ///< numbers stay finite below that

  explicit PoseFilter(const ProcessModel<Order>& model, const PoseFilterSettings& settings = {})
      : model_(model), settings_(settings) {
    HOLDFAST_ASSERT(!model.problem(), "bad process model");
    HOLDFAST_ASSERT(settings.noise.position_m > 0.0 && settings.noise.orientation_rad > 0.0, "a pose without noise");
  }

  PoseFilterStatus update(const TimedPose& measured) {
    const bool absurd = !(measured.X_WB.p().squaredNorm() < farthest_m * farthest_m) || !measured.X_WB.is_finite();
    if (absurd || (started_ && measured.t <= state_.t)) {
      ++refused_;
      return PoseFilterStatus::refused;
    }
    if (!started_ || is_after_gap(measured.t)) {
      start(measured);
      return PoseFilterStatus::started;
    }
    correct(predict_to(measured.t), measured);
    return PoseFilterStatus::updated;
  }

  /// Forgets all but this pose. Precondition: it is finite.
  void start(const TimedPose& measured) {
    HOLDFAST_ASSERT(measured.X_WB.is_finite(), "a filter starts from finite numbers");
    state_ = TargetState<Order>();
    state_.t = measured.t;
    state_.X_WB = measured.X_WB;
    const PoseFilterStart& s = settings_.start;
    const std::array deviations{
        settings_.noise.position_m, settings_.noise.orientation_rad, s.speed_m_s, s.angular_speed_rad_s,
        s.acceleration_m_s2,        s.angular_acceleration_rad_s2};
    state_.P.setZero();
    for (int i = 0; i < 6 * Order; ++i) {
      const double deviation = deviations[static_cast<std::size_t>(i / 3)];
      state_.P(i, i) = deviation * deviation;
    }
    started_ = true;
  }

  [[nodiscard]] bool is_started() const { return started_; }
  /// After the last measurement that counted. Of its covariance, what couples the axes is zero.
  [[nodiscard]] const TargetState<Order>& state() const { return state_; }
  [[nodiscard]] const ProcessModel<Order>& model() const { return model_; }
  [[nodiscard]] std::uint64_t refused() const { return refused_; }

 private:
  /// In floating point, which no two times overflow.
  [[nodiscard]] bool is_after_gap(HostTime t) const {
    const auto ticks = [](auto of) { return static_cast<double>(of.count()); };
    return ticks(t.time_since_epoch()) - ticks(state_.t.time_since_epoch()) > ticks(settings_.longest_gap);
  }

  /// Carries state and covariance to t; answers how far the pose moved.
  [[nodiscard]] Vector6 predict_to(HostTime t) {
    const double dt = to_seconds(t - state_.t);
    Vector6 moved;
    for (int axis = 0; axis < 6; ++axis) {
      const ChainStep<Order> step = chain_step<Order>(model_.intensity[axis], model_.decay[axis], dt);
      const VectorOf<double, Order> x = step.A * numbers(axis);
      moved[axis] = x[0];
      set_derivatives(axis, x);
      set_covariance(axis, step.A * covariance(axis) * step.A.transpose() + step.Q);
    }
    state_.t = t;
    return moved;
  }

  void correct(const Vector6& moved, const TimedPose& measured) {
    const Vector3 p = state_.X_WB.p() + moved.head<3>();
    const Quaternion q = state_.X_WB.q() * so3::exp<double>(moved.tail<3>());
    Vector6 residual;
    residual << measured.X_WB.p() - p, so3::log<double>(q.conjugate() * measured.X_WB.q());
    Vector6 d;
    for (int axis = 0; axis < 6; ++axis) {
      const double noise = axis < 3 ? settings_.noise.position_m : settings_.noise.orientation_rad;
      const MatrixOf<double, Order> P = covariance(axis);
      const double S = P(0, 0) + noise * noise;
      const VectorOf<double, Order> C = P.col(0);
      d[axis] = C[0] / S * residual[axis];
      set_derivatives(axis, numbers(axis) + C / S * residual[axis]);
      MatrixOf<double, Order> corrected = P - C * C.transpose() / S;
      corrected.diagonal() += rounding_floor * P.diagonal();
      set_covariance(axis, corrected);
    }
    state_.X_WB = Rigid(q * so3::exp<double>(d.tail<3>()), p + d.head<3>());
  }

  // One axis's numbers (its pose counts from zero) and covariance.
  [[nodiscard]] VectorOf<double, Order> numbers(int axis) const {
    VectorOf<double, Order> x;
    const int i = axis % 3;
    x[0] = 0.0;
    x[1] = axis < 3 ? state_.velocity.v_WB[i] : state_.velocity.w_WB_B[i];
    if constexpr (Order == 3) x[2] = axis < 3 ? state_.acceleration.a_WB[i] : state_.acceleration.alpha_WB_B[i];
    return x;
  }
  void set_derivatives(int axis, const VectorOf<double, Order>& x) {
    const int i = axis % 3;
    (axis < 3 ? state_.velocity.v_WB[i] : state_.velocity.w_WB_B[i]) = x[1];
    if constexpr (Order == 3) (axis < 3 ? state_.acceleration.a_WB[i] : state_.acceleration.alpha_WB_B[i]) = x[2];
  }
  [[nodiscard]] MatrixOf<double, Order> covariance(int axis) const {
    MatrixOf<double, Order> P;
    for (int i = 0; i < Order; ++i) {
      for (int j = 0; j < Order; ++j) P(i, j) = state_.P(axis + 6 * i, axis + 6 * j);
    }
    return P;
  }
  void set_covariance(int axis, const MatrixOf<double, Order>& P) {
    for (int i = 0; i < Order; ++i) {
      for (int j = i; j < Order; ++j) {
        state_.P(axis + 6 * i, axis + 6 * j) = state_.P(axis + 6 * j, axis + 6 * i) = P(i, j);
      }
    }
  }

  ProcessModel<Order> model_;
  PoseFilterSettings settings_;
  TargetState<Order> state_;
  bool started_ = false;
  std::uint64_t refused_ = 0;
};

}  // namespace holdfast
