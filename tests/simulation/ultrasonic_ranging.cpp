#include <array>
#include <cmath>
#include <set>

#include <doctest/doctest.h>

#include <holdfast/motion/head_motions.hpp>
#include <holdfast/simulation/ultrasonic_ranging.hpp>

using namespace holdfast;
using namespace std::chrono_literals;

namespace {

const ConstellationRig bench{bench_constellation(), head_receivers()};

}  // namespace

TEST_CASE("sound is faster in warm air") {
  CHECK(speed_of_sound(0.0) == 331.4);
  CHECK(speed_of_sound(20.0) == doctest::Approx(343.3).epsilon(1e-3));  // tables: 343.2 m/s
  // 0.17 % a degree: half of 1 / 293 K.
  CHECK(speed_of_sound(21.0) / speed_of_sound(20.0) - 1.0 == doctest::Approx(0.5 / 293.15).epsilon(0.01));
  CHECK(speed_of_sound(-300.0) == 0.0);
}

TEST_CASE("a transducer reaches less far to its side, and nothing behind it") {
  const auto reaches = [](double distance, double degrees_off) {
    const double a = degrees(degrees_off).radians();
    const Vector3 receiver(distance * std::sin(a), -distance * std::cos(a), 0.0);
    return TransducerPair(Vector3::Zero(), -Vector3::UnitY(), receiver, Vector3::UnitY()).in_reach();
  };
  CHECK(reaches(4.99, 0.0));
  CHECK_FALSE(reaches(5.01, 0.0));
  CHECK(reaches(2.49, 60.0));  // both are 60 degrees off: 5 m sqrt(1/2 1/2)
  CHECK_FALSE(reaches(2.51, 60.0));
  CHECK_FALSE(reaches(0.1, 100.0));
  CHECK(TransducerPair(Vector3::Zero(), Vector3::Zero(), Vector3(0, 4.9, 0), Vector3::Zero()).in_reach());
}

TEST_CASE("table 1's errors stay in their intervals, and fill them") {
  ConstellationRig rig{infinite_constellation(), head_receivers()};
  const UltrasonicDevices devices(rig, table_1_errors(), 3);
  Vector3 largest = Vector3::Zero();
  double longest_delay = 0.0;
  for (std::size_t i = 0; i < rig.beacons.size(); ++i) {
    largest = largest.cwiseMax((devices.beacons_W[i] - rig.beacons[i].p_W).cwiseAbs());
    longest_delay = std::max(longest_delay, std::abs(devices.beacon_delays_m[i]));
  }
  CHECK((largest.array() <= Vector3(2e-3, 4e-3, 2e-3).array()).all());
  // The largest of 289 uniform numbers is below 95 % of the end once in 3 million.
  CHECK((largest.array() > 0.95 * Vector3(2e-3, 4e-3, 2e-3).array()).all());
  CHECK(longest_delay <= 1e-3);
  CHECK(longest_delay > 0.95e-3);

  // At 60 degrees off the receiver's axis: 2.5 mm; 0.2 degrees Celsius: 0.034 % of the range.
  ConstellationRig one{{CodedBeacon{}}, {RangeReceiver{}}};
  UltrasonicErrors errors = table_1_errors();
  errors.beacon_delay_m = errors.receiver_delay_m = 0.0;
  const UltrasonicDevices exact(one, errors);
  TransducerPair pair(Vector3::Zero(), Vector3::Zero(), Vector3(0, -2.0, 0), Vector3::Zero());
  pair.cos_receiver = 0.5;
  CHECK(exact.measured_m(pair, 0, 0) == doctest::Approx(2.0 * (1.0 - 0.5 * 0.2 / 293.15) + 2.5e-3).epsilon(1e-6));
}

TEST_CASE("a range is that to where the receiver is when it hears the pulse") {
  const auto motion = make_swing(1, 5s);
  RangingOptions options;
  options.noise_per_m = 0.0;
  const auto heard = ultrasonic_stream(*motion, bench, UltrasonicDevices(bench, UltrasonicErrors{}), options);
  REQUIRE(heard.size() > 600);
  HostTime last = motion->begin();
  for (const SimulatedRange& s : heard) {
    const auto& r = bench.receivers[static_cast<std::size_t>(s.range.receiver)];
    const double distance = (motion->at(s.range.t).X_WB * r.p_B - bench.beacons[s.range.beacon].p_W).norm();
    // The head moves by 1 um between the time of the last round of iteration, and its stamp of whole nanoseconds.
    CHECK(std::abs(s.range.range_m - distance) < 1e-8);
    CHECK(s.range.t >= last);
    last = s.range.t;
    // One beacon at a time: the flight began at a multiple of the interval.
    const double shot = to_seconds(s.range.t - motion->begin()) - distance / speed_of_sound(20.0);
    CHECK(std::abs(shot / 0.02 - std::round(shot / 0.02)) < 1e-5);
  }
}

TEST_CASE("beacons take turns") {
  const auto motion = make_walk_around(1, 2s);
  UltrasonicSimulator simulator(*motion, bench, UltrasonicDevices(bench, UltrasonicErrors{}));
  for (int round = 0; round < 3; ++round) {
    std::set<int> fired;
    for (int k = 0; k < 8; ++k) {
      std::vector<SimulatedRange> heard;
      simulator.fire(heard);
      REQUIRE(heard.size() == 3);
      fired.insert(heard[0].range.beacon);
      CHECK(heard[0].range.beacon == heard[2].range.beacon);
    }
    CHECK(fired.size() == 8);
  }
}

TEST_CASE("faults hit as many ranges as they should, and leave the others alone") {
  const auto motion = make_walk_around(1, 20s);
  const UltrasonicDevices devices(bench, table_1_errors());
  RangingOptions options;
  const auto good = ultrasonic_stream(*motion, bench, devices, options);
  options.faults = {0.1, 0.1, 0.1};
  const auto bad = ultrasonic_stream(*motion, bench, devices, options);
  int echoes = 0, early = 0;
  const auto key = [](const SimulatedRange& s) { return std::pair(s.range.t, s.range.receiver); };
  std::set<std::pair<HostTime, int>> same;
  for (const SimulatedRange& s : good) same.insert(key(s));
  std::size_t unchanged = 0;
  for (const SimulatedRange& s : bad) {
    echoes += s.fault == RangingFault::echo;
    early += s.fault == RangingFault::early;
    if (s.fault == RangingFault::none) unchanged += same.count(key(s));
  }
  const double n = static_cast<double>(good.size());
  // Binomial: standard deviation 0.0055 of 3000.
  CHECK(std::abs(echoes / n - 0.1) < 0.02);
  CHECK(std::abs(early / n - 0.1) < 0.02);
  CHECK(std::abs((n - static_cast<double>(bad.size())) / n - 0.1) < 0.02);
  CHECK(unchanged == bad.size() - static_cast<std::size_t>(echoes + early));
}
