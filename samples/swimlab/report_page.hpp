/// A report's page, assembled: apart from report.hpp, for commands that draw no pictures.
#pragma once

#include <string>

#include <holdfast/io/result_json.hpp>

namespace swimlab {

/// The page with its data: one file. Data with a member `page` bring their own words (report.js, `tell`).
[[nodiscard]] std::string report_page(const holdfast::io::ResultJson& data);

}  // namespace swimlab
