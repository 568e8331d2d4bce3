/// A PoseFilter that poses which no head could have cannot throw: it believes everything, and would.
///
/// A pose more than eight standard deviations off where it was expected, noisy by 10 mm and 1 degree at that, is
/// rejected; four in a row are a head that was carried away, and begin it anew. Poses that go back in time are refused;
/// ten in a row are a clock that was set back, and begin it anew.
/// Hot path: nothing here allocates, locks or throws. Bad input: poses that are not finite or of unusual times are
/// refused.
#pragma once

#include <holdfast/prediction/state_prediction.hpp>
#include <holdfast/tracking/inertial_filter.hpp>
#include <holdfast/tracking/pose_filter.hpp>

namespace holdfast {

class GuardedPoseFilter {
 public:
  explicit GuardedPoseFilter(const PvaModel& model = head_model(), const PoseFilterSettings& settings = {})
      : filter_(model, settings), longest_gap_(settings.longest_gap) {}

  InertialPoseUpdate update(const TimedPose& pose) {
    clock_was_set_back_ = false;
    if (!is_usual(pose.t) || !pose.X_WB.is_finite()) return InertialPoseUpdate::refused;
    if (filter_.is_started() && pose.t <= filter_.state().t) {
      if (++refused_ < new_clock_after) return InertialPoseUpdate::refused;
      clock_was_set_back_ = true;
      return start(pose);
    }
    if (contradicts(pose)) return ++doubted_ < patience ? InertialPoseUpdate::rejected : start(pose);
    const PoseFilterStatus status = filter_.update(pose);
    if (status == PoseFilterStatus::refused) return InertialPoseUpdate::refused;
    refused_ = doubted_ = 0;
    return status == PoseFilterStatus::updated ? InertialPoseUpdate::updated : InertialPoseUpdate::started;
  }

  [[nodiscard]] const PoseFilter<3>& filter() const { return filter_; }
  /// Whether it has just begun anew for that.
  [[nodiscard]] bool clock_was_set_back() const { return clock_was_set_back_; }

 private:
  static constexpr int new_clock_after = 10, patience = 4;

  InertialPoseUpdate start(const TimedPose& pose) {
    if (!(pose.X_WB.p().squaredNorm() < 1e18)) return InertialPoseUpdate::refused;
    filter_.start(pose);
    refused_ = doubted_ = 0;
    return InertialPoseUpdate::started;
  }

  [[nodiscard]] bool contradicts(const TimedPose& pose) const {
    if (!filter_.is_started() || pose.t - filter_.state().t > longest_gap_) return false;
    const PredictionResult expected =
        predict_state(filter_.state(), filter_.model(), pose.t, StatePredictionLimits{longest_gap_});
    const auto is_off = [](double square, double variance, double noise) {
      return !(square < 64.0 * (variance + noise * noise));
    };
    const double turn = so3::angle_between<double>(expected.X_WB.q(), pose.X_WB.q());
    const Vector6 variance = expected.covariance.diagonal();
    return is_off((pose.X_WB.p() - expected.X_WB.p()).squaredNorm(), variance.head<3>().sum(), 0.01) ||
           is_off(turn * turn, variance.tail<3>().sum(), 0.0175);
  }

  PoseFilter<3> filter_;
  Duration longest_gap_;
  bool clock_was_set_back_ = false;
  int refused_ = 0, doubted_ = 0;  ///< in a row
};

}  // namespace holdfast
