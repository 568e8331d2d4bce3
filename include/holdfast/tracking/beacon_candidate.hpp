/// A beacon of which nothing is known but ranges: where they were heard, and so where it must hang (003 section 5, step 3).
///
/// Ranges gather a step apart, with the places of their receivers. Once there are enough, least squares
/// (multilateration.hpp) place the beacon if the rest agree when those that fit least are left out (echoes, early pulses),
/// and if no direction is left untold. Places of a walk may lie in a plane, and leave a mirrored beacon: it hangs on the side
/// to which receivers point.
/// The covariance holds the receivers' own, as if all poses erred alike: then more ranges do not help.
/// Metres. Bad input: `add` takes what is finite (assert); `place` answers nothing until it can.
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>
#include <vector>

#include <Eigen/Eigenvalues>

#include <holdfast/assert.hpp>
#include <holdfast/tracking/chi_square.hpp>
#include <holdfast/tracking/multilateration.hpp>

namespace holdfast {

struct BeaconPlacingSettings {
  int least_ranges = 20;        ///< that agree
  double step_m = 0.05;         ///< a receiver's places gather this far apart
  double worst_sigma_m = 0.05;  ///< worst direction's deviation, at most
  double probability = 0.999;   ///< that ranges which are right are taken for it
};

/// Where a range of it was heard.
struct CandidateRange {
  int receiver = 0;
  Vector3 p_W = Vector3::Zero();     ///< the receiver's place
  Matrix3 P = Matrix3::Zero();       ///< its covariance
  Vector3 axis_W = Vector3::Zero();  ///< where it points; zero: anywhere
  double range_m = 0.0;
  double variance = 0.0;  ///< of the range alone
};

struct PlacedBeacon {
  Vector3 p_W;
  Matrix3 P;
};

class BeaconCandidate {
 public:
  explicit BeaconCandidate(int code) : code_(code) {}

  [[nodiscard]] int code() const { return code_; }

  /// False when its receiver has hardly moved since its last one.
  bool add(const CandidateRange& range, const BeaconPlacingSettings& settings) {
    HOLDFAST_ASSERT(range.p_W.allFinite() && range.P.allFinite() && range.range_m > 0.0 && range.variance > 0.0,
                    "a range that tells nothing");
    const auto before = std::find_if(ranges_.rbegin(), ranges_.rend(),
                                     [&](const CandidateRange& r) { return r.receiver == range.receiver; });
    if (before != ranges_.rend() && (before->p_W - range.p_W).norm() < settings.step_m) return false;
    ranges_.push_back(range);
    return true;
  }

  [[nodiscard]] std::optional<PlacedBeacon> place(const BeaconPlacingSettings& settings) const {
    const auto enough = static_cast<std::size_t>(std::max(4, settings.least_ranges));
    if (ranges_.size() < enough) return std::nullopt;
    std::vector<WeightedRange> ranges;
    Vector3 axis_W = Vector3::Zero();
    Matrix3 pose_P = Matrix3::Zero();
    for (const CandidateRange& r : ranges_) {
      ranges.push_back({r.p_W, r.range_m, std::sqrt(r.variance + r.P.trace() / 3.0)});
      axis_W += r.axis_W;
      pose_P += r.P / static_cast<double>(ranges_.size());
    }
    Multilateration found = multilaterate_anywhere(ranges, axis_W);
    const auto misfit = [&](const WeightedRange& r) {
      return std::abs(r.range_m - (found.p_W - r.anchor_W).norm()) / r.sigma_m;
    };
    while (found.ok() && ranges.size() >= enough &&
           found.cost > chi_square_quantile(settings.probability, static_cast<int>(ranges.size()) - 3)) {
      ranges.erase(std::max_element(ranges.begin(), ranges.end(), [&](const WeightedRange& a, const WeightedRange& b) {
        return misfit(a) < misfit(b);
      }));
      found = multilaterate_anywhere(ranges, axis_W);
    }
    if (!found.ok() || ranges.size() < enough) return std::nullopt;
    const PlacedBeacon placed{found.p_W, found.covariance + pose_P};
    const Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> axes(Eigen::Matrix3d(placed.P), Eigen::EigenvaluesOnly);
    if (!(axes.eigenvalues()[2] < settings.worst_sigma_m * settings.worst_sigma_m)) return std::nullopt;
    return placed;
  }

 private:
  int code_;
  std::vector<CandidateRange> ranges_;
};

}  // namespace holdfast
