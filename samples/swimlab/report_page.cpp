#include "report_page.hpp"

#include <string_view>

#include "report_assets.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

void replace_once(std::string& text, std::string_view mark, std::string_view by) {
  const std::size_t at = text.find(mark);
  if (at != std::string::npos) text.replace(at, mark.size(), by);
}

}  // namespace

std::string report_page(const ResultJson& data) {
  std::string json = data.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace);
  // Inside a script element only "</" and "<!--" could end it early; "<" is plain in JSON's strings.
  std::string safe;
  safe.reserve(json.size());
  for (const char c : json) {
    if (c == '<') {
      safe += "\\u003c";
    } else {
      safe += c;
    }
  }
  std::string page(assets::page);
  replace_once(page, "{{chart_style}}", assets::chart_style);
  replace_once(page, "{{style}}", assets::style);
  replace_once(page, "{{data}}", safe);
  // dygraphs names a source map that is not here: browsers would look for it.
  std::string charts(assets::chart_script);
  const std::size_t map = charts.rfind("//# sourceMappingURL");
  if (map != std::string::npos) charts.erase(map);
  replace_once(page, "{{chart_script}}", charts);
  replace_once(page, "{{script}}", assets::script);
  return page;
}

}  // namespace swimlab
