/// How far linear interpolation over triangles of the panel is from radial lenses, without looking through them.
///
/// With p the panel point from the lens's centre, r = |p| and s = f / r, the second derivative along an edge u is
///
///     d2/dt2 distort(p + t u) = (B q + A) |u|^2 along p, and 2 A sqrt(q (1 - q)) |u|^2 across it,
///     A = s',  B = r s'' + s' = f'' - s',  q = cos^2 of the angle between u and p.
///
/// Interpolation misses a function of constant second derivative by 4 (l1 l2 a + l2 l0 b + l0 l1 c) at barycentric
/// l0, l1, l2, with a, b, c what it misses at the edges' middles: |u|^2 / 8 of those derivatives. A table over r^2 holds
/// the largest A and B of all colours; q is largest at a triangle's corner, or 1 where an edge's direction points at the
/// centre. So the error found is one that is not exceeded, and close to the true one.
///
/// Two circles are known exactly: where the lens's domain ends, and where its slope jumps (KinkedProfile). Triangles that
/// one of them crosses will be cut along its chords; an arc leaves its chord h by h^2 / 8 R.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>
#include <utility>
#include <variant>
#include <vector>

#include <holdfast/optics/lens.hpp>
#include <holdfast/optics/radial_model.hpp>
#include <holdfast/optics/tangents.hpp>

namespace holdfast::detail {

/// A circle of the lens on the panel, in tangents: centre + scale .* (a circle of this radius).
struct LensCircle {
  LensPlacement place;
  double radius = 0.0;

  [[nodiscard]] Vector2 to_model(const Vector2& panel) const {
    return (panel - place.centre).cwiseQuotient(place.scale);
  }

  friend bool operator==(const LensCircle&, const LensCircle&) = default;
};

/// Where a radial lens first shows something less than 1/32 as large as it is, by det J / |J|; infinite when it has no
/// fold. (The smallest singular value is between det J / |J| and sqrt(2) times that.)
template <RadialProfile P>
[[nodiscard]] double end_radius(const P& profile, double fold) {
  if (!std::isfinite(fold)) return fold;
  const auto shows = [&](double r) {
    const RadialValue f = profile.at(r);
    const double across = f.seen / r;
    return across * f.slope >= std::hypot(across, f.slope) / 32.0;
  };
  constexpr int steps = 64;  // over the outer half, where folds are near
  double inside = 0.5 * fold, outside = fold;
  for (int i = 1; i <= steps; ++i) {
    const double r = fold * (0.5 + 0.5 * i / steps);
    if (!shows(r)) {
      outside = r;
      break;
    }
    inside = r;
  }
  for (int i = 0; i < 60; ++i) {
    const double middle = inside + (outside - inside) / 2.0;
    (shows(middle) ? inside : outside) = middle;
  }
  return inside;
}
[[nodiscard]] inline double end_radius(const Lens& lens) {
  return std::visit(
      [](const auto& model) {
        if constexpr (RadiallySymmetric<std::remove_cvref_t<decltype(model)>>) {
          return end_radius(model.profile(), model.valid_radius());
        } else {
          return std::numeric_limits<double>::infinity();
        }
      },
      lens.model());
}

[[nodiscard]] inline bool is_radial(const Lens& lens) {
  return std::visit([](const auto& model) { return RadiallySymmetric<std::remove_cvref_t<decltype(model)>>; },
                    lens.model());
}

/// The largest error of the equal triangles that a triangle is cut into.
struct BendError {
  double px = 0.0;
  double border_px = 0.0;  ///< how far the domain's end is from the chords that are drawn
  bool dark = false;       ///< nothing is shown
};

class RadialBend {
 public:
  struct Bend {
    double across = 0.0;  ///< A
    double along = 0.0;   ///< B, never less than A: so the derivative is largest where q is

    void take(const Bend& other) {
      across = std::max(across, other.across);
      along = std::max(along, other.along);
    }
    /// Length of the second derivative along a unit vector.
    [[nodiscard]] double at(double q) const {
      const double radial = along * q + across;
      return std::sqrt(radial * radial + 4.0 * across * across * q * (1.0 - q));
    }
  };

  struct Kink {
    double radius = 0.0;
    double jump = 0.0;  ///< of the slope
  };

  /// Colours of one placement.
  struct Group {
    static constexpr std::size_t bins = 256;

    LensPlacement place;
    double px = 0.0;          ///< per unit of the model, at most
    double end_radius = 0.0;  ///< of the smallest domain
    double widest = 0.0;      ///< beyond every point of the panel
    double bins_per_r2 = 0.0;
    std::vector<Kink> kinks;
    std::vector<std::vector<Bend>> largest;  ///< [level][i]: of the bins from i, 2^level of them

    template <typename Model>
    void add(const Model& model) {
      if constexpr (RadiallySymmetric<Model>) {
        const double range = std::min(widest, end_radius);
        bins_per_r2 = bins / (range * range);
        const std::vector<Bend> bend = bends(model.profile());
        for (std::size_t i = 0; i < bins; ++i) largest[0][i].take(bend[i]);
        if constexpr (KinkedProfile<std::remove_cvref_t<decltype(model.profile())>>) add_kink(model.profile(), range);
      }
    }

    template <typename Profile>
    void add_kink(const Profile& profile, double range) {
      const double r = profile.kink(), beside = 1e-9 * r;
      if (!(r < range)) return;
      const double jump = std::abs(profile.at(r + beside).slope - profile.at(r - beside).slope);
      for (Kink& kink : kinks) {
        if (kink.radius != r) continue;
        kink.jump = std::max(kink.jump, jump);
        return;
      }
      kinks.push_back({r, jump});
    }

    /// Of each bin; f'' is the mean over the bin, and the largest of it and its neighbours.
    template <typename Profile>
    [[nodiscard]] std::vector<Bend> bends(const Profile& profile) const {
      std::vector<Bend> bend(bins);
      std::vector<double> along(bins);
      const auto across = [](const RadialValue& f, double r) { return (f.slope - f.seen / r) / r; };
      const double first = 1e-3 / std::sqrt(bins_per_r2);
      double r = first;
      RadialValue f = profile.at(r);
      for (std::size_t i = 0; i < bins; ++i) {
        const double next_r = std::sqrt(static_cast<double>(i + 1) / bins_per_r2);
        const RadialValue next = profile.at(next_r);
        const double a = across(f, r), b = across(next, next_r);
        bend[i].across = std::max(std::abs(a), std::abs(b));
        along[i] = mean_second_derivative(profile, r, f, next_r, next) - (a + b) / 2.0;
        r = next_r;
        f = next;
      }
      for (std::size_t i = 0; i < bins; ++i) {
        // At the outer end as if it went on so.
        const double before = along[i > 0 ? i - 1 : 0], after = i + 1 < bins ? along[i + 1] : 2.0 * along[i] - before;
        bend[i].along = std::max({std::abs(before), std::abs(along[i]), std::abs(after), bend[i].across});
      }
      return bend;
    }

    /// Over [r, next_r], but for a jump of the slope.
    template <typename Profile>
    [[nodiscard]] static double mean_second_derivative(const Profile& profile, double r, const RadialValue& f,
                                                       double next_r, const RadialValue& next) {
      double rise = next.slope - f.slope;
      if constexpr (KinkedProfile<Profile>) {
        const double kink = profile.kink(), beside = 1e-9 * kink;
        if (r < kink && kink < next_r) rise -= profile.at(kink + beside).slope - profile.at(kink - beside).slope;
      }
      return rise / (next_r - r);
    }

    void prepare() {
      for (std::size_t width = 1; 2 * width <= bins; width *= 2) {
        const std::vector<Bend>& half = largest.back();
        std::vector<Bend> whole(half);
        for (std::size_t i = 0; i + width < bins; ++i) whole[i].take(half[i + width]);
        largest.push_back(std::move(whole));
      }
    }

    /// The largest between two squared radii.
    [[nodiscard]] Bend between(double low_r2, double high_r2) const {
      const auto bin = [&](double r2) {
        return static_cast<std::size_t>(std::min(r2 * bins_per_r2, static_cast<double>(bins - 1)));
      };
      const std::size_t first = bin(low_r2), last = bin(high_r2);
      std::size_t level = 0;
      while ((std::size_t{2} << level) <= last - first + 1) ++level;
      Bend bend = largest[level][first];
      bend.take(largest[level][last + 1 - (std::size_t{1} << level)]);
      return bend;
    }

    /// share: 1 / pieces^2, that is each piece's share of the area.
    [[nodiscard]] BendError error(const std::array<Vector2, 3>& corner, double share) const {
      std::array<Vector2, 3> p;
      std::array<double, 3> r2;
      for (std::size_t i = 0; i < 3; ++i) {
        p[i] = (corner[i] - place.centre).cwiseQuotient(place.scale);
        r2[i] = p[i].squaredNorm();
      }
      // Edge i is opposite to corner i.
      const std::array<Vector2, 3> edge{p[2] - p[1], p[0] - p[2], p[1] - p[0]};
      std::array<double, 3> length2;
      for (std::size_t i = 0; i < 3; ++i) length2[i] = edge[i].squaredNorm();
      const double longest2 = std::max({length2[0], length2[1], length2[2]});
      // No point of a triangle is farther than its longest edge / sqrt(3) from the nearest corner.
      const double low = std::max(0.0, std::min({r2[0], r2[1], r2[2]}) - longest2 / 3.0);
      const double high = std::max({r2[0], r2[1], r2[2]});
      const double end2 = end_radius * end_radius;
      if (low > end2) return {0.0, 0.0, true};
      const Bend bend = between(low, std::min(high, end2));
      const double piece2 = longest2 * share;
      BendError result;
      double chord = 0.0;  // what the kinks add
      for (const Kink& kink : kinks) {
        if (low < kink.radius * kink.radius && kink.radius * kink.radius < high) {
          chord += kink.jump * (piece2 / (8.0 * kink.radius) + std::sqrt(piece2) / 1024.0);
        }
      }
      if (high > end2) result.border_px = px * piece2 / (8.0 * end_radius);
      if (high > end2 || chord > 0.0) {
        result.px = px * (chord + piece2 / 8.0 * bend.at(1.0));
        return result;
      }
      std::array<double, 3> middle;
      for (std::size_t i = 0; i < 3; ++i) middle[i] = length2[i] * bend.at(largest_cos2(p, r2, edge, length2, i));
      result.px = px * share / 8.0 * largest_inside(middle[0], middle[1], middle[2]);
      return result;
    }

    /// Of the angle between edge i and the way to the centre, anywhere in the triangle.
    [[nodiscard]] static double largest_cos2(const std::array<Vector2, 3>& p, const std::array<double, 3>& r2,
                                             const std::array<Vector2, 3>& edge, const std::array<double, 3>& length2,
                                             std::size_t i) {
      const auto cross = [&](std::size_t k) { return edge[i].x() * p[k].y() - edge[i].y() * p[k].x(); };
      const std::size_t on = (i + 1) % 3;
      if (!(cross(i) * cross(on) > 0.0)) return 1.0;
      double cos2 = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        const double dot = edge[i].dot(p[k]);
        cos2 = std::max(cos2, dot * dot / (length2[i] * r2[k]));
      }
      return std::min(cos2, 1.0);
    }

    /// The largest 4 (l1 l2 a + l2 l0 b + l0 l1 c): at the middle of an edge, or inside.
    [[nodiscard]] static double largest_inside(double a, double b, double c) {
      const double on_edges = std::max({a, b, c});
      if (2.0 * on_edges >= a + b + c) return on_edges;
      return 4.0 * a * b * c / (2.0 * (a * b + b * c + c * a) - a * a - b * b - c * c);
    }
  };

  /// Lenses of all colours, each radial or none at all.
  RadialBend(std::span<const Lens> lenses, const FieldTangents& panel, const Vector2& px_per_tangent) {
    for (const Lens& lens : lenses) {
      Group& group = group_of(lens, panel, px_per_tangent);
      group.end_radius = std::min(group.end_radius, detail::end_radius(lens));
    }
    for (const Lens& lens : lenses) {
      Group& group = group_of(lens, panel, px_per_tangent);
      std::visit([&](const auto& model) { group.add(model); }, lens.model());
    }
    for (Group& group : groups_) group.prepare();
  }

  /// The lenses by their placement.
  [[nodiscard]] const std::vector<Group>& groups() const { return groups_; }

  /// Circles along which a mesh has to be cut.
  [[nodiscard]] std::vector<LensCircle> kinks() const {
    std::vector<LensCircle> circles;
    for (const Group& group : groups_) {
      for (const Kink& kink : group.kinks) circles.push_back({group.place, kink.radius});
    }
    return circles;
  }

  /// Of the triangle with these tangents, cut into pieces x pieces equal ones.
  [[nodiscard]] BendError error(const std::array<Vector2, 3>& corner, double pieces) const {
    BendError worst;
    for (const Group& group : groups_) {
      const BendError one = group.error(corner, 1.0 / (pieces * pieces));
      if (one.dark) return one;
      worst.px = std::max(worst.px, one.px);
      worst.border_px = std::max(worst.border_px, one.border_px);
    }
    return worst;
  }

 private:
  [[nodiscard]] Group& group_of(const Lens& lens, const FieldTangents& panel, const Vector2& px_per_tangent) {
    for (Group& group : groups_) {
      if (group.place == lens.placement()) return group;
    }
    Group group;
    group.place = lens.placement();
    const Vector2 scale = group.place.scale.cwiseAbs();
    group.px = scale.cwiseProduct(px_per_tangent.cwiseAbs()).maxCoeff();
    group.end_radius = std::numeric_limits<double>::infinity();
    const Vector2 low = Vector2(panel.left, panel.down) - group.place.centre;
    const Vector2 high = Vector2(panel.right, panel.up) - group.place.centre;
    group.widest = low.cwiseAbs().cwiseMax(high.cwiseAbs()).cwiseQuotient(scale).norm();
    group.largest.emplace_back(Group::bins);
    groups_.push_back(std::move(group));
    return groups_.back();
  }

  std::vector<Group> groups_;
};

}  // namespace holdfast::detail
