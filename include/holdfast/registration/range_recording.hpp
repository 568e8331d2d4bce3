/// A recording of a body that measures its distances to anchors one at a time, with inertial sensors, and the truth.
///
/// B is the body: the inertial sensors' place and axes, and what the truth is the pose of. W is the world in which the
/// anchors were surveyed. Readings are in the order of their times. Read from files by io/range_files.hpp.
#pragma once

#include <cstddef>
#include <vector>

#include <holdfast/motion/timed_pose.hpp>
#include <holdfast/tracking/inertial_reading.hpp>

namespace holdfast {

struct RangeAnchor {
  int id = 0;
  Vector3 p_W = Vector3::Zero();  ///< m
};

struct RangeReading {
  HostTime t;
  std::size_t anchor = 0;  ///< index in RangeRecording::anchors
  double range_m = 0.0;
};

struct RangeRecording {
  std::vector<RangeAnchor> anchors;
  std::vector<RangeReading> ranges;
  std::vector<InertialReading> inertial;
  std::vector<TimedPose> truth;
};

}  // namespace holdfast
