#include <cmath>
#include <filesystem>
#include <fstream>
#include <limits>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/optics/lens.hpp>
#include <holdfast/optics/point_mesh_lens.hpp>

using namespace holdfast;

namespace {

template <typename Map>
std::vector<PointMeshSample> sampled(const Map& map, int columns = 21, int rows = 21, double half = 0.5) {
  std::vector<PointMeshSample> samples;
  for (int i = 0; i < columns; ++i) {
    for (int k = 0; k < rows; ++k) {
      const Vector2 p(half * (2.0 * i / (columns - 1) - 1), half * (2.0 * k / (rows - 1) - 1));
      samples.push_back({p, map(p)});
    }
  }
  return samples;
}

PointMeshLens lens_of(std::vector<PointMeshSample> samples) {
  const PointMeshResult result = make_point_mesh(std::move(samples));
  REQUIRE(result.ok());
  return PointMeshLens(result.mesh);
}

Vector2 barrel(const Vector2& p) {
  return p * (1.0 - 0.3 * p.squaredNorm());
}

/// Random points of the square [-half, half].
template <typename Visit>
void for_random(int n, double half, const Visit& visit) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> u(-half, half);
  for (int i = 0; i < n; ++i) visit(Vector2(u(random), u(random)));
}

}  // namespace

TEST_CASE("an affine map is reproduced everywhere, with its Jacobian") {
  Matrix2 A;
  A << 1.1, 0.2, -0.1, 0.9;
  const auto affine = [&](const Vector2& p) { return Vector2(A * p + Vector2(0.01, -0.02)); };
  const PointMeshLens lens = lens_of(sampled(affine));
  for_random(2000, 0.5, [&](const Vector2& p) {
    const auto seen = lens.distort(p);
    REQUIRE(seen);
    CHECK((*seen - affine(p)).norm() < 1e-14);             // a few roundings of numbers below 1
    CHECK((lens.distort_jacobian(p) - A).norm() < 1e-12);  // edges are 0.05 long: their differences lose two digits
    const auto back = lens.undistort(*seen);
    REQUIRE(back);
    CHECK((*back - p).norm() < 1e-14);
    CHECK((*lens.undistort_jacobian(*seen) * A - Matrix2::Identity()).norm() < 1e-12);
  });
}

TEST_CASE("samples are met exactly, and between them the error falls with the square of the spacing") {
  double last = 0.0;
  for (const int n : {11, 21, 41}) {
    const PointMeshLens lens = lens_of(sampled(barrel, n, n));
    for (const PointMeshSample& s : lens.mesh().samples) CHECK((*lens.distort(s.panel) - s.seen).norm() < 1e-15);
    double worst = 0.0;
    for_random(3000, 0.5, [&](const Vector2& p) { worst = std::max(worst, (*lens.distort(p) - barrel(p)).norm()); });
    // Linear interpolation errs by at most h^2/8 times the second derivative (here below 6 * 0.3 * 0.7 in any
    // direction), on a diagonal of length h sqrt(2).
    const double h = std::sqrt(2.0) / (n - 1);
    CHECK(worst < h * h / 8 * 1.8 * 0.71 * 1.01);
    if (last > 0.0) CHECK(last / worst == doctest::Approx(4).epsilon(0.25));
    last = worst;
  }
}

TEST_CASE("there and back is exact on the whole domain, and outside there is nothing") {
  const PointMeshLens lens = lens_of(sampled(barrel));
  CHECK(lens.mesh().folds.empty());
  for_random(5000, 0.7, [&](const Vector2& p) {
    const auto seen = lens.distort(p);
    const bool inside = p.cwiseAbs().maxCoeff() <= 0.5;
    CHECK(seen.has_value() == inside);
    if (!seen) return;
    const auto back = lens.undistort(*seen);
    REQUIRE(back);
    CHECK((*back - p).norm() < 1e-14);
  });
  CHECK(lens.valid_radius() == doctest::Approx(0.5).epsilon(1e-14));
  // The seen border is a barrel: nearest in the middle of a side, or between two samples beside it.
  CHECK(lens.valid_image_radius() == doctest::Approx(0.5 * (1 - 0.3 * 0.25)).epsilon(1e-3));
  CHECK_FALSE(lens.distort(Vector2(std::numeric_limits<double>::quiet_NaN(), 0)).has_value());
  CHECK_FALSE(lens.undistort(Vector2(0, INFINITY)).has_value());
  CHECK_FALSE(lens.distort_jacobian(Vector2(2, 2)).allFinite());
}

TEST_CASE("the Jacobian is the derivative inside each triangle") {
  const PointMeshLens lens = lens_of(sampled(barrel));
  int inside = 0;
  for_random(500, 0.49, [&](const Vector2& p) {
    const double h = 1e-6;  // the map is linear: only rounding, 1e-16 / h
    Matrix2 numeric;
    for (int i = 0; i < 2; ++i) {
      const Vector2 step = h * Vector2::Unit(i);
      numeric.col(i) = (*lens.distort(Vector2(p + step)) - *lens.distort(Vector2(p - step))) / (2 * h);
      // Only where both sides lie in the same triangle.
      if ((lens.distort_jacobian(Vector2(p + step)) - lens.distort_jacobian(Vector2(p - step))).norm() > 0) return;
    }
    ++inside;
    CHECK((lens.distort_jacobian(p) - numeric).norm() < 1e-9);
  });
  CHECK(inside > 450);
}

TEST_CASE("a single wild sample is found as folds, and costs only its surroundings") {
  std::vector<PointMeshSample> samples = sampled(barrel);
  const std::size_t wild = 5 * 21 + 7;
  samples[wild].seen += Vector2(0.2, 0.1);  // four samples too far
  const PointMeshLens lens = lens_of(samples);
  CHECK_FALSE(lens.mesh().folds.empty());
  for (const PointMeshFold& fold : lens.mesh().folds) {
    const bool touches = fold.samples[0] == int(wild) || fold.samples[1] == int(wild) || fold.samples[2] == int(wild);
    CHECK(touches);
  }
  int answered = 0;
  for_random(5000, 0.5, [&](const Vector2& p) {
    const auto seen = lens.distort(p);
    if (!seen) return;
    ++answered;
    const auto back = lens.undistort(*seen);
    REQUIRE(back);
    CHECK((*back - p).norm() < 1e-12);  // one-to-one all the same
  });
  CHECK(answered > 4900);  // of 800 triangles about six are lost
}

TEST_CASE("a lens sampled beyond its fold keeps the part inside") {
  // r (1 - r^2) turns back at r = 1/sqrt(3) = 0.577.
  const auto folding = [](const Vector2& p) { return Vector2(p * (1.0 - p.squaredNorm())); };
  const PointMeshLens lens = lens_of(sampled(folding, 61, 61, 0.9));
  CHECK(lens.mesh().folds.size() > 100);
  const double fold = 1 / std::sqrt(3.0);
  const double spacing = 0.03;
  CHECK(lens.valid_radius() > fold - 2 * spacing);
  CHECK(lens.valid_radius() < fold + 2 * spacing);
  for_random(5000, 0.9, [&](const Vector2& p) {
    const auto seen = lens.distort(p);
    if (!seen) return;
    const auto back = lens.undistort(*seen);
    REQUIRE(back);
    CHECK((*back - p).norm() < 1e-9);
  });
}

TEST_CASE("a map that wraps round itself is cut where it overlaps, though no triangle of it is mirrored") {
  // z -> z^2 on a ring: every triangle keeps its orientation, but z and -z are seen at the same place.
  std::vector<PointMeshSample> samples;
  for (int i = 0; i < 40; ++i) {
    for (const double r : {0.5, 0.75, 1.0}) {
      const double a = 2 * 3.14159265358979 * i / 40;
      samples.push_back(
          {Vector2(r * std::cos(a), r * std::sin(a)), Vector2(r * r * std::cos(2 * a), r * r * std::sin(2 * a))});
    }
  }
  const PointMeshLens lens = lens_of(samples);
  CHECK(lens.mesh().folds.size() > 40);
  int answered = 0;
  for_random(5000, 1.0, [&](const Vector2& p) {
    const auto seen = lens.distort(p);
    if (!seen) return;
    ++answered;
    const auto back = lens.undistort(*seen);
    REQUIRE(back);
    CHECK((*back - p).norm() < 1e-9);
  });
  CHECK(answered > 500);
}

TEST_CASE("the picture does not tear where the nearest three samples lie on a line") {
  // Rows twenty times as dense as columns: the nearest three samples are of one row nearly everywhere, and a plane
  // through them jumps from row to row. The triangle round the point is continuous: steps of the map are at most its
  // steepest slope times the step.
  const PointMeshLens lens = lens_of(sampled(barrel, 201, 11));
  double steepest = 0.0;
  for (const Matrix2& J : lens.mesh().jacobians) steepest = std::max(steepest, J.norm());
  for_random(2000, 0.49, [&](const Vector2& p) {
    for (const Vector2& step : {Vector2(1e-4, 0), Vector2(0, 1e-4), Vector2(1e-7, -1e-7)}) {
      const Vector2 moved = *lens.distort(Vector2(p + step)) - *lens.distort(p);
      CHECK(moved.norm() <= steepest * step.norm() * (1 + 1e-6) + 1e-15);
    }
  });
}

TEST_CASE("mirrored and moved by its placement, like any lens") {
  const PointMeshLens model = lens_of(sampled(barrel));
  const Lens lens(model, LensPlacement{Vector2(0.1, -0.2), Vector2(2.0, 1.5)});
  const Lens other = mirrored(lens);
  for_random(500, 0.45, [&](const Vector2& u) {
    const Vector2 t(0.1 + 2.0 * u.x(), -0.2 + 1.5 * u.y());
    const auto seen = lens.distort(t);
    const auto mirrored_seen = other.distort(Vector2(-t.x(), t.y()));
    REQUIRE(seen);
    REQUIRE(mirrored_seen);
    CHECK((Vector2(-mirrored_seen->x(), mirrored_seen->y()) - *seen).norm() < 1e-15);
    CHECK((*lens.undistort(*seen) - t).norm() < 1e-14);
  });
  CHECK(lens.valid_radius() == doctest::Approx(0.75).epsilon(1e-12));
  const Lens copy = lens;
  CHECK(&copy.model_if<PointMeshLens>()->mesh() == &model.mesh());  // copies share
}

TEST_CASE("samples that make no lens are refused with the reason") {
  const auto problem = [](std::vector<PointMeshSample> s) { return make_point_mesh(std::move(s)); };
  CHECK(problem({}).problem == PointMeshProblem::too_few_samples);
  CHECK(problem({{{0, 0}, {0, 0}}, {{1, 0}, {1, 0}}}).problem == PointMeshProblem::too_few_samples);
  CHECK(problem({{{0, 0}, {0, 0}}, {{1, 1}, {1, 0}}, {{2, 2}, {0, 1}}}).problem == PointMeshProblem::collinear);
  std::vector<PointMeshSample> twice = sampled(barrel, 5, 5);
  twice.push_back(twice[7]);
  CHECK(problem(twice).problem == PointMeshProblem::duplicate_panel_point);
  CHECK(problem(twice).sample + problem(twice).other_sample == 25 + 7);
  std::vector<PointMeshSample> wild = sampled(barrel, 5, 5);
  wild[3].seen.x() = std::numeric_limits<double>::quiet_NaN();
  CHECK(problem(wild).problem == PointMeshProblem::not_finite);
  CHECK(problem(wild).sample == 3);
  const auto mirror = [](const Vector2& p) { return Vector2(-p.x(), p.y()); };
  CHECK(problem(sampled(mirror)).problem == PointMeshProblem::folded);
  const auto flat = [](const Vector2& p) { return Vector2(p.x(), p.x()); };
  CHECK(problem(sampled(flat)).problem == PointMeshProblem::folded);
  // All panel points of a lens seen at wild places: hopeless, and said so quickly.
  std::mt19937_64 random(3);
  std::uniform_real_distribution<double> u(-1, 1);
  const auto scattered = [&](const Vector2&) { return Vector2(u(random), u(random)); };
  const PointMeshResult result = problem(sampled(scattered, 60, 60));
  CHECK(result.problem == PointMeshProblem::folded);
}
