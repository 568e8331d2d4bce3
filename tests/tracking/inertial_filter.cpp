#include <cmath>
#include <limits>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/motion/generators.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/tracking/inertial_filter.hpp>

#include "tracking/random_values.hpp"

using namespace holdfast;
using test::random_vector;
using namespace std::chrono_literals;

namespace {

constexpr double no_number = std::numeric_limits<double>::quiet_NaN();

/// A unit with an error of every kind that the filter finds out.
InertialUnit unit_with_errors() {
  InertialUnit unit = mems_inertial_unit();
  unit.X_BS = Rigid::translation(Vector3(0.008, -0.005, 0.012));
  unit.lag = 4ms;
  return unit;
}

Rigid noisy(const Rigid& X, std::mt19937& random) {
  return Rigid(X.q() * so3::exp<double>(random_vector<3>(random, 5e-4)), X.p() + random_vector<3>(random, 2e-4));
}

/// Poses of 100 Hz that arrive `delay` after they were measured.
InertialFilter followed(const Motion& motion, const InertialUnit& unit, Duration delay) {
  InertialFilter filter;
  std::mt19937 random(1);
  HostTime next = motion.begin() + 20ms;
  for (const InertialReading& reading : inertial_stream(motion, unit)) {
    filter.update(reading);
    for (; next + delay <= reading.t; next += 10ms) filter.update(TimedPose{next, noisy(motion.at(next).X_WB, random)});
  }
  return filter;
}

}  // namespace

TEST_CASE("a fading polynomial follows a parabola, and its integral is the parabola's") {
  const Vector3 c0(1.0, -2.0, 0.5), c1(0.3, 0.1, -4.0), c2(2.0, -1.0, 3.0);
  const auto at = [&](double t) { return Vector3(c0 + t * c1 + 0.5 * t * t * c2); };
  FadingPolynomial filter(0.02);
  double t = 0.0;
  filter.update(0.0, at(0.0));
  for (int i = 0; i < 400; ++i) {
    const double dt = i % 3 == 0 ? 0.002 : 0.003;  // uneven
    t += dt;
    filter.update(dt, at(t));
  }
  // The start is forgotten by exp(-1 s / 0.02 s); what is left is rounding, divided by dt^2.
  CHECK((filter.value() - at(t)).norm() < 1e-10);
  CHECK((filter.rate() - (c1 + t * c2)).norm() < 1e-8);
  CHECK((filter.second() - c2).norm() < 1e-6);
}

TEST_CASE("the strapdown integral of constant rate and force is the closed form's, wherever it begins and ends") {
  const Vector3 w(0.0, 0.0, 2.0), f(1.0, 0.0, 3.0);
  InertialHistory history(64);
  for (int i = 0; i <= 50; ++i) CHECK(history.push({time_at(0.002 * i), w, f}));
  CHECK_FALSE(history.push({time_at(0.1), w, f}));  // not later
  CHECK_FALSE(history.push({time_at(0.05), w, f}));
  const double T = 0.0611;
  const StrapdownIncrement felt = history.integrate(time_at(0.0123), time_at(0.0123 + T), {}, Vector3::Zero());
  const double a = w.z() * T;
  CHECK(felt.seconds == doctest::Approx(T));
  CHECK(so3::angle_between<double>(felt.q, so3::exp<double>(Vector3(0, 0, a))) < 1e-12);
  // Integral of the turned force; the midpoint rule errs by (w dt)^2 / 24 = 7e-7 of it.
  CHECK((felt.velocity_B - Vector3(std::sin(a) / w.z(), (1.0 - std::cos(a)) / w.z(), 3.0 * T)).norm() < 1e-6 * T);
  CHECK((felt.position_B - Vector3((1.0 - std::cos(a)) / 4.0, (a - std::sin(a)) / 4.0, 1.5 * T * T)).norm() < 1e-6 * T);
  // Two stretches are one.
  const StrapdownIncrement first = history.integrate(time_at(0.0123), time_at(0.04), {}, Vector3::Zero());
  const StrapdownIncrement second = history.integrate(time_at(0.04), time_at(0.0123 + T), {}, Vector3::Zero());
  CHECK(so3::angle_between<double>(first.q * second.q, felt.q) < 1e-12);
  CHECK((first.velocity_B + first.q * second.velocity_B - felt.velocity_B).norm() < 1e-6 * T);
  // Past the newest reading the rate goes on as told, for 20 ms.
  const StrapdownIncrement beyond = history.integrate(time_at(0.1), time_at(0.11), {}, Vector3(0, 0, 100.0));
  CHECK(beyond.rate_end_B.z() == doctest::Approx(3.0));
}

TEST_CASE("biases, gravity, time offset and lever arm are found, as surely as the filter says") {
  const InertialUnit unit = unit_with_errors();
  for (const std::string name : {"M5", "M4"}) {
    const auto motion = make_motion(name);
    for (const Duration delay : {0ms, 45ms}) {
      CAPTURE(name);
      CAPTURE(delay.count());
      const InertialFilter filter = followed(*motion, unit, delay);
      const InertialState& found = filter.state();
      const auto sigma = [&](int i) { return std::sqrt(filter.covariance().diagonal().segment<3>(i).maxCoeff()); };
      const auto within = [&](const Vector3& error, int i) { return error.norm() < 5.0 * sigma(i) + 1e-3; };
      MESSAGE(name << ": force bias " << (found.bias.force_B - unit.accelerometer.bias).norm() << " of "
                   << sigma(InertialState::force_bias) << " m/s2, gravity " << (found.gravity_W - unit.gravity_W).norm()
                   << " of " << sigma(InertialState::gravity) << " m/s2, lever "
                   << (found.lever_B - unit.X_BS.p()).norm() << " of " << sigma(InertialState::lever) << " m, offset "
                   << found.time_offset_s << " s");
      CHECK(std::abs(found.time_offset_s - 0.004) < 5e-4);
      CHECK(within(found.bias.rate_B - unit.gyro.bias, InertialState::rate_bias));
      CHECK(within(found.bias.force_B - unit.accelerometer.bias, InertialState::force_bias));
      CHECK(within(found.gravity_W - unit.gravity_W, InertialState::gravity));
      CHECK(within(found.lever_B - unit.X_BS.p(), InertialState::lever));
      CHECK(sigma(InertialState::rate_bias) < 0.005);
      CHECK(sigma(InertialState::gravity) < 0.3);
      // Late poses or not: now is now.
      const MotionState truth = motion->at(filter.now().t);
      CHECK(filter.now().t >= motion->end() - 12ms);
      CHECK(so3::angle_between<double>(filter.now().X_WB().q(), truth.X_WB.q()) < 1.5e-3);
      CHECK((filter.now().X_WB().p() - truth.X_WB.p()).norm() < 1e-3);
      // The noise of the poses, too: 0.2 mm and 0.5 mrad.
      CHECK(filter.pose_noise().position_m == doctest::Approx(2e-4).epsilon(0.4));
      CHECK(filter.pose_noise().orientation_rad == doctest::Approx(5e-4).epsilon(0.4));
    }
  }
}

TEST_CASE("the world may be turned: the filter's errors turn with it") {
  const auto motion = make_motion("M6");
  const InertialUnit unit = unit_with_errors();
  const Rigid X_VW(so3::exp<double>(Vector3(0.4, -1.1, 2.0)), Vector3(3.0, -1.0, 7.0));
  const auto readings = inertial_stream(*motion, unit);
  InertialFilter in_W, in_V;
  for (std::size_t i = 0; i < 1500; ++i) {
    in_W.update(readings[i]);
    in_V.update(readings[i]);
    if (i % 5 != 0) continue;
    const Rigid X = motion->at(readings[i].t).X_WB;
    in_W.update(TimedPose{readings[i].t, X});
    in_V.update(TimedPose{readings[i].t, X_VW * X});
  }
  const Rigid turned = X_VW * in_W.now().X_WB();
  CHECK(so3::angle_between<double>(turned.q(), in_V.now().X_WB().q()) < 1e-6);  // solved for in another order: rounding
  CHECK((turned.p() - in_V.now().X_WB().p()).norm() < 1e-6);
  CHECK((X_VW.q() * in_W.state().gravity_W - in_V.state().gravity_W).norm() < 1e-4);
}

TEST_CASE("bad readings and poses are refused, a wrong pose is rejected, and a jump believed in the end") {
  const auto motion = make_motion("M5");
  InertialFilter filter = followed(*motion, mems_inertial_unit(), 0ms);
  const HostTime t = filter.state().t;
  const Rigid X = filter.state().X_WB();
  const auto measured = [&](Duration later, const Rigid& X_WB) { return filter.update(TimedPose{t + later, X_WB}); };
  const InertialReading without_number{t + 20ms, Vector3(no_number, 0, 0), Vector3::Zero()},
      old{t - 20ms, Vector3::Zero(), Vector3::Zero()};
  CHECK_FALSE(filter.update(without_number));
  CHECK_FALSE(filter.update(old));
  CHECK(measured(0ms, X) == InertialPoseUpdate::refused);
  CHECK(measured(10ms, Rigid::translation(Vector3(0, 0, 1e300))) == InertialPoseUpdate::refused);
  const Rigid wrong = Rigid::translation(Vector3(0.5, 0.0, 0.0)) * X;
  CHECK(measured(10ms, wrong) == InertialPoseUpdate::rejected);
  CHECK((filter.now().X_WB().p() - X.p()).norm() < 0.1);
  const Vector3 bias = filter.state().bias.rate_B;
  CHECK(measured(20ms, wrong) == InertialPoseUpdate::rejected);
  CHECK(measured(30ms, wrong) == InertialPoseUpdate::rejected);
  CHECK(measured(40ms, wrong) == InertialPoseUpdate::started);
  CHECK((filter.now().X_WB().p() - wrong.p()).norm() < 1e-9);
  CHECK(filter.state().bias.rate_B == bias);  // what is known of the sensors stays
  CHECK(filter.state().is_finite());
}
