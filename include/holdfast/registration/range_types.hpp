/// The ways to track by recorded ranges that are compared, and what each is told to have achieved: a row of `swimlab track ranges`.
///
/// Apart from range_experiment.hpp, which runs them: who only shows rows needs no filter. Numbers are NaN when nothing was judged.
#pragma once

#include <array>
#include <limits>
#include <string_view>
#include <vector>

#include <holdfast/registration/three_point_error.hpp>

namespace holdfast {

struct RangeVariant {
  bool bias_states = true;
  bool gate = true;
};
inline constexpr std::array range_variants{RangeVariant{false, false}, RangeVariant{false, true},
                                           RangeVariant{true, false}, RangeVariant{true, true}};

[[nodiscard]] constexpr std::string_view name_of(const RangeVariant& variant) {
  if (variant.bias_states) return variant.gate ? "bias_and_gate" : "bias";
  return variant.gate ? "gate" : "neither";
}

struct RangeRow {
  RangeVariant variant;
  ThreePointError three_point;              ///< m
  RmsAndPeak position, horizontal, height;  ///< m
  RmsAndPeak angle;                         ///< rad
  long ranges = 0;                          ///< given to the tracker
  long accepted = 0;
  long gated = 0;                                         ///< turned away by the gate, or on probation
  long refused = 0;                                       ///< ranges and inertial samples that could not be used at all
  double microseconds_per_range = 0.0;                    ///< in the tracker, inertial samples included
  double nis = std::numeric_limits<double>::quiet_NaN();  ///< mean of all ranges; 1 is consistent
  double position_nees = std::numeric_limits<double>::quiet_NaN();  ///< mean, per degree of freedom
  std::vector<double> biases_m;  ///< at the end, by anchor; empty without bias states
};

}  // namespace holdfast
