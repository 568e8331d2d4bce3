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

TEST_CASE("a fading polynomial follows a parabola") {
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

TEST_CASE("the error's transition is the state's, by central differences: also for the time offset") {
  using S = InertialState;
  std::mt19937 random(7);
  InertialHistory history(256);
  for (int i = 0; i < 200; ++i) {
    const double t = 0.001 * i;
    const Vector3 rate(2.0 + std::sin(20.0 * t), -1.5, 3.0 * std::cos(15.0 * t));
    const Vector3 force(2.0 + 5.0 * std::sin(25.0 * t), 9.0 - 20.0 * t, 30.0 * t);
    history.push({time_at(t), rate, force});
  }
  S begin;
  begin.t = time_at(0.05);
  begin.X_WS = Rigid(so3::exp<double>(Vector3(0.3, -0.8, 1.2)), Vector3(1.0, 2.0, 3.0));
  begin.v_WS = Vector3(0.5, -0.2, 0.1);
  begin.gravity_W = Vector3(0.0, -9.8, 0.0);
  constexpr double dt = 0.03;
  const auto felt = [&](const S& state) {
    const Duration offset = from_seconds(state.time_offset_s);
    return history.integrate(state.t + offset, state.t + from_seconds(dt) + offset, state.bias, Vector3::Zero());
  };
  const auto moved = [&](const S::Error& d) {
    S state = begin;
    state.add(d);
    state.move(felt(state));
    return state;
  };
  const S::Covariance F = error_transition(felt(begin), begin.X_WS.R());
  for (int k = 0; k < S::lever; ++k) {
    constexpr double h = 1e-4;
    S::Error d = S::Error::Zero();
    d[k] = h;
    const S more = moved(d), less = moved(-d);
    VectorOf<double, 9> change;
    change << more.X_WS.p() - less.X_WS.p(), so3::log<double>(less.X_WS.q().conjugate() * more.X_WS.q()),
        more.v_WS - less.v_WS;
    change /= 2.0 * h;
    CAPTURE(k);
    const bool is_bias = k >= S::rate_bias && k < S::gravity;
    for (const int part : {S::place, S::turn, S::velocity}) {
      const Vector3 truth = change.segment<3>(part), ours = F.block<3, 1>(part, k);
      // A bias turns with the body, which F takes into account to first order at most: w dt = 0.1. Its second-order part,
      // of the place and velocity by the rate's bias, is left out: |f| dt^2 / 2 and more.
      if (is_bias && part != S::turn && k < S::force_bias) {
        CHECK((ours - truth).norm() < 15.0 * dt * dt);
      } else {
        CHECK((ours - truth).norm() < (is_bias ? 0.1 : 2e-3) * truth.norm() + 1e-6);
      }
    }
  }
}

TEST_CASE("without the accelerometer nothing pushes the body, and nothing is learnt of what is not there") {
  const auto motion = make_motion("M5");
  const InertialUnit unit = unit_with_errors();
  const HostTime lost = motion->begin() + 5s;
  InertialFilter filter;
  InertialState before;
  double variance = 0.0, worst = 0.0;
  for (const InertialReading& reading : inertial_stream(*motion, unit)) {
    if (reading.t >= lost) filter.use_force(false);
    filter.update(reading);
    if (reading.t.time_since_epoch() % 10ms != 0ms) continue;
    if (reading.t < lost) {
      before = filter.state();
      variance = filter.covariance().diagonal().segment<3>(InertialState::force_bias).sum();
    }
    filter.update(TimedPose{reading.t - 10ms, motion->at(reading.t - 10ms).X_WB});
    if (reading.t >= lost)
      worst = std::max(worst, (filter.now().X_WB().p() - motion->at(reading.t - 4ms).X_WB.p()).norm());
  }
  CHECK(filter.covariance().diagonal().segment<3>(InertialState::force_bias).sum() > 0.9 * variance);
  CHECK((filter.state().bias.force_B - before.bias.force_B).norm() < 0.02);
  CHECK((filter.state().gravity_W - before.gravity_W).norm() < 0.02);
  MESSAGE("worst place " << 1e3 * worst << " mm");
  CHECK(worst < 2e-3);
}

TEST_CASE("gravity is taken from the first reading, when the first pose came before") {
  InertialFilter filter;
  filter.update(TimedPose{time_at(1.0), Rigid()});
  const Vector3 up(0.0, 0.0, standard_gravity);
  CHECK(filter.update(InertialReading{time_at(1.001), Vector3::Zero(), up}));
  CHECK((filter.state().gravity_W + up).norm() < 1e-12);
  filter.forget_force();  // was in another unit
  CHECK(filter.update(InertialReading{time_at(1.002), Vector3::Zero(), 2.0 * up}));
  CHECK((filter.state().gravity_W + 2.0 * up).norm() < 1e-12);
  // The first force may come later still.
  InertialFilter late;
  late.update(TimedPose{time_at(1.0), Rigid()});
  CHECK(late.update(InertialReading{time_at(1.001), Vector3::Zero(), Vector3::Constant(no_number)}));
  CHECK(late.update(TimedPose{time_at(1.01), Rigid()}) == InertialPoseUpdate::updated);
  CHECK(late.now().v_WS.norm() < 1e-9);
  CHECK(late.update(InertialReading{time_at(1.012), Vector3::Zero(), up}));
  CHECK((late.state().gravity_W + up).norm() < 1e-12);
}

TEST_CASE("what no head does, and times beyond a century, leave the filter as it was") {
  InertialFilter filter;
  const Vector3 up(0.0, 9.8, 0.0), none = Vector3::Zero();
  filter.update(InertialReading{time_at(0.0), none, up});
  filter.update(TimedPose{time_at(0.0), Rigid()});
  CHECK_FALSE(filter.update(InertialReading{time_at(0.01), Vector3(1e200, 0.0, 0.0), up}));
  CHECK_FALSE(filter.update(InertialReading{HostTime::max(), none, up}));
  CHECK_FALSE(filter.update(InertialReading{HostTime::min(), none, up}));
  CHECK(filter.update(InertialReading{time_at(0.02), none, Vector3(0.0, -1e200, 0.0)}));  // as if without the force
  CHECK(filter.update(TimedPose{HostTime::max(), Rigid()}) == InertialPoseUpdate::refused);
  CHECK(filter.update(TimedPose{HostTime::min(), Rigid()}) == InertialPoseUpdate::refused);
  CHECK(filter.update(TimedPose{time_at(0.02), Rigid()}) == InertialPoseUpdate::updated);
  CHECK(filter.now().X_WB().p().norm() < 1e-6);
  // A single pose far off says nothing of the poses' noise.
  const double noise = filter.pose_noise().position_m;
  CHECK(filter.update(TimedPose{time_at(0.03), Rigid::translation(Vector3(5.0, 0.0, 0.0))}) ==
        InertialPoseUpdate::rejected);
  CHECK(filter.pose_noise().position_m == noise);
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

TEST_CASE("a pose of the far future is left again: ten older ones in a row are a clock that was set back") {
  InertialFilter filter;
  const auto pose = [](double t) { return TimedPose{time_at(t), Rigid::translation(Vector3(t, 0.0, 0.0))}; };
  for (int i = 0; i < 20; ++i) filter.update(pose(0.01 * i));
  CHECK(filter.update(pose(1e6)) == InertialPoseUpdate::started);
  for (int i = 20; i < 29; ++i) CHECK(filter.update(pose(0.01 * i)) == InertialPoseUpdate::refused);
  CHECK(filter.update(pose(0.29)) == InertialPoseUpdate::started);
  CHECK(filter.update(pose(0.30)) == InertialPoseUpdate::updated);
  CHECK(filter.state().t == time_at(0.30));
}

TEST_CASE("innovations: noise is what is not explained; going on alike they ask for more of the state's own") {
  std::mt19937 random(6);
  NoiseEstimate noise(1.0, 0.1);
  for (int i = 0; i < 2000; ++i) noise.add(random_vector<3>(random, 0.5), 0.16);
  // 0.25 - 0.16 of variance; the last hundred of three numbers each tell it to some 6 % of 0.25.
  CHECK(noise.found() == doctest::Approx(0.3).epsilon(0.15));
  InnovationBalance alike, alternating;
  for (int i = 0; i < 2000; ++i) {
    const Vector3 e = random_vector<3>(random, 2.0);
    alike.add(e.cwiseAbs(), 4.0);
    alternating.add((i % 2 == 0 ? 1.0 : -1.0) * e.cwiseAbs(), 4.0);
  }
  CHECK(alike.scale() == 4.0);
  CHECK(alternating.scale() == 0.3);
}
