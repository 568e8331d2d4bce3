/// Coded beacons and the ranges to them: what acquisition and mapping of a Constellation (003 section 2) work on.
///
/// A beacon answers to a code; codes repeat where a room is large (003 has eight of them). A receiver rides on the body. Axes
/// are the directions in which transducers point: a range can only be between transducers that lie in front of each other.
/// A zero axis stands for a transducer that works in all directions. Metres.
#pragma once

#include <holdfast/geometry/types.hpp>

namespace holdfast {

struct CodedBeacon {
  int code = 0;
  Vector3 p_W = Vector3::Zero();
  Vector3 axis_W = Vector3::Zero();  ///< unit length, or zero
};

struct RangeReceiver {
  Vector3 p_B = Vector3::Zero();
  Vector3 axis_B = Vector3::Zero();  ///< unit length, or zero
};

struct CodedRange {
  int receiver = 0;  ///< index
  int code = 0;
  double range_m = 0.0;
};

}  // namespace holdfast
