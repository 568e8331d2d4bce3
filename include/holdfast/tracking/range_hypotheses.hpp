/// Poses that the ranges to four codes suggest: the first half of acquisition by ranges (003 section 2.2, steps 1 and 2).
///
/// Four codes hang together in many places of a large room. Each such place is a hypothesis that
///  - has beacons as close together as the ranges allow: the triangle's inequality,
///  - places at least one receiver by three spheres, on a side from which it hears the three, no other beacon with one of their
///    codes being nearer, and the fourth at about its range,
///  - explains that receiver's four ranges by least squares: four for three numbers, so most wrong places contradict themselves.
/// Receivers so placed, with the directions that inertial sensors know, give the orientation, and least squares of all their
/// ranges the pose. It must pass chi-square, and transducers must face each other. The verdict gets it (range_verdict.hpp).
/// Allocates. Preconditions: HeardCodes::take found nothing wrong.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <vector>

#include <holdfast/geometry/align.hpp>
#include <holdfast/tracking/range_verdict.hpp>
#include <holdfast/tracking/trilateration.hpp>

namespace holdfast::detail {

class RangeHypotheses {
 public:
  using Four = std::array<int, 4>;  // of codes, or of beacons

  explicit RangeHypotheses(const HeardCodes& heard) : heard_(&heard), coarse_m_(40.0 * heard.settings().sigma_m) {}

  /// Whether all receivers and directions together fix an orientation.
  [[nodiscard]] bool can_be_oriented() const {
    std::vector<int> all;
    std::vector<Vector3> as_they_are;
    for (int k = 0; k < heard_->receivers(); ++k) {
      all.push_back(k);
      as_they_are.push_back(heard_->receiver(k).p_B);
    }
    std::vector<Vector3> known;  // the directions must not lie in one line either: seen ones stand for both sides
    for (const SeenDirection& d : heard_->directions()) known.push_back(d.seen_B);
    return orientation(all, as_they_are, known).has_value();
  }

  /// Offers the verdict all poses by these four codes.
  void try_codes(const Four& codes, RangeVerdict& verdict) const {
    const std::vector<int> complete = complete_receivers(codes);
    if (complete.empty()) return;
    for (const int a : heard_->heard(codes[0]).beacons) {
      for (const int b : heard_->heard(codes[1]).beacons) {
        if (!are_close(codes[0], a, codes[1], b)) continue;
        for (const int c : heard_->heard(codes[2]).beacons) {
          if (!are_close(codes[0], a, codes[2], c) || !are_close(codes[1], b, codes[2], c)) continue;
          if (are_in_line(a, b, c)) {  // then the fourth places the receivers, and the third is asked
            const Four other{codes[0], codes[1], codes[3], codes[2]};
            for (const int d : heard_->heard(codes[3]).beacons) {
              if (!are_in_line(a, b, d))
                try_beacons(other, {a, b, d, c}, by_three(other, {a, b, d, -1}, complete), verdict);
            }
            continue;
          }
          const std::vector<Place> places = by_three(codes, {a, b, c, -1}, complete);
          if (places.empty()) continue;
          for (const int d : heard_->heard(codes[3]).beacons) try_beacons(codes, {a, b, c, d}, places, verdict);
        }
      }
    }
  }

 private:
  /// Where a receiver may be, on one side of the beacons.
  struct Place {
    int receiver = 0, side = 0;
    Vector3 p_W = Vector3::Zero();
  };

  /// Only receivers that heard all four can tell.
  [[nodiscard]] std::vector<int> complete_receivers(const Four& codes) const {
    std::vector<int> complete;
    for (int k = 0; k < heard_->receivers(); ++k) {
      const bool all =
          std::all_of(codes.begin(), codes.end(), [&](int c) { return !std::isnan(heard_->range_m(c, k)); });
      if (all) complete.push_back(k);
    }
    return complete;
  }

  /// Whether two beacons can be as far apart as they are, by at least one receiver: the triangle's inequality.
  [[nodiscard]] bool are_close(int code_a, int beacon_a, int code_b, int beacon_b) const {
    const double apart_m = (heard_->beacon(beacon_a).p_W - heard_->beacon(beacon_b).p_W).norm();
    const double slack_m = 10.0 * heard_->settings().sigma_m;
    for (int k = 0; k < heard_->receivers(); ++k) {
      const double a = heard_->range_m(code_a, k), b = heard_->range_m(code_b, k);
      if (apart_m <= a + b + slack_m && apart_m >= std::abs(a - b) - slack_m) return true;
    }
    return false;
  }

  [[nodiscard]] bool are_in_line(int a, int b, int c) const {
    const Vector3 &a_W = heard_->beacon(a).p_W, &b_W = heard_->beacon(b).p_W, &c_W = heard_->beacon(c).p_W;
    return !((b_W - a_W).cross(c_W - a_W).norm() > 1e-3 * (b_W - a_W).norm());
  }

  /// Where each complete receiver can be by the first three beacons, on either side: where three spheres meet (000 eqs 4.1-4.3).
  /// Precondition: the three are not in one line.
  [[nodiscard]] std::vector<Place> by_three(const Four& codes, const Four& tuple,
                                            const std::vector<int>& complete) const {
    std::vector<Place> places;
    const Vector3& a_W = heard_->beacon(tuple[0]).p_W;
    const Vector3 ab_W = heard_->beacon(tuple[1]).p_W - a_W, ac_W = heard_->beacon(tuple[2]).p_W - a_W;
    const double apart = ab_W.norm(), along = ab_W.dot(ac_W) / apart;
    const Vector3 x_W = ab_W / apart, off_W = ac_W - along * x_W;
    const double across = off_W.norm();
    const Vector3 y_W = off_W / across, z_W = x_W.cross(y_W);
    for (const int k : complete) {
      const double ra = heard_->range_m(codes[0], k), rb = heard_->range_m(codes[1], k),
                   rc = heard_->range_m(codes[2], k);
      const double x = (ra * ra - rb * rb + apart * apart) / (2.0 * apart);
      const double y = (ra * ra - rc * rc + along * along + across * across - 2.0 * along * x) / (2.0 * across);
      const double square = ra * ra - x * x - y * y;
      if (square < -coarse_m_ * ra) continue;  // the spheres do not meet
      const double z = std::sqrt(std::max(0.0, square));
      for (const int side : {0, 1}) {
        const Place place{k, side, a_W + x * x_W + y * y_W + (side == 0 ? z : -z) * z_W};
        if (is_first_heard(codes, tuple, place, 3)) places.push_back(place);
      }
    }
    return places;
  }

  /// Whether a receiver there would hear these beacons, roughly, and no others of their codes before them.
  [[nodiscard]] bool is_first_heard(const Four& codes, const Four& tuple, const Place& place, std::size_t count) const {
    for (std::size_t n = 0; n < count; ++n) {
      const CodedBeacon& beacon = heard_->beacon(tuple[n]);
      if ((place.p_W - beacon.p_W).dot(beacon.axis_W) < -coarse_m_) return false;
      const double before_m = heard_->range_m(codes[n], place.receiver) - coarse_m_;
      if (before_m <= 0.0) continue;
      for (const int i : heard_->heard(codes[n]).beacons) {
        const Vector3 apart_W = place.p_W - heard_->beacon(i).p_W;
        const bool is_nearer = apart_W.squaredNorm() < before_m * before_m;
        if (is_nearer && apart_W.dot(heard_->beacon(i).axis_W) >= 0.0) return false;
      }
    }
    return true;
  }

  void try_beacons(const Four& codes, const Four& tuple, const std::vector<Place>& by_three,
                   RangeVerdict& verdict) const {
    std::array<std::vector<Place>, 2> sides;
    for (const Place& place : by_three) {
      const double expected_m = (place.p_W - heard_->beacon(tuple[3]).p_W).norm();
      if (std::abs(expected_m - heard_->range_m(codes[3], place.receiver)) > coarse_m_) continue;
      const auto [p_W, rms_m] = polish_position(anchor_ranges(codes, tuple, place.receiver), place.p_W);
      if (!(rms_m < 4.0 * heard_->settings().sigma_m)) continue;
      const Place placed{place.receiver, place.side, p_W};
      if (is_first_heard(codes, tuple, placed, 4)) sides[static_cast<std::size_t>(place.side)].push_back(placed);
    }
    for (const std::vector<Place>& places : sides) {
      if (!places.empty()) try_places(codes, tuple, places, verdict);
    }
  }

  [[nodiscard]] std::array<AnchorRange, 4> anchor_ranges(const Four& codes, const Four& tuple, int k) const {
    std::array<AnchorRange, 4> ranges;
    for (std::size_t i = 0; i < 4; ++i) ranges[i] = {heard_->beacon(tuple[i]).p_W, heard_->range_m(codes[i], k)};
    return ranges;
  }

  /// Rotation that lays receivers and directions of B best over those of W.
  [[nodiscard]] std::optional<Matrix3> orientation(const std::vector<int>& placed, const std::vector<Vector3>& p_W,
                                                   const std::vector<Vector3>& direction_W) const {
    Vector3 centre_W = Vector3::Zero(), centre_B = Vector3::Zero();
    for (std::size_t i = 0; i < placed.size(); ++i) {
      centre_W += p_W[i] / static_cast<double>(placed.size());
      centre_B += heard_->receiver(placed[i]).p_B / static_cast<double>(placed.size());
    }
    const double sigma_m = heard_->settings().sigma_m;
    Matrix3 M = Matrix3::Zero();
    for (std::size_t i = 0; i < placed.size(); ++i) {
      M += (p_W[i] - centre_W) * (heard_->receiver(placed[i]).p_B - centre_B).transpose() / (sigma_m * sigma_m);
    }
    for (std::size_t i = 0; i < direction_W.size(); ++i) {
      const SeenDirection& d = heard_->directions()[i];
      M += direction_W[i] * d.seen_B.transpose() / (d.sigma_rad * d.sigma_rad);
    }
    const auto nearest = align_detail::nearest_rotation(M, 1e-8);
    if (!nearest) return std::nullopt;
    return nearest->R;
  }

  void try_places(const Four& codes, const Four& tuple, const std::vector<Place>& places, RangeVerdict& verdict) const {
    std::vector<int> placed;
    std::vector<Vector3> p_W, known_W;
    for (const Place& place : places) {
      placed.push_back(place.receiver);
      p_W.push_back(place.p_W);
    }
    for (const SeenDirection& d : heard_->directions()) known_W.push_back(d.direction_W);
    const std::optional<Matrix3> R_WB = orientation(placed, p_W, known_W);
    if (!R_WB) return;
    Vector3 origin_W = Vector3::Zero();
    std::vector<ReceiverRange> ranges;
    for (std::size_t i = 0; i < placed.size(); ++i) {
      const Vector3& p_B = heard_->receiver(placed[i]).p_B;
      origin_W += (p_W[i] - *R_WB * p_B) / static_cast<double>(placed.size());
      for (const AnchorRange& r : anchor_ranges(codes, tuple, placed[i])) {
        ranges.push_back({r.anchor_W, p_B, r.range_m, heard_->settings().sigma_m});
      }
    }
    const Resection found = resect_ranges(ranges, heard_->directions(), Rigid(Quaternion(*R_WB), origin_W));
    if (!found.ok() || !verdict.passes(found, ranges.size())) return;
    for (const int k : placed) {
      for (const int i : tuple) {
        if (!heard_->are_facing(found.X_WB, k, i)) return;
      }
    }
    verdict.consider(found);
  }

  const HeardCodes* heard_;
  double coarse_m_;  ///< so far off three beacons may place a receiver
};

}  // namespace holdfast::detail
