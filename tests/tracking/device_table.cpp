#include <doctest/doctest.h>

#include <holdfast/tracking/device_table.hpp>

using namespace holdfast;

namespace {

DeviceSettings<3> settings() {
  DeviceSettings<3> s;
  s.initial_variance = Vector3(1e-6, 2e-6, 3e-6);
  s.wander = Vector3(1e-10, 2e-10, 3e-10);
  s.residual_variance = Vector3(1e-7, 1e-7, 1e-7);
  return s;
}

}  // namespace

TEST_CASE("a device table gives back what was stored, in at most 96 bytes a beacon") {
  static_assert(sizeof(DeviceRecord<3>) <= 96);  // the issue's
  DeviceTable<3> table(settings());
  CHECK(table.add(Vector3(1.0, 2.0, 3.0)) == 0);
  CHECK(table.add(Vector3(4.0, 5.0, 6.0)) == 1);
  CHECK(table.size() == 2);
  CHECK(table.at(1).x == Vector3(4.0, 5.0, 6.0));
  CHECK(table.at(1).P.diagonal() == settings().initial_variance);
  CHECK(table.at(1).P(0, 1) == 0.0);
  CHECK(table.at(1).residual_variance == settings().residual_variance);

  DeviceEstimate<3> learnt = table.at(0);
  learnt.x = Vector3(1.1, 2.1, 3.1);
  learnt.P << 1.0, 0.1, 0.2, 0.1, 2.0, 0.3, 0.2, 0.3, 3.0;
  table.store(0, learnt);
  CHECK(table.at(0).x == learnt.x);
  CHECK(table.at(0).P == learnt.P);
  CHECK(table.at(1).x == Vector3(4.0, 5.0, 6.0));
  CHECK(table.records().size_bytes() == 2 * sizeof(DeviceRecord<3>));
}

TEST_CASE("a device wanders when it is seen, unless it is locked; sightings are counted") {
  DeviceTable<3> table(settings());
  table.add(Vector3::Zero());
  CHECK((table.for_sighting(0).P.diagonal() - settings().initial_variance - settings().wander).norm() < 1e-20);
  CHECK(table.at(0).P.diagonal() == settings().initial_variance);
  CHECK_FALSE(table.last_sighting(0));
  table.count_sighting(0, time_at(2.5));
  CHECK(table.sightings(0) == 1);
  CHECK(*table.last_sighting(0) == time_at(2.5));

  table.lock(0);
  CHECK(table.at(0).locked);
  CHECK(table.for_sighting(0).P.diagonal() == settings().initial_variance);
  DeviceEstimate<3> unlocked = table.at(0);
  unlocked.locked = false;
  table.store(0, unlocked);
  CHECK(table.is_locked(0));
  table.unlock(0);
  CHECK_FALSE(table.at(0).locked);
  table.lock_all();
  CHECK(table.is_locked(0));
  CHECK(table.contains(0));
  CHECK_FALSE(table.contains(1));
  CHECK_FALSE(table.contains(-1));
}
