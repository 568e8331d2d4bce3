/// Which of many triangles overlap, and which to remove so that none do.
///
/// Two triangles overlap when their insides share area; neighbours that touch along an edge or a corner do not, to
/// rounding (1e-9 of their size). All triangles must be counter-clockwise with area. Unit: any. overlapping_pairs takes
/// about n log n for triangles of like size.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <numeric>
#include <queue>
#include <span>
#include <utility>
#include <vector>

#include <holdfast/geometry/types.hpp>

namespace holdfast {

/// Whether the insides of two counter-clockwise triangles share area: no edge of either separates them.
[[nodiscard]] inline bool triangles_overlap(const std::array<Vector2, 3>& a, const std::array<Vector2, 3>& b) {
  const auto is_separated_by_an_edge_of = [](const std::array<Vector2, 3>& t, const std::array<Vector2, 3>& other) {
    for (std::size_t i = 0; i < 3; ++i) {
      const Vector2 along = t[(i + 1) % 3] - t[i];
      const Vector2 inward = Vector2(-along.y(), along.x()).normalized();
      double farthest = -std::numeric_limits<double>::infinity();
      double extent = inward.dot(t[(i + 2) % 3] - t[i]);
      for (const Vector2& p : other) {
        const double depth = inward.dot(p - t[i]);
        farthest = std::max(farthest, depth);
        extent = std::max(extent, std::abs(depth));
      }
      if (farthest <= 1e-9 * extent) return true;
    }
    return false;
  };
  return !is_separated_by_an_edge_of(a, b) && !is_separated_by_an_edge_of(b, a);
}

/// Pairs of indices of triangles that overlap, found by a sweep along x. Stops when `most` pairs are found.
[[nodiscard]] inline std::vector<std::pair<std::size_t, std::size_t>> overlapping_pairs(
    std::span<const Vector2> points, std::span<const std::array<int, 3>> triangles, std::size_t most) {
  struct Box {
    std::array<Vector2, 3> corners;
    Vector2 low, high;
  };
  std::vector<Box> boxes;
  for (const std::array<int, 3>& t : triangles) {
    Box box;
    for (std::size_t i = 0; i < 3; ++i) box.corners[i] = points[static_cast<std::size_t>(t[i])];
    box.low = box.corners[0].cwiseMin(box.corners[1]).cwiseMin(box.corners[2]);
    box.high = box.corners[0].cwiseMax(box.corners[1]).cwiseMax(box.corners[2]);
    boxes.push_back(box);
  }
  std::vector<std::size_t> order(boxes.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(),
            [&](std::size_t a, std::size_t b) { return boxes[a].low.x() < boxes[b].low.x(); });
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  std::vector<std::size_t> active;
  for (const std::size_t i : order) {
    const Box& box = boxes[i];
    std::erase_if(active, [&](std::size_t k) { return boxes[k].high.x() <= box.low.x(); });
    for (const std::size_t k : active) {
      const Box& other = boxes[k];
      const bool apart = other.high.y() <= box.low.y() || box.high.y() <= other.low.y();
      if (apart || !triangles_overlap(box.corners, other.corners)) continue;
      pairs.emplace_back(i, k);
      if (pairs.size() >= most) return pairs;
    }
    active.push_back(i);
  }
  return pairs;
}

/// Removes items until no pair is left whole, always the one in most pairs next (the lower index of equals).
[[nodiscard]] inline std::vector<std::size_t> fewest_to_remove(
    const std::vector<std::pair<std::size_t, std::size_t>>& pairs, std::size_t items) {
  std::vector<std::vector<std::size_t>> partners(items);
  for (const auto& [a, b] : pairs) {
    partners[a].push_back(b);
    partners[b].push_back(a);
  }
  std::vector<std::size_t> count(items);
  std::priority_queue<std::pair<std::size_t, std::size_t>> busiest;  // count, items - index
  for (std::size_t i = 0; i < items; ++i) {
    count[i] = partners[i].size();
    if (count[i] > 0) busiest.emplace(count[i], items - i);
  }
  std::vector<std::size_t> removed;
  while (!busiest.empty()) {
    const auto [old_count, rank] = busiest.top();
    busiest.pop();
    const std::size_t i = items - rank;
    if (count[i] != old_count || count[i] == 0) continue;  // changed since: it stands again farther down
    removed.push_back(i);
    count[i] = 0;
    for (const std::size_t k : partners[i]) {
      if (count[k] == 0) continue;
      if (--count[k] > 0) busiest.emplace(count[k], items - k);
    }
  }
  return removed;
}

}  // namespace holdfast
