/// Acquisition by ranges: pose from nothing but the ranges to coded beacons (003 section 2.2).
///
///  1. Codes are ordered by how near they are; 4-tuples of them are tried, the nearest first.
///  2. For each place in the constellation that has this combination of beacons as close together as the ranges allow, each
///     receiver that heard all four is placed by trilateration, on either side of beacons that hang in a plane. Four ranges for
///     three numbers: a receiver that they do not agree on (an echo, an early pulse, the wrong place) does not count.
///  3. Receivers so placed, with the directions that inertial sensors know, give the orientation; least squares of all their ranges
///     the pose. It must pass chi-square, and transducers must face each other: so mirrored poses fall.
///  4. Every other range is asked. The pose that most agree with wins; a rival with as many, or nearly, means ambiguous.
/// A tuple with wrong ranges finds no such pose, and the next one has its turn.
/// Orientation needs three receivers that are not in one line, or two and the vertical, or one with vertical and heading.
/// Codes that no beacon of the constellation has are left out. Ranges count as simultaneous; `sigma_m` must cover motion,
/// and systematic errors. Allocates: for once, not for every frame.
/// Bad input: RangeAcquisitionStatus names why there is no pose.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>
#include <string_view>
#include <vector>

#include <holdfast/geometry/align.hpp>
#include <holdfast/tracking/chi_square.hpp>
#include <holdfast/tracking/coded_range.hpp>
#include <holdfast/tracking/range_resection.hpp>
#include <holdfast/tracking/trilateration.hpp>

namespace holdfast {

struct RangeAcquisitionSettings {
  double sigma_m = 0.005;           ///< of a range, with all its errors
  double gate_probability = 0.999;  ///< that right ranges pass
  double minimum_share = 0.6;       ///< of the ranges that must agree with the pose: four of eight codes do with any
  double settled_share = 0.7;       ///< with so many no further tuple is tried
  int margin = 3;                   ///< by so many ranges more than any other pose: one beacon's, with three receivers
  int tuples = 100;                 ///< at most, of codes, that are tried
  double same_pose_m = 0.05;        ///< nearer than this, and
  double same_pose_rad = 0.05;      ///< than this, two poses are one
};

enum class RangeAcquisitionStatus {
  acquired,
  bad_reading,      ///< not finite, not positive, or of a receiver that is not there
  repeated_code,    ///< one receiver, one code, two ranges
  too_few,          ///< no receiver with ranges to four known codes
  no_orientation,   ///< receivers and known directions leave a turn free
  beacons_in_line,  ///< all that could have been heard hang in one line, within 1 mm
  no_pose,          ///< the ranges contradict each other wherever the beacons are looked for
  ambiguous         ///< several poses explain them: more beacons, or their axes, or the vertical would tell
};

[[nodiscard]] constexpr std::string_view to_string(RangeAcquisitionStatus status) {
  constexpr std::array<std::string_view, 8> names{"acquired",       "bad_reading",     "repeated_code", "too_few",
                                                  "no_orientation", "beacons_in_line", "no_pose",       "ambiguous"};
  return names[static_cast<std::size_t>(status)];
}

struct RangeAcquisition {
  RangeAcquisitionStatus status = RangeAcquisitionStatus::too_few;
  Rigid X_WB;
  Matrix6 covariance = Matrix6::Zero();  ///< of (dp, dphi), by sigma_m
  std::vector<int> beacon;               ///< of each range: the beacon that it agrees with, -1 for none
  int agreeing = 0;                      ///< ranges
  int rival = 0;                         ///< ranges that agree with the next best pose
  int tuples_tried = 0;

  [[nodiscard]] bool ok() const { return status == RangeAcquisitionStatus::acquired; }
};

namespace detail {

class RangePoseSearch {
 public:
  RangePoseSearch(std::span<const CodedBeacon> beacons, std::span<const RangeReceiver> receivers,
                  std::span<const CodedRange> ranges, std::span<const SeenDirection> directions,
                  const RangeAcquisitionSettings& settings)
      : beacons_(beacons), receivers_(receivers), ranges_(ranges), directions_(directions), settings_(settings) {}

  [[nodiscard]] RangeAcquisition run() {
    RangeAcquisition result;
    if (const auto problem = take_readings()) {
      result.status = *problem;
      return result;
    }
    if (!can_be_oriented()) {
      result.status = RangeAcquisitionStatus::no_orientation;
      return result;
    }
    const int count = static_cast<int>(codes_.size());
    // The nearest four first, then those with the fifth, and so on.
    for (int d = 3; d < count; ++d) {
      for (int c = 2; c < d; ++c) {
        for (int b = 1; b < c; ++b) {
          for (int a = 0; a < b; ++a) {
            if (tried_ >= settings_.tuples || (tried_ > 0 && is_settled())) return judged();
            try_tuple({a, b, c, d});
          }
        }
      }
    }
    return judged();
  }

 private:
  /// The ranges to one code, by receiver; NaN: none.
  struct HeardCode {
    int code = 0;
    double nearest_m = std::numeric_limits<double>::infinity();
    std::vector<double> range_m;
    std::vector<int> beacons;  ///< with this code
  };
  struct Candidate {
    Rigid X_WB;
    Matrix6 covariance = Matrix6::Zero();
    std::vector<int> beacon;
    int agreeing = 0;
  };
  using Four = std::array<int, 4>;  // of codes_, or of beacons_

  [[nodiscard]] std::optional<RangeAcquisitionStatus> take_readings() {
    for (const CodedRange& r : ranges_) {
      const bool exists = r.receiver >= 0 && static_cast<std::size_t>(r.receiver) < receivers_.size();
      if (!exists || !std::isfinite(r.range_m) || !(r.range_m > 0.0)) return RangeAcquisitionStatus::bad_reading;
      auto heard = std::find_if(codes_.begin(), codes_.end(), [&](const HeardCode& h) { return h.code == r.code; });
      if (heard == codes_.end()) {
        HeardCode fresh;
        fresh.code = r.code;
        fresh.range_m.assign(receivers_.size(), std::nan(""));
        for (std::size_t i = 0; i < beacons_.size(); ++i) {
          if (beacons_[i].code == r.code && beacons_[i].p_W.allFinite()) fresh.beacons.push_back(static_cast<int>(i));
        }
        heard = codes_.insert(codes_.end(), fresh);
      }
      double& slot = heard->range_m[static_cast<std::size_t>(r.receiver)];
      if (!std::isnan(slot)) return RangeAcquisitionStatus::repeated_code;
      slot = r.range_m;
      heard->nearest_m = std::min(heard->nearest_m, r.range_m);
    }
    std::erase_if(codes_, [](const HeardCode& h) { return h.beacons.empty(); });
    std::stable_sort(codes_.begin(), codes_.end(),
                     [](const HeardCode& a, const HeardCode& b) { return a.nearest_m < b.nearest_m; });
    for (std::size_t k = 0; k < receivers_.size(); ++k) {
      const auto heard =
          std::count_if(codes_.begin(), codes_.end(), [&](const HeardCode& h) { return !std::isnan(h.range_m[k]); });
      if (heard >= 4) return std::nullopt;
    }
    return RangeAcquisitionStatus::too_few;
  }

  /// Whether all receivers and directions together fix an orientation.
  [[nodiscard]] bool can_be_oriented() const {
    std::vector<int> all;
    for (std::size_t k = 0; k < receivers_.size(); ++k) all.push_back(static_cast<int>(k));
    std::vector<Vector3> as_they_are;
    for (const RangeReceiver& receiver : receivers_) as_they_are.push_back(receiver.p_B);
    std::vector<Vector3> known;  // the directions must not lie in one line either: seen ones stand for both sides
    for (const SeenDirection& d : directions_) known.push_back(d.seen_B);
    return orientation(all, as_they_are, known).has_value();
  }

  /// Rotation that lays receivers and directions of B best over those of W.
  [[nodiscard]] std::optional<Matrix3> orientation(const std::vector<int>& placed, const std::vector<Vector3>& p_W,
                                                   const std::vector<Vector3>& direction_W) const {
    Vector3 centre_W = Vector3::Zero(), centre_B = Vector3::Zero();
    for (std::size_t i = 0; i < placed.size(); ++i) {
      centre_W += p_W[i] / static_cast<double>(placed.size());
      centre_B += receiver(placed[i]).p_B / static_cast<double>(placed.size());
    }
    Matrix3 M = Matrix3::Zero();
    for (std::size_t i = 0; i < placed.size(); ++i) {
      M += (p_W[i] - centre_W) * (receiver(placed[i]).p_B - centre_B).transpose() /
           (settings_.sigma_m * settings_.sigma_m);
    }
    for (std::size_t i = 0; i < directions_.size(); ++i) {
      const SeenDirection& d = directions_[i];
      M += direction_W[i] * d.seen_B.transpose() / (d.sigma_rad * d.sigma_rad);
    }
    const auto nearest = align_detail::nearest_rotation(M, 1e-8);
    if (!nearest) return std::nullopt;
    return nearest->R;
  }

  [[nodiscard]] const RangeReceiver& receiver(int k) const { return receivers_[static_cast<std::size_t>(k)]; }
  [[nodiscard]] const CodedBeacon& beacon(int i) const { return beacons_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] const HeardCode& heard(int i) const { return codes_[static_cast<std::size_t>(i)]; }

  /// Whether two beacons can be as far apart as they are, by at least one receiver: the triangle's inequality.
  [[nodiscard]] bool are_close(int code_a, int beacon_a, int code_b, int beacon_b) const {
    const double apart = (beacon(beacon_a).p_W - beacon(beacon_b).p_W).norm(), slack = 10.0 * settings_.sigma_m;
    for (std::size_t k = 0; k < receivers_.size(); ++k) {
      const double a = heard(code_a).range_m[k], b = heard(code_b).range_m[k];
      if (apart <= a + b + slack && apart >= std::abs(a - b) - slack) return true;
    }
    return false;
  }

  void try_tuple(const Four& codes) {
    ++tried_;
    // Only receivers that heard all four can tell.
    std::vector<int> complete;
    for (std::size_t k = 0; k < receivers_.size(); ++k) {
      const bool all = std::all_of(codes.begin(), codes.end(), [&](int c) { return !std::isnan(heard(c).range_m[k]); });
      if (all) complete.push_back(static_cast<int>(k));
    }
    if (complete.empty()) return;
    for (const int a : heard(codes[0]).beacons) {
      for (const int b : heard(codes[1]).beacons) {
        if (!are_close(codes[0], a, codes[1], b)) continue;
        for (const int c : heard(codes[2]).beacons) {
          if (!are_close(codes[0], a, codes[2], c) || !are_close(codes[1], b, codes[2], c)) continue;
          const std::vector<Vector3> by_three = placed_by_three(codes, {a, b, c, -1}, complete);
          for (const int d : heard(codes[3]).beacons) {
            if (is_within_reach(codes[3], d, complete, by_three)) try_hypothesis(codes, {a, b, c, d}, complete);
          }
        }
      }
    }
  }

  /// Where each complete receiver is by the first three beacons, on either side: two each, or NaN if they are in line.
  [[nodiscard]] std::vector<Vector3> placed_by_three(const Four& codes, const Four& tuple,
                                                     const std::vector<int>& complete) const {
    std::vector<Vector3> places;
    for (const int k : complete) {
      const std::array<AnchorRange, 4> four = anchor_ranges(codes, tuple, k);
      const auto found = trilaterate(std::span(four).first(3));
      const Vector3 nowhere = Vector3::Constant(std::nan(""));
      places.push_back(found ? found->above_W : nowhere);
      places.push_back(found ? found->below_W : nowhere);
    }
    return places;
  }

  /// Whether the fourth beacon's range is near what three beacons let expect of at least one receiver. Coarse: it only saves
  /// work.
  [[nodiscard]] bool is_within_reach(int code, int i, const std::vector<int>& complete,
                                     const std::vector<Vector3>& places) const {
    for (std::size_t n = 0; n < places.size(); ++n) {
      const double measured = heard(code).range_m[static_cast<std::size_t>(complete[n / 2])];
      const double off = std::abs((places[n] - beacon(i).p_W).norm() - measured);
      if (!(off > 40.0 * settings_.sigma_m)) return true;  // NaN passes
    }
    return false;
  }

  [[nodiscard]] std::array<AnchorRange, 4> anchor_ranges(const Four& codes, const Four& tuple, int k) const {
    std::array<AnchorRange, 4> ranges;
    for (std::size_t i = 0; i < 4; ++i) {
      if (tuple[i] < 0) continue;
      ranges[i] = {beacon(tuple[i]).p_W, heard(codes[i]).range_m[static_cast<std::size_t>(k)]};
    }
    return ranges;
  }

  /// The normal of the plane that four beacons are in, or nearly; zero if they hang in one line.
  [[nodiscard]] Vector3 normal(const Four& tuple) const {
    Vector3 longest = Vector3::Zero();
    const Vector3& from = beacon(tuple[0]).p_W;
    for (std::size_t i = 1; i < 4; ++i) {
      const Vector3 first = beacon(tuple[i]).p_W - from, second = beacon(tuple[i % 3 + 1]).p_W - from;
      const Vector3 across = first.cross(second);
      if (across.norm() > longest.norm()) longest = across;
    }
    if (!(longest.norm() > 1e-3)) return Vector3::Zero();
    return longest.normalized();
  }

  void try_hypothesis(const Four& codes, const Four& tuple, const std::vector<int>& complete) {
    const Vector3 up_W = normal(tuple);
    if (up_W.isZero()) return;
    std::vector<int> placed;
    std::vector<Vector3> above_W, below_W;
    for (const int k : complete) {
      const std::array<AnchorRange, 4> four = anchor_ranges(codes, tuple, k);
      const std::optional<Trilateration> found = trilaterate(four);
      if (!found || !(std::min(found->above_rms_m, found->below_rms_m) < 4.0 * settings_.sigma_m)) continue;
      const bool turned = (found->above_W - found->below_W).dot(up_W) < 0.0;
      placed.push_back(k);
      above_W.push_back(turned ? found->below_W : found->above_W);
      below_W.push_back(turned ? found->above_W : found->below_W);
    }
    if (placed.empty()) return;
    try_places(codes, tuple, placed, above_W);
    if (above_W != below_W) try_places(codes, tuple, placed, below_W);
  }

  void try_places(const Four& codes, const Four& tuple, const std::vector<int>& placed,
                  const std::vector<Vector3>& p_W) {
    std::vector<Vector3> known;
    for (const SeenDirection& d : directions_) known.push_back(d.direction_W);
    const std::optional<Matrix3> R_WB = orientation(placed, p_W, known);
    if (!R_WB) return;
    Vector3 origin_W = Vector3::Zero();
    std::vector<ReceiverRange> ranges;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const Vector3& p_B = receiver(placed[i]).p_B;
      origin_W += (p_W[i] - *R_WB * p_B) / static_cast<double>(placed.size());
      for (const AnchorRange& r : anchor_ranges(codes, tuple, placed[i])) {
        ranges.push_back({r.anchor_W, p_B, r.range_m, settings_.sigma_m});
      }
    }
    const Resection found = resect_ranges(ranges, directions_, Rigid(Quaternion(*R_WB), origin_W));
    const int freedom = static_cast<int>(ranges.size() + 2 * directions_.size()) - 6;
    if (!found.ok() || freedom < 1) return;
    if (found.cost > chi_square_quantile(settings_.gate_probability, freedom)) return;
    for (const int k : placed) {
      for (const int i : tuple) {
        if (!are_facing(found.X_WB, k, i)) return;
      }
    }
    consider(found);
  }

  /// Whether receiver and beacon lie in front of each other.
  [[nodiscard]] bool are_facing(const Rigid& X_WB, int k, int i) const {
    const Vector3 down = X_WB * receiver(k).p_B - beacon(i).p_W;
    return down.dot(beacon(i).axis_W) >= 0.0 && down.dot(X_WB.q() * receiver(k).axis_B) <= 0.0;
  }

  /// Asks every range, takes all that agree into the pose, and asks again.
  void consider(const Resection& by_tuple) {
    Candidate candidate = agreement(by_tuple.X_WB, by_tuple.covariance);
    std::vector<ReceiverRange> ranges;
    for (std::size_t n = 0; n < ranges_.size(); ++n) {
      if (candidate.beacon[n] < 0) continue;
      ranges.push_back(
          {beacon(candidate.beacon[n]).p_W, receiver(ranges_[n].receiver).p_B, ranges_[n].range_m, settings_.sigma_m});
    }
    const Resection refined = resect_ranges(ranges, directions_, by_tuple.X_WB);
    if (!refined.ok()) return;
    candidate = agreement(refined.X_WB, refined.covariance);
    const auto same =
        std::find_if(found_.begin(), found_.end(), [&](const Candidate& c) { return is_same(c.X_WB, candidate.X_WB); });
    if (same == found_.end()) {
      found_.push_back(candidate);
    } else if (candidate.agreeing > same->agreeing) {
      *same = candidate;
    }
  }

  /// Which beacon each range is of, if the pose is right. Of several with its code the one that fits best.
  [[nodiscard]] Candidate agreement(const Rigid& X_WB, const Matrix6& covariance) const {
    Candidate candidate{X_WB, covariance, std::vector<int>(ranges_.size(), -1)};
    const double gate = chi_square_quantile(settings_.gate_probability, 1);
    TargetState<1> state;
    state.X_WB = X_WB;
    for (std::size_t n = 0; n < ranges_.size(); ++n) {
      const CodedRange& r = ranges_[n];
      double least = gate;
      for (std::size_t i = 0; i < beacons_.size(); ++i) {
        if (beacons_[i].code != r.code || !are_facing(X_WB, r.receiver, static_cast<int>(i))) continue;
        Linearization<Range> linear;
        const Range range{r.range_m, receiver(r.receiver).p_B, settings_.sigma_m * settings_.sigma_m};
        if (!range.linearize(state, beacons_[i].p_W, {}, linear)) continue;
        const double variance = linear.R(0, 0) + (linear.H * covariance * linear.H.transpose()).value();
        const double nis = linear.residual[0] * linear.residual[0] / variance;
        if (!(nis < least)) continue;
        least = nis;
        candidate.beacon[n] = static_cast<int>(i);
      }
      candidate.agreeing += candidate.beacon[n] >= 0;
    }
    return candidate;
  }

  [[nodiscard]] bool is_same(const Rigid& a, const Rigid& b) const {
    return (a.p() - b.p()).norm() < settings_.same_pose_m && so3::angle_between(a.q(), b.q()) < settings_.same_pose_rad;
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

  [[nodiscard]] int usable() const {
    int count = 0;
    for (const HeardCode& h : codes_) {
      count +=
          static_cast<int>(std::count_if(h.range_m.begin(), h.range_m.end(), [](double r) { return !std::isnan(r); }));
    }
    return count;
  }
  [[nodiscard]] bool is_enough(const Candidate& c) const { return c.agreeing >= settings_.minimum_share * usable(); }
  [[nodiscard]] bool is_settled() const {
    const Candidate* candidate = best().first;
    return candidate != nullptr && candidate->agreeing >= settings_.settled_share * usable();
  }

  [[nodiscard]] RangeAcquisition judged() const {
    RangeAcquisition result;
    result.tuples_tried = tried_;
    const auto [candidate, rival] = best();
    if (candidate == nullptr) {
      result.status = in_line() ? RangeAcquisitionStatus::beacons_in_line : RangeAcquisitionStatus::no_pose;
      return result;
    }
    result.X_WB = candidate->X_WB;
    result.covariance = candidate->covariance;
    result.beacon = candidate->beacon;
    result.agreeing = candidate->agreeing;
    result.rival = rival;
    result.status = !is_enough(*candidate)                           ? RangeAcquisitionStatus::no_pose
                    : rival > candidate->agreeing - settings_.margin ? RangeAcquisitionStatus::ambiguous
                                                                     : RangeAcquisitionStatus::acquired;
    return result;
  }

  /// Whether all beacons with codes that were heard hang in one line.
  [[nodiscard]] bool in_line() const {
    const Vector3& from = beacon(codes_.front().beacons.front()).p_W;
    Vector3 longest = Vector3::Zero();
    const auto every = [&](const auto& visit) {
      for (const HeardCode& h : codes_) std::for_each(h.beacons.begin(), h.beacons.end(), visit);
    };
    every([&](int i) {
      const Vector3 apart = beacon(i).p_W - from;
      if (apart.norm() > longest.norm()) longest = apart;
    });
    double across = 0.0;
    every([&](int i) { across = std::max(across, longest.cross(beacon(i).p_W - from).norm()); });
    return across <= 1e-3 * longest.norm();
  }

  std::span<const CodedBeacon> beacons_;
  std::span<const RangeReceiver> receivers_;
  std::span<const CodedRange> ranges_;
  std::span<const SeenDirection> directions_;
  RangeAcquisitionSettings settings_;
  std::vector<HeardCode> codes_;  // the nearest first
  std::vector<Candidate> found_;
  int tried_ = 0;
};

}  // namespace detail

/// The body's pose in the beacons' world W from `ranges` to `constellation`, heard by `receivers` of the body B, all of one moment.
/// `directions`: what inertial sensors and a compass know, for fewer than three receivers. Metres, radians.
/// Bad input: the answer's status names it, and its pose then means nothing.
[[nodiscard]] inline RangeAcquisition acquire_by_ranges(std::span<const CodedBeacon> constellation,
                                                        std::span<const RangeReceiver> receivers,
                                                        std::span<const CodedRange> ranges,
                                                        std::span<const SeenDirection> directions = {},
                                                        const RangeAcquisitionSettings& settings = {}) {
  return detail::RangePoseSearch(constellation, receivers, ranges, directions, settings).run();
}

}  // namespace holdfast
