/// A device filter (002 section 4.4.2): the calibrated parameters of one source or sensor, and how well they are known.
///
/// Parameters are constants that may wander a little: `advance` adds Q per sighting. A locked device (002 section 5.1.4)
/// keeps its numbers, but its uncertainty still counts against every measurement that it takes part in.
#pragma once

#include <holdfast/geometry/types.hpp>

namespace holdfast {

template <int Size>
struct DeviceEstimate {
  static constexpr int size = Size;
  VectorOf<double, Size> x = VectorOf<double, Size>::Zero();
  MatrixOf<double, Size> P = MatrixOf<double, Size>::Zero();
  bool locked = false;
};

/// A device without parameters.
using NoDevice = DeviceEstimate<0>;

}  // namespace holdfast
