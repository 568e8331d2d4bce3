#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>

#include "motion/motion_checks.hpp"

using namespace holdfast;

namespace {

struct Speeds {
  double mean_deg_s = 0, peak_deg_s = 0, mean_m_s = 0, peak_m_s = 0, widest_gaze_deg = 0, farthest_m = 0;
};

Speeds speeds_of(const Motion& motion) {
  Speeds speeds;
  int count = 0;
  for (HostTime t = motion.begin(); t <= motion.end(); t += std::chrono::milliseconds(5), ++count) {
    const MotionState s = motion.at(t);
    const double w = radians(s.w_WB_B.norm()).degrees();
    speeds.mean_deg_s += w;
    speeds.peak_deg_s = std::max(speeds.peak_deg_s, w);
    speeds.mean_m_s += s.v_WB.norm();
    speeds.peak_m_s = std::max(speeds.peak_m_s, s.v_WB.norm());
    const Vector3 target_B = s.X_WB.inverse() * gaze_target_W;
    speeds.widest_gaze_deg =
        std::max(speeds.widest_gaze_deg, radians(std::atan2(target_B.head<2>().norm(), -target_B.z())).degrees());
    speeds.farthest_m = std::max(speeds.farthest_m, s.X_WB.p().norm());
  }
  speeds.mean_deg_s /= count;
  speeds.mean_m_s /= count;
  return speeds;
}

}  // namespace

TEST_CASE("every named motion exists, an unknown one does not, and all begin at zero near the origin") {
  CHECK(motion_names().size() == 9);
  for (const MotionName& name : motion_names()) {
    CAPTURE(name.id);
    const auto motion = make_motion(name.id, 7);
    REQUIRE(motion != nullptr);
    CHECK(motion->begin() == time_at(0.0));
    CHECK(motion->duration() >= std::chrono::seconds(2));
    CHECK(motion->at(motion->begin()).X_WB.p().norm() < 0.2);
  }
  CHECK(make_motion("M9", 1) == nullptr);
  CHECK(make_motion("", 1) == nullptr);
}

TEST_CASE("derivatives agree with central differences") {
  std::mt19937_64 random(11);
  for (const MotionName& name : motion_names()) {
    CAPTURE(name.id);
    const auto motion = make_motion(name.id, 3);
    for (int i = 0; i < 40; ++i) {
      const double end = to_seconds(motion->duration());
      const double t = 0.01 + (end - 0.02) * static_cast<double>(random() >> 11) * 0x1p-53;
      CAPTURE(t);
      if (name.id == "M3" && (std::abs(t - 0.6) < 0.01 || std::abs(t - 1.0) < 0.01)) continue;  // its corners
      // Truncation h^2/6 times the third derivative; the chirp at 10 Hz has (2 pi 10)^4 0.035 = 5e5 rad/s^4 in its
      // fourth.
      check_derivatives(*motion, time_at(t), std::chrono::microseconds(100), name.id == "M8" ? 2e-3 : 5e-5);
    }
  }
}

TEST_CASE("acceleration is continuous in the smooth motions, also where pieces meet") {
  for (const char* id : {"M4", "M5", "M6", "M7"}) {
    CAPTURE(std::string(id));
    const auto motion = make_motion(id, 5);
    for (HostTime t = motion->begin(); t < motion->end(); t += std::chrono::milliseconds(1)) {
      const MotionState s = motion->at(t);
      const MotionState next = motion->at(t + std::chrono::microseconds(10));
      // 10 us of a jerk below 200 m/s^3 and 200 rad/s^3.
      CHECK((next.a_WB - s.a_WB).norm() < 2e-3);
      CHECK((next.alpha_WB_B - s.alpha_WB_B).norm() < 2e-3);
    }
  }
}

TEST_CASE("the speeds of walk-around, rotation and swing are those of figure 6 of 001") {
  struct Wanted {
    const char* id;
    double mean_deg_s, peak_deg_s, mean_m_s, peak_m_s;
  };
  for (const Wanted& wanted : {Wanted{"M4", 1.3 / 0.06, 4.3 / 0.06, 0.0143 / 0.06, 0.038 / 0.06},
                               Wanted{"M5", 2.2 / 0.06, 5.3 / 0.06, 0.0066 / 0.06, 0.0176 / 0.06},
                               Wanted{"M6", 2.5 / 0.06, 6.5 / 0.06, 0.0178 / 0.06, 0.046 / 0.06}}) {
    for (std::uint64_t seed : {1u, 2u, 3u, 4u, 5u}) {
      const Speeds speeds = speeds_of(*make_motion(wanted.id, seed));
      CAPTURE(std::string(wanted.id));
      CAPTURE(seed);
      MESSAGE(std::string(wanted.id) << " seed " << seed << ": " << speeds.mean_deg_s << " / " << speeds.peak_deg_s
                                     << " deg/s, " << speeds.mean_m_s << " / " << speeds.peak_m_s << " m/s, gaze "
                                     << speeds.widest_gaze_deg << " deg");
      // Seeds change speeds by about a tenth. Peaks of a smooth formula stay below those of a recording with its jerks.
      CHECK(speeds.mean_deg_s == doctest::Approx(wanted.mean_deg_s).epsilon(0.2));
      CHECK(speeds.mean_m_s == doctest::Approx(wanted.mean_m_s).epsilon(0.2));
      CHECK(speeds.peak_deg_s > 0.6 * wanted.peak_deg_s);
      CHECK(speeds.peak_deg_s < 1.2 * wanted.peak_deg_s);
      CHECK(speeds.peak_m_s > 0.6 * wanted.peak_m_s);
      CHECK(speeds.peak_m_s < 1.2 * wanted.peak_m_s);
      CHECK(speeds.widest_gaze_deg < 30.0);  // the target stays inside a field of 60 deg
      CHECK(speeds.farthest_m < 1.0);
    }
  }
}

TEST_CASE("a seed repeats its motion and another one changes it") {
  for (const char* id : {"M4", "M5", "M6"}) {
    const HostTime t = time_at(3.21);
    const MotionState a = make_motion(id, 42)->at(t), b = make_motion(id, 42)->at(t), c = make_motion(id, 43)->at(t);
    CHECK(a.X_WB.p() == b.X_WB.p());
    CHECK(a.w_WB_B == b.w_WB_B);
    CHECK((a.X_WB.p() - c.X_WB.p()).norm() > 1e-4);
  }
}

TEST_CASE("sines reach their amplitude and rate") {
  const auto m1 = make_motion("M1", 1);
  const MotionState crest = m1->at(time_at(0.125));  // a quarter of 0.5 s
  CHECK(radians(so3::log<double>(crest.X_WB.q()).y()).degrees() == doctest::Approx(3.0).epsilon(1e-12));
  CHECK(crest.w_WB_B.norm() < 1e-9);
  // Peak rate 2 pi f A = 37.7 deg/s at the zero crossing.
  CHECK(radians(m1->at(time_at(0.0)).w_WB_B.y()).degrees() ==
        doctest::Approx(2 * std::numbers::pi * 2 * 3).epsilon(1e-12));
}

TEST_CASE("the ramp turns at 100 deg/s and stops abruptly at 1 s") {
  const auto m3 = make_motion("M3", 1);
  const auto yaw_deg = [&](double t) { return radians(so3::log<double>(m3->at(time_at(t)).X_WB.q()).y()).degrees(); };
  CHECK(yaw_deg(0.3) == doctest::Approx(-20.0));
  CHECK(yaw_deg(0.8) == doctest::Approx(0.0).epsilon(1e-9));
  CHECK(yaw_deg(0.9) - yaw_deg(0.7) == doctest::Approx(20.0));
  CHECK(yaw_deg(1.0) == doctest::Approx(20.0));
  CHECK(radians(m3->at(time_at(0.999999)).w_WB_B.y()).degrees() == doctest::Approx(100.0));
  CHECK(m3->at(time_at(1.0)).w_WB_B.norm() == 0.0);
}

TEST_CASE("the lateral shuttle passes at 0.5 m/s, never faster, and reaches what it says") {
  const LateralShuttle shuttle;
  double widest = 0.0, fastest = 0.0;
  for (double t = 0.0; t < shuttle.period_s(); t += 1e-3) {
    const Jet x = shuttle.at(Jet::time(t));
    widest = std::max(widest, std::abs(x.value));
    fastest = std::max(fastest, std::abs(x.rate));
  }
  CHECK(shuttle.at(Jet::time(0.0)).rate == doctest::Approx(0.5));
  CHECK(shuttle.at(Jet::time(1.2)).rate == doctest::Approx(-0.5));
  CHECK(fastest == doctest::Approx(0.5).epsilon(1e-9));
  CHECK(widest == doctest::Approx(shuttle.reach_m()).epsilon(1e-5));  // sampled at 1 ms
}

TEST_CASE("the chirp's frequency rises from 0.2 to 10 Hz") {
  Chirp chirp;
  chirp.amplitude = 1.0;
  // At a zero crossing the rate is 2 pi f(t): check by the identity x'^2 / (2 pi f)^2 + x^2 = 1 at any t.
  for (double t : {0.0, 3.3, 12.0, 19.9}) {
    const Jet x = chirp.at(Jet::time(t));
    const double rate = x.rate / (2 * std::numbers::pi * chirp.hz_at(t));
    CHECK(rate * rate + x.value * x.value == doctest::Approx(1.0).epsilon(1e-10));
  }
  CHECK(chirp.hz_at(0.0) == doctest::Approx(0.2));
  CHECK(chirp.hz_at(20.0) == doctest::Approx(10.0));
}

TEST_CASE("time outside the motion is answered by the nearer end, and says so") {
  const auto m2 = make_motion("M2", 1);
  CHECK(m2->at(time_at(-1.0)).t == m2->begin());
  CHECK(m2->at(time_at(99.0)).t == m2->end());
}
