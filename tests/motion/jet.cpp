#include <functional>

#include <doctest/doctest.h>

#include <holdfast/motion/jet.hpp>

using holdfast::Jet;

TEST_CASE("each operation's derivatives agree with central differences") {
  const std::function<Jet(Jet)> formulas[] = {
      [](Jet t) { return t * t * t - 2.0 * t + 1.0; },   [](Jet t) { return 1.0 / (t + 2.0); },
      [](Jet t) { return sin(3.0 * t) * cos(t); },       [](Jet t) { return sqrt(t * t + 0.5); },
      [](Jet t) { return exp(-t) - log(t + 3.0); },      [](Jet t) { return atan(t * t); },
      [](Jet t) { return atan2(sin(t), cos(t) + 2.0); }, [](Jet t) { return atan2(t + 3.0, 0.1 * t); },
      [](Jet t) { return smooth_step(0.3 * t + 0.4); }};
  const double h = 1e-4;
  int index = 0;
  for (const auto& f : formulas) {
    CAPTURE(index++);
    for (const double t : {-0.9, -0.2, 0.0, 0.4, 1.3}) {
      CAPTURE(t);
      const double before = f(Jet::time(t - h)).value, here = f(Jet::time(t)).value, after = f(Jet::time(t + h)).value;
      // h^2/6 of third derivatives below 50; rounding 1e-16 / h^2 in the second difference.
      CHECK(f(Jet::time(t)).rate == doctest::Approx((after - before) / (2 * h)).epsilon(1e-6));
      CHECK(std::abs(f(Jet::time(t)).acceleration - (after - 2 * here + before) / (h * h)) < 3e-6);
    }
  }
}

TEST_CASE("the smooth step is flat outside and its rate and acceleration vanish at both ends") {
  for (const double s : {-5.0, 0.0, 1.0, 7.0}) {
    const Jet step = holdfast::smooth_step(Jet::time(s));
    CHECK(step.value == (s > 0.5 ? 1.0 : 0.0));
    CHECK(step.rate == 0.0);
  }
  CHECK(std::abs(holdfast::smooth_step(Jet::time(1e-9)).acceleration) < 1e-6);  // 60 s
  CHECK(holdfast::smooth_step(Jet::time(0.5)).value == doctest::Approx(0.5));
}
