/// Delaunay triangulation of scattered points.
///
/// delaunay(points) joins the points to triangles that cover their convex hull and none of whose circumcircles holds a
/// point (to rounding: points nearly on one circle may be joined either way). It is valid whatever the points: exact
/// orientation tests (predicates.hpp) keep every triangle counter-clockwise, collinear and cocircular points included.
/// Points are added in the order of x, each joined to the hull edges it sees; edges are then flipped while that is
/// surely an improvement (Lawson 1977), which comes to an end. Typical time n log n plus the flips. Unit: any in which
/// the points are 1e-60 to 1e70 apart (beyond, products under- or overflow and few edges are flipped); coordinates
/// below 1e-120 count as 0. Bad input: the result names the problem and the points.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <functional>
#include <numeric>
#include <span>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/geometry/predicates.hpp>
#include <holdfast/geometry/types.hpp>

namespace holdfast {

struct Triangulation {
  std::vector<Vector2> points;                 ///< as given
  std::vector<std::array<int, 3>> triangles;   ///< indices of points, counter-clockwise
  std::vector<std::array<int, 3>> neighbours;  ///< of each triangle, across from its i-th point; -1: the hull's edge
};

enum class DelaunayProblem {
  none,
  too_few_points,   ///< fewer than three
  not_finite,       ///< a coordinate is NaN, infinite or beyond 1e70
  duplicate_point,  ///< two points are the same
  collinear,        ///< all points lie on one line
};

[[nodiscard]] constexpr std::string_view describe(DelaunayProblem problem) {
  switch (problem) {
    case DelaunayProblem::none:
      return "the points can be triangulated";
    case DelaunayProblem::too_few_points:
      return "fewer than three points";
    case DelaunayProblem::not_finite:
      return "a coordinate is not a finite number, or beyond 1e70";
    case DelaunayProblem::duplicate_point:
      return "two points are the same";
    case DelaunayProblem::collinear:
      return "all points lie on one line";
  }
  return "unknown problem";
}

struct DelaunayResult {
  Triangulation mesh;  ///< empty when there is a problem
  DelaunayProblem problem = DelaunayProblem::none;
  std::size_t point = 0;        ///< index of the point that is the problem
  std::size_t other_point = 0;  ///< the point that it duplicates

  [[nodiscard]] bool ok() const { return problem == DelaunayProblem::none; }
};

namespace detail {

class DelaunayBuilder {
 public:
  explicit DelaunayBuilder(std::vector<Vector2> points) : p_(std::move(points)) {
    const std::size_t n = p_.size();
    next_.resize(n);
    prev_.resize(n);
    inside_.resize(n);
    t_.reserve(2 * n);
    neighbour_.reserve(2 * n);
  }

  /// `order`: indices sorted by x, then y; all different. False when all are on one line.
  [[nodiscard]] bool build(const std::vector<int>& order) {
    std::size_t apex = 2;
    while (apex < order.size() && turn(order[0], order[1], order[apex]) == 0) ++apex;
    if (apex == order.size()) return false;
    begin_with_fan(order, apex);
    for (std::size_t i = apex + 1; i < order.size(); ++i) add_outside(order[i], order[i - 1]);
    flip_all();
    return true;
  }

  [[nodiscard]] std::vector<std::array<int, 3>>& triangles() { return t_; }
  [[nodiscard]] std::vector<std::array<int, 3>>& neighbours() { return neighbour_; }

 private:
  [[nodiscard]] const Vector2& at(int i) const { return p_[static_cast<std::size_t>(i)]; }
  [[nodiscard]] int turn(int a, int b, int c) const { return orientation(at(a), at(b), at(c)); }
  [[nodiscard]] std::array<int, 3>& triangle(int t) { return t_[static_cast<std::size_t>(t)]; }
  [[nodiscard]] std::array<int, 3>& neighbours_of(int t) { return neighbour_[static_cast<std::size_t>(t)]; }
  [[nodiscard]] int& next(int v) { return next_[static_cast<std::size_t>(v)]; }
  [[nodiscard]] int& prev(int v) { return prev_[static_cast<std::size_t>(v)]; }
  [[nodiscard]] int& inside(int v) { return inside_[static_cast<std::size_t>(v)]; }

  int add(int a, int b, int c) {
    t_.push_back({a, b, c});
    neighbour_.push_back({-1, -1, -1});
    return static_cast<int>(t_.size()) - 1;
  }

  /// Makes t and u neighbours across the edge between points a and b.
  void join(int t, int u, int a, int b) {
    for (const auto& [one, other] : {std::pair(t, u), std::pair(u, t)}) {
      for (std::size_t i = 0; i < 3; ++i) {
        const int corner = triangle(one)[i];
        if (corner != a && corner != b) neighbours_of(one)[i] = other;
      }
    }
  }

  /// The hull goes counter-clockwise from a to b along triangle t.
  void hull_edge(int a, int b, int t) {
    next(a) = b;
    prev(b) = a;
    inside(a) = t;
  }

  /// The first points, which lie on one line, joined to the first one beside it.
  void begin_with_fan(const std::vector<int>& order, std::size_t apex) {
    std::vector<int> line(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(apex));
    const int q = order[apex];
    if (turn(line[0], line[1], q) < 0) std::reverse(line.begin(), line.end());
    int last = -1;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
      const int t = add(line[i], line[i + 1], q);
      hull_edge(line[i], line[i + 1], t);
      if (last >= 0) join(last, t, line[i], q);
      if (i == 0) hull_edge(q, line[0], t);
      last = t;
    }
    hull_edge(line.back(), q, last);
  }

  /// Joins a point beyond all others to the hull edges it sees, which lie on both sides of the point before it.
  void add_outside(int p, int before) {
    int first = before;
    while (turn(prev(first), first, p) < 0) first = prev(first);
    int end = before;
    while (turn(end, next(end), p) < 0) end = next(end);
    int last = -1;
    int first_triangle = -1;
    for (int a = first; a != end; a = next(a)) {
      const int b = next(a);
      const int t = add(b, a, p);
      join(t, inside(a), a, b);
      if (last >= 0) join(last, t, a, p);
      if (first_triangle < 0) first_triangle = t;
      last = t;
    }
    hull_edge(first, p, first_triangle);
    hull_edge(p, end, last);
  }

  void flip_all() {
    std::vector<std::pair<int, std::size_t>> edges;
    for (int t = 0; t < static_cast<int>(t_.size()); ++t) {
      for (std::size_t i = 0; i < 3; ++i) edges.emplace_back(t, i);
    }
    while (!edges.empty()) {
      const auto [t, i] = edges.back();
      edges.pop_back();
      const int u = neighbours_of(t)[i];
      if (u < 0) continue;
      const std::size_t j = slot_of_neighbour(u, t);
      const std::array<int, 3> abc = triangle(t);
      if (!surely_in_circle(at(abc[0]), at(abc[1]), at(abc[2]), at(triangle(u)[j]))) continue;
      flip(t, i, u, j);
      for (const int changed : {t, u}) {
        for (std::size_t k = 0; k < 3; ++k) edges.emplace_back(changed, k);
      }
    }
  }

  [[nodiscard]] std::size_t slot_of_neighbour(int t, int neighbour) {
    const std::array<int, 3>& n = neighbours_of(t);
    return n[0] == neighbour ? 0 : n[1] == neighbour ? 1 : 2;
  }

  /// The edge b c between t = a b c and u = d c b becomes a d.
  void flip(int t, std::size_t i, int u, std::size_t j) {
    const std::size_t i1 = (i + 1) % 3, i2 = (i + 2) % 3, j1 = (j + 1) % 3, j2 = (j + 2) % 3;
    const int a = triangle(t)[i], b = triangle(t)[i1], c = triangle(t)[i2], d = triangle(u)[j];
    const int across_ca = neighbours_of(t)[i1], across_ab = neighbours_of(t)[i2];
    const int across_bd = neighbours_of(u)[j1], across_dc = neighbours_of(u)[j2];
    triangle(t) = {a, b, d};
    neighbours_of(t) = {across_bd, u, across_ab};
    triangle(u) = {a, d, c};
    neighbours_of(u) = {across_dc, across_ca, t};
    if (across_bd >= 0) neighbours_of(across_bd)[slot_of_neighbour(across_bd, u)] = t;
    if (across_ca >= 0) neighbours_of(across_ca)[slot_of_neighbour(across_ca, t)] = u;
  }

  std::vector<Vector2> p_;
  std::vector<std::array<int, 3>> t_;
  std::vector<std::array<int, 3>> neighbour_;
  std::vector<int> next_, prev_;  ///< along the hull, counter-clockwise
  std::vector<int> inside_;       ///< the triangle along the hull edge from a point to its next
};

}  // namespace detail

[[nodiscard]] inline DelaunayResult delaunay(std::span<const Vector2> points) {
  DelaunayResult result;
  if (points.size() < 3) {
    result.problem = DelaunayProblem::too_few_points;
    return result;
  }
  std::vector<Vector2> rounded(points.begin(), points.end());
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!(std::abs(points[i].x()) <= 1e70 && std::abs(points[i].y()) <= 1e70)) {
      result.problem = DelaunayProblem::not_finite;
      result.point = i;
      return result;
    }
    for (double& x : {std::ref(rounded[i].x()), std::ref(rounded[i].y())}) {
      if (std::abs(x) < 1e-120) x = 0.0;
    }
  }
  std::vector<int> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  const auto before = [&](int a, int b) {
    const Vector2& u = rounded[static_cast<std::size_t>(a)];
    const Vector2& v = rounded[static_cast<std::size_t>(b)];
    return u.x() != v.x() ? u.x() < v.x() : u.y() != v.y() ? u.y() < v.y() : a < b;
  };
  std::sort(order.begin(), order.end(), before);
  for (std::size_t i = 1; i < order.size(); ++i) {
    const auto one = static_cast<std::size_t>(order[i - 1]), other = static_cast<std::size_t>(order[i]);
    if (rounded[one] != rounded[other]) continue;
    result.problem = DelaunayProblem::duplicate_point;
    result.point = other;
    result.other_point = one;
    return result;
  }
  detail::DelaunayBuilder builder(std::move(rounded));
  if (!builder.build(order)) {
    result.problem = DelaunayProblem::collinear;
    return result;
  }
  result.mesh.points.assign(points.begin(), points.end());
  result.mesh.triangles = std::move(builder.triangles());
  result.mesh.neighbours = std::move(builder.neighbours());
  return result;
}

}  // namespace holdfast
