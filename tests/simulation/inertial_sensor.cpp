#include <algorithm>
#include <cmath>
#include <random>

#include <doctest/doctest.h>

#include <holdfast/motion/head_motions.hpp>
#include <holdfast/simulation/inertial_faults.hpp>
#include <holdfast/simulation/inertial_sensor.hpp>
#include <holdfast/tracking/linear_acceleration.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

/// A head that tumbles: all six numbers move, and `place_B` is added to the position by formula, not by mechanics.
HeadCurve tumble(const Jet& t, const Vector3& place_B) {
  HeadCurve curve;
  curve.yaw = 1.1 * sin(2.3 * t);
  curve.pitch = 0.7 * sin(3.1 * t + 0.4);
  curve.roll = 0.9 * sin(1.7 * t + 1.0);
  curve.x = 0.4 * sin(2.0 * t);
  curve.y = 0.2 * sin(3.3 * t + 0.2);
  curve.z = 0.3 * sin(1.1 * t + 2.0);
  detail::add_rotated(curve, place_B);
  return curve;
}

CurveMotion tumbling(const Vector3& place_B = Vector3::Zero()) {
  return CurveMotion(10s, [place_B](const Jet& t) { return tumble(t, place_B); });
}

/// A unit that sits askew, without errors.
InertialUnit askew_unit() {
  InertialUnit unit;
  unit.X_BS = Rigid(so3::exp<double>(Vector3(0.3, -0.8, 0.5)), Vector3(0.06, 0.11, -0.04));
  unit.accelerometers_S = {Vector3(0.05, 0.01, -0.02), Vector3(-0.03, 0.04, 0.01), Vector3(0.02, -0.06, 0.03)};
  unit.gravity_W = Vector3(0.3, -9.7, 0.2);
  return unit;
}

struct Moments {
  double mean, deviation;
};

Moments moments(const std::vector<double>& x) {
  const auto n = static_cast<double>(x.size());
  double sum = 0.0, squares = 0.0;
  for (const double v : x) sum += v;
  for (const double v : x) squares += (v - sum / n) * (v - sum / n);
  return {sum / n, std::sqrt(squares / n)};
}

}  // namespace

// 001 appendix A: "by not using the equations of motion in step 3 to generate the simulated data, we avoid incestual
// problems". The accelerometers' places are differentiated as formulas of time.
TEST_CASE("separate accelerometers: what they feel is the acceleration of their places, less gravity") {
  const InertialUnit unit = askew_unit();
  const CurveMotion body = tumbling();
  double worst = 0.0, turning = 0.0;
  for (std::size_t i = 0; i < 3; ++i) {
    const CurveMotion place = tumbling(unit.X_BS * unit.accelerometers_S[i]);
    for (double t = 0.0; t < 10.0; t += 0.0731) {
      const MotionState at_place = place.at(time_at(t));
      const Vector3 force_W = at_place.a_WB - unit.gravity_W;
      const Vector3 force_S = unit.X_BS.q().conjugate() * (at_place.X_WB.q().conjugate() * force_W);
      const int axis = static_cast<int>(i);
      const MotionState state = body.at(time_at(t));
      worst = std::max(worst, std::abs(ideal_inertial_reading(state, unit).force_B[axis] - force_S[axis]));
      turning = std::max(turning, (at_place.a_WB - state.a_WB).norm());
    }
  }
  CHECK(worst < 1e-12);  // rounding of numbers of 10
  CHECK(turning > 1.0);  // the places matter
}

TEST_CASE("001 appendix A: the acceleration of the origin comes back from three separate accelerometers, and a triad") {
  const CurveMotion body = tumbling();
  const InertialUnit separate = askew_unit();
  InertialUnit triad = separate;
  triad.accelerometers_S.fill(Vector3::Zero());
  const SeparateAccelerometers sensors = accelerometers_on_body(separate.X_BS, separate.accelerometers_S);
  const SeparateAccelerometers together = accelerometers_on_body(triad.X_BS, triad.accelerometers_S);
  double apart_error = 0.0, triad_error = 0.0, disagreement = 0.0, without_turning = 0.0;
  for (double t = 0.0; t < 10.0; t += 0.0137) {
    const MotionState truth = body.at(time_at(t));
    const TurningState turning = turning_state(truth);
    const Vector3 apart = ideal_inertial_reading(truth, separate).force_B;
    const Vector3 said = ideal_inertial_reading(truth, triad).force_B;
    const Vector3 a = linear_acceleration(sensors, apart, turning, separate.gravity_W);
    const Vector3 b = linear_acceleration(triad.X_BS, said, turning, triad.gravity_W);
    apart_error = std::max(apart_error, (a - truth.a_WB).norm());
    triad_error = std::max(triad_error, (b - truth.a_WB).norm());
    disagreement = std::max(disagreement, (linear_acceleration(together, said, turning, triad.gravity_W) - b).norm());
    const Vector3 c = linear_acceleration(sensors, apart, {turning.q_WB, {0, 0, 0}, {0, 0, 0}}, separate.gravity_W);
    without_turning = std::max(without_turning, (c - truth.a_WB).norm());
  }
  CHECK(apart_error < 1e-9);  // the bound; rounding is 1e-14
  CHECK(triad_error < 1e-9);
  CHECK(disagreement < 1e-12);
  CHECK(without_turning > 1.0);  // step 3 is not idle here
}

TEST_CASE("at rest a unit feels its support, whichever way it lies, and no turning") {
  const auto still = make_still(1s);
  InertialUnit unit = askew_unit();
  unit.gravity_W = Vector3(0.0, -9.80665, 0.0);
  const InertialReading reading = ideal_inertial_reading(still->at(time_at(0.5)), unit);
  CHECK((unit.X_BS.q() * reading.force_B - Vector3(0.0, 9.80665, 0.0)).norm() < 1e-14);
  CHECK(reading.rate_B.norm() == 0.0);
}

TEST_CASE(
    "noise and bias walk have the stated deviations; same seed same readings; noise keeps when parameters change") {
  const auto still = make_still(40s);
  InertialUnit unit;
  unit.gyro.noise_density = 0.001;
  unit.accelerometer.noise_density = 0.02;
  unit.gyro.bias = Vector3(0.1, -0.2, 0.3);
  const std::vector<InertialReading> readings = inertial_stream(*still, unit, 5);
  CHECK(readings.size() == 20001);  // 40 s of 500 Hz, and the first
  std::array<std::vector<double>, 6> numbers;
  for (const InertialReading& r : readings) {
    for (std::size_t k = 0; k < 3; ++k) {
      numbers[k].push_back(r.rate_B[static_cast<int>(k)]);
      numbers[k + 3].push_back(r.force_B[static_cast<int>(k)]);
    }
  }
  for (std::size_t k = 0; k < 6; ++k) {
    const double expected = (k < 3 ? 0.001 : 0.02) * std::sqrt(500.0);
    const double mean = k < 3 ? unit.gyro.bias[static_cast<int>(k)] : (k == 4 ? standard_gravity : 0.0);
    const Moments m = moments(numbers[k]);
    CHECK(std::abs(m.mean - mean) < 4.5 * expected / std::sqrt(20001.0));          // of a mean of so many
    CHECK(std::abs(m.deviation / expected - 1.0) < 4.5 / std::sqrt(2 * 20001.0));  // of their deviation
  }
  InertialUnit biased = unit;
  biased.gyro.bias += Vector3(1.0, 1.0, 1.0);
  const std::vector<InertialReading> again = inertial_stream(*still, biased, 5),
                                     other = inertial_stream(*still, unit, 6);
  CHECK((again[777].rate_B - readings[777].rate_B - Vector3(1.0, 1.0, 1.0)).norm() < 1e-12);
  CHECK(again[777].force_B == readings[777].force_B);
  CHECK(other[777].rate_B != readings[777].rate_B);

  // The walk: over 200 seeds the bias after 4 s has gained 0.01 sqrt(4).
  const auto short_still = make_still(4s);
  unit.gyro = InertialTriad();
  unit.gyro.bias_walk = 0.01;
  unit.interval = 20ms;
  std::vector<double> gained;
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    InertialSimulator simulator(*short_still, unit, seed);
    Vector3 last;
    while (!simulator.is_done()) last = simulator.next().rate_B;
    CHECK((last - simulator.unit().gyro.bias).norm() < 1e-15);
    gained.insert(gained.end(), last.data(), last.data() + 3);
  }
  CHECK(std::abs(moments(gained).deviation / 0.02 - 1.0) < 4.5 / std::sqrt(2 * 600.0));
}

TEST_CASE("scale, misalignment, range, steps and lag do what they say") {
  const CurveMotion body = tumbling();
  InertialUnit unit;
  unit.gyro.scale = Vector3(1.02, 0.98, 1.0);
  unit.gyro.axes.row(0) = Vector3(1.0, 0.03, 0.0).normalized().transpose();
  const MotionState state = body.at(time_at(1.0));
  const InertialReading reading = ideal_inertial_reading(state, unit);
  CHECK(reading.rate_B[0] ==
        doctest::Approx(1.02 * (state.w_WB_B.x() + 0.03 * state.w_WB_B.y()) / std::hypot(1.0, 0.03)).epsilon(1e-14));
  CHECK(reading.rate_B[1] == doctest::Approx(0.98 * state.w_WB_B.y()).epsilon(1e-14));

  unit.gyro.range = 1.5;
  unit.gyro.resolution = 0.01;
  unit.lag = 4ms;
  const std::vector<InertialReading> readings = inertial_stream(body, unit);
  CHECK(readings.front().t == body.begin() + 4ms);
  std::size_t limited = 0;
  for (const InertialReading& r : readings) {
    const MotionState then = body.at(r.t - 4ms);
    const double exact = std::clamp(0.98 * then.w_WB_B.y(), -1.5, 1.5);
    CHECK(std::abs(r.rate_B.y() - exact) < 0.005 + 1e-12);        // half a step
    CHECK(std::abs(std::remainder(r.rate_B.y(), 0.01)) < 1e-12);  // whole steps only
    limited += std::abs(r.rate_B.y()) > 1.5 - 1e-12 ? 1 : 0;
  }
  CHECK(limited > 10);
}

TEST_CASE("the two named units lie within what they say, and their converters have the stated steps") {
  const auto walk = make_walk_around(1, 2s);
  for (const InertialUnit& unit : {mems_inertial_unit(), azuma_bishop_inertial_unit()}) {
    for (const InertialReading& r : inertial_stream(*walk, unit)) {
      CHECK(r.has_rate());
      CHECK(r.has_force());
      CHECK(r.force_B.norm() < 2.0 * standard_gravity);
      CHECK(std::abs(std::remainder(r.rate_B.x(), unit.gyro.resolution)) < 1e-12);
    }
  }
}

TEST_CASE("faults: disconnected, dead, stuck, lost, saturated, clock jumped; and nothing outside the span") {
  const CurveMotion body = tumbling();
  const std::vector<InertialReading> clean = inertial_stream(body, InertialUnit());
  const TimeSpan span{time_at(2.0), time_at(3.0)};
  std::vector<InertialReading> readings = clean;
  disconnect(readings, span);
  CHECK(readings.size() == clean.size() - 500);

  readings = clean;
  const std::array<int, 1> yaw{1}, up{4}, roll{2};
  make_dead(readings, span, yaw);
  make_stuck(readings, span, accelerometer_channels);
  lose(readings, span, roll);
  saturate(readings, {time_at(4.0), time_at(5.0)}, up, 9.0);
  for (std::size_t k = 0; k < clean.size(); ++k) {
    const InertialReading &r = readings[k], &was = clean[k];
    CHECK(r.rate_B.x() == was.rate_B.x());
    if (span.contains(was.t)) {
      CHECK(r.rate_B.y() == 0.0);
      CHECK(std::isnan(r.rate_B.z()));
      CHECK(r.force_B == clean[999].force_B);  // the last before 2 s
      CHECK_FALSE(r.has_rate());
    } else {
      CHECK(r.rate_B == was.rate_B);
      CHECK(r.force_B.x() == was.force_B.x());
      CHECK((r.force_B.y() == was.force_B.y()) != (r.force_B.y() == 9.0 && was.force_B.y() > 9.0));
    }
  }
  jump_clock(readings, time_at(6.0), -3s);
  CHECK(readings[2999].t == clean[2999].t);
  CHECK(readings[3000].t == clean[3000].t - 3s);
}

TEST_CASE("the page's example") {
  const auto walking = make_walk_around(1, std::chrono::seconds(10));

  InertialUnit unit = mems_inertial_unit();                   // like those in today's headsets, 500 Hz
  unit.X_BS = Rigid::translation(Vector3(0.0, 0.08, -0.05));  // where it sits on the head
  unit.lag = std::chrono::milliseconds(4);                    // readings are stamped that much too late
  std::vector<InertialReading> readings = inertial_stream(*walking, unit);

  make_stuck(readings, {time_at(4.0), time_at(6.0)}, accelerometer_channels);

  CHECK(readings.size() == 5001);
  CHECK(readings[2100].force_B == readings[2200].force_B);
  CHECK(readings[2100].rate_B != readings[2200].rate_B);
}
