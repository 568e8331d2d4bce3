/// The part of a triangle that shows something, as triangles, and its vertices once each.
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include <holdfast/optics/detail/mesh_draft.hpp>

namespace holdfast::detail {

/// A vertex of the cut mesh: of the draft when in == out, else on the border between a vertex inside and one outside.
struct CutVertex {
  std::uint32_t in = 0, out = 0;
  friend bool operator==(const CutVertex&, const CutVertex&) = default;
};

/// At most two triangles.
struct CutTriangle {
  std::array<std::array<CutVertex, 3>, 2> parts{};
  std::size_t count = 0;
};

/// v: the triangle's vertices in the draft, counter-clockwise.
[[nodiscard]] inline CutTriangle cut(const MeshDraft& draft, const std::array<std::uint32_t, 3>& v) {
  const int inside = draft.is_inside(v[0]) + draft.is_inside(v[1]) + draft.is_inside(v[2]);
  const auto kept = [](std::uint32_t i) { return CutVertex{i, i}; };
  CutTriangle result;
  if (inside == 0) return result;
  if (inside == 3) {
    result.parts[0] = {kept(v[0]), kept(v[1]), kept(v[2])};
    result.count = 1;
    return result;
  }
  // Turned so that the one that differs from the other two comes first.
  std::size_t odd = 0;
  while (draft.is_inside(v[odd]) != (inside == 1)) ++odd;
  const std::uint32_t a = v[odd], b = v[(odd + 1) % 3], c = v[(odd + 2) % 3];
  if (inside == 1) {
    result.parts[0] = {kept(a), CutVertex{a, b}, CutVertex{a, c}};
    result.count = 1;
  } else {
    result.parts[0] = {CutVertex{b, a}, kept(b), kept(c)};
    result.parts[1] = {CutVertex{b, a}, kept(c), CutVertex{c, a}};
    result.count = 2;
  }
  return result;
}

/// The two border vertices of a triangle that has some: on the way from the first to the second, what shows something is
/// on the left.
[[nodiscard]] inline std::array<CutVertex, 2> border_of(const CutTriangle& cut_triangle) {
  if (cut_triangle.count == 1) return {cut_triangle.parts[0][1], cut_triangle.parts[0][2]};
  return {cut_triangle.parts[1][2], cut_triangle.parts[0][0]};
}

[[nodiscard]] inline MeshCorner corner_of(const MeshDraft& draft, const CutVertex& v) {
  return v.in == v.out ? draft.corner(v.in) : draft.border_between(v.in, v.out);
}

/// Gathers cut triangles into vertices and indices.
class MeshGatherer {
 public:
  explicit MeshGatherer(const MeshDraft& draft) : draft_(draft), index_of_(draft.size(), none) {}

  /// Leaves out what has no area, and slivers at the border that would show the picture turned over.
  void add(const CutTriangle& cut_triangle) {
    for (std::size_t i = 0; i < cut_triangle.count; ++i) {
      const auto& part = cut_triangle.parts[i];
      const bool whole = part[0].in == part[0].out && part[1].in == part[1].out && part[2].in == part[2].out;
      if (!whole && !has_area(part)) continue;
      for (const CutVertex& v : part) triangles.push_back(index(v));
    }
  }

  std::vector<MeshCorner> corners;
  std::vector<std::uint32_t> triangles;

 private:
  static constexpr std::uint32_t none = 0xffffffff;

  [[nodiscard]] bool has_area(const std::array<CutVertex, 3>& part) const {
    const MeshCorner a = corner_of(draft_, part[0]), b = corner_of(draft_, part[1]), c = corner_of(draft_, part[2]);
    const auto difference = [](std::uint32_t p, std::uint32_t q) { return static_cast<std::int64_t>(q) - p; };
    const std::int64_t area = difference(a.point.x, b.point.x) * difference(a.point.y, c.point.y) -
                              difference(a.point.y, b.point.y) * difference(a.point.x, c.point.x);
    return area > 0 && !draft_.is_turned_over(a, b, c);
  }

  [[nodiscard]] std::uint32_t index(const CutVertex& v) {
    if (v.in == v.out) {
      std::uint32_t& known = index_of_[v.in];
      if (known == none) known = push(draft_.corner(v.in));
      return known;
    }
    const MeshCorner corner = corner_of(draft_, v);
    if (corner.point == draft_.corner(v.in).point) return index({v.in, v.in});
    const auto [entry, is_new] = border_.try_emplace((static_cast<std::uint64_t>(v.in) << 32) | v.out, none);
    if (is_new) entry->second = push(corner);
    return entry->second;
  }

  [[nodiscard]] std::uint32_t push(const MeshCorner& corner) {
    corners.push_back(corner);
    return static_cast<std::uint32_t>(corners.size() - 1);
  }

  const MeshDraft& draft_;
  std::vector<std::uint32_t> index_of_;
  std::unordered_map<std::uint64_t, std::uint32_t> border_;
};

}  // namespace holdfast::detail
