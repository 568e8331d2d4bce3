/// What comes to the covariance that was learnt while poses came, where they are missing.
///
/// Then, and for half a second after a start, what the filter's own covariance says beyond the usual comes to it
/// (inertial_spread.hpp). The usual is also the least that is learnt (error_spread.hpp).
/// Units: m^2, rad^2, s. Nothing here allocates. Bad input: precondition a filter that is started, h >= 0.
#pragma once

#include <algorithm>

#include <holdfast/tracking/inertial_filter.hpp>

namespace holdfast {

class LearntUncertainty {
 public:
  /// After each pose that the filter took.
  void update(const InertialFilter& filter, InertialPoseUpdate status) {
    const HostTime t = filter.state().t;
    if (status == InertialPoseUpdate::updated) {
      pose_interval_s_ += (pose_interval_s_ > 0.0 ? 0.05 : 1.0) * (to_seconds(t - newest_) - pose_interval_s_);
    } else {
      settled_ = t + std::chrono::milliseconds(500);
    }
    newest_ = t;
    spread_ = filter.spread();
    if (t < settled_) return;
    usual_.place += 0.05 * (spread_.place - usual_.place);
    usual_.turn += 0.05 * (spread_.turn - usual_.turn);
  }

  /// How uncertain the filter's pose is after a pose, of late.
  [[nodiscard]] const PoseSpread& usual() const { return usual_; }

  /// Of a prediction over h from the filter's newest state, at `now`.
  void complete(Matrix6& covariance, HostTime now, double h) const {
    const double unseen = to_seconds(now - newest_);
    if (unseen <= 1.5 * pose_interval_s_ && newest_ >= settled_) return;
    const double usual = pose_interval_s_ + h, since = unseen + h;
    covariance.diagonal().head<3>().array() += std::max(0.0, spread_.place_m2(since) - usual_.place_m2(usual));
    covariance.diagonal().tail<3>().array() += std::max(0.0, spread_.turn_rad2(since) - usual_.turn_rad2(usual));
  }

 private:
  PoseSpread spread_, usual_;  ///< after the newest pose, and of late
  double pose_interval_s_ = 0.0;
  HostTime newest_, settled_;
};

}  // namespace holdfast
