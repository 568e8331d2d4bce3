/// One round of ranges, sorted by code, beside all that is known of the room: what acquisition by ranges works on.
///
/// Codes that no beacon of the constellation has are left out; the others are ordered by how near they sound.
/// Bad input: `take` names it. Metres.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <span>
#include <vector>

#include <holdfast/tracking/coded_range.hpp>
#include <holdfast/tracking/range_acquisition_types.hpp>
#include <holdfast/tracking/range_resection.hpp>

namespace holdfast::detail {

/// The ranges to one code, by receiver; NaN: none.
struct HeardCode {
  int code = 0;
  double distance_m = 0.0;  ///< the median of them: an early pulse at one receiver brings no code to the front
  std::vector<double> range_m;
  std::vector<int> beacons;  ///< with this code
};

class HeardCodes {
 public:
  HeardCodes(std::span<const CodedBeacon> beacons, std::span<const RangeReceiver> receivers,
             std::span<const CodedRange> ranges, std::span<const SeenDirection> directions,
             const RangeAcquisitionSettings& settings)
      : beacons_(beacons), receivers_(receivers), ranges_(ranges), directions_(directions), settings_(settings) {}

  /// Nothing: there is something to search for.
  [[nodiscard]] std::optional<RangeAcquisitionStatus> take() {
    for (const CodedRange& r : ranges_) {
      const bool exists = r.receiver >= 0 && static_cast<std::size_t>(r.receiver) < receivers_.size();
      if (!exists || !std::isfinite(r.range_m) || !(r.range_m > 0.0)) return RangeAcquisitionStatus::bad_reading;
      HeardCode& heard = entry(r.code);
      double& slot = heard.range_m[static_cast<std::size_t>(r.receiver)];
      if (!std::isnan(slot)) return RangeAcquisitionStatus::repeated_code;
      slot = r.range_m;
    }
    std::erase_if(codes_, [](const HeardCode& h) { return h.beacons.empty(); });
    for (HeardCode& h : codes_) h.distance_m = median(h.range_m);
    std::stable_sort(codes_.begin(), codes_.end(),
                     [](const HeardCode& a, const HeardCode& b) { return a.distance_m < b.distance_m; });
    for (std::size_t k = 0; k < receivers_.size(); ++k) {
      const auto heard =
          std::count_if(codes_.begin(), codes_.end(), [&](const HeardCode& h) { return !std::isnan(h.range_m[k]); });
      if (heard >= 4) return std::nullopt;
    }
    return RangeAcquisitionStatus::too_few;
  }

  /// The nearest first.
  [[nodiscard]] const std::vector<HeardCode>& codes() const { return codes_; }
  [[nodiscard]] const HeardCode& heard(int i) const { return codes_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] double range_m(int code, int receiver) const {
    return heard(code).range_m[static_cast<std::size_t>(receiver)];
  }
  [[nodiscard]] std::span<const CodedBeacon> beacons() const { return beacons_; }
  [[nodiscard]] const CodedBeacon& beacon(int i) const { return beacons_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int receivers() const { return static_cast<int>(receivers_.size()); }
  [[nodiscard]] const RangeReceiver& receiver(int k) const { return receivers_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] std::span<const CodedRange> ranges() const { return ranges_; }
  [[nodiscard]] std::span<const SeenDirection> directions() const { return directions_; }
  [[nodiscard]] const RangeAcquisitionSettings& settings() const { return settings_; }

  /// Ranges of known codes.
  [[nodiscard]] int usable() const {
    int count = 0;
    for (const HeardCode& h : codes_) {
      count +=
          static_cast<int>(std::count_if(h.range_m.begin(), h.range_m.end(), [](double r) { return !std::isnan(r); }));
    }
    return count;
  }

  /// Whether receiver and beacon lie in front of each other.
  [[nodiscard]] bool are_facing(const Rigid& X_WB, int k, int i) const {
    const Vector3 down_W = X_WB * receiver(k).p_B - beacon(i).p_W;
    return down_W.dot(beacon(i).axis_W) >= 0.0 && down_W.dot(X_WB.q() * receiver(k).axis_B) <= 0.0;
  }

  /// Whether all beacons with codes that were heard hang in one line.
  [[nodiscard]] bool in_line() const {
    const Vector3& from_W = beacon(codes_.front().beacons.front()).p_W;
    Vector3 longest_W = Vector3::Zero();
    const auto every = [&](const auto& visit) {
      for (const HeardCode& h : codes_) std::for_each(h.beacons.begin(), h.beacons.end(), visit);
    };
    every([&](int i) {
      const Vector3 apart_W = beacon(i).p_W - from_W;
      if (apart_W.norm() > longest_W.norm()) longest_W = apart_W;
    });
    double across = 0.0;
    every([&](int i) { across = std::max(across, longest_W.cross(beacon(i).p_W - from_W).norm()); });
    return across <= 1e-3 * longest_W.norm();
  }

 private:
  /// Of those that are numbers; of two the smaller. Precondition: there is one.
  [[nodiscard]] static double median(std::vector<double> ranges_m) {
    std::erase_if(ranges_m, [](double r) { return std::isnan(r); });
    std::sort(ranges_m.begin(), ranges_m.end());
    return ranges_m[(ranges_m.size() - 1) / 2];
  }
  [[nodiscard]] HeardCode& entry(int code) {
    const auto known = std::find_if(codes_.begin(), codes_.end(), [&](const HeardCode& h) { return h.code == code; });
    if (known != codes_.end()) return *known;
    HeardCode fresh;
    fresh.code = code;
    fresh.range_m.assign(receivers_.size(), std::nan(""));
    for (std::size_t i = 0; i < beacons_.size(); ++i) {
      if (beacons_[i].code == code && beacons_[i].p_W.allFinite()) fresh.beacons.push_back(static_cast<int>(i));
    }
    codes_.push_back(fresh);
    return codes_.back();
  }

  std::span<const CodedBeacon> beacons_;
  std::span<const RangeReceiver> receivers_;
  std::span<const CodedRange> ranges_;
  std::span<const SeenDirection> directions_;
  RangeAcquisitionSettings settings_;
  std::vector<HeardCode> codes_;
};

}  // namespace holdfast::detail
