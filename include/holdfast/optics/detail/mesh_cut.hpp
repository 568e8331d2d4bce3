/// The part of a triangle that shows something, where a border cuts it.
#pragma once

#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>

#include <holdfast/optics/detail/triangle_error.hpp>

namespace holdfast::detail {

/// A corner of a cut triangle: the corner `in` of the whole one, or the border between `in` and its corner `out`.
struct CutCorner {
  std::size_t in = 0, out = 0;
  [[nodiscard]] bool is_on_border() const { return in != out; }
};

/// At most two triangles, counter-clockwise.
struct CutTriangle {
  std::array<std::array<CutCorner, 3>, 2> parts{};
  std::size_t count = 0;

  [[nodiscard]] bool is_cut() const { return count == 2 || (count == 1 && parts[0][1].is_on_border()); }
};

/// inside: which of the corners show something.
[[nodiscard]] inline CutTriangle cut(const std::array<bool, 3>& inside) {
  const int count = inside[0] + inside[1] + inside[2];
  CutTriangle result;
  if (count == 0) return result;
  if (count == 3) {
    result.parts[0] = {CutCorner{0, 0}, CutCorner{1, 1}, CutCorner{2, 2}};
    result.count = 1;
    return result;
  }
  // Turned so that the one that differs from the other two comes first.
  std::size_t a = 0;
  while (inside[a] != (count == 1)) ++a;
  const std::size_t b = (a + 1) % 3, c = (a + 2) % 3;
  if (count == 1) {
    result.parts[0] = {CutCorner{a, a}, CutCorner{a, b}, CutCorner{a, c}};
    result.count = 1;
  } else {
    result.parts[0] = {CutCorner{b, a}, CutCorner{b, b}, CutCorner{c, c}};
    result.parts[1] = {CutCorner{b, a}, CutCorner{c, c}, CutCorner{c, a}};
    result.count = 2;
  }
  return result;
}

/// The last point from `in` towards `out` that still shows something, in steps of 1/1024 of the way. All triangles at
/// that edge get the same one; it lies exactly on the edge where the lattice divides so finely.
[[nodiscard]] inline PanelPoint border_between(const PanelLooker& looker, const PanelPoint& in, const PanelPoint& out) {
  constexpr std::int64_t steps = 1024;
  const auto at = [&](std::int64_t k) {
    const auto along = [k](std::uint32_t p, std::uint32_t q) {
      return static_cast<std::uint32_t>(p + (static_cast<std::int64_t>(q) - p) * k / steps);
    };
    return PanelPoint{along(in.x, out.x), along(in.y, out.y)};
  };
  std::int64_t low = 0, high = steps;
  while (high - low > 1) {
    const std::int64_t middle = (low + high) / 2;
    (looker.shows(at(middle)) ? low : high) = middle;
  }
  return at(low);
}

/// The part's corners on the panel.
[[nodiscard]] inline std::array<PanelPoint, 3> points_of(const PanelLooker& looker,
                                                         const std::array<PanelPoint, 3>& corner,
                                                         const std::array<CutCorner, 3>& part) {
  std::array<PanelPoint, 3> points;
  for (std::size_t k = 0; k < 3; ++k) {
    const CutCorner& c = part[k];
    points[k] = c.is_on_border() ? border_between(looker, corner[c.in], corner[c.out]) : corner[c.in];
  }
  return points;
}

/// Whether a b c is counter-clockwise with some area.
[[nodiscard]] inline bool has_area(const PanelPoint& a, const PanelPoint& b, const PanelPoint& c) {
  const auto difference = [](std::uint32_t p, std::uint32_t q) { return static_cast<std::int64_t>(q) - p; };
  return difference(a.x, b.x) * difference(a.y, c.y) > difference(a.y, b.y) * difference(a.x, c.x);
}

/// Whether the chord from p to q has the true border within the tolerance (panel px), at its middle.
[[nodiscard]] inline bool keeps_to_border(const PanelLooker& looker, const PanelPoint& p, const PanelPoint& q,
                                          double tolerance_px) {
  const Vector2 chord = looker.pixels_between(p, q);
  const double length = chord.norm();
  if (length < tolerance_px) return true;
  const Vector2 inward = Vector2(-chord.y(), chord.x()) * (tolerance_px / length);
  return looker.shows(p, Vector2(chord / 2.0 + inward)) && !looker.shows(p, Vector2(chord / 2.0 - inward));
}

}  // namespace holdfast::detail
