/// What all results written as JSON have in common: keys keep their order, a number that is not finite is null.
///
/// Source: design.md, "The command". Apart from results.hpp, which knows the experiments: who writes a page or a table of its own needs
/// no more than this. Files are written by whole_file.hpp: whole or not at all.
#pragma once

#include <cmath>
#include <optional>
#include <string>

#include <nlohmann/json.hpp>

#include <holdfast/io/whole_file.hpp>

namespace holdfast::io {

/// Keeps keys in the order in which they were written.
using ResultJson = nlohmann::ordered_json;

[[nodiscard]] inline ResultJson number_or_null(double value) {
  return std::isfinite(value) ? ResultJson(value) : ResultJson(nullptr);
}
[[nodiscard]] inline ResultJson number_or_null(const std::optional<double>& value) {
  return value ? number_or_null(*value) : ResultJson(nullptr);
}

/// The text of a result file.
[[nodiscard]] inline std::string json_text(const ResultJson& json) {
  // Names of files may hold any bytes: what is not UTF-8 is replaced, not thrown.
  return json.dump(2, ' ', false, nlohmann::json::error_handler_t::replace) + '\n';
}

}  // namespace holdfast::io
