#include <filesystem>
#include <random>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/device_file.hpp>

using namespace holdfast;

namespace {

DeviceTable<3> some_devices(int count) {
  std::mt19937 random(4);
  std::normal_distribution<double> normal;
  DeviceSettings<3> settings;
  settings.initial_variance.setConstant(1e-6);
  settings.wander = Vector3(1e-10, 2e-10, 1.0 / 3.0);
  settings.residual_variance.setConstant(1e-7);
  DeviceTable<3> table(settings);
  for (int i = 0; i < count; ++i) {
    DeviceEstimate<3> device;
    Matrix3 root;
    for (double& x : root.reshaped()) x = 1e-3 * normal(random);
    for (double& x : device.x) x = normal(random);
    device.P = root * root.transpose();
    device.P = (0.5 * (device.P + device.P.transpose())).eval();
    device.locked = i % 3 == 0;
    table.add(device);
    for (int k = 0; k < i % 5; ++k) table.count_sighting(i, time_at(0.1));
  }
  return table;
}

std::string message_of(const std::string& text) {
  try {
    (void)io::parse_devices<3>(text, "ceiling.json");
  } catch (const io::InputError& error) {
    return error.what();
  }
  return "";
}

std::string with(const std::string& from, const std::string& to) {
  const std::string good =
      "{\"schema\": \"holdfast/devices/1\", \"parameters\": 3,\n"
      "\"settings\": {\"initial_variance\": [1, 1, 1], \"wander\": [0, 0, 0], \"residual_variance\": [0, 0, 0]},\n"
      "\"devices\": [\n{\"x\": [1, 2, 3], \"P\": [1, 0, 1, 0, 0, 1], \"sightings\": 7, \"locked\": true}]}\n";
  std::string text = good;
  const std::size_t place = text.find(from);
  REQUIRE(place != std::string::npos);
  return text.replace(place, from.size(), to);
}

}  // namespace

TEST_CASE("devices come back bit by bit, but for what belongs to the run") {
  const DeviceTable<3> table = some_devices(3024);  // the HiBall's
  const std::filesystem::path path = std::filesystem::temp_directory_path() / "holdfast_devices.json";
  io::save_devices(table, path);
  const DeviceTable<3> back = io::load_devices<3>(path);
  std::filesystem::remove(path);
  REQUIRE(back.size() == table.size());
  CHECK(back.settings().wander == table.settings().wander);
  CHECK(back.settings().initial_variance == table.settings().initial_variance);
  CHECK(back.settings().residual_variance == table.settings().residual_variance);
  int different = 0;
  for (int i = 0; i < table.size(); ++i) {
    const bool same = back.at(i).x == table.at(i).x && back.at(i).P == table.at(i).P &&
                      back.sightings(i) == table.sightings(i) && back.is_locked(i) == table.is_locked(i);
    different += !same || back.last_sighting(i).has_value();
  }
  CHECK(different == 0);
  CHECK(io::parse_devices<3>(io::devices_json(DeviceTable<3>()), "empty.json").size() == 0);
}

TEST_CASE("a device file that is wrong is refused with its place") {
  CHECK(message_of(with("7", "7")).empty());
  const auto names = [](const std::string& message, const std::string& part) {
    CAPTURE(message);
    CHECK(message.find("ceiling.json") != std::string::npos);
    CHECK(message.find(part) != std::string::npos);
  };
  names(message_of(with("[1, 2, 3]", "[1, 2]")), "devices[0].x");
  names(message_of(with("[1, 2, 3]", "[1, 2, \"3\"]")), "devices[0].x[2]");
  names(message_of(with("[1, 0, 1, 0, 0, 1]", "[1, 2, 1, 0, 0, 1]")), "is no covariance");
  names(message_of(with("[1, 0, 1, 0, 0, 1]", "[-1, 0, 1, 0, 0, 1]")), "devices[0].P");
  // Each pair is possible, all three together are not.
  names(message_of(with("[1, 0, 1, 0, 0, 1]", "[1, 0.9, 1, -0.9, 0.9, 1]")), "is no covariance");
  names(message_of(with("7", "-7")), "devices[0].sightings");
  names(message_of(with("true", "1")), "devices[0].locked");
  names(message_of(with("\"parameters\": 3", "\"parameters\": 1")), "parameters");
  names(message_of(with("holdfast/devices/1", "holdfast/hmd/1")), "schema");
  names(message_of(with("\"locked\"", "\"lcoked\"")), "lcoked");
  names(message_of(with("\"wander\": [0, 0, 0]", "\"wander\": [0, 0, -1]")), "settings.wander[2]");
  CHECK(message_of("").find("ceiling.json") != std::string::npos);
}
