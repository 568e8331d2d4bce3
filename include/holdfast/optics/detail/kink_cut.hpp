/// Cuts a draft's triangles along a circle of the lens, so that its kink lies between triangles.
///
/// Where an edge crosses the circle it gets a vertex, in steps of 1/1024 of its length, for both triangles at it: the
/// draft conforms as before. A triangle becomes two or three. Arcs that enter a triangle by one edge alone stay.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <unordered_map>
#include <utility>
#include <vector>

#include <holdfast/optics/detail/mesh_pieces.hpp>
#include <holdfast/optics/detail/radial_bend.hpp>
#include <holdfast/optics/detail/triangle_error.hpp>

namespace holdfast::detail {

class KinkCut {
 public:
  KinkCut(const PanelLooker& looker, const LensCircle& circle, MeshDraft& draft)
      : looker_(looker), circle_(circle), draft_(draft) {}

  void cut() {
    side_.reserve(draft_.points.size());
    const double radius2 = circle_.radius * circle_.radius;
    // Closer ones are on the circle: their edges would be cut right beside them.
    constexpr double beside = 1e-6;
    for (const PanelPoint& p : draft_.points) {
      const double off = from_centre(p).squaredNorm() / radius2 - 1.0;
      side_.push_back(off > beside ? 1 : off < -beside ? -1 : 0);
    }
    const std::size_t count = draft_.triangles.size();
    for (std::size_t i = 0; i < count; i += 3) cut_triangle(i);
  }

 private:
  [[nodiscard]] Vector2 from_centre(const PanelPoint& p) const { return circle_.to_model(looker_.tangent_at(p)); }

  void cut_triangle(std::size_t at) {
    std::array<std::uint32_t, 3> v{draft_.triangles[at], draft_.triangles[at + 1], draft_.triangles[at + 2]};
    std::array<bool, 3> crossed{};  // edge i is from corner i to the next
    for (std::size_t i = 0; i < 3; ++i) crossed[i] = side_[v[i]] * side_[v[(i + 1) % 3]] < 0;
    const int count = crossed[0] + crossed[1] + crossed[2];
    if (count == 0) return;
    // Turned so that the edge from corner 0 is crossed, and the one from corner 2 when there are two.
    std::size_t first = 0;
    while (!crossed[first] || (count == 2 && !crossed[(first + 2) % 3])) ++first;
    std::rotate(v.begin(), v.begin() + static_cast<std::ptrdiff_t>(first), v.end());
    const std::uint32_t m = crossing(v[0], v[1]);
    if (count == 1) {
      put(at, {v[0], m, v[2]});
      add({m, v[1], v[2]});
      return;
    }
    const std::uint32_t n = crossing(v[2], v[0]);
    put(at, {v[0], m, n});
    add({m, v[1], v[2]});
    add({m, v[2], n});
  }

  void put(std::size_t at, const std::array<std::uint32_t, 3>& v) {
    std::copy(v.begin(), v.end(), draft_.triangles.begin() + static_cast<std::ptrdiff_t>(at));
  }
  void add(const std::array<std::uint32_t, 3>& v) {
    draft_.triangles.insert(draft_.triangles.end(), v.begin(), v.end());
  }

  /// The vertex on the edge between a and b, which lie on both sides.
  [[nodiscard]] std::uint32_t crossing(std::uint32_t a, std::uint32_t b) {
    if (b < a) std::swap(a, b);
    const auto next = static_cast<std::uint32_t>(draft_.points.size());
    const auto [entry, is_new] = known_.try_emplace((static_cast<std::uint64_t>(a) << 32) | b, next);
    if (!is_new) return entry->second;
    const PanelPoint p = draft_.points[a], q = draft_.points[b];
    constexpr std::int64_t steps = 1024;
    const auto k = std::clamp<std::int64_t>(std::llround(crossed_at(p, q) * steps), 1, steps - 1);
    const auto along = [k](std::uint32_t from, std::uint32_t to) {
      return static_cast<std::uint32_t>(from + (static_cast<std::int64_t>(to) - from) * k / steps);
    };
    draft_.points.push_back({along(p.x, q.x), along(p.y, q.y)});
    return next;
  }

  /// The share of the way from p to q: |a + t (b - a)| = radius.
  [[nodiscard]] double crossed_at(const PanelPoint& p, const PanelPoint& q) const {
    const Vector2 a = from_centre(p), way = from_centre(q) - a;
    const double A = way.squaredNorm(), B = a.dot(way), C = a.squaredNorm() - circle_.radius * circle_.radius;
    const double root = std::sqrt(std::max(0.0, B * B - A * C));
    return C < 0.0 ? (-B + root) / A : (-B - root) / A;  // outward, inward
  }

  const PanelLooker& looker_;
  const LensCircle& circle_;
  MeshDraft& draft_;
  std::vector<signed char> side_;  ///< of each of the draft's points: -1 inside, 1 outside
  std::unordered_map<std::uint64_t, std::uint32_t> known_;
};

}  // namespace holdfast::detail
