#include <cmath>

#include <doctest/doctest.h>

#include <holdfast/deflection/lit_line.hpp>

using namespace holdfast;

namespace {

/// A thing shown at height first + moved * s + bent * s^2 of the picture (the place is the height, and the line too), for
/// lines of [from, to] only.
struct Thing {
  double first, moved, bent = 0.0, from = -1e9, to = 1e9;
  mutable int asked = 0;

  std::optional<LitPlace<double>> operator()(double s) const {
    ++asked;
    if (!(s >= from && s <= to)) return std::nullopt;
    const double height = first + s * (moved + s * bent);
    return LitPlace<double>{height, height};
  }
};

}  // namespace

TEST_CASE("a thing that moves evenly lights where its way meets the scan's") {
  for (const double first : {-0.3, 0.0, 0.2, 0.5, 0.97, 1.4}) {
    for (const double moved : {-0.5, -0.05, 0.0, 0.03, 0.5, 0.8}) {
      const Thing thing{first, moved};
      const auto lit = on_its_line(thing);
      REQUIRE(lit);
      // first + moved s = s; s is found to 1e-13, and the place moves by `moved` of that and divides it by 1 - moved.
      CHECK(std::abs(*lit - first / (1.0 - moved)) < 1e-12);
      CHECK(thing.asked <= 4);  // a secant meets a straight line at once
    }
  }
  const Thing bent{0.3, 0.1, 0.05};
  const auto lit = on_its_line(bent);
  REQUIRE(lit);
  CHECK(std::abs(*lit - (0.3 + *lit * (0.1 + *lit * 0.05))) < 1e-13);
  CHECK(bent.asked <= 7);
}

TEST_CASE("what is shown for a part of the lines only is found there") {
  // Lit at line 0.1, shown for the lines up to 0.12: neither the middle line nor the last shows it.
  CHECK(*on_its_line(Thing{0.098, 0.02, 0.0, -1e9, 0.12}) == doctest::Approx(0.1).epsilon(1e-12));
  CHECK(*on_its_line(Thing{0.882, 0.02, 0.0, 0.89, 1e9}) == doctest::Approx(0.9).epsilon(1e-12));
  // The first step, to 0.6, leads beyond what is shown.
  CHECK(*on_its_line(Thing{0.6, -0.5, 0.0, -1e9, 0.45}) == doctest::Approx(0.4).epsilon(1e-12));
  CHECK(*on_its_line(Thing{0.31, 0.01, 0.0, 0.25, 0.4}) == doctest::Approx(0.31 / 0.99).epsilon(1e-12));
  // Shown only before, or only after, it would be lit.
  CHECK_FALSE(on_its_line(Thing{0.6, 0.0, 0.0, -1e9, 0.55}));
  CHECK_FALSE(on_its_line(Thing{0.3, 0.0, 0.0, 0.4, 1e9}));
  CHECK_FALSE(on_its_line(Thing{0.5, 0.0, 0.0, 2.0, 1.0}));
}

TEST_CASE("what keeps pace with the scan lights nowhere, or for ever") {
  CHECK_FALSE(on_its_line(Thing{0.3, 1.0}));
  CHECK_FALSE(on_its_line(Thing{0.3, 0.95}));
}

TEST_CASE("a place known at whole nanoseconds is found to a part of one") {
  // 11.1 ms in steps of 1 ns are 9e-8 of a scan; half a step of a thing that moves by 0.1 of the picture is 5e-9 of it.
  constexpr double step = 1.0 / 11.1e6;
  for (int i = 0; i < 200; ++i) {
    const double first = 0.2 + 0.6 * i / 200;
    for (const double moved : {-0.1, 0.1}) {
      const auto lit = on_its_line([&](double s) -> std::optional<LitPlace<double>> {
        const double height = first + moved * step * std::round(s / step);
        return LitPlace<double>{height, height};
      });
      REQUIRE(lit);
      CHECK(std::abs(*lit - first / (1.0 - moved)) < 2e-8);
    }
  }
}
