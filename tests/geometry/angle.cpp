#include <numbers>
#include <type_traits>

#include <doctest/doctest.h>

#include <holdfast/geometry/angle.hpp>

using namespace holdfast;
using namespace holdfast::literals;

// Bare numbers are no angles, in either direction.
static_assert(!std::is_convertible_v<double, Angle>);
static_assert(!std::is_convertible_v<int, Angle>);
static_assert(!std::is_constructible_v<Angle, double>);
static_assert(!std::is_convertible_v<Angle, double>);

template <typename A, typename B>
concept Addable = requires(A a, B b) {
  a + b;
};
template <typename A, typename B>
concept Comparable = requires(A a, B b) {
  a < b;
};
template <typename A, typename B>
concept Multipliable = requires(A a, B b) {
  a* b;
};
static_assert(Addable<Angle, Angle> && !Addable<Angle, double>);
static_assert(Comparable<Angle, Angle> && !Comparable<Angle, double>);
static_assert(Multipliable<Angle, double> && !Multipliable<Angle, Angle>);

static_assert(degrees(180).radians() == std::numbers::pi);
static_assert(sizeof(Angle) == sizeof(double) && std::is_trivially_copyable_v<Angle>);

TEST_CASE("units convert into each other") {
  CHECK(degrees(90).radians() == doctest::Approx(std::numbers::pi / 2).epsilon(1e-15));
  CHECK(radians(std::numbers::pi).degrees() == doctest::Approx(180).epsilon(1e-15));
  CHECK(arcmin(90).degrees() == doctest::Approx(1.5).epsilon(1e-15));
  CHECK(degrees(1.11).arcmin() == doctest::Approx(66.6).epsilon(1e-15));
  CHECK((30_deg).degrees() == doctest::Approx(30).epsilon(1e-15));
  CHECK((1.5_deg).arcmin() == doctest::Approx(90).epsilon(1e-15));
  CHECK((60_arcmin).degrees() == doctest::Approx(1).epsilon(1e-15));
  CHECK((0.5_rad).radians() == 0.5);
}

TEST_CASE("arithmetic is that of the numbers") {
  CHECK((30_deg + 15_deg).degrees() == doctest::Approx(45).epsilon(1e-15));
  CHECK((30_deg - 45_deg).degrees() == doctest::Approx(-15).epsilon(1e-15));
  CHECK((-(2 * 10_deg) / 4).degrees() == doctest::Approx(-5).epsilon(1e-15));
  CHECK(90_deg / 30_deg == doctest::Approx(3).epsilon(1e-15));
  CHECK(1_deg > 59_arcmin);
  CHECK(sin(30_deg) == doctest::Approx(0.5).epsilon(1e-15));
  CHECK(cos(60_deg) == doctest::Approx(0.5).epsilon(1e-15));
  CHECK(tan(45_deg) == doctest::Approx(1).epsilon(1e-15));
}

TEST_CASE("wrapped gives the same direction in (-pi, pi]") {
  for (const double degrees_in : {-900.0, -540.0, -180.0, -179.0, 0.0, 90.0, 180.0, 181.0, 359.0, 720.0, 1000.0}) {
    const Angle wrapped = degrees(degrees_in).wrapped();
    CHECK(wrapped.degrees() > -180.0);
    CHECK(wrapped.degrees() <= 180.0);
    // 1000 degrees carry 1e-15 of relative rounding.
    CHECK(std::abs(sin(wrapped) - sin(degrees(degrees_in))) < 1e-14);
    CHECK(std::abs(cos(wrapped) - cos(degrees(degrees_in))) < 1e-14);
  }
  CHECK(degrees(190).wrapped().degrees() == doctest::Approx(-170).epsilon(1e-14));
}
