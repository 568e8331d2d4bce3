#include <array>
#include <cmath>

#include <holdfast/registration/metrics.hpp>

#include "text.hpp"
#include "track_constellation.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

/// Of curves, in report.js.
constexpr std::array curve_styles{"b", "a", "c", "d", "e", "f"};

ResultJson rounded(double value, double step) {
  return io::number_or_null(step * std::round(value / step));
}

ResultJson table(const std::vector<ConstellationTrack>& tracks) {
  ResultJson json = {{"label", "Cases"},
                     {"columns",
                      {{{"name", "Case"}, {"text", true}},
                       {{"name", "Position RMS"}, {"unit", "mm"}},
                       {{"name", "peak"}, {"unit", "mm"}},
                       {{"name", "Angle RMS"}, {"unit", "deg"}},
                       {{"name", "peak"}, {"unit", "deg"}},
                       {{"name", "Effective latency"}, {"unit", "ms"}},
                       {{"name", "Turned away"}, {"unit", "%"}},
                       {{"name", "Wrong let in"}},
                       {{"name", "Named"}, {"text", true}}}},
                     {"rows", ResultJson::array()}};
  for (const ConstellationTrack& track : tracks) {
    const ConstellationRow& row = track.row;
    std::string named = track.gyro.empty() ? "" : "gyro: " + track.gyro;
    if (!track.accelerometer.empty()) named += (named.empty() ? "" : ", ") + ("accelerometer: " + track.accelerometer);
    json["rows"].push_back({row.name, rounded(1e3 * row.position.rms(), 0.01), rounded(1e3 * row.position.peak(), 0.01),
                            rounded(degrees_per_rad * row.angle.rms(), 0.001),
                            rounded(degrees_per_rad * row.angle.peak(), 0.001),
                            track.latency.has_latency() ? rounded(track.latency.effective_latency_ms, 0.01) : nullptr,
                            rounded(100.0 * static_cast<double>(row.gated) / static_cast<double>(row.ranges), 0.1),
                            row.corrupt_accepted, named});
  }
  return json;
}

ResultJson error_chart(const std::vector<ConstellationTrack>& tracks) {
  ResultJson chart = {{"id", "error"},
                      {"title", "Position error"},
                      {"caption", "The largest of each 50 ms."},
                      {"x", {{"label", "time"}, {"unit", "s"}}},
                      {"y", {{"label", "error"}, {"unit", "mm"}}},
                      {"logToggle", true},
                      {"series", ResultJson::array()},
                      {"rows", ResultJson::array()}};
  const std::size_t shown = std::min(tracks.size(), curve_styles.size());
  std::size_t points = tracks.front().errors.size();
  for (std::size_t k = 0; k < shown; ++k) {
    chart["series"].push_back({{"name", tracks[k].row.name}, {"style", curve_styles[k]}});
    points = std::min(points, tracks[k].errors.size());
  }
  for (std::size_t i = 0; i < points; ++i) {
    ResultJson row = ResultJson::array({rounded(tracks.front().errors[i].t_s, 0.001)});
    for (std::size_t k = 0; k < shown; ++k) row.push_back(rounded(tracks[k].errors[i].position_mm, 0.01));
    chart["rows"].push_back(std::move(row));
  }
  return chart;
}

/// The paper's figures beside ours, as a picture: the page has room for one table.
ResultJson figures_picture(const std::vector<ConstellationFigure>& figures) {
  constexpr double line = 30.0;
  std::string svg = text_of(
      "<svg xmlns='http://www.w3.org/2000/svg' width='800' height='%.0f' font-family='sans-serif' font-size='14'>"
      "<rect width='100%%' height='100%%' fill='white'/>",
      line * static_cast<double>(figures.size() + 2));
  double y = line;
  const auto row = [&](const std::string& what, const std::string& paper, const std::string& ours, const char* look) {
    svg += text_of("<g fill='%s'><text x='20' y='%.0f'>%s</text><text x='440' y='%.0f'>%s</text>", look, y,
                   what.c_str(), y, paper.c_str());
    svg += text_of("<text x='600' y='%.0f'>%s</text></g>", y, ours.c_str());
    y += line;
  };
  row("", "paper", "here", "#666");
  for (const ConstellationFigure& figure : figures) row(figure.what, figure.paper, figure.ours, "#222");
  return {
      {"title", "The paper's figures, and ours"},
      {"svg", svg + "</svg>"},
      {"caption", "Foxlin, Harrington and Pfeifer measured a tracker; ours is simulated with their errors (table 1)."}};
}

}  // namespace

ResultJson constellation_page(const ConstellationFacts& facts, const std::vector<ConstellationTrack>& tracks,
                              const std::vector<ConstellationFigure>& figures) {
  ResultJson page;
  page["eyebrow"] = "tracking by sound and inertia";
  page["title"] =
      text_of("Under eight beacons the track is %.1f mm off (RMS)", 1e3 * tracks.front().row.position.rms());
  page["paragraphs"] = {
      "Gyros and accelerometers on the head are integrated, and each reading's pose goes out at once. Beacons on the "
      "ceiling click one after another; the time that sound takes to three microphones gives ranges, and each range by "
      "itself corrects what the integrals have gathered.",
      text_of("Simulated: %s, %.0f s. Errors are counted after 2 s, at each reading, against the truth.",
              facts.motion.c_str(), facts.seconds)};
  page["table"] = table(tracks);
  page["charts"] = ResultJson::array({error_chart(tracks)});
  page["pictures"] = ResultJson::array();
  if (!figures.empty()) page["pictures"].push_back(figures_picture(figures));
  page["command"] = facts.command;
  return {{"page", page}};
}

}  // namespace swimlab
