/// A device filter (002 section 4.4.2): the calibrated parameters of one source or sensor, and how well they are known.
///
/// Parameters are constants that may wander a little: their owner adds 002's Q_b to P per sighting (device_table.hpp). A
/// locked device (002 section 5.1.4) keeps its numbers, but its uncertainty still counts against every measurement that
/// it takes part in. So does `residual_variance`, of what no calibration takes away: it is added to P where a measurement
/// is weighed, and is never learnt. Without it a body at rest and its devices drift together, for they gain confidence
/// that their common origin does not earn (the gauge freedom of 002 section 5.1.4).
#pragma once

#include <holdfast/geometry/types.hpp>

namespace holdfast {

template <int Size>
struct DeviceEstimate {
  static constexpr int size = Size;
  VectorOf<double, Size> x = VectorOf<double, Size>::Zero();
  MatrixOf<double, Size> P = MatrixOf<double, Size>::Zero();
  VectorOf<double, Size> residual_variance = VectorOf<double, Size>::Zero();
  bool locked = false;
};

/// A device without parameters.
using NoDevice = DeviceEstimate<0>;

}  // namespace holdfast
