/// What acquisition by ranges (range_acquisition.hpp) is told, and what it answers.
/// Units are in the names: m, rad.
#pragma once

#include <array>
#include <string_view>
#include <vector>

#include <holdfast/geometry/rigid.hpp>

namespace holdfast {

struct RangeAcquisitionSettings {
  double sigma_m = 0.005;           ///< of a range, with all its errors
  double gate_probability = 0.999;  ///< that right ranges pass
  double minimum_share = 0.6;       ///< of the ranges that must agree with the pose: four of eight codes do with any
  double settled_share = 0.7;       ///< with so many no further tuple is tried
  int margin = 3;                   ///< by so many ranges more than any other pose: one beacon's, with three receivers
  int tuples = 300;                 ///< at most, of codes, that are tried
  double same_pose_m = 0.05;        ///< nearer than this, and
  double same_pose_rad = 0.05;      ///< than this, two poses are one
};

enum class RangeAcquisitionStatus {
  acquired,
  bad_reading,      ///< not finite, not positive, or of a receiver that is not there
  repeated_code,    ///< one receiver, one code, two ranges
  too_few,          ///< no receiver with ranges to four known codes
  no_orientation,   ///< receivers and known directions leave a turn free
  beacons_in_line,  ///< all that could have been heard hang in one line, within 1 mm
  no_pose,          ///< the ranges contradict each other wherever the beacons are looked for
  ambiguous         ///< several poses explain them: more beacons, or their axes, or the vertical would tell
};

[[nodiscard]] constexpr std::string_view to_string(RangeAcquisitionStatus status) {
  constexpr std::array<std::string_view, 8> names{"acquired",       "bad_reading",     "repeated_code", "too_few",
                                                  "no_orientation", "beacons_in_line", "no_pose",       "ambiguous"};
  return names[static_cast<std::size_t>(status)];
}

struct RangeAcquisition {
  RangeAcquisitionStatus status = RangeAcquisitionStatus::too_few;
  Rigid X_WB;
  Matrix6 covariance = Matrix6::Zero();  ///< of (dp, dphi), by sigma_m
  std::vector<int> beacon;               ///< of each range: the beacon that it agrees with, -1 for none
  int agreeing = 0;                      ///< ranges
  int rival = 0;                         ///< ranges that agree with the next best pose
  int tuples_tried = 0;

  [[nodiscard]] bool ok() const { return status == RangeAcquisitionStatus::acquired; }
};

}  // namespace holdfast
