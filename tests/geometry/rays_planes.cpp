#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/rays_planes.hpp>

using namespace holdfast;

namespace {
const double nan_value = std::numeric_limits<double>::quiet_NaN();
Vector3 random_vector(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return {normal(random), normal(random), normal(random)};
}
}  // namespace

TEST_CASE("make normalises and refuses") {
  const auto ray = Ray::make(Vector3(1, 2, 3), Vector3(0, 3, 4));
  REQUIRE(ray);
  CHECK((ray->at(5) - Vector3(1, 5, 7)).norm() < 1e-15);
  CHECK_FALSE(Ray::make(Vector3(1, 2, 3), Vector3::Zero()));
  CHECK_FALSE(Ray::make(Vector3(1, nan_value, 3), Vector3(0, 0, 1)));
  CHECK_FALSE(Ray::make(Vector3(1, 2, 3), Vector3(0, nan_value, 1)));
  CHECK(Ray::make(Vector3::Zero(), Vector3(1e-200, 0, 0)));  // its square is zero, the vector is not
  CHECK_FALSE(Plane::make(Vector3::Zero(), Vector3(1, 2, 3)));
  CHECK_FALSE(Plane::make(Vector3(0, 1, 0), Vector3(1, 2, nan_value)));
}

TEST_CASE("signed distance is positive on the normal's side") {
  const auto floor = Plane::make(Vector3(0, 2, 0), Vector3(5, -1.5, 7));
  REQUIRE(floor);
  CHECK(floor->signed_distance(Vector3(1, 0.5, 2)) == doctest::Approx(2.0).epsilon(1e-15));
  CHECK(floor->signed_distance(Vector3(1, -2, 2)) == doctest::Approx(-0.5).epsilon(1e-15));
  CHECK((floor->nearest_point(Vector3(1, 0.5, 2)) - Vector3(1, -1.5, 2)).norm() < 1e-15);
}

TEST_CASE("a ray meets a plane from either side, ahead only") {
  const Plane floor{Vector3(0, 1, 0), -1.0};
  const Ray down = *Ray::make(Vector3(0, 1, 0), Vector3(1, -1, 0));
  REQUIRE(intersection(down, floor));
  CHECK((*intersection(down, floor) - Vector3(2, -1, 0)).norm() < 1e-15);
  CHECK(*intersection_distance(down, floor) == doctest::Approx(2 * std::sqrt(2.0)).epsilon(1e-15));
  const Ray from_below = *Ray::make(Vector3(0, -3, 0), Vector3(0, 1, 0));
  CHECK((*intersection(from_below, floor) - Vector3(0, -1, 0)).norm() < 1e-15);
  CHECK_FALSE(intersection(*Ray::make(Vector3(0, 1, 0), Vector3(0, 1, 0)), floor));  // away
  CHECK_FALSE(intersection(*Ray::make(Vector3(0, 1, 0), Vector3(1, 0, 0)), floor));  // parallel
  const Ray in_plane = *Ray::make(Vector3(0, -1, 0), Vector3(1, 0, 0));
  CHECK_FALSE(intersection(in_plane, floor));
}

TEST_CASE("a moved frame sees the same meeting point and distance") {
  std::mt19937 random(31);
  for (int i = 0; i < 20; ++i) {
    const Rigid X_AB(so3::exp<double>(random_vector(random)), random_vector(random));
    const Plane plane_B = *Plane::make(random_vector(random), random_vector(random));
    const Vector3 p_B = random_vector(random);
    const Vector3 target_B = plane_B.nearest_point(random_vector(random));
    const Ray ray_B = *Ray::make(p_B, target_B - p_B);
    CHECK((X_AB * plane_B).signed_distance(X_AB * p_B) == doctest::Approx(plane_B.signed_distance(p_B)).epsilon(1e-12));
    const auto hit_A = intersection(X_AB * ray_B, X_AB * plane_B);
    REQUIRE(hit_A);
    // The intersection divides by the sine of the grazing angle: a few digits may go.
    CHECK((*hit_A - X_AB * target_B).norm() < 1e-12);
  }
}

TEST_CASE("two rays: 000 eqs 4.4-4.8") {
  // Along X at height 0, and along -Z at height 0.2, crossing at right angles over (3, *, 0).
  const Ray ray_1{Vector3(0, 0, 0), Vector3(1, 0, 0)};
  const Ray ray_2{Vector3(3, 0.2, 5), Vector3(0, 0, -1)};
  const auto nearest = nearest_points(ray_1, ray_2);
  REQUIRE(nearest);
  CHECK(nearest->distance_1 == doctest::Approx(3).epsilon(1e-15));
  CHECK(nearest->distance_2 == doctest::Approx(5).epsilon(1e-15));
  CHECK(nearest->gap() == doctest::Approx(0.2).epsilon(1e-15));
  CHECK((nearest->midpoint() - Vector3(3, 0.1, 0)).norm() < 1e-15);
}

TEST_CASE("the shortest line is perpendicular to both rays, and matches eq. 4.7 as printed") {
  std::mt19937 random(32);
  for (int i = 0; i < 50; ++i) {
    const Ray ray_1 = *Ray::make(random_vector(random), random_vector(random));
    const Ray ray_2 = *Ray::make(random_vector(random), random_vector(random));
    const auto nearest = nearest_points(ray_1, ray_2);
    REQUIRE(nearest);
    const Vector3 line = nearest->point_2 - nearest->point_1;
    const Vector3 B = ray_2.origin - ray_1.origin;
    const double c = ray_1.direction.dot(ray_2.direction);
    const double k = 1 - c * c;
    CHECK(std::abs(line.dot(ray_1.direction)) < 1e-12 / k);
    CHECK(std::abs(line.dot(ray_2.direction)) < 1e-12 / k);
    CHECK(std::abs(nearest->distance_1 - (B.dot(ray_1.direction) - c * B.dot(ray_2.direction)) / k) < 1e-12 / k);
    CHECK(std::abs(nearest->distance_2 - (c * B.dot(ray_1.direction) - B.dot(ray_2.direction)) / k) < 1e-12 / k);
  }
}

TEST_CASE("nearly parallel rays keep their digits, parallel ones are refused") {
  // Two cameras 1 mm apart see a point 1 km ahead: the rays differ by 1e-6 rad, where 1 - c^2 keeps four digits only.
  const Vector3 target(0.2, 0.1, -1000);
  const Ray ray_1 = *Ray::make(Vector3(0, 0, 0), target);
  const Ray ray_2 = *Ray::make(Vector3(0.001, 0, 0), target - Vector3(0.001, 0, 0));
  const auto nearest = nearest_points(ray_1, ray_2);
  REQUIRE(nearest);
  // Directions round to 1e-16, over 1e-6 rad of difference: 1e-10 of 1 km, and a few of those.
  CHECK((nearest->midpoint() - target).norm() < 1e-6);
  CHECK_FALSE(nearest_points(ray_1, ray_1));
  CHECK_FALSE(nearest_points(ray_1, Ray{Vector3(1, 0, 0), -ray_1.direction}));
}

TEST_CASE("a plane through points") {
  const auto plane = plane_through(Vector3(1, 0, 2), Vector3(0, 1, 2), Vector3(-1, -1, 2));
  REQUIRE(plane);
  CHECK((plane->normal - Vector3(0, 0, 1)).norm() < 1e-15);  // anticlockwise seen from +Z
  CHECK(plane->offset == doctest::Approx(2).epsilon(1e-15));
  CHECK((plane_through(Vector3(0, 1, 2), Vector3(1, 0, 2), Vector3(-1, -1, 2))->normal - Vector3(0, 0, -1)).norm() <
        1e-15);
}

TEST_CASE("a plane through many noisy points is nearer to them than its neighbours") {
  std::mt19937 random(33);
  std::normal_distribution<double> noise(0.0, 0.01);
  const Plane truth = *Plane::make(Vector3(1, 2, -1), Vector3(0.3, 0.2, 0.1));
  std::vector<Vector3> points;
  for (int i = 0; i < 400; ++i)
    points.push_back(truth.nearest_point(random_vector(random)) + noise(random) * truth.normal);
  const auto fit = plane_through(points);
  REQUIRE(fit);
  // The noise over 20 (root of 400): 0.5 mm of offset, 0.5 mrad of tilt; five times that.
  CHECK(std::abs(std::abs(fit->normal.dot(truth.normal)) - 1) < 5e-6);
  CHECK(std::abs(fit->signed_distance(Vector3(0.3, 0.2, 0.1))) < 2.5e-3);
  const auto cost = [&points](const Plane& plane) {
    double sum = 0;
    for (const Vector3& p : points) sum += plane.signed_distance(p) * plane.signed_distance(p);
    return sum;
  };
  const double best = cost(*fit);
  for (int i = 0; i < 20; ++i) {
    const Vector3 turn = 1e-3 * random_vector(random);
    CHECK(cost(Plane{so3::exp<double>(turn) * fit->normal, fit->offset}) > best);
  }
  CHECK(cost(Plane{fit->normal, fit->offset + 1e-3}) > best);
}

TEST_CASE("points on a line, too few, or not finite give no plane") {
  const std::vector<Vector3> line = {Vector3(0, 0, 0), Vector3(1, 1, 1), Vector3(2, 2, 2), Vector3(-4, -4, -4)};
  CHECK_FALSE(plane_through(line));
  CHECK_FALSE(plane_through(std::span<const Vector3>(line).first(2)));
  CHECK_FALSE(plane_through(Vector3(1, 0, 0), Vector3(1, 0, 0), Vector3(1, 0, 0)));
  CHECK_FALSE(plane_through(Vector3(1, 0, 0), Vector3(0, nan_value, 0), Vector3(0, 0, 1)));
}
