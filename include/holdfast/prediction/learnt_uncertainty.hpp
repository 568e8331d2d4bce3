/// From a covariance learnt between measured poses to that of a prediction's error now.
///
/// What was learnt is of errors against measured poses: the noise that these were found to have goes, as far as the
/// rest is no smaller than what the filter's own covariance says. And it was learnt while poses came: where they are
/// missing, and for half a second after a start, what the filter's covariance says beyond the usual comes to it
/// (inertial_spread.hpp).
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

  /// Of a prediction over h from the filter's newest state, at `now`.
  void complete(Matrix6& covariance, const InertialFilter& filter, HostTime now, double h) const {
    const double usual = pose_interval_s_ + h, since = to_seconds(now - newest_) + h;
    const double place = usual_.place_m2(usual), turn = usual_.turn_rad2(usual);
    const PoseNoise noise = filter.pose_noise();
    const auto without_noise = [](double learnt, double deviation, double by_filter) {
      return std::min(1.0, std::max(learnt - deviation * deviation, by_filter) / learnt);
    };
    covariance.topLeftCorner<3, 3>() *= without_noise(covariance.diagonal().head<3>().mean(), noise.position_m, place);
    covariance.bottomRightCorner<3, 3>() *=
        without_noise(covariance.diagonal().tail<3>().mean(), noise.orientation_rad, turn);
    if (since - h <= 1.5 * pose_interval_s_ && newest_ >= settled_) return;
    covariance.diagonal().head<3>().array() += std::max(0.0, spread_.place_m2(since) - place);
    covariance.diagonal().tail<3>().array() += std::max(0.0, spread_.turn_rad2(since) - turn);
  }

 private:
  PoseSpread spread_, usual_;  ///< after the newest pose, and of late
  double pose_interval_s_ = 0.0;
  HostTime newest_, settled_;
};

}  // namespace holdfast
