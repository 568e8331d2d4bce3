#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <set>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/delaunay.hpp>

using namespace holdfast;

namespace {

using Points = std::vector<Vector2>;

const Vector2& at(const Points& p, int i) {
  return p[static_cast<std::size_t>(i)];
}

/// Area of the convex hull, by Andrew's monotone chain: another way to the same number.
double hull_area(Points p) {
  std::sort(p.begin(), p.end(),
            [](const Vector2& a, const Vector2& b) { return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y(); });
  Points hull;
  for (int half = 0; half < 2; ++half) {
    const std::size_t begin = hull.size();
    for (const Vector2& c : p) {
      while (hull.size() >= begin + 2 && orientation(hull[hull.size() - 2], hull.back(), c) <= 0) hull.pop_back();
      hull.push_back(c);
    }
    hull.pop_back();
    std::reverse(p.begin(), p.end());
  }
  double twice = 0.0;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2& a = hull[i];
    const Vector2& b = hull[(i + 1) % hull.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2.0;
}

/// Everything that makes a triangulation one, and Delaunay's.
void check_triangulation(const Points& p) {
  const DelaunayResult result = delaunay(p);
  REQUIRE(result.ok());
  const Triangulation& mesh = result.mesh;
  REQUIRE(mesh.neighbours.size() == mesh.triangles.size());
  std::set<int> used;
  std::size_t hull_edges = 0;
  double area = 0.0;
  for (std::size_t t = 0; t < mesh.triangles.size(); ++t) {
    const std::array<int, 3>& c = mesh.triangles[t];
    used.insert(c.begin(), c.end());
    REQUIRE(orientation(at(p, c[0]), at(p, c[1]), at(p, c[2])) == 1);
    const Vector2 u = at(p, c[1]) - at(p, c[0]);
    const Vector2 v = at(p, c[2]) - at(p, c[0]);
    area += 0.5 * (u.x() * v.y() - u.y() * v.x());
    for (std::size_t i = 0; i < 3; ++i) {
      const int n = mesh.neighbours[t][i];
      if (n < 0) {
        ++hull_edges;
        continue;
      }
      // The neighbour has the same edge the other way round, and knows this triangle.
      const std::array<int, 3>& other = mesh.triangles[static_cast<std::size_t>(n)];
      const int a = c[(i + 1) % 3], b = c[(i + 2) % 3];
      bool found = false;
      for (std::size_t k = 0; k < 3; ++k) {
        if (other[(k + 1) % 3] != b || other[(k + 2) % 3] != a) continue;
        found = mesh.neighbours[static_cast<std::size_t>(n)][k] == static_cast<int>(t);
        // The opposite point is in no circle of the pair: locally Delaunay everywhere means Delaunay (Delaunay's lemma).
        CHECK_FALSE(surely_in_circle(at(p, c[0]), at(p, c[1]), at(p, c[2]), at(p, other[k])));
      }
      CHECK(found);
    }
  }
  CHECK(used.size() == p.size());
  // Euler: a triangulation of n points with h on the hull's edges has 2n - 2 - h triangles.
  CHECK(mesh.triangles.size() == 2 * p.size() - 2 - hull_edges);
  const double expected = hull_area(p);
  // A rounding per triangle, of its area and of products of coordinates (below 500 in all cases).
  CHECK(std::abs(area - expected) <= 1e-15 * static_cast<double>(p.size()) * (1e3 * expected + 1.0));
}

}  // namespace

TEST_CASE("orientation is exact where plain arithmetic is not") {
  // Points of y = x shifted by single last bits (Kettner et al. 2008, "Classroom examples of robustness problems").
  const double ulp = std::numeric_limits<double>::epsilon() / 2;  // of numbers in [0.5, 1)
  const Vector2 b(12, 12), c(24, 24);
  int plain_is_wrong = 0;
  for (int i = 0; i < 64; ++i) {
    for (int k = 0; k < 64; ++k) {
      const Vector2 a(0.5 + i * ulp, 0.5 + k * ulp);
      // a is left of the upward line b c exactly when its y is greater.
      const int truth = k > i ? 1 : k < i ? -1 : 0;
      CHECK(orientation(a, b, c) == truth);
      CHECK(orientation(b, c, a) == truth);
      CHECK(orientation(c, b, a) == -truth);
      const double det = (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
      if (((det > 0) - (det < 0)) != truth) ++plain_is_wrong;
    }
  }
  CHECK(plain_is_wrong > 100);  // or the case is no test
  CHECK(orientation(Vector2(0, 0), Vector2(1e-60, 0), Vector2(0, 1e-60)) == 1);
  CHECK(orientation(Vector2(0, 0), Vector2(1e90, 0), Vector2(0, 1e90)) == 1);
}

TEST_CASE("a point is in the circle only when it surely is") {
  const Vector2 a(1, 0), b(0, 1), c(-1, 0);
  CHECK(surely_in_circle(a, b, c, Vector2(0, 0)));
  CHECK(surely_in_circle(a, b, c, Vector2(0, -0.999999)));
  CHECK_FALSE(surely_in_circle(a, b, c, Vector2(0, -1)));
  CHECK_FALSE(surely_in_circle(a, b, c, Vector2(0, -1.000001)));
  // Its own scale changes nothing.
  CHECK(surely_in_circle(1e-9 * a, 1e-9 * b, 1e-9 * c, Vector2(0, -0.999999e-9)));
}

TEST_CASE("random points") {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> u(-1, 1);
  for (const int n : {3, 4, 5, 10, 100, 2000}) {
    Points p;
    for (int i = 0; i < n; ++i) p.emplace_back(u(random), u(random));
    check_triangulation(p);
  }
}

TEST_CASE("no other point lies in any circle") {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> u(-1, 1);
  Points p;
  for (int i = 0; i < 150; ++i) p.emplace_back(u(random), 0.01 * u(random));
  for (const auto& t : delaunay(p).mesh.triangles) {
    for (const Vector2& other : p) CHECK_FALSE(surely_in_circle(at(p, t[0]), at(p, t[1]), at(p, t[2]), other));
  }
}

TEST_CASE("grids: every point on lines and circles with others") {
  for (const double step : {1.0, 0.1, 0.0521}) {
    Points p;
    for (int i = 0; i < 20; ++i) {
      for (int k = 0; k < 15; ++k) p.emplace_back(i * step, k * step);
    }
    check_triangulation(p);
    // Sheared a little, so that rounding decides what is on a line.
    for (Vector2& q : p) q = Vector2(q.x() + 1e-15 * q.y(), q.y() - 3e-16 * q.x());
    check_triangulation(p);
  }
}

TEST_CASE("a line of points with a single one beside it, on either side") {
  for (const double beside : {1.0, -1.0, 1e-300, 1e-18}) {
    Points p;
    for (int i = 0; i < 10; ++i) p.emplace_back(0.1 * i, 0.3 * i);
    p.emplace_back(0.45, 0.3 * 4.5 + beside);
    const DelaunayResult result = delaunay(p);
    if (result.ok()) {
      // The last point first, last and in the middle of the order all work: x decides the order.
      check_triangulation(p);
    } else {
      CHECK(result.problem == DelaunayProblem::collinear);
    }
  }
  Points column;
  for (int i = 0; i < 30; ++i) column.emplace_back(0, i);
  column.emplace_back(5, 7);
  check_triangulation(column);
  column.emplace_back(-5, 9);
  check_triangulation(column);
}

TEST_CASE("points on one circle, and far from round") {
  Points p;
  for (int i = 0; i < 100; ++i) {
    const double a = 2 * std::numbers::pi * i / 100;
    p.emplace_back(std::cos(a), std::sin(a));
  }
  check_triangulation(p);
  for (Vector2& q : p) q.y() *= 1e-7;
  check_triangulation(p);
}

TEST_CASE("the same whatever the order, the place and the size") {
  std::mt19937_64 random(7);
  std::uniform_real_distribution<double> u(0, 1);
  Points p;
  for (int i = 0; i < 60; ++i) p.emplace_back(u(random), u(random));
  const auto as_set = [](const Points& points, double scale) {
    std::set<std::set<std::pair<double, double>>> all;
    for (const auto& t : delaunay(points).mesh.triangles) {
      std::set<std::pair<double, double>> one;
      for (const int i : t) one.emplace(at(points, i).x() / scale, at(points, i).y() / scale);
      all.insert(one);
    }
    return all;
  };
  const auto expected = as_set(p, 1.0);
  for (int trial = 0; trial < 5; ++trial) {
    std::shuffle(p.begin(), p.end(), random);
    CHECK(as_set(p, 1.0) == expected);
  }
  for (Vector2& q : p) q *= 1024.0;  // a power of two: no rounding
  CHECK(as_set(p, 1024.0) == expected);
}

TEST_CASE("what cannot be triangulated is refused with the reason") {
  CHECK(delaunay(Points{}).problem == DelaunayProblem::too_few_points);
  CHECK(delaunay(Points{{0, 0}, {1, 0}}).problem == DelaunayProblem::too_few_points);
  CHECK(delaunay(Points{{0, 0}, {1, 1}, {2, 2}, {-3, -3}}).problem == DelaunayProblem::collinear);
  const DelaunayResult twice = delaunay(Points{{0, 0}, {1, 0}, {0, 1}, {1, 0}, {5, 5}});
  CHECK(twice.problem == DelaunayProblem::duplicate_point);
  CHECK(twice.point == 3);
  CHECK(twice.other_point == 1);
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const double bad : {nan, std::numeric_limits<double>::infinity(), 1e101}) {
    const DelaunayResult result = delaunay(Points{{0, 0}, {1, 0}, {0, bad}, {1, 1}});
    CHECK(result.problem == DelaunayProblem::not_finite);
    CHECK(result.point == 2);
    CHECK(result.mesh.triangles.empty());
  }
  CHECK_FALSE(describe(DelaunayProblem::collinear).empty());
}
