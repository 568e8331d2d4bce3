// Positions without a filter: ranges to anchors, planes that meet; and a camera's table of deviations.
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/tracking/deviation_table.hpp>
#include <holdfast/tracking/plane_intersection.hpp>
#include <holdfast/tracking/trilateration.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

namespace {

constexpr double nan_value = std::numeric_limits<double>::quiet_NaN();

std::vector<AnchorRange> ranges_from(const std::vector<Vector3>& anchors, const Vector3& p) {
  std::vector<AnchorRange> ranges;
  for (const Vector3& anchor : anchors) ranges.push_back({anchor, (p - anchor).norm()});
  return ranges;
}

}  // namespace

TEST_CASE("trilateration: the microphones of 000 eqs 4.2 and 4.3") {
  const std::vector<Vector3> microphones{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  const double r0 = 1.3;
  const double r1 = 1.1;
  const double r2 = 0.9;
  const double x = (r0 * r0 - r1 * r1 + 1) / 2;
  const double y = (r0 * r0 - r2 * r2 + 1) / 2;
  const double z = std::sqrt(r0 * r0 - x * x - y * y);
  const auto found =
      trilaterate(std::vector<AnchorRange>{{microphones[0], r0}, {microphones[1], r1}, {microphones[2], r2}});
  REQUIRE(found);
  CHECK(found->flat);
  CHECK((found->above_W - Vector3(x, y, z)).norm() < 1e-14);
  CHECK((found->below_W - Vector3(x, y, -z)).norm() < 1e-14);
  CHECK(found->above_rms_m < 1e-14);
  CHECK(found->below_rms_m < 1e-14);
}

TEST_CASE("trilateration: any three anchors, in any world") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 200; ++trial) {
    CAPTURE(trial);
    const std::vector<Vector3> anchors{random_vector(random, 3), random_vector(random, 3), random_vector(random, 3)};
    const Vector3 p = random_vector(random, 3);
    const auto found = trilaterate(ranges_from(anchors, p));
    REQUIRE(found);
    CHECK(found->flat);
    const Vector3 up = (anchors[1] - anchors[0]).cross(anchors[2] - anchors[0]);
    const bool above = up.dot(p - anchors[0]) > 0.0;
    // Where the spheres touch at a flat angle, rounding of 1e-15 grows to its square root at worst.
    CHECK(((above ? found->above_W : found->below_W) - p).norm() < 1e-6);
    CHECK(up.dot(found->above_W - anchors[0]) >= up.dot(found->below_W - anchors[0]));

    const Rigid G(so3::exp<double>(random_vector(random)), random_vector(random));
    std::vector<Vector3> moved;
    for (const Vector3& anchor : anchors) moved.push_back(G * anchor);
    const auto moved_found = trilaterate(ranges_from(moved, G * p));
    REQUIRE(moved_found);
    CHECK((moved_found->above_W - G * found->above_W).norm() < 1e-6);
    CHECK((moved_found->below_W - G * found->below_W).norm() < 1e-6);
  }
}

TEST_CASE("trilateration: four anchors or more leave one position") {
  std::mt19937 random(2);
  for (int trial = 0; trial < 100; ++trial) {
    CAPTURE(trial);
    std::vector<Vector3> anchors{{0, 0, 0}, {4, 0, 0.2}, {0, 5, 2.5}, {4, 5, 0.3}};
    for (int more = trial % 5; more > 0; --more) anchors.push_back(random_vector(random, 3));
    const Vector3 p = random_vector(random, 2);
    const auto found = trilaterate(ranges_from(anchors, p));
    REQUIRE(found);
    CHECK_FALSE(found->flat);
    CHECK((found->above_W - p).norm() < 1e-12);
    CHECK(found->above_W == found->below_W);
    CHECK(found->above_rms_m < 1e-12);
  }
}

TEST_CASE("trilateration: noisy ranges by least squares") {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, 0.05);
  const std::vector<Vector3> anchors{{0, 0, 0}, {4, 0, 2.5}, {0, 5, 2.4}, {4, 5, 0.1}, {2, 2, 3}};
  double sum = 0.0;
  double expected = 0.0;
  for (int trial = 0; trial < 400; ++trial) {
    const Vector3 p = Vector3(2, 2.5, 1) + random_vector(random, 0.5);
    auto ranges = ranges_from(anchors, p);
    for (AnchorRange& range : ranges) range.range_m += noise(random);
    const auto found = trilaterate(ranges);
    REQUIRE(found);
    // At the least squares of the ranges, the gradient of their squared residuals is zero.
    Vector3 gradient = Vector3::Zero();
    Matrix3 normal = Matrix3::Zero();
    for (const AnchorRange& range : ranges) {
      const Vector3 apart = found->above_W - range.anchor_W;
      gradient += (range.range_m - apart.norm()) * apart.normalized();
      normal += apart.normalized() * apart.normalized().transpose();
    }
    CHECK(gradient.norm() < 1e-6);
    sum += (found->above_W - p).squaredNorm();
    expected += 0.05 * 0.05 * normal.inverse().trace();
  }
  // The error is what the geometry makes of the noise: within 15 % by 400 trials, whose own deviation is 5 %.
  CHECK(sum == Approx(expected).epsilon(0.15));
}

TEST_CASE("trilateration: coplanar anchors, targets in their plane, spheres that do not meet") {
  const std::vector<Vector3> ceiling{{0, 0, 3}, {4, 0, 3}, {4, 4, 3}, {0, 4, 3}};
  const auto below = trilaterate(ranges_from(ceiling, Vector3(1, 1.5, 1.2)));
  REQUIRE(below);
  CHECK(below->flat);
  CHECK((below->below_W - Vector3(1, 1.5, 1.2)).norm() < 1e-12);
  CHECK((below->above_W - Vector3(1, 1.5, 4.8)).norm() < 1e-12);
  // Nearly coplanar anchors: the tilt tells which side, and both are still told.
  std::vector<Vector3> sagging = ceiling;
  sagging[2].z() -= 0.02;
  const auto sagged = trilaterate(ranges_from(sagging, Vector3(1, 1.5, 1.2)));
  REQUIRE(sagged);
  CHECK(sagged->flat);
  CHECK((sagged->best_W() - Vector3(1, 1.5, 1.2)).norm() < 1e-9);
  CHECK(sagged->above_rms_m > 1e-4);

  const auto inside = trilaterate(ranges_from(ceiling, Vector3(1, 1.5, 3)));
  REQUIRE(inside);
  // The height's square is zero within rounding: the height is within its root.
  CHECK((inside->above_W - Vector3(1, 1.5, 3)).norm() < 1e-6);

  auto apart = ranges_from({ceiling[0], ceiling[1], ceiling[2]}, Vector3(2, 1, 3));
  for (AnchorRange& range : apart) range.range_m -= 0.1;
  const auto compromise = trilaterate(apart);
  REQUIRE(compromise);
  CHECK(compromise->above_W == compromise->below_W);
  CHECK(compromise->above_W.z() == Approx(3.0).epsilon(1e-9));
  CHECK(compromise->above_rms_m > 0.01);
  CHECK(compromise->above_rms_m < 0.1);
}

TEST_CASE("trilateration: what it refuses") {
  const std::vector<Vector3> good{{0, 0, 0}, {4, 0, 0}, {0, 4, 0}};
  auto ranges = ranges_from(good, Vector3(1, 1, 1));
  CHECK(trilaterate(ranges));
  CHECK_FALSE(trilaterate(std::span(ranges).first(2)));
  CHECK_FALSE(trilaterate({}));
  CHECK_FALSE(trilaterate(ranges_from({{0, 0, 0}, {1, 2, 3}, {2, 4, 6}, {-1, -2, -3}}, Vector3(1, 1, 1))));  // a line
  CHECK_FALSE(trilaterate(ranges_from({{1, 1, 0}, {1, 1, 0}, {1, 1, 0}}, Vector3(1, 1, 1))));                // a point
  auto bad = ranges;
  bad[1].range_m = -1.0;
  CHECK_FALSE(trilaterate(bad));
  bad[1].range_m = nan_value;
  CHECK_FALSE(trilaterate(bad));
  bad = ranges;
  bad[2].anchor_W.x() = std::numeric_limits<double>::infinity();
  CHECK_FALSE(trilaterate(bad));
}

TEST_CASE("planes: three meet in a point, more by least squares") {
  std::mt19937 random(4);
  for (int trial = 0; trial < 100; ++trial) {
    CAPTURE(trial);
    const Vector3 p = random_vector(random, 3);
    std::vector<Plane> planes;
    for (int i = 0; i < 3 + trial % 4; ++i) planes.push_back(*Plane::make(random_vector(random), p));
    const auto found = intersection(planes);
    REQUIRE(found);
    CHECK((*found - p).norm() < 1e-9);  // three random planes may meet at a flat angle

    for (Plane& plane : planes) plane.offset += 0.01 * random_vector(random).x();
    const auto fitted = intersection(planes);
    REQUIRE(fitted);
    Vector3 gradient = Vector3::Zero();
    for (const Plane& plane : planes) gradient += plane.signed_distance(*fitted) * plane.normal;
    CHECK(gradient.norm() < 1e-10);  // of the squared distances

    const Rigid G(so3::exp<double>(random_vector(random)), random_vector(random));
    for (Plane& plane : planes) plane = G * plane;
    const auto moved = intersection(planes);
    REQUIRE(moved);
    CHECK((*moved - G * *fitted).norm() < 1e-8);
  }
}

TEST_CASE("planes: what they refuse") {
  const Plane x{Vector3(1, 0, 0), 1.0};
  const Plane y{Vector3(0, 1, 0), 2.0};
  const Plane z{Vector3(0, 0, 1), 3.0};
  const Plane xy = *Plane::make(Vector3(1, 1, 0), Vector3(0, 0, 0));
  CHECK((intersection(std::vector{x, y, z}).value() - Vector3(1, 2, 3)).norm() < 1e-15);
  CHECK_FALSE(intersection(std::vector{x, y}));
  CHECK_FALSE(intersection(std::vector{x, y, xy}));  // all upright: the height is free
  CHECK_FALSE(intersection(std::vector{x, x, x, x}));
  CHECK_FALSE(intersection(std::vector{x, y, Plane{Vector3(0, 0, 1), nan_value}}));
  // A plane that is nearly upright determines the height badly: refused when that is too badly.
  const Plane leaning = *Plane::make(Vector3(1, 0, 1e-4), Vector3(1, 2, 3));
  CHECK(intersection(std::vector{x, y, leaning}));
  CHECK_FALSE(intersection(std::vector{x, y, leaning}, 1000.0));
}

TEST_CASE("deviation table: bilinear between nodes, constant beyond") {
  DeviationTable table;
  table.half_extent_m = 2e-3;
  // A bilinear field is met exactly everywhere.
  const auto field = [](const Vector2& uv) {
    return Vector2(1e-5 + 0.01 * uv.x() - 2.0 * uv.x() * uv.y(), -2e-5 + 0.02 * uv.y() + 3.0 * uv.x() * uv.y());
  };
  for (int row = 0; row < DeviationTable::nodes; ++row) {
    for (int column = 0; column < DeviationTable::nodes; ++column) {
      table.deviation[row * DeviationTable::nodes + column] = field(table.node_at(column, row));
    }
  }
  std::mt19937 random(5);
  std::uniform_real_distribution<double> place(-2e-3, 2e-3);
  for (int trial = 0; trial < 200; ++trial) {
    const Vector2 real(place(random), place(random));
    CHECK((table.deviation_at(real) - field(real)).norm() < 1e-18);
    CHECK((table.ideal(real) + field(real) - real).norm() < 1e-18);
    const auto back = table.real(table.ideal(real));
    REQUIRE(back);
    CHECK((*back - real).norm() < 1e-16);
  }
  CHECK((table.deviation_at(Vector2(2e-3, -2e-3)) - field(Vector2(2e-3, -2e-3))).norm() < 1e-18);
  CHECK((table.deviation_at(Vector2(9e-3, 1e-3)) - field(Vector2(2e-3, 1e-3))).norm() < 1e-18);
  CHECK(table.deviation_at(Vector2(nan_value, 0)).isZero());
  CHECK(DeviationTable().ideal(Vector2(1e-3, 2e-3)) == Vector2(1e-3, 2e-3));  // an empty table changes nothing
}

TEST_CASE("deviation table: a fit to a sensor's bench calibration") {
  const double half = 2e-3;
  // A barrel of 8 % at the corner with some decentring: what a simple lens does.
  const auto ideal_of = [&](const Vector2& real) {
    const double r2 = real.squaredNorm() / (half * half);
    return Vector2(real.x() * (1.0 + 0.04 * r2) + 2e-5 * r2, real.y() * (1.0 + 0.04 * r2) - 1e-5 * real.x() / half);
  };
  std::mt19937 random(6);
  std::uniform_real_distribution<double> place(-half, half);
  std::normal_distribution<double> noise(0.0, 1e-7);
  std::vector<DeviationSample> samples;
  for (int i = 0; i < 2500; ++i) {  // as many rays as the paper took of a view, evenly spaced
    const Vector2 real = half * Vector2((i % 50 - 24.5) / 24.5, (i / 50 - 24.5) / 24.5);
    samples.push_back({real, ideal_of(real) + Vector2(noise(random), noise(random))});
  }
  const auto table = fit_deviation_table(samples, half);
  REQUIRE(table);
  double before = 0.0;
  double after = 0.0;
  for (int i = 0; i < 5000; ++i) {
    const Vector2 real(place(random), place(random));
    before = std::max(before, (real - ideal_of(real)).norm());
    after = std::max(after, (table->ideal(real) - ideal_of(real)).norm());
  }
  CHECK(before > 1e-4);
  // A cell of 1/12 of the half extent bends by 0.3 micrometres at the corner; sparse samples there double that and more.
  CHECK(after < 3e-6);

  // Slopes are met exactly, at the edges too, where a plain average would lean inwards.
  for (DeviationSample& sample : samples) sample.ideal = sample.real - Vector2(0.01 * sample.real.x(), 1e-5);
  const auto slope = fit_deviation_table(samples, half);
  REQUIRE(slope);
  CHECK((slope->deviation_at(Vector2(half, half)) - Vector2(0.01 * half, 1e-5)).norm() < 1e-12);
}

TEST_CASE("deviation table: few samples, and what a fit refuses") {
  const std::vector<DeviationSample> one{{Vector2(1e-4, 2e-4), Vector2(2e-4, 1e-4)}};
  const auto table = fit_deviation_table(one, 1e-3);
  REQUIRE(table);
  for (const Vector2& corner : {Vector2(-1e-3, -1e-3), Vector2(1e-3, 1e-3), Vector2(1e-4, 2e-4)}) {
    CHECK((table->deviation_at(corner) - Vector2(-1e-4, 1e-4)).norm() < 1e-18);  // spread to every node
  }
  CHECK_FALSE(fit_deviation_table({}, 1e-3));
  CHECK_FALSE(fit_deviation_table(one, 0.0));
  CHECK_FALSE(fit_deviation_table(one, nan_value));
  CHECK_FALSE(fit_deviation_table(one, 1e-5));  // it lies outside
  CHECK_FALSE(fit_deviation_table(std::vector<DeviationSample>{{Vector2(nan_value, 0), Vector2(0, 0)}}, 1e-3));
}
