/// Keeps a table of calibrated devices (tracking/device_table.hpp) between runs: JSON, schema "holdfast/devices/1".
///
///     io::save_devices(beacons, "ceiling.json");
///     DeviceTable<3> beacons = io::load_devices<3>("ceiling.json");
/// 002's second runs (its dagger figures) start like this from what the first has learnt. Each device is one line:
///     {"x": [parameters], "P": [lower triangle by rows], "sightings": 12, "locked": false}
/// Units are the parameters' own. Every number is given back bit by bit. What belongs to a run alone is not kept: when a
/// device was seen last, and whether it is on probation. The file is written whole or not at all; up to about 10,000
/// beacons fit (4 MB, as all JSON here).
/// Bad input: io::InputError with file, line, key, value and what was expected; a covariance that is none is refused.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include <holdfast/io/input_error.hpp>
#include <holdfast/io/json_reader.hpp>
#include <holdfast/io/whole_file.hpp>
#include <holdfast/tracking/device_table.hpp>
#include <holdfast/tracking/innovation.hpp>

namespace holdfast::io {

inline constexpr std::string_view devices_schema = "holdfast/devices/1";

namespace detail {

/// More than any parameter or variance in SI units.
inline constexpr double largest_parameter = 1e12;

template <typename Numbers>
[[nodiscard]] nlohmann::ordered_json numbers_json(const Numbers& numbers) {
  return nlohmann::ordered_json(std::vector<double>(numbers.begin(), numbers.end()));
}

template <int Size>
[[nodiscard]] VectorOf<double, Size> numbers_of(const JsonNode& node, double lowest) {
  const std::vector<JsonNode> elements = node.elements(Size, Size);
  VectorOf<double, Size> numbers;
  for (int i = 0; i < Size; ++i) numbers[i] = elements[static_cast<std::size_t>(i)].number(lowest, largest_parameter);
  return numbers;
}

template <int Size>
[[nodiscard]] DeviceRecord<Size> device_of(const JsonNode& node) {
  constexpr int packed = DeviceRecord<Size>::packed_size;
  node.allow_only({"x", "P", "sightings", "locked"});
  DeviceRecord<Size> record;
  record.x = numbers_of<Size>(node.at("x"), -largest_parameter);
  const VectorOf<double, packed> P = numbers_of<packed>(node.at("P"), -largest_parameter);
  MatrixOf<double, Size> covariance;
  for (int row = 0, k = 0; row < Size; ++row) {
    for (int column = 0; column <= row; ++column, ++k) {
      record.P[static_cast<std::size_t>(k)] = covariance(row, column) = P[k];
    }
  }
  if (!holdfast::detail::is_noise<Size>(covariance)) {
    node.at("P").fail("is no covariance", "variances of at least 0, and no covariance above what they allow");
  }
  record.sightings = static_cast<std::uint32_t>(node.at("sightings").number(0.0, 4294967295.0));
  record.locked = node.at("locked").boolean();
  return record;
}

}  // namespace detail

/// The text of a device file.
template <int Size>
[[nodiscard]] std::string devices_json(const DeviceTable<Size>& table) {
  const DeviceSettings<Size>& settings = table.settings();
  const nlohmann::ordered_json settings_json{{"initial_variance", detail::numbers_json(settings.initial_variance)},
                                             {"wander", detail::numbers_json(settings.wander)},
                                             {"residual_variance", detail::numbers_json(settings.residual_variance)}};
  std::string text = "{\"schema\": \"" + std::string(devices_schema) + "\",\n \"parameters\": " + std::to_string(Size) +
                     ",\n \"settings\": " + settings_json.dump() + ",\n \"devices\": [";
  for (const DeviceRecord<Size>& record : table.records()) {
    const nlohmann::ordered_json device{{"x", detail::numbers_json(record.x)},
                                        {"P", detail::numbers_json(record.P)},
                                        {"sightings", record.sightings},
                                        {"locked", record.locked}};
    text += (&record == table.records().data() ? "\n  " : ",\n  ") + device.dump();
  }
  return text + "]}\n";
}

/// `file` is for messages.
template <int Size>
[[nodiscard]] DeviceTable<Size> parse_devices(std::string_view text, std::string file) {
  const JsonDocument document = JsonDocument::parse(text, std::move(file));
  const JsonNode root = document.root();
  root.allow_only({"schema", "parameters", "settings", "devices"});
  (void)root.at("schema").choice({devices_schema});
  (void)root.at("parameters").integer(Size, Size);
  const JsonNode settings_node = root.at("settings");
  settings_node.allow_only({"initial_variance", "wander", "residual_variance"});
  DeviceSettings<Size> settings;
  settings.initial_variance = detail::numbers_of<Size>(settings_node.at("initial_variance"), 0.0);
  settings.wander = detail::numbers_of<Size>(settings_node.at("wander"), 0.0);
  settings.residual_variance = detail::numbers_of<Size>(settings_node.at("residual_variance"), 0.0);
  DeviceTable<Size> table(settings);
  const std::vector<JsonNode> devices = root.at("devices").elements(0, 1'000'000);
  table.reserve(static_cast<int>(devices.size()));
  for (const JsonNode& node : devices) {
    const DeviceRecord<Size> record = detail::device_of<Size>(node);
    table.record(table.add(record.x)) = record;
  }
  return table;
}

template <int Size>
void save_devices(const DeviceTable<Size>& table, const std::filesystem::path& path) {
  const std::string text = devices_json(table);
  if (text.size() > JsonDocument::longest) {
    throw InputError({.file = path.string(),
                      .problem = std::to_string(table.size()) + " devices are too many for one file",
                      .expected = "a table whose text takes at most 4 MB"});
  }
  write_whole_file(path, text);
}

template <int Size>
[[nodiscard]] DeviceTable<Size> load_devices(const std::filesystem::path& path) {
  return parse_devices<Size>(read_whole_file(path), path.string());
}

}  // namespace holdfast::io
