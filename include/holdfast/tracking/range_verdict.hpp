/// Which of the poses that a few ranges suggest all ranges agree on: the second half of acquisition by ranges (003 section 2.2,
/// steps 3 and 4).
///
/// A pose is asked what it lets expect of each range. A code that hangs in several places is heard from the nearest of them that
/// faces the receiver: if the range is not that one's, it does not agree, even if it is one further away's. (Otherwise, with
/// eight codes in hundreds of places, a wrong pose finds some beacon for most ranges.) Ranges that agree are taken into the
/// pose, first those that only one beacon explains, and all are asked again, until nothing changes. Then the pose must pass
/// chi-square with all of them.
/// Where a nearer beacon is hidden, the further one's range counts as wrong: that costs agreement.
/// Allocates. Bad input: poses that are not finite agree with nothing.
#pragma once

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <holdfast/tracking/chi_square.hpp>
#include <holdfast/tracking/heard_codes.hpp>

namespace holdfast::detail {

class RangeVerdict {
 public:
  explicit RangeVerdict(const HeardCodes& heard)
      : heard_(&heard), gate_(chi_square_quantile(heard.settings().gate_probability, 1)) {}

  /// Takes a pose that some ranges suggest.
  void consider(const Resection& suggested) {
    Resection fit = suggested;
    Candidate candidate;
    for (int round = 0; round < most_rounds; ++round) {
      std::vector<int> before = std::move(candidate.beacon);
      candidate = agreement(fit, round == 0);
      if (round > 1 && candidate.beacon == before) break;
      const std::vector<ReceiverRange> ranges = agreed_ranges(candidate);
      fit = resect_ranges(ranges, heard_->directions(), fit.X_WB);
      if (!fit.ok() || (round > 0 && !passes(fit, ranges.size()))) return;
    }
    const auto same =
        std::find_if(found_.begin(), found_.end(), [&](const Candidate& c) { return is_same(c.X_WB, candidate.X_WB); });
    if (same == found_.end()) {
      found_.push_back(std::move(candidate));
    } else if (candidate.agreeing > same->agreeing) {
      *same = std::move(candidate);
    }
  }

  /// Chi-square of a pose by so many ranges, and by the known directions. Precondition: more numbers than six.
  [[nodiscard]] bool passes(const Resection& fit, std::size_t ranges) const {
    const int freedom = static_cast<int>(ranges + 2 * heard_->directions().size()) - 6;
    return freedom > 0 && fit.cost <= chi_square_quantile(heard_->settings().gate_probability, freedom);
  }

  /// So many agree that no further pose is looked for.
  [[nodiscard]] bool is_settled() const {
    const Candidate* candidate = best().first;
    return candidate != nullptr && candidate->agreeing >= heard_->settings().settled_share * heard_->usable();
  }

  [[nodiscard]] RangeAcquisition result() const {
    RangeAcquisition result;
    const auto [candidate, rival] = best();
    if (candidate == nullptr) {
      result.status = heard_->in_line() ? RangeAcquisitionStatus::beacons_in_line : RangeAcquisitionStatus::no_pose;
      return result;
    }
    result.X_WB = candidate->X_WB;
    result.covariance = candidate->covariance;
    result.beacon = candidate->beacon;
    result.agreeing = candidate->agreeing;
    result.rival = rival;
    const bool enough = candidate->agreeing >= heard_->settings().minimum_share * heard_->usable();
    const bool alone = rival <= candidate->agreeing - heard_->settings().margin;
    result.status = !enough  ? RangeAcquisitionStatus::no_pose
                    : !alone ? RangeAcquisitionStatus::ambiguous
                             : RangeAcquisitionStatus::acquired;
    return result;
  }

 private:
  struct Candidate {
    Rigid X_WB;
    Matrix6 covariance = Matrix6::Zero();
    std::vector<int> beacon;
    int agreeing = 0;
  };
  static constexpr int most_rounds = 8;

  [[nodiscard]] std::vector<ReceiverRange> agreed_ranges(const Candidate& candidate) const {
    std::vector<ReceiverRange> ranges;
    for (std::size_t n = 0; n < candidate.beacon.size(); ++n) {
      if (candidate.beacon[n] < 0) continue;
      const CodedRange& r = heard_->ranges()[n];
      ranges.push_back({heard_->beacon(candidate.beacon[n]).p_W, heard_->receiver(r.receiver).p_B, r.range_m,
                        heard_->settings().sigma_m});
    }
    return ranges;
  }

  /// Which beacon each range is of, if the pose is right. `sole`: leaving out what two beacons would explain.
  [[nodiscard]] Candidate agreement(const Resection& fit, bool sole) const {
    Candidate candidate{fit.X_WB, fit.covariance, {}};
    for (const CodedRange& r : heard_->ranges()) {
      candidate.beacon.push_back(explaining(r, fit, sole));
      candidate.agreeing += candidate.beacon.back() >= 0;
    }
    return candidate;
  }

  /// -1: none.
  [[nodiscard]] int explaining(const CodedRange& r, const Resection& fit, bool sole) const {
    const double sigma = heard_->settings().sigma_m;
    const Range range{r.range_m, heard_->receiver(r.receiver).p_B, sigma * sigma};
    const Vector3 p_W = fit.X_WB * range.antenna_B;
    const auto could_be = [&](int i) {
      return heard_->beacon(i).code == r.code && heard_->are_facing(fit.X_WB, r.receiver, i);
    };
    double nearest_m = std::numeric_limits<double>::infinity();
    const int count = static_cast<int>(heard_->beacons().size());
    for (int i = 0; i < count; ++i) {
      if (could_be(i)) nearest_m = std::min(nearest_m, (heard_->beacon(i).p_W - p_W).norm());
    }
    TargetState<1> state;
    state.X_WB = fit.X_WB;
    int found = -1, explanations = 0;
    double least = gate_;
    for (int i = 0; i < count; ++i) {
      Linearization<Range> linear;
      if (!could_be(i) || !range.linearize(state, heard_->beacon(i).p_W, {}, linear)) continue;
      const double variance = linear.R(0, 0) + (linear.H * fit.covariance * linear.H.transpose()).value();
      const double further_m = (heard_->beacon(i).p_W - p_W).norm() - nearest_m;
      // Of two that are as near as the pose is uncertain either may be the first.
      if (further_m * further_m > 4.0 * gate_ * variance) continue;
      const double nis = linear.residual[0] * linear.residual[0] / variance;
      if (!(nis < gate_)) continue;
      ++explanations;
      if (nis < least || found < 0) {
        least = nis;
        found = i;
      }
    }
    return sole && explanations > 1 ? -1 : found;
  }

  [[nodiscard]] bool is_same(const Rigid& a, const Rigid& b) const {
    const RangeAcquisitionSettings& settings = heard_->settings();
    return (a.p() - b.p()).norm() < settings.same_pose_m && so3::angle_between(a.q(), b.q()) < settings.same_pose_rad;
  }

  /// The best pose and how many ranges agree with the next best.
  [[nodiscard]] std::pair<const Candidate*, int> best() const {
    const Candidate* best = nullptr;
    int rival = 0;
    for (const Candidate& c : found_) {
      if (best == nullptr || c.agreeing > best->agreeing) {
        if (best != nullptr) rival = best->agreeing;
        best = &c;
      } else {
        rival = std::max(rival, c.agreeing);
      }
    }
    return {best, rival};
  }

  const HeardCodes* heard_;
  double gate_;
  std::vector<Candidate> found_;
};

}  // namespace holdfast::detail
