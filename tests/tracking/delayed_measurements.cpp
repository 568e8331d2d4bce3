// Late and disordered measurements must leave nothing behind: neither in the filter, nor in any device.
#include <random>

#include <allocation_counter.hpp>
#include <doctest/doctest.h>
#include <tracking/hiball_scene.hpp>

#include <holdfast/simulation/faults.hpp>
#include <holdfast/tracking/delayed_measurements.hpp>
#include <holdfast/tracking/inertial_measurement.hpp>
#include <holdfast/tracking/multiple_models.hpp>
#include <holdfast/tracking/pose_measurement.hpp>

using namespace holdfast;

namespace {

using Event = UpdateEvent<CameraSighting, AngularRate, PositionMeasurement>;

/// What may be applied, and when it arrives.
struct Arrival {
  HostTime delivered;
  std::int64_t order = 0;  ///< place in the stream
};

double difference(const TargetState<2>& a, const TargetState<2>& b) {
  return std::max(a.error_of(b).cwiseAbs().maxCoeff(), (a.P - b.P).cwiseAbs().maxCoeff());
}

template <int Size>
double difference(const DeviceEstimate<Size>& a, const DeviceEstimate<Size>& b) {
  return std::max((a.x - b.x).cwiseAbs().maxCoeff(), (a.P - b.P).cwiseAbs().maxCoeff());
}

double difference(const DeviceTable<3>& a, const DeviceTable<3>& b) {
  double largest = 0.0;
  for (int i = 0; i < a.size(); ++i) {
    largest = std::max(largest, difference(a.at(i), b.at(i)));
    if (a.sightings(i) != b.sightings(i) || a.last_sighting(i) != b.last_sighting(i)) largest = 1.0;
    if (a.record(i).probation != b.record(i).probation) largest = 1.0;
  }
  return largest;
}

/// A filter and everything that it works on.
template <typename Filter>
struct Bench {
  Filter filter;
  DeviceTable<3> beacons;
  DeviceEstimate<3> gyro_bias;

  Bench(const Filter& start, const DeviceTable<3>& table) : filter(start), beacons(table) {
    gyro_bias.P = 1e-4 * Matrix3::Identity();
  }
};

/// Sightings, two of one time each, with every fifth time an angular rate and every tenth a position, and one sighting in
/// twenty of a beacon mistaken for another.
class Stream {
 public:
  explicit Stream(const test::HiBallScene& scene) : scene_(&scene) {
    StreamOptions options;
    options.group = 2;
    sightings_ = sighting_stream(scene.simulator, options);
    misidentify(sightings_, scene.simulator, 0.05, 4);
  }
  [[nodiscard]] std::size_t size() const { return sightings_.size(); }
  [[nodiscard]] HostTime time(std::size_t i) const { return sightings_[i].t; }

  template <typename Filter>
  [[nodiscard]] Event event(std::size_t i, Bench<Filter>& bench) const {
    const HostTime t = sightings_[i].t;
    const auto order = static_cast<std::int64_t>(i);
    const MotionState truth = scene_->truth.at(t);
    const double error = 0.001 * std::sin(100.0 * static_cast<double>(i));
    if (i % 10 == 3) {
      const Vector3 rate = truth.w_WB_B + Vector3(0.01 + error, error, -error);
      return Event(t, AngularRate{rate, Quaternion::Identity(), 1e-5}, {}, bench.gyro_bias, order);
    }
    if (i % 20 == 8) {
      const Vector3 lever(0.1, 0.0, 0.0);
      return Event(
          t, PositionMeasurement{truth.X_WB * lever + Vector3(error, 0.0, 0.0), lever, 1e-6 * Matrix3::Identity()},
          order);
    }
    return Event(t, scene_->measurement(sightings_[i]), {bench.beacons, sightings_[i].beacon}, order);
  }

 private:
  const test::HiBallScene* scene_;
  std::vector<BeaconSighting> sightings_;
};

/// 10 % late by up to 50 ms; the rest in order.
std::vector<Arrival> disordered(const Stream& stream, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> share(0.0, 1.0);
  std::vector<Arrival> arrivals;
  for (std::size_t i = 0; i < stream.size(); ++i) {
    const double late_s = share(random) < 0.1 ? 0.05 * share(random) : 0.0;
    arrivals.push_back({stream.time(i) + from_seconds(late_s), static_cast<std::int64_t>(i)});
  }
  std::ranges::stable_sort(arrivals, {}, &Arrival::delivered);
  return arrivals;
}

template <typename Filter>
void check_order_does_not_matter(const test::HiBallScene& scene, const Filter& start, double good_m) {
  const Stream stream(scene);
  Bench<Filter> in_order(start, scene.beacons());
  for (std::size_t i = 0; i < stream.size(); ++i) (void)stream.event(i, in_order).apply(in_order.filter);

  Bench<Filter> bench(start, scene.beacons());
  DelayedFilter<Filter, Event> delayed(start, 100);
  const std::vector<Arrival> arrivals = disordered(stream, 7);
  HostTime newest = scene.truth.begin();
  int held_back = 0;
  const std::size_t allocations = test::allocations();
  for (const Arrival& arrival : arrivals) {
    const auto i = static_cast<std::size_t>(arrival.order);
    const Event event = stream.event(i, bench);
    const UpdateStatus status = delayed.update(event);
    newest = std::max(newest, event.time());
    // The newest estimate is of the newest event's time, unless that was turned away.
    if (status == UpdateStatus::updated && event.time() == newest && delayed.filter().state().t != newest) ++held_back;
  }
  CHECK(test::allocations() == allocations);
  CHECK(held_back == 0);
  const auto& counters = delayed.counters();
  MESSAGE(counters.late << " of " << stream.size() << " late, " << counters.replayed << " replayed");
  CHECK(counters.too_old == 0);
  CHECK(counters.late > stream.size() / 12);  // 10 %, of which a few overtake nothing
  // The bound is 1e-9; the same operations on the same numbers give the same.
  CHECK(difference(delayed.filter().state(), in_order.filter.state()) == 0.0);
  CHECK(difference(bench.beacons, in_order.beacons) == 0.0);
  CHECK(difference(bench.gyro_bias, in_order.gyro_bias) == 0.0);
  for (std::size_t status = 0; status < update_statuses; ++status) {
    CAPTURE(name_of(static_cast<UpdateStatus>(status)));
    CHECK(delayed.filter().counters()[static_cast<UpdateStatus>(status)] ==
          in_order.filter.counters()[static_cast<UpdateStatus>(status)]);
  }
  CHECK(in_order.filter.counters()[UpdateStatus::gated] > 0);
  CHECK(in_order.filter.counters()[UpdateStatus::on_probation] > 0);
  CHECK(in_order.filter.counters()[UpdateStatus::updated] > stream.size() / 2);
  const TargetState<2>& state = delayed.filter().state();
  MESSAGE("updated " << in_order.filter.counters()[UpdateStatus::updated] << ", last at "
                     << to_seconds(newest - state.t) << " s before the end");
  CHECK((state.X_WB.p() - scene.simulator.pose_at(state.t).p()).norm() < good_m);
}

}  // namespace

TEST_CASE("delayed: 10 % late by up to 50 ms end as the same in order, state, devices and counters alike") {
  const test::HiBallScene scene(test::swaying_hiball(5.0));
  check_order_does_not_matter(scene, ScaatFilter<2>(scene.start(), test::HiBallScene::model()), 0.002);
}

TEST_CASE("delayed: the same with multiple models") {
  const test::HiBallScene scene(test::swaying_hiball(1.0));
  PvModel still = test::HiBallScene::model();
  still.intensity *= 1e-4;
  const ModelSet<2, 2> set{{still, test::HiBallScene::model()}, {0.5, 0.5}};
  check_order_does_not_matter(scene, MultipleModelFilter<2, 2>(scene.start(), set), 0.02);
}

TEST_CASE("delayed: events of one time and order keep the order of arrival; a single kind needs no variant") {
  const test::HiBallScene scene(test::swaying_hiball(0.1));
  StreamOptions options;
  options.group = 10;
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator, options);
  using Plain = MeasurementEvent<CameraSighting>;
  const ScaatFilter<2> start(scene.start(), test::HiBallScene::model());
  ScaatFilter<2> in_order = start;
  DelayedFilter<ScaatFilter<2>, Plain> delayed(start, 64);
  DeviceTable<3> table = scene.beacons();
  DeviceTable<3> delayed_table = table;
  for (const BeaconSighting& s : sightings) {
    (void)in_order.update(s.t, scene.measurement(s), {table, s.beacon});
  }
  // Later groups first, each within itself in order.
  for (std::size_t group = sightings.size() / 10; group-- > 0;) {
    if (group % 2 == 0 && group > 0) continue;
    for (const std::size_t g : {group + 1, group}) {
      for (std::size_t i = 10 * g; i < 10 * g + 10 && i < sightings.size(); ++i) {
        if (group == 0 && g == 1) continue;
        const BeaconSighting& s = sightings[i];
        (void)delayed.update(Plain(s.t, scene.measurement(s), {delayed_table, s.beacon}, {}));
      }
    }
  }
  REQUIRE(delayed.remembered() <= 64);
  if (delayed.counters().too_old == 0) {
    CHECK(difference(delayed.filter().state(), in_order.state()) == 0.0);
    CHECK(difference(delayed_table, table) == 0.0);
  }
}

TEST_CASE("delayed: what is older than the history is refused, what is far ahead leaves no trace") {
  const test::HiBallScene scene(test::swaying_hiball(0.2));
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator);
  using Plain = MeasurementEvent<CameraSighting>;
  const ScaatFilter<2> start(scene.start(), test::HiBallScene::model());
  DeviceTable<3> table = scene.beacons();
  const auto event = [&](std::size_t i) {
    const BeaconSighting& s = sightings[i];
    return Plain(s.t, scene.measurement(s), {table, s.beacon}, {});
  };
  DelayedFilter<ScaatFilter<2>, Plain> delayed(start, 10);
  for (std::size_t i = 0; i < 50; ++i) {
    if (i != 20 && i != 45) (void)delayed.update(event(i));
  }
  CHECK(delayed.remembered() == 10);
  const TargetState<2> before = delayed.filter().state();
  const DeviceTable<3> table_before = table;
  CHECK(delayed.update(event(20)) == UpdateStatus::time_backwards);
  CHECK(delayed.counters().too_old == 1);
  CHECK(difference(delayed.filter().state(), before) == 0.0);

  Plain ahead = Plain(time_at(3600.0), scene.measurement(sightings[50]), {table, sightings[50].beacon}, {});
  CHECK(delayed.update(ahead) == UpdateStatus::gap_too_long);
  CHECK(delayed.counters().too_far_ahead == 1);
  CHECK(delayed.filter().counters()[UpdateStatus::gap_too_long] == 0);
  CHECK(delayed.remembered() == 10);
  CHECK(difference(delayed.filter().state(), before) == 0.0);
  CHECK(difference(table, table_before) == 0.0);

  CHECK(delayed.counters().late == 0);
  (void)delayed.update(event(45));
  CHECK(delayed.counters().late == 1);
  CHECK(delayed.counters().replayed == 4);
  (void)delayed.update(event(50));

  // The same without 20, and without detours.
  ScaatFilter<2> in_order = start;
  DeviceTable<3> in_order_table = scene.beacons();
  for (std::size_t i = 0; i <= 50; ++i) {
    const BeaconSighting& s = sightings[i];
    if (i != 20) (void)in_order.update(s.t, scene.measurement(s), {in_order_table, s.beacon});
  }
  CHECK(difference(delayed.filter().state(), in_order.state()) == 0.0);
  CHECK(difference(table, in_order_table) == 0.0);

  delayed.restart(start);
  CHECK(delayed.remembered() == 0);
  CHECK(delayed.update(event(60)) == UpdateStatus::updated);
}

TEST_CASE("delayed: taking back leaves a lock that was set meanwhile") {
  const test::HiBallScene scene(test::swaying_hiball(0.2));
  const std::vector<BeaconSighting> sightings = sighting_stream(scene.simulator);
  using Plain = MeasurementEvent<CameraSighting>;
  DeviceTable<3> table = scene.beacons();
  const auto event = [&](std::size_t i) {
    const BeaconSighting& s = sightings[i];
    return Plain(s.t, scene.measurement(s), {table, s.beacon}, {});
  };
  DelayedFilter<ScaatFilter<2>, Plain> delayed({scene.start(), test::HiBallScene::model()}, 10);
  (void)delayed.update(event(2));
  table.lock(sightings[2].beacon);
  (void)delayed.update(event(1));
  CHECK(table.is_locked(sightings[2].beacon));
  // Replayed, it was locked: it stayed as designed.
  CHECK(table.at(sightings[2].beacon).x ==
        scene.simulator.rig().nominal_beacons_W[static_cast<std::size_t>(sightings[2].beacon)]);
}
