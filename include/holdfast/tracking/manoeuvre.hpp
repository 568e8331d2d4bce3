/// Notices that a body moves more vigorously than its process model says, and tells by how much its noise should grow.
///
///     ScaatSettings settings{.manoeuvre = {.threshold = 1.5}};      // of ScaatFilter, MultipleModelFilter, JointFilter
/// A filter that is tuned for usual motion lags when a body is snatched up: residuals grow, the gate turns away all that speak
/// of the manoeuvre and lets those pass that do not, and the error runs on. The sign is in the normalised innovation squared
/// (innovation.hpp), 1 per number on average while all is as modelled. `ManoeuvreDetector` keeps its running mean over the
/// newest `memory` measurements that are near: accepted, or such as the gate would take at its widest. Above `threshold`
/// the process noise is raised by (mean / threshold)^2, up to `largest` times; all is as it was when the mean falls again
/// (Bar-Shalom, Li and Kirubarajan 2001, section 11.2.2: continuous noise level adjustment). Wrong names do no harm: they
/// are far off, a hundred deviations rather than five, and do not count (InnovationGate::is_near). With the gate switched off
/// (its probability 1) nothing is far off: then they do rouse it, and it had better be off too.
/// Noise that is raised lets a filter that is altogether wrong take more for its own: heed InnovationGate::lost.
/// Threshold: of 20 measurements of two numbers the mean scatters by 0.16 about 1. So for filters as sure as they may be 1.5
/// is right; less is for those that are told of more noise than there is, whose mean is below 1.
/// Units: none. Bad input: `problem` names it. A threshold of 0, the default, never notices anything.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <string_view>

namespace holdfast {

struct ManoeuvreSettings {
  double threshold = 0.0;  ///< of the mean, per number of a measurement; 0: off
  double memory = 20.0;    ///< measurements
  double largest = 100.0;  ///< times the process noise

  [[nodiscard]] std::optional<std::string_view> problem() const {
    if (!(threshold >= 0.0)) return "a manoeuvre's threshold is negative";
    if (!(memory >= 1.0) || !(largest >= 1.0)) return "a manoeuvre's memory or largest noise is below 1";
    if (!std::isfinite(threshold + memory + largest)) return "a manoeuvre's setting is not finite";
    return std::nullopt;
  }
};

class ManoeuvreDetector {
 public:
  explicit ManoeuvreDetector(const ManoeuvreSettings& settings = {})
      : settings_(settings), most_(settings.threshold * std::sqrt(settings.largest)) {}

  /// A near measurement's normalised innovation squared, of `size` numbers. Beyond what raises the noise to its largest
  /// none counts for more, however wide the gate was: or one would be remembered for long.
  void add(double nis, int size) { mean_ += (std::min(nis / size, most_) - mean_) / settings_.memory; }

  /// Of the process noise; 1 while nothing is noticed.
  [[nodiscard]] double noise_scale() const {
    if (!(mean_ > settings_.threshold)) return 1.0;
    const double ratio = mean_ / settings_.threshold;
    return ratio * ratio;
  }

 private:
  ManoeuvreSettings settings_;
  double most_;
  double mean_ = 0.0;
};

}  // namespace holdfast
