// The code of docs/motion.md, as it stands there.
#include <doctest/doctest.h>

#include <holdfast/motion/motions.hpp>

using namespace holdfast;

TEST_CASE("the page's first example") {
  std::unique_ptr<Motion> walk = make_motion("M4", 1);
  MotionState s = walk->at(time_at(2.5));
  Vector3 ahead_W = s.X_WB.p() + 0.06 * s.v_WB;
  // Half the acceleration times 60 ms squared: below 2 m/s^2 * 1.8e-3 s^2.
  CHECK((ahead_W - walk->at(time_at(2.56)).X_WB.p()).norm() < 0.004);
}

TEST_CASE("the page's motion of one's own") {
  CurveMotion nod(std::chrono::seconds(5), [](const Jet& t) {
    HeadCurve head;
    head.pitch = 0.1 * sin(4.0 * t);
    head.y = 1.6;
    return head;
  });
  CHECK(nod.at(time_at(0)).w_WB_B.x() == doctest::Approx(0.4));
  CHECK(nod.at(time_at(1)).X_WB.p().y() == 1.6);
}
