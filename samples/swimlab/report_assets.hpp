/// Text of the report's page, style, scripts and of dygraphs, put into the program by embed.cmake.
#pragma once

#include <string_view>

namespace swimlab::assets {

extern const std::string_view page, style, script, chart_style, chart_script;

}  // namespace swimlab::assets
