#include <array>
#include <functional>
#include <limits>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/geometry/numeric_jacobian.hpp>
#include <holdfast/motion/head_motions.hpp>
#include <holdfast/registration/constellation_experiment.hpp>
#include <holdfast/simulation/inertial_faults.hpp>
#include <holdfast/tracking/range_aided_ins.hpp>

#include "allocation_counter.hpp"

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

constexpr double degrees_a_rad = 180.0 / std::numbers::pi;
constexpr double no_number = std::numeric_limits<double>::quiet_NaN();
using S = InertialState;
using Error15 = VectorOf<double, strapdown_error_size>;

ConstellationCase bench_case() {
  ConstellationCase c;
  c.rig = {bench_constellation(), head_receivers()};
  c.unit.X_BS = Rigid::translation(Vector3(0.0, 0.05, -0.08));
  c.errors = table_1_errors();
  return c;
}

/// 20 ms of a head that turns and accelerates.
struct Stretch {
  InertialHistory history{64};
  HostTime begin{}, end{20ms};
  InertialState state;

  Stretch() {
    for (int k = -1; k <= 11; ++k) {
      const double s = 0.1 * k;
      InertialReading reading;
      reading.t = HostTime(2ms * k);
      reading.rate_B = Vector3(0.8 + 0.1 * s, -1.1, 0.5 - 0.2 * s);
      reading.force_B = Vector3(1.0, 9.5 + s, -2.0 + 0.5 * s);
      history.push(reading);
    }
    state.t = begin;
    state.X_WS = Rigid(so3::exp<double>(Vector3(0.3, -0.9, 0.4)), Vector3(0.1, -0.2, 0.3));
    state.v_WS = Vector3(0.4, 0.1, -0.3);
    state.gravity_W = Vector3(0.0, -standard_gravity, 0.0);
    state.bias = {Vector3(0.01, -0.02, 0.015), Vector3(0.1, 0.2, -0.3)};
  }
  [[nodiscard]] StrapdownIncrement step(const InertialState& from) const {
    return history.integrate(begin, end, from.bias, Vector3::Zero());
  }
  [[nodiscard]] InertialState moved(const Error15& d) const {
    InertialState from = state;
    InertialState::Error all = InertialState::Error::Zero();
    all.head<strapdown_error_size>() = d;
    from.add(all);
    from.move(step(from));
    return from;
  }
};

StrapdownCovariance some_covariance(unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<double> normal;
  const StrapdownCovariance root = StrapdownCovariance::NullaryExpr([&] { return normal(random); });
  const StrapdownCovariance P = root * root.transpose();
  return 0.5 * (P + P.transpose());
}

/// Everything that reaches a tracker, in its order.
struct Heard {
  std::vector<InertialReading> readings;
  std::vector<SimulatedRange> ranges;

  Heard(const ConstellationCase& c, const Motion& motion)
      : readings(inertial_stream(motion, c.unit, 1)),
        ranges(ultrasonic_stream(motion, c.rig, UltrasonicDevices(c.rig, c.errors, 1), c.ranging)) {}

  template <typename Tracker>
  void play(Tracker& tracker, HostTime until, const std::function<void()>& after = {}) {
    for (; next_ < readings.size() && readings[next_].t <= until; ++next_) {
      for (; next_range_ < ranges.size() && ranges[next_range_].range.t < readings[next_].t; ++next_range_) {
        tracker.update(ranges[next_range_].range);
      }
      tracker.update(readings[next_]);
      if (after) after();
    }
  }

 private:
  std::size_t next_ = 0, next_range_ = 0;
};

RangeAidedIns started(const ConstellationCase& c, const Motion& motion) {
  RangeAidedIns tracker(c.rig.beacons, c.rig.receivers, detail::settings_for(c));
  tracker.start(detail::acquired_pose(motion, 1), {0.005, degrees(1.0).radians()});
  return tracker;
}

double distance(const RangeAidedIns& tracker, const Motion& motion) {
  return (tracker.pose().X_WB.p() - motion.at(tracker.pose().t).X_WB.p()).norm();
}

}  // namespace

TEST_CASE("the transition of the navigator's error against central differences") {
  const Stretch stretch;
  const InertialState nominal = stretch.moved(Error15::Zero());
  const auto error_after = [&](const Error15& d) {
    const InertialState x = stretch.moved(d);
    Error15 e;
    e << x.X_WS.p() - nominal.X_WS.p(), so3::log<double>(nominal.X_WS.q().conjugate() * x.X_WS.q()),
        x.v_WS - nominal.v_WS, x.bias.rate_B - nominal.bias.rate_B, x.bias.force_B - nominal.bias.force_B;
    return e;
  };
  const StrapdownCovariance numeric = numeric_jacobian(error_after, Error15(Error15::Zero()));
  const StrapdownCovariance analytic = strapdown_transition(stretch.step(stretch.state), stretch.state.X_WS.R());
  // All but the blocks below: what a force that turns within the stretch changes about b_f, dt^2 |w| / 2 of a unit bias,
  // and the trapeze's error about b_w, dt^2 |change of w| / 12 = 7e-6.
  const StrapdownCovariance difference = analytic - numeric;
  CHECK(difference.topLeftCorner<9, 9>().cwiseAbs().maxCoeff() < 1e-7);
  CHECK(difference.bottomRows<6>().cwiseAbs().maxCoeff() < 1e-9);
  CHECK(difference.block<3, 3>(S::turn, S::rate_bias).cwiseAbs().maxCoeff() < 1e-5);
  CHECK(difference.block<3, 3>(S::velocity, S::force_bias).cwiseAbs().maxCoeff() < 4e-4);
  CHECK(difference.block<3, 3>(S::place, S::force_bias).cwiseAbs().maxCoeff() < 4e-6);
  // b_w on velocity: dt^2 |f| / 2 = 2e-3, of which a part dt |w| = 3 % is left out.
  CHECK(difference.block<3, 3>(S::velocity, S::rate_bias).cwiseAbs().maxCoeff() < 1e-4);
  CHECK(difference.block<3, 3>(S::place, S::rate_bias).cwiseAbs().maxCoeff() < 1e-6);
  CHECK(numeric.block<3, 3>(S::velocity, S::rate_bias).cwiseAbs().maxCoeff() > 1e-3);
}

TEST_CASE("the covariance carried block by block is that of the dense form") {
  const Stretch stretch;
  for (unsigned seed = 1; seed <= 5; ++seed) {
    BelievedAxes believed;
    if (seed > 3) believed = {Vector3(1, 0, 1), Vector3(0, 1, seed == 5 ? 0 : 1)};
    StrapdownCovariance P = some_covariance(seed);
    const Matrix3 R = stretch.state.X_WS.R();
    const StrapdownIncrement step = stretch.step(stretch.state);
    const StrapdownCovariance F = strapdown_transition(step, R, believed);
    const StrapdownCovariance dense = F * P * F.transpose();
    carry_covariance(P, step, R, believed);
    CHECK((P - dense).cwiseAbs().maxCoeff() < 1e-12 * dense.cwiseAbs().maxCoeff());  // rounding
    const bool symmetric = P == P.transpose();
    CHECK(symmetric);
  }
}

TEST_CASE("the noise of a stretch is that of its halves") {
  const Stretch stretch;
  StrapdownNoise noise;
  noise.rate = Vector3(1e-3, 2e-3, 3e-3);
  noise.force = Vector3(0.1, 0.2, 0.5);
  noise.rate_walk = noise.force_walk = Vector3::Constant(1e-3);
  const Matrix3 R = stretch.state.X_WS.R();
  StrapdownCovariance whole = StrapdownCovariance::Zero(), halves = whole;
  add_noise(whole, 0.02, R, noise);
  StrapdownIncrement half;  // nothing but time passes
  half.seconds = 0.01;
  add_noise(halves, 0.01, R, noise);
  carry_covariance(halves, half, R, {Vector3::Zero(), Vector3::Zero()});
  add_noise(halves, 0.01, R, noise);
  CHECK((whole - halves).cwiseAbs().maxCoeff() < 1e-17);  // rounding of 1e-3
}

TEST_CASE("each reading's pose goes out at once, and nothing allocates") {
  const auto motion = make_rotation(1, 4s);
  const ConstellationCase c = bench_case();
  Heard heard(c, *motion);
  RangeAidedIns tracker = started(c, *motion);
  heard.play(tracker, motion->begin() + 1s);
  std::size_t next = 501, next_range = 0;
  while (heard.ranges[next_range].range.t < tracker.now().t) ++next_range;
  const std::size_t before = test::allocations();
  for (; next < 1500; ++next) {
    for (; heard.ranges[next_range].range.t < heard.readings[next].t; ++next_range) {
      tracker.update(heard.ranges[next_range].range);
    }
    tracker.update(heard.readings[next]);
    const bool now = tracker.pose().t == heard.readings[next].t;
    const bool finite = tracker.estimate().is_finite() && tracker.status().gyro == SensorFault::none;
    if (!now || !finite) break;
  }
  CHECK(test::allocations() == before);
  CHECK(next == 1500);
  CHECK(test::counts_allocations());
}

TEST_CASE("in a world that is turned and moved, all errors are the same") {
  const auto motion = make_swing(2, 5s);
  const Rigid X_VW(so3::exp<double>(Vector3(0.7, -0.4, 1.9)), Vector3(3.0, -2.0, 1.0));
  const ConstellationCase c = bench_case();
  Heard heard(c, *motion), again(c, *motion);
  RangeAidedInsSettings settings = detail::settings_for(c);
  RangeAidedIns tracker(c.rig.beacons, c.rig.receivers, settings);
  settings.gravity_W = X_VW.q() * settings.gravity_W;
  std::vector<CodedBeacon> beacons = c.rig.beacons;
  for (CodedBeacon& beacon : beacons) beacon.p_W = X_VW * beacon.p_W;
  RangeAidedIns turned(beacons, c.rig.receivers, settings);
  const TimedPose start = detail::acquired_pose(*motion, 1);
  tracker.start(start, {0.005, 0.02});
  turned.start({start.t, X_VW * start.X_WB}, {0.005, 0.02});
  heard.play(tracker, motion->end());
  again.play(turned, motion->end());
  const Rigid difference = turned.pose().X_WB.inverse() * (X_VW * tracker.pose().X_WB);
  CHECK(difference.p().norm() < 1e-9);  // rounding of 750 updates
  CHECK(so3::log<double>(difference.q()).norm() < 1e-9);
  CHECK(turned.status().counts.ranges_accepted == tracker.status().counts.ranges_accepted);
  CHECK(turned.estimate().covariance.trace() == doctest::Approx(tracker.estimate().covariance.trace()).epsilon(1e-6));
}

TEST_CASE("the gate turns echoes away, and widens while ranges are missing") {
  const auto motion = make_walk_around(1, 12s);
  const ConstellationCase c = bench_case();
  Heard heard(c, *motion);
  RangeAidedIns tracker = started(c, *motion);
  heard.play(tracker, motion->begin() + 4s);
  const auto off_by = [&](RangeAidedIns& asked, double metres) {
    const Rigid X_WB = asked.pose().X_WB;
    BeaconRange range{asked.now().t, 4, 0, 0.0};
    range.range_m = (X_WB * c.rig.receivers[0].p_B - c.rig.beacons[4].p_W).norm() + metres;
    return asked.update(range);
  };
  RangeAidedIns asked = tracker;
  CHECK(off_by(asked, 0.002) == RangeUpdate::accepted);
  CHECK(off_by(asked, 0.05) == RangeUpdate::gated);
  CHECK(off_by(asked, -0.05) == RangeUpdate::gated);
  // Four seconds unaided: readings only.
  for (const InertialReading& reading : heard.readings) {
    if (reading.t > tracker.now().t && reading.t < motion->begin() + 8s) tracker.update(reading);
  }
  CHECK(tracker.status().unaided_s > 3.9);
  CHECK(off_by(tracker, 0.05) == RangeUpdate::accepted);
}

TEST_CASE("it coasts for a second without ranges, and comes back") {
  const auto motion = make_walk_around(3, 10s);
  const ConstellationCase c = bench_case();
  Heard heard(c, *motion);
  std::erase_if(heard.ranges, [&](const SimulatedRange& s) {
    return s.range.t > motion->begin() + 5s && s.range.t < motion->begin() + 6s;
  });
  RangeAidedIns tracker = started(c, *motion);
  heard.play(tracker, motion->begin() + 5990ms);
  // Tilt errs by 0.3 deg or so: 5 cm/s^2, 2.5 cm in a second.
  CHECK(distance(tracker, *motion) < 0.05);
  heard.play(tracker, motion->end());
  CHECK(distance(tracker, *motion) < 0.01);
}

TEST_CASE("what is wrong with a unit is named, tracked through, and forgotten") {
  const auto motion = make_rotation(2, 12s);
  const TimeSpan span{motion->begin() + 5s, motion->begin() + 8s};
  static constexpr std::array one_gyro{1}, one_accelerometer{4};
  struct Fault {
    const char* name;
    std::function<void(std::vector<InertialReading>&)> spoil;
    SensorFault gyro, accelerometer;
    double range_of_gyro = 34.9;
  };
  using Readings = std::vector<InertialReading>;
  using enum SensorFault;
  const std::array faults{
      Fault{"dead gyro", [&](Readings& r) { make_dead(r, span, gyro_channels); }, dead, none},
      Fault{"dead accelerometer", [&](Readings& r) { make_dead(r, span, accelerometer_channels); }, none, dead},
      Fault{"stuck gyro", [&](Readings& r) { make_stuck(r, span, gyro_channels); }, stuck, none},
      Fault{"stuck unit", [&](Readings& r) { make_stuck(r, span, inertial_channels); }, stuck, stuck},
      Fault{"stuck axis", [&](Readings& r) { make_stuck(r, span, one_gyro); }, stuck, none},
      Fault{"missing rate", [&](Readings& r) { lose(r, span, one_gyro); }, not_finite, none},
      Fault{"missing force", [&](Readings& r) { lose(r, span, one_accelerometer); }, none, not_finite},
      Fault{"all missing", [&](Readings& r) { lose(r, span, inertial_channels); }, not_finite, not_finite},
      Fault{"saturated",
            [&](Readings& r) {
              saturate(r, {span.begin, span.end}, gyro_channels, 0.3);
            },
            saturated, none, 0.3},
      Fault{"disconnected", [&](Readings& r) { disconnect(r, span); }, disconnected, disconnected},
  };
  for (const Fault& fault : faults) {
    CAPTURE(fault.name);
    ConstellationCase c = bench_case();
    // A range that is met only within the span: the same unit, but for its limits.
    c.spoil = fault.spoil;
    c.settle = 2s;
    c.unit.gyro.range = fault.range_of_gyro;
    if (fault.range_of_gyro < 1.0) c.spoil = [](Readings&) {};  // the simulated unit clips by itself
    bool gyro_named = fault.gyro == none, accelerometer_named = fault.accelerometer == none, wrongly = false;
    const auto row = run_constellation(c, *motion, [&](const ConstellationMoment& moment) {
      const RangeAidedInsStatus status = moment.tracker.status();
      const HostTime t = moment.tracker.now().t;
      gyro_named = gyro_named || (t > span.begin + 100ms && t < span.end && status.gyro == fault.gyro);
      accelerometer_named = accelerometer_named ||
                            (t > span.begin + 100ms && t < span.end && status.accelerometer == fault.accelerometer);
      const bool any = status.gyro != none || status.accelerometer != none;
      const bool outside = t > motion->begin() + 1s && (t < span.begin || t > span.end + 300ms);
      wrongly = wrongly || (any && outside && fault.range_of_gyro > 1.0);
    });
    CHECK(gyro_named);
    CHECK(accelerometer_named);
    CHECK_FALSE(wrongly);
    CHECK(row.finite);
    CHECK_FALSE(row.lost);
    CHECK(row.position.peak() < 0.06);
    CHECK(degrees_a_rad * row.angle.peak() < 15.0);
  }
}

TEST_CASE("an accelerometer in units of g, or gravity the wrong way: named, and the gyro goes on") {
  const auto motion = make_walk_around(2, 8s);
  for (const double factor : {1.0 / standard_gravity, -1.0}) {
    CAPTURE(factor);
    ConstellationCase c = bench_case();
    c.spoil = [&](std::vector<InertialReading>& readings) {
      for (InertialReading& reading : readings) reading.force_B *= factor;
    };
    bool named = true;
    const auto row = run_constellation(c, *motion, [&](const ConstellationMoment& moment) {
      if (moment.tracker.now().t < motion->begin() + 1s) return;
      named = named && moment.tracker.status().accelerometer == SensorFault::wrong_gravity &&
              moment.tracker.status().gyro == SensorFault::none;
    });
    CHECK(named);
    CHECK(row.finite);
    CHECK(row.position.peak() < 0.06);
    CHECK(degrees_a_rad * row.angle.peak() < 3.0);
  }
}

TEST_CASE("clocks that jump: named, refused, and lived with") {
  const auto motion = make_walk_around(1, 10s);
  for (const auto by : {-1000ms, 3000ms}) {
    CAPTURE(by.count());
    ConstellationCase c = bench_case();
    c.clock_jump = {motion->begin() + 4s, by};
    bool named = false;
    const auto row = run_constellation(c, *motion, [&](const ConstellationMoment& moment) {
      const RangeAidedInsStatus status = moment.tracker.status();
      named = named || (status.gyro == (by < 0ms ? SensorFault::time_backwards : SensorFault::disconnected) &&
                        status.counts.readings_refused > 0);
    });
    CHECK(named);
    CHECK(row.finite);
    CHECK_FALSE(row.lost);
    CHECK(row.position.peak() < 0.06);
  }

  // Both clocks together: after a hundred refusals time goes on from there.
  const ConstellationCase c = bench_case();
  for (const auto by : {-60s, 60s}) {
    const Heard heard(c, *motion);
    const auto told = [&](HostTime t) { return t > motion->begin() + 4s ? t + by : t; };
    RangeAidedIns tracker = started(c, *motion);
    std::size_t next = 0;
    for (InertialReading reading : heard.readings) {
      for (; next < heard.ranges.size() && heard.ranges[next].range.t < reading.t; ++next) {
        BeaconRange range = heard.ranges[next].range;
        range.t = told(range.t);
        tracker.update(range);
      }
      reading.t = told(reading.t);
      tracker.update(reading);
    }
    CHECK(tracker.now().t == heard.readings.back().t + by);
    CHECK((tracker.pose().X_WB.p() - motion->at(tracker.now().t - by).X_WB.p()).norm() < 0.01);
  }
}

TEST_CASE("bad input is refused, and the state stays") {
  const auto motion = make_walk_around(1, 3s);
  const ConstellationCase c = bench_case();
  Heard heard(c, *motion);
  RangeAidedIns tracker(c.rig.beacons, c.rig.receivers, detail::settings_for(c));
  CHECK(tracker.update(BeaconRange{motion->begin(), 0, 0, 1.5}) == RangeUpdate::refused);
  CHECK_FALSE(tracker.is_started());
  tracker = started(c, *motion);
  heard.play(tracker, motion->begin() + 2s);
  const HostTime t = tracker.now().t;
  const Rigid X = tracker.pose().X_WB;
  const StrapdownCovariance P = tracker.covariance();
  for (const BeaconRange& range :
       {BeaconRange{t, 0, 0, no_number}, BeaconRange{t, 0, 0, -1.0}, BeaconRange{t, 0, 0, 0.0},
        BeaconRange{t, 0, 0, std::numeric_limits<double>::infinity()}, BeaconRange{t, 8, 0, 1.5},
        BeaconRange{t, -1, 0, 1.5}, BeaconRange{t, 0, 3, 1.5}, BeaconRange{t - 1s, 0, 0, 1.5},
        BeaconRange{HostTime::max(), 0, 0, 1.5}, BeaconRange{HostTime::min(), 0, 0, 1.5}}) {
    CHECK(tracker.update(range) == RangeUpdate::refused);
  }
  for (const HostTime wrong : {t, t - 5ms, HostTime::min(), HostTime::max()}) {
    InertialReading reading = heard.readings.front();
    reading.t = wrong;
    CHECK_FALSE(tracker.update(reading));
  }
  CHECK(tracker.pose().X_WB.p() == X.p());
  const bool stays = tracker.covariance() == P;
  CHECK(stays);
  CHECK(tracker.status().counts.readings_refused == 4);
  // 10 here: that before the start went with the tracker it was told to.
  CHECK(tracker.status().counts.ranges_refused == 10);
}
