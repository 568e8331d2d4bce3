/// A pose with the time at which it was true: what recordings are made of.
///
/// X_WB is the pose of the moving body B (the head, a camera, a tracker's rigid body) in the world W, metres; t is on
/// the host's clock, int64 nanoseconds.
#pragma once

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/timing/clock.hpp>

namespace holdfast {

struct TimedPose {
  HostTime t;
  Rigid X_WB;
};

}  // namespace holdfast
