#include <array>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/delaunay.hpp>
#include <holdfast/geometry/triangle_grid.hpp>
#include <holdfast/geometry/triangle_overlap.hpp>

using namespace holdfast;

namespace {

std::vector<Vector2> random_points(int n, std::uint64_t seed, double height) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  std::vector<Vector2> p{{-1, -height}, {1, -height}, {1, height}, {-1, height}};
  for (int i = 0; i < n; ++i) p.emplace_back(u(random), height * u(random));
  return p;
}

}  // namespace

TEST_CASE("every point of the hull is in one triangle, which gives the point back") {
  for (const double height : {1.0, 1e-4, 1e3}) {
    const std::vector<Vector2> p = random_points(300, 11, height);
    const Triangulation mesh = delaunay(p).mesh;
    const TriangleGrid grid(p, mesh.triangles);
    std::mt19937_64 random(12);
    std::uniform_real_distribution<double> u(-1, 1);
    for (int i = 0; i < 5000; ++i) {
      const Vector2 q(u(random), height * u(random));
      const auto place = grid.find(q);
      REQUIRE(place);
      Vector2 back = Vector2::Zero();
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k) {
        CHECK(place->weights[k] >= -1e-12);
        sum += place->weights[k];
        back += place->weights[k] *
                p[static_cast<std::size_t>(mesh.triangles[static_cast<std::size_t>(place->triangle)][k])];
      }
      CHECK(sum == doctest::Approx(1).epsilon(1e-14));
      // Weights of slivers lose some digits; the point does not.
      CHECK(std::abs(back.x() - q.x()) < 1e-12);
      CHECK(std::abs(back.y() - q.y()) < 1e-12 * height);
    }
  }
}

TEST_CASE("no crack lies between triangles: corners and points of edges are found") {
  const std::vector<Vector2> p = random_points(100, 13, 1.0);
  const Triangulation mesh = delaunay(p).mesh;
  const TriangleGrid grid(p, mesh.triangles);
  for (const auto& t : mesh.triangles) {
    const auto corner = [&](std::size_t i) { return p[static_cast<std::size_t>(t[i % 3])]; };
    for (std::size_t i = 0; i < 3; ++i) {
      for (const double s : {0.0, 0.1, 1.0 / 3.0, 0.5, 0.9, 1.0}) {
        CHECK(grid.find(Vector2(corner(i) + s * (corner(i + 1) - corner(i)))).has_value());
      }
    }
  }
}

TEST_CASE("outside, and where there are no triangles, nothing is found") {
  const std::vector<Vector2> p{{0, 0}, {1, 0}, {0, 1}, {3, 3}};
  const std::vector<std::array<int, 3>> triangles{{0, 1, 2}};
  const TriangleGrid grid(p, triangles);
  CHECK(grid.find(Vector2(0.25, 0.25)).has_value());
  const double nan = std::numeric_limits<double>::quiet_NaN();
  for (const Vector2& q : {Vector2(0.6, 0.6), Vector2(-0.01, 0.5), Vector2(2, 2), Vector2(nan, 0.2), Vector2(0.2, nan),
                           Vector2(INFINITY, 0.1), Vector2(0.1, -INFINITY), Vector2(1e300, 1e300)}) {
    CHECK_FALSE(grid.find(q).has_value());
  }
  CHECK_FALSE(TriangleGrid().find(Vector2(0, 0)).has_value());
  CHECK_FALSE(TriangleGrid(p, std::vector<std::array<int, 3>>{}).find(Vector2(0, 0)).has_value());
  // Triangles without area are never found, and do no harm.
  const std::vector<Vector2> line{{0, 0}, {1, 1}, {2, 2}};
  CHECK_FALSE(TriangleGrid(line, triangles).find(Vector2(1, 1)).has_value());
}

TEST_CASE("overlaps: neighbours do not, those that share area do") {
  using Triangle = std::array<Vector2, 3>;
  const Triangle a{Vector2(0, 0), Vector2(1, 0), Vector2(0, 1)};
  const Triangle across{Vector2(1, 0), Vector2(1, 1), Vector2(0, 1)};
  const Triangle corner{Vector2(0, 0), Vector2(-1, 0), Vector2(0, -1)};
  const Triangle inside{Vector2(0.1, 0.1), Vector2(0.2, 0.1), Vector2(0.1, 0.2)};
  const Triangle crossing{Vector2(-1, 0.2), Vector2(2, 0.2), Vector2(2, 0.3)};
  for (const auto& [other, truth] : {std::pair(across, false), std::pair(corner, false), std::pair(inside, true),
                                     std::pair(crossing, true), std::pair(a, true)}) {
    CHECK(triangles_overlap(a, other) == truth);
    CHECK(triangles_overlap(other, a) == truth);
  }
}

TEST_CASE("a triangulation has no overlaps; a corner drawn over its neighbours has, and few need go") {
  std::vector<Vector2> p = random_points(200, 14, 1.0);
  const Triangulation mesh = delaunay(p).mesh;
  CHECK(overlapping_pairs(p, mesh.triangles, 1000).empty());
  std::vector<std::array<int, 3>> triangles;
  for (const auto& t : mesh.triangles) triangles.push_back(t);
  p.emplace_back(0.0, 0.0);
  p.emplace_back(0.5, 0.0);
  p.emplace_back(0.0, 0.5);
  const int n = static_cast<int>(p.size());
  triangles.push_back({n - 3, n - 2, n - 1});
  const auto pairs = overlapping_pairs(p, triangles, 1000);
  CHECK(pairs.size() > 10);
  const auto removed = fewest_to_remove(pairs, triangles.size());
  REQUIRE(removed.size() == 1);
  CHECK(removed[0] == triangles.size() - 1);
  CHECK(overlapping_pairs(p, triangles, 5).size() == 5);
}

TEST_CASE("removing leaves no pair whole") {
  std::mt19937_64 random(15);
  std::vector<std::pair<std::size_t, std::size_t>> pairs;
  for (int i = 0; i < 300; ++i) {
    const std::size_t a = random() % 100, b = random() % 100;
    if (a != b) pairs.emplace_back(a, b);
  }
  std::vector<bool> kept(100, true);
  for (const std::size_t i : fewest_to_remove(pairs, 100)) kept[i] = false;
  for (const auto& [a, b] : pairs) CHECK_FALSE((kept[a] && kept[b]));
}
