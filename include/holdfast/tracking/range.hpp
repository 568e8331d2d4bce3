/// Distances between an antenna on the body and anchors in the world: ultrasound, ultra-wideband (000 section 3.1.1).
///
///   Range            r = |p_WB + R_WB l_B - a|
///   RangeWithBias    r + b, with the bias b of this link (a late first path, cables, clocks) for the sensor's parameter
///   RangeDifference  |antenna - a| - |antenna - c|: what two anchors with one clock, but none on the body, can tell
/// The source's parameters are the anchor's position a in W (m); of a range difference the sensor's are the other
/// anchor's position c. Locked or exactly known anchors have a zero covariance.
/// Bad input: measured ranges must be positive, and an antenna less than 1 mm from an anchor gives no measurement.
#pragma once

#include <holdfast/tracking/body_point.hpp>
#include <holdfast/tracking/measurement.hpp>

namespace holdfast {

namespace detail {

/// A distance from a point of the body to an anchor, with its gradients. Alike |p_W - anchor| and its unit vector.
struct AnchorDistance {
  double distance_m;
  Vector3 away_W;  ///< unit vector from the anchor to the point: the gradient by the point; by the anchor its negative

  AnchorDistance(const Vector3& p_W, const Vector3& anchor_W) {
    const Vector3 apart = p_W - anchor_W;
    distance_m = apart.norm();
    away_W = apart / distance_m;
  }
  [[nodiscard]] bool usable() const { return distance_m > nearest_sighting_m; }
};

}  // namespace detail

struct Range {
  static constexpr int size = 1;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 0;

  double range_m = 0.0;
  Vector3 antenna_B = Vector3::Zero();
  double variance = 0.0;  ///< m^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& anchor_W, const DeviceParameters<0>&,
                               Linearization<Range>& linear) const {
    const BodyPoint antenna = body_point(state, antenna_B);
    const detail::AnchorDistance to(antenna.p_W, anchor_W);
    if (!(range_m > 0.0) || !to.usable()) return false;
    linear.residual[0] = range_m - to.distance_m;
    linear.H = to.away_W.transpose() * antenna.by_error;
    linear.H_source = -to.away_W.transpose();
    linear.R(0, 0) = variance;
    return true;
  }
};

struct RangeWithBias {
  static constexpr int size = 1;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 1;

  Range range;

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& anchor_W,
                               const DeviceParameters<1>& bias_m, Linearization<RangeWithBias>& linear) const {
    Linearization<Range> unbiased;
    if (!range.linearize(state, anchor_W, {}, unbiased)) return false;
    linear.residual[0] = unbiased.residual[0] - bias_m[0];
    linear.H = unbiased.H;
    linear.H_source = unbiased.H_source;
    linear.H_sensor(0, 0) = 1.0;
    linear.R = unbiased.R;
    return true;
  }
};

struct RangeDifference {
  static constexpr int size = 1;
  static constexpr int state_size = 6;
  static constexpr int source_size = 3;
  static constexpr int sensor_size = 3;

  double difference_m = 0.0;  ///< distance to the source's anchor less distance to the other
  Vector3 antenna_B = Vector3::Zero();
  double variance = 0.0;  ///< m^2

  template <int Order>
  [[nodiscard]] bool linearize(const TargetState<Order>& state, const Vector3& anchor_W, const Vector3& other_W,
                               Linearization<RangeDifference>& linear) const {
    const BodyPoint antenna = body_point(state, antenna_B);
    const detail::AnchorDistance to(antenna.p_W, anchor_W);
    const detail::AnchorDistance to_other(antenna.p_W, other_W);
    if (!to.usable() || !to_other.usable()) return false;
    linear.residual[0] = difference_m - (to.distance_m - to_other.distance_m);
    linear.H = (to.away_W - to_other.away_W).transpose() * antenna.by_error;
    linear.H_source = -to.away_W.transpose();
    linear.H_sensor = to_other.away_W.transpose();
    linear.R(0, 0) = variance;
    return true;
  }
};

}  // namespace holdfast
