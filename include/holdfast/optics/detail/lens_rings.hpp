/// Where the rings of a mesh of rings and spokes stand, and how many vertices each has (polar_mesher.hpp).
///
/// A lens that is a function of the radius bends along it more than across, by f'' against f'/r - f/r^2. Between two
/// rings d apart, with vertices L apart on each, linear interpolation misses at most
///
///     sqrt((f'' d^2 + A L^2)^2 + (2 A d L)^2) / 8,     A = (f / r)'
///
/// (radial_bend.hpp: the longest edge goes d along the radius and L across.) L takes a fixed part of the bound, d what is
/// left. A ring stands where the slope jumps and where the domain ends, with vertices close enough for its chords.
/// Rings need not have equally many vertices.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numbers>
#include <vector>

#include <holdfast/optics/detail/radial_bend.hpp>
#include <holdfast/optics/predistortion_mesh_types.hpp>

namespace holdfast::detail {

/// Lengths in the lens's unit.
struct LensRing {
  double radius = 0.0;
  double step = 0.0;        ///< from the ring within
  std::size_t sectors = 0;  ///< 0: the centre

  /// Of its vertices.
  [[nodiscard]] double apart() const {
    return sectors == 0 ? 0.0 : 2.0 * std::numbers::pi * radius / static_cast<double>(sectors);
  }
  /// Of the largest disc within the polygon.
  [[nodiscard]] double inner_radius() const {
    return sectors == 0 ? 0.0 : radius * std::cos(std::numbers::pi / static_cast<double>(sectors));
  }
};

class LensRings {
 public:
  static constexpr double margin =
      1.2;  ///< for the table's steps, bends that differ within a triangle, and rounding to float

  LensRings(const RadialBend::Group& bend, const AdaptiveMeshOptions& options)
      : bend_(bend), room_(8.0 * options.max_error_px / (margin * bend.px)) {
    for (const RadialBend::Kink& kink : bend.kinks)
      stops_.push_back({kink.radius, 0.1 * room_ * kink.radius / kink.jump});
    if (std::isfinite(bend.end_radius)) {
      // A hair inside, for the rounding of its points.
      const double end = bend.end_radius * (1.0 - 1e-6);
      stops_.push_back({end, 8.0 * end * options.border_error_px / bend.px});
    }
    std::sort(stops_.begin(), stops_.end(), [](const Stop& a, const Stop& b) { return a.radius < b.radius; });
  }

  /// From the centre to the end of the domain or beyond the panel.
  [[nodiscard]] std::vector<LensRing> chosen() const {
    std::vector<LensRing> rings{{0.0, bend_.widest / 6.0, 0}};
    while (rings.back().radius < last_radius() && rings.back().inner_radius() < bend_.widest) {
      rings.push_back(ring_round(rings.back()));
    }
    return rings;
  }

  /// What interpolation between two neighbouring rings misses at most, without the margin.
  [[nodiscard]] double missed_px(const LensRing& inner, const LensRing& outer) const {
    return missed(bend_between(inner, outer), outer.step, apart(inner, outer)) * bend_.px / 8.0;
  }

 private:
  static constexpr double share_across = 0.45;

  /// A radius at which a ring has to be.
  struct Stop {
    double radius;
    double largest_apart2;  ///< squared distance of its vertices, for the sake of its chords
  };

  /// Rings and their vertices need not be closer than 1/32 px, in the lens's unit.
  [[nodiscard]] double shortest() const { return 1.0 / (32.0 * bend_.px); }
  [[nodiscard]] double last_radius() const {
    return std::isfinite(bend_.end_radius) ? stops_.back().radius : std::numeric_limits<double>::infinity();
  }

  [[nodiscard]] RadialBend::Bend bend_between(double low, double high) const {
    return bend_.between(low * low, high * high);
  }
  /// The same for triangles between two rings: at its ends a chord of a ring is not square to the radius.
  [[nodiscard]] RadialBend::Bend bend_between(const LensRing& inner, const LensRing& outer) const {
    RadialBend::Bend bend = bend_between(inner.radius, outer.radius);
    const double turned = apart(inner, outer) / (2.0 * outer.radius);
    bend.across += bend.along * turned * turned;
    return bend;
  }
  [[nodiscard]] static double apart(const LensRing& inner, const LensRing& outer) {
    return std::max(inner.apart(), outer.apart());
  }

  [[nodiscard]] LensRing ring_round(const LensRing& inner) const {
    LensRing outer;
    const Stop* stop = nullptr;
    for (auto s = stops_.rbegin(); s != stops_.rend(); ++s) stop = s->radius > inner.radius ? &*s : stop;
    const double to_stop = stop ? stop->radius - inner.radius : std::numeric_limits<double>::infinity();
    for (double step = std::min(1.5 * inner.step, to_stop);;) {
      // Of what is left to the stop two rings make halves, not a ring and a rest.
      if (step < to_stop && 1.5 * step > to_stop) step = to_stop / 2.0;
      const bool is_stop = step >= to_stop;
      outer.radius = is_stop ? stop->radius : inner.radius + step;
      outer.step = step;
      // What the next rings need across, too.
      const RadialBend::Bend about = bend_between(inner.radius, outer.radius + 2.0 * step);
      outer.sectors = sectors(outer.radius, about.across, is_stop ? stop->largest_apart2 : 0.0);
      const RadialBend::Bend bend = bend_between(inner, outer);
      const double found = missed(bend, step, apart(inner, outer));
      if (found <= room_ || step < shortest()) return outer;
      const double largest = largest_step(bend, apart(inner, outer));
      step = largest > 0.0 ? std::min(0.98 * largest, 0.9 * step) : 0.7 * step;
    }
  }

  [[nodiscard]] std::size_t sectors(double radius, double across, double largest_apart2) const {
    double apart2 = share_across * room_ / std::max(across, 1e-12);
    if (largest_apart2 > 0.0) apart2 = std::min(apart2, largest_apart2);
    apart2 = std::max(apart2, shortest() * shortest());
    constexpr double fewest = 8.0;
    return static_cast<std::size_t>(std::max(fewest, std::ceil(2.0 * std::numbers::pi * radius / std::sqrt(apart2))));
  }

  /// Eight times what interpolation misses, in the lens's unit.
  [[nodiscard]] static double missed(const RadialBend::Bend& bend, double step, double apart) {
    const double both = (bend.along + bend.across) * step * step + bend.across * apart * apart;
    const double askew = 2.0 * bend.across * step * apart;
    return std::sqrt(both * both + askew * askew);
  }
  /// The step that misses as much as there is room for; 0 or less: none.
  [[nodiscard]] double largest_step(const RadialBend::Bend& bend, double apart) const {
    const double along = bend.along + bend.across, across = bend.across * apart * apart;
    const double half_b = along * across + 2.0 * bend.across * across, c = across * across - room_ * room_;
    if (!(c < 0.0) || !(along > 0.0)) return 0.0;
    return std::sqrt((-half_b + std::sqrt(half_b * half_b - along * along * c)) / (along * along));
  }

  const RadialBend::Group& bend_;
  double room_;  ///< eight times what may be missed
  std::vector<Stop> stops_;
};

}  // namespace holdfast::detail
