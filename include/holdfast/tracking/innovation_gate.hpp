/// Decides whether a measurement may correct the filter: a chi-square gate, on by default, that can neither lock a filter
/// out for good nor let a bad device in at once.
///
/// A good measurement's normalised innovation squared (innovation.hpp) stays below the chi-square quantile of `probability`
/// and the measurement's size: at 99 % one good measurement in a hundred is turned away, and what is off by many standard
/// deviations always is (a beacon taken for its neighbour, a reflection). Three things go beyond the textbook:
///   Window. When everything is rejected it is the filter that is wrong. After `patience` rejections in a row the gate
///     widens by `widening` with each further one, up to `widest` times the quantile, and narrows as quickly with each
///     accepted one. Meanwhile the filter's own uncertainty grows too, since no rejected measurement narrows it.
///   A device on probation. A device whose measurement was rejected has to be consistent again, `device_probation` times,
///     before its measurements count. This holds off a beacon that is mistaken, moved or dying while others speak against
///     it. It is waived while the filter itself is in doubt, and after `patience` measurements in a row that did not count:
///     devices are not to blame for the filter's error, and never all be silenced at once.
///   A filter on probation. After `patience` rejections in a row `trusted` says no, until `filter_probation` measurements
///     were consistent at the window's normal width, as it does at the beginning. What it says meanwhile may be shown, not built upon.
///     `lost` says that it should be found anew (acquisition): `lost_after` rejections since it was last trusted. Not in a
///     row: a filter that knows next to nothing takes one measurement in ten for its own, wherever it is.
/// Settings: probability 1 switches the gate off. Units: the window is in squared standard deviations, so widest = 16
/// reaches 4 times as far.
/// Bad input: a normalised innovation squared that is not finite is rejected. `problem` names bad settings.
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include <holdfast/tracking/chi_square.hpp>

namespace holdfast {

struct GateSettings {
  double probability = 0.99;
  int patience = 8;          ///< rejections in a row before the filter doubts itself
  double widening = 1.3;     ///< of the window, by each rejection after that
  double widest = 16.0;      ///< window, in times the quantile
  int device_probation = 1;  ///< consistent measurements of a rejected device that do not count yet; 0 to 255
  int filter_probation = 10;
  int lost_after = 50;  ///< rejections without being trusted in between

  [[nodiscard]] std::optional<std::string_view> problem() const {
    if (!(probability > 0.0 && probability <= 1.0)) return "the gate's probability is not in (0, 1]";
    if (patience < 0 || filter_probation < 0 || lost_after < 1) return "a count of rejections is negative";
    if (!(widening >= 1.0) || !(widest >= 1.0)) return "the gate's window would shrink below its quantile";
    if (device_probation < 0 || device_probation > 255) return "a device's probation is not in 0 to 255";
    return std::nullopt;
  }
};

enum class GateVerdict { accepted, rejected, on_probation };

class InnovationGate {
 public:
  explicit InnovationGate(const GateSettings& settings = {}) : settings_(settings) {
    for (std::size_t i = 0; i < quantiles_.size(); ++i) {
      quantiles_[i] = chi_square_quantile(settings.probability, static_cast<int>(i) + 1);
    }
  }

  /// `probation` is the device's own counter (device_table.hpp); null for a device that keeps none.
  GateVerdict judge(double nis, int size, std::uint8_t* probation) {
    if (!(nis <= quantile(size) * window_)) return reject(probation);
    rejected_in_a_row_ = 0;
    consistent_ = window_ == 1.0 ? std::min(consistent_ + 1, settings_.filter_probation) : 0;
    if (trusted()) rejected_since_trusted_ = 0;
    const bool device_to_blame = trusted() && unused_in_a_row_ < settings_.patience;
    if (probation != nullptr && *probation > 0) {
      --*probation;
      if (device_to_blame) {
        ++unused_in_a_row_;
        return GateVerdict::on_probation;
      }
    }
    unused_in_a_row_ = 0;
    window_ = std::max(1.0, window_ / settings_.widening);
    return GateVerdict::accepted;
  }

  /// Whether the window at its widest would take it. What would not even then is of something else: a wrong name.
  [[nodiscard]] bool is_near(double nis, int size) const { return nis <= quantile(size) * settings_.widest; }

  [[nodiscard]] const GateSettings& settings() const { return settings_; }
  /// Times the quantile; 1 normally.
  [[nodiscard]] double window() const { return window_; }
  [[nodiscard]] int rejected_in_a_row() const { return rejected_in_a_row_; }
  [[nodiscard]] bool trusted() const { return consistent_ >= settings_.filter_probation; }
  [[nodiscard]] bool lost() const { return rejected_since_trusted_ >= settings_.lost_after; }

 private:
  [[nodiscard]] double quantile(int size) const {
    const std::size_t i = static_cast<std::size_t>(size) - 1;
    return i < quantiles_.size() ? quantiles_[i] : chi_square_quantile(settings_.probability, size);
  }

  GateVerdict reject(std::uint8_t* probation) {
    if (probation != nullptr && trusted()) *probation = static_cast<std::uint8_t>(settings_.device_probation);
    ++unused_in_a_row_;
    ++rejected_since_trusted_;
    if (++rejected_in_a_row_ > settings_.patience) {
      consistent_ = 0;
      window_ = std::min(settings_.widest, window_ * settings_.widening);
    }
    return GateVerdict::rejected;
  }

  GateSettings settings_;
  std::array<double, 16> quantiles_{};
  double window_ = 1.0;
  int rejected_in_a_row_ = 0;
  int rejected_since_trusted_ = 0;  ///< or since the last accepted one that left it trusted
  int unused_in_a_row_ = 0;
  int consistent_ = 0;  ///< measurements since the filter was last in doubt, as far as they matter
};

}  // namespace holdfast
