// Position by weighted ranges, and how much of the ranges' errors it takes over.
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/rigid.hpp>
#include <holdfast/tracking/range_dilution.hpp>

#include "random_values.hpp"

using namespace holdfast;
using namespace holdfast::test;
using doctest::Approx;

namespace {

std::vector<WeightedRange> weighted_ranges(const std::vector<Vector3>& anchors_W, const Vector3& p_W) {
  std::vector<WeightedRange> ranges;
  for (const Vector3& anchor : anchors_W) ranges.push_back({anchor, (p_W - anchor).norm(), 0.001});
  return ranges;
}

std::vector<Vector3> random_anchors(std::mt19937& random, int count) {
  std::vector<Vector3> anchors;
  for (int i = 0; i < count; ++i) anchors.push_back(2.0 * random_vector(random) + Vector3(0.0, 0.0, 4.0));
  return anchors;
}

/// Anchors round a circle, all seen `angle` off the vertical from the origin.
std::vector<Vector3> cone(int count, double angle) {
  std::vector<Vector3> anchors;
  for (int i = 0; i < count; ++i) {
    const double turn = 2.0 * std::numbers::pi * i / count;
    anchors.push_back((1.0 + 0.3 * i) * Vector3(std::sin(angle) * std::cos(turn), std::sin(angle) * std::sin(turn),
                                                std::cos(angle)));  // distance does not matter
  }
  return anchors;
}

}  // namespace

TEST_CASE("multilateration: exact on exact ranges, from nothing and from afar, in any world") {
  std::mt19937 random(1);
  for (int trial = 0; trial < 100; ++trial) {
    const std::vector<Vector3> anchors = random_anchors(random, 4 + trial % 20);
    const Vector3 p_W = random_vector(random);
    const Multilateration near = multilaterate(weighted_ranges(anchors, p_W), p_W + 0.2 * random_vector(random));
    REQUIRE(near.ok());
    CHECK((near.p_W - p_W).norm() < 1e-8);  // a step below 1e-10, times what four random anchors dilute
    const Multilateration anywhere = multilaterate_anywhere(weighted_ranges(anchors, p_W));
    REQUIRE(anywhere.ok());
    CHECK(anywhere.cost < 1e-6);  // anchors may happen to lie in a plane: the mirrored place is as good

    const Rigid X_VW = random_pose(random);
    std::vector<Vector3> moved;
    for (const Vector3& anchor : anchors) moved.push_back(X_VW * anchor);
    const Multilateration there = multilaterate(weighted_ranges(moved, X_VW * p_W), X_VW * (p_W + Vector3(0.1, 0, 0)));
    REQUIRE(there.ok());
    CHECK((there.p_W - X_VW * p_W).norm() < 1e-8);
    CHECK((there.covariance - X_VW.R() * near.covariance * X_VW.R().transpose()).norm() <
          1e-6 * near.covariance.norm());
  }
}

TEST_CASE("multilateration: of two mirrored places the one on the given side") {
  const std::vector<Vector3> ceiling{{0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1.2, 3}};
  const Vector3 p_W(0.3, 0.7, 1.2);
  const Vector3 mirrored_W(0.3, 0.7, 4.8);
  const auto ranges = weighted_ranges(ceiling, p_W);
  CHECK((multilaterate_anywhere(ranges, -Vector3::UnitZ()).p_W - p_W).norm() < 1e-9);
  CHECK((multilaterate_anywhere(ranges, Vector3::UnitZ()).p_W - mirrored_W).norm() < 1e-9);
}

TEST_CASE("multilateration: its covariance is that of its errors, and its cost chi-square") {
  std::mt19937 random(2);
  std::normal_distribution<double> normal;
  const std::vector<Vector3> anchors = random_anchors(random, 7);
  const Vector3 p_W(0.2, -0.3, 0.1);
  std::vector<WeightedRange> ranges = weighted_ranges(anchors, p_W);
  for (std::size_t i = 0; i < ranges.size(); ++i) ranges[i].sigma_m = 0.001 * (1.0 + static_cast<double>(i));
  Matrix3 spread = Matrix3::Zero();
  double cost = 0.0;
  const int trials = 4000;
  Matrix3 covariance;
  for (int trial = 0; trial < trials; ++trial) {
    std::vector<WeightedRange> noisy = ranges;
    for (WeightedRange& r : noisy) r.range_m += r.sigma_m * normal(random);
    const Multilateration found = multilaterate(noisy, p_W);
    REQUIRE(found.ok());
    const Vector3 error = found.p_W - p_W;
    spread += error * error.transpose() / trials;
    cost += found.cost / trials;
    covariance = found.covariance;
  }
  CHECK((spread - covariance).norm() < 0.08 * covariance.norm());  // 1 / sqrt(4000) is 1.6 %, of each element
  CHECK(cost == Approx(4.0).epsilon(0.06));                        // deviation of the mean: sqrt(8 / 4000) = 0.045
}

TEST_CASE("multilateration: bad input is named") {
  const std::vector<Vector3> anchors{{0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1, 2}};
  const Vector3 p_W(0.3, 0.7, 1.2);
  const auto status = [&](auto&& change) {
    std::vector<WeightedRange> ranges = weighted_ranges(anchors, p_W);
    change(ranges);
    const Multilateration found = multilaterate(ranges, p_W), anywhere = multilaterate_anywhere(ranges);
    CHECK(found.p_W.allFinite());
    CHECK(found.covariance.allFinite());
    CHECK(anywhere.status == found.status);
    return to_string(found.status);
  };
  using Ranges = std::vector<WeightedRange>;
  CHECK(status([](Ranges&) {}) == "converged");
  CHECK(status([](Ranges& r) { r.resize(2); }) == "too_few");
  CHECK(status([](Ranges& r) { r[1].range_m = std::numeric_limits<double>::quiet_NaN(); }) == "not_finite");
  CHECK(status([](Ranges& r) { r[1].range_m = -1.0; }) == "not_finite");
  CHECK(status([](Ranges& r) { r[2].anchor_W.x() = std::numeric_limits<double>::infinity(); }) == "not_finite");
  CHECK(status([](Ranges& r) { r[0].sigma_m = 0.0; }) == "not_finite");
  CHECK(status([](Ranges& r) {
          for (std::size_t i = 0; i < r.size(); ++i) r[i].anchor_W = Vector3(1.0 * static_cast<double>(i), 0, 3);
        }) == "degenerate");
  CHECK(to_string(multilaterate(weighted_ranges(anchors, p_W), Vector3::Constant(std::nan(""))).status) ==
        "not_finite");
}

TEST_CASE("dilution: anchors on a cone, in closed form") {
  for (const int count : {3, 4, 8, 20}) {
    for (const double angle : {0.2, 0.7, 1.2}) {
      const auto dilution = range_dilution(cone(count, angle), Vector3::Zero());
      REQUIRE(dilution);
      const double s = std::sin(angle) * std::sin(angle), c = std::cos(angle) * std::cos(angle);
      CHECK(dilution->across(Vector3::UnitZ()) == Approx(std::sqrt(4.0 / (count * s))));
      CHECK(dilution->along(Vector3::UnitZ()) == Approx(std::sqrt(1.0 / (count * c))));
      CHECK(dilution->geometric() == Approx(std::sqrt(4.0 / (count * s) + 1.0 / (count * c))));
      CHECK(dilution->per_axis().x() == Approx(std::sqrt(2.0 / (count * s))));
      CHECK(dilution->per_axis().norm() == Approx(dilution->geometric()));
    }
  }
}

TEST_CASE("dilution: the world's rotation turns it, one more anchor never makes it worse") {
  std::mt19937 random(3);
  for (int trial = 0; trial < 50; ++trial) {
    std::vector<Vector3> anchors = random_anchors(random, 5);
    const auto before = range_dilution(anchors, Vector3::Zero());
    REQUIRE(before);
    const Rigid X_VW = random_pose(random);
    std::vector<Vector3> moved;
    for (const Vector3& anchor : anchors) moved.push_back(X_VW * anchor);
    const auto turned = range_dilution(moved, X_VW.p());
    REQUIRE(turned);
    CHECK(turned->geometric() == Approx(before->geometric()));
    CHECK(turned->along(X_VW.q() * Vector3::UnitX()) == Approx(before->along(Vector3::UnitX())));
    anchors.push_back(random_vector(random) + Vector3(0, 0, 4));
    CHECK(range_dilution(anchors, Vector3::Zero())->geometric() < before->geometric());
  }
}

TEST_CASE("dilution: what cannot be diluted") {
  const std::vector<Vector3> ceiling{{0, 0, 3}, {1, 0, 3}, {1, 1, 3}, {0, 1, 3}};
  CHECK(range_dilution(ceiling, Vector3(0.2, 0.2, 1.0)));
  CHECK_FALSE(range_dilution(ceiling, Vector3(0.2, 0.3, 3.0)));  // in their plane
  CHECK_FALSE(range_dilution(ceiling, Vector3(0.0, 0.0, 3.0)));  // at one of them
  CHECK_FALSE(range_dilution(std::span(ceiling).first(2), Vector3::Zero()));
  CHECK_FALSE(range_dilution(ceiling, Vector3(0.0, std::nan(""), 1.0)));
  const std::vector<Vector3> line{{0, 0, 3}, {1, 0, 3}, {2, 0, 3}, {5, 0, 3}};
  CHECK_FALSE(range_dilution(line, Vector3(0.2, 0.2, 1.0)));
}
