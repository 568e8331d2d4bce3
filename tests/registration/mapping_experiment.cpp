// Auto-mapping: new beacons from a seed of three, as exact as the mapper says; and what it refuses.
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/registration/mapping_experiment.hpp>

using namespace holdfast;

namespace {

/// Two of a head's receivers hear each of n beacons from places on a walk.
BeaconCandidate heard_on_a_walk(const Vector3& beacon_W, int n, double height_step, int wrong) {
  BeaconCandidate candidate(7);
  for (int i = 0; i < n; ++i) {
    CandidateRange r;
    r.p_W = Vector3(std::cos(0.3 * i), 1.5 + height_step * (i % 5), std::sin(0.3 * i));
    r.P = 1e-8 * Matrix3::Identity();
    r.axis_W = Vector3::UnitY();
    r.variance = 1e-6;
    r.range_m = (beacon_W - r.p_W).norm() + (i % 7 == 3 && wrong-- > 0 ? 0.4 : 0.0);
    candidate.add(r, {});
  }
  return candidate;
}

}  // namespace

TEST_CASE("beacon candidate: exact on exact ranges, on the side to which receivers point, echoes left out") {
  const Vector3 beacon_W(0.4, 2.7, -0.9);
  for (const double height_step : {0.1, 0.0}) {  // without, all places are in one plane
    const auto placed = heard_on_a_walk(beacon_W, 40, height_step, 0).place({});
    REQUIRE(placed);
    CHECK((placed->p_W - beacon_W).norm() < 1e-8);  // steps of 1e-10 end the least squares
  }
  const auto with_echoes = heard_on_a_walk(beacon_W, 40, 0.1, 4).place({});
  REQUIRE(with_echoes);
  CHECK((with_echoes->p_W - beacon_W).norm() < 1e-8);
  CHECK_FALSE(heard_on_a_walk(beacon_W, 19, 0.1, 0).place({}));
  // All from one line: a circle of places is as good.
  BeaconCandidate on_a_line(1);
  for (int i = 0; i < 40; ++i) {
    CandidateRange r{0, Vector3(0.1 * i, 1.5, 0.0), 1e-8 * Matrix3::Identity(), Vector3::UnitY(), 1.0, 1e-6};
    r.range_m = (beacon_W - r.p_W).norm();
    CHECK(on_a_line.add(r, {}));
    CHECK_FALSE(on_a_line.add(r, {}));  // it has not moved
  }
  CHECK_FALSE(on_a_line.place({}));
}

TEST_CASE("beacon mapping: new beacons end within 5 mm, and the covariance says how well") {
  ConsistencyMean nees(3);
  for (const std::uint64_t seed : {1, 2, 3}) {
    MappingCase room = MappingCase::random(5, seed);
    room.duration = std::chrono::seconds(60);
    if (seed == 2) {  // table 1's, uncompensated
      room.errors = table_1_errors();
      room.errors.beacon_horizontal_m = room.errors.beacon_vertical_m = 0.0;
    }
    if (seed == 3) room.ranging.faults = {0.1, 0.1, 0.1};
    const MappingRow row = map_beacons(room);
    MESSAGE("seed ", seed, ": mean ", row.mean_mm, " mm, worst ", row.worst_mm, " mm, NEES ", row.nees, ", position ",
            row.position_mm, " mm");
    CHECK(row.installed == 5);
    CHECK(row.worst_mm < 5.0);
    CHECK(row.position_mm < 5.0);
    for (const MappedBeaconError& beacon : row.beacons) {
      nees.add(beacon.nees);
      CHECK(beacon.error_mm < std::max(5.0, beacon.first_mm));
      CHECK(beacon.ranges > 100);
    }
  }
  // Errors of one run have much in common, so the bounds of independent ones, 0.5 to 1.7, are wider here.
  CHECK(nees.mean() / 3.0 > 0.2);
  CHECK(nees.mean() / 3.0 < 2.5);
}

TEST_CASE("beacon mapping: what it refuses leaves it as it was, and never a NaN") {
  const MappingCase room = MappingCase::random(1, 1);
  const std::unique_ptr<Motion> motion = make_mapping_walk(std::chrono::seconds(2));
  const MappingStart start = detail::mapping_start(*motion, 1);
  BeaconMapper mapper(room.seeds, room.receivers, start);
  const auto ms = [&](int t) { return start.t + std::chrono::milliseconds(t); };
  CHECK(mapper.add(ms(1), {0, 0, 2.0}) == MappingStatus::refused);  // no reading yet
  for (int t = 0; t <= 100; t += 2) {
    InertialReading reading;
    reading.t = ms(t);
    reading.force_B = start.X_WB.q().conjugate() * Vector3(0.0, standard_gravity, 0.0);
    CHECK(mapper.add(reading));
    CHECK_FALSE(mapper.add(reading));  // the same time again
    reading.t = ms(t + 1);
    reading.rate_B.x() = std::nan("");
    CHECK_FALSE(mapper.add(reading));
  }
  const double range_m = (start.X_WB * room.receivers[0].p_B - room.seeds[0].p_W).norm();
  CHECK(mapper.add(ms(10), {0, 0, range_m}) == MappingStatus::used);
  const Vector3 before_W = mapper.state().X_WB().p();
  CHECK(mapper.add(ms(5), {0, 0, range_m}) == MappingStatus::refused);
  CHECK(mapper.add(ms(900), {0, 0, range_m}) == MappingStatus::refused);
  CHECK(mapper.add(ms(10), {3, 0, range_m}) == MappingStatus::bad_reading);
  CHECK(mapper.add(ms(10), {-1, 0, range_m}) == MappingStatus::bad_reading);
  CHECK(mapper.add(ms(10), {0, 0, -1.0}) == MappingStatus::bad_reading);
  CHECK(mapper.add(ms(10), {0, 0, std::numeric_limits<double>::quiet_NaN()}) == MappingStatus::bad_reading);
  CHECK(mapper.add(ms(10), {0, 0, std::numeric_limits<double>::infinity()}) == MappingStatus::bad_reading);
  CHECK(mapper.add(ms(10), {0, 0, range_m + 1.0}) == MappingStatus::gated);
  CHECK(mapper.state().X_WB().p() == before_W);
  CHECK(mapper.unplaced() == 0);

  std::vector<CodedBeacon> seeds = room.seeds;
  CHECK_FALSE(BeaconMapper::problem(seeds, room.receivers));
  CHECK(BeaconMapper::problem(seeds, {}));
  CHECK(*BeaconMapper::problem(std::span(seeds).first(2), room.receivers) == "fewer than three seed beacons");
  seeds[1].code = seeds[0].code;
  CHECK(*BeaconMapper::problem(seeds, room.receivers) == "two seed beacons have one code");
  seeds[1] = {1, 0.5 * (seeds[0].p_W + seeds[2].p_W), Vector3::Zero()};
  CHECK(*BeaconMapper::problem(seeds, room.receivers) == "all seed beacons hang in one line");
  seeds[1].p_W.x() = std::nan("");
  CHECK(*BeaconMapper::problem(seeds, room.receivers) == "a seed beacon's position is not finite");
}
