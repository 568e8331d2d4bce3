#include <algorithm>
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

/// What the scenario is about: the faults that were named, or the ranges that were turned away.
ResultJson table(const std::vector<ConstellationTrack>& tracks, bool faults) {
  ResultJson json = {
      {"label", "Cases"}, {"columns", {{{"name", "Case"}, {"text", true}}}}, {"rows", ResultJson::array()}};
  const auto column = [&](const char* name, const char* unit) {
    json["columns"].push_back({{"name", name}, {"unit", unit}});
  };
  if (faults) json["columns"].push_back({{"name", "Named"}, {"text", true}});
  column("Position RMS", "mm");
  column("peak", "mm");
  column("Angle RMS", "deg");
  column("peak", "deg");
  column("Latency", "ms");
  if (!faults) {
    column("Turned away", "echoes");
    column("", "early");
    column("", "good");
    column("Let in", "wrong");
    column("NEES", "");
    column("NIS", "");
  }
  for (const ConstellationTrack& track : tracks) {
    const ConstellationRow& row = track.row;
    std::string named = track.gyro.empty() ? "" : "gyro: " + track.gyro;
    if (!track.accelerometer.empty()) named += (named.empty() ? "" : ", ") + ("accelerometer: " + track.accelerometer);
    if (track.gyro == track.accelerometer && !named.empty()) named = "both: " + track.gyro;
    ResultJson line = ResultJson::array({row.name});
    if (faults) line.push_back(named);
    line.push_back(rounded(1e3 * row.position.rms(), 0.01));
    line.push_back(rounded(1e3 * row.position.peak(), 0.01));
    line.push_back(rounded(degrees_per_rad * row.angle.rms(), 0.001));
    line.push_back(rounded(degrees_per_rad * row.angle.peak(), 0.001));
    line.push_back(track.latency.has_latency() ? rounded(track.latency.effective_latency_ms, 0.01) : nullptr);
    if (!faults) {
      for (const long count :
           {row.turned_away.echo, row.turned_away.early, row.turned_away.good, row.corrupt_accepted}) {
        line.push_back(count);
      }
      line.push_back(rounded(row.nees, 0.01));
      line.push_back(rounded(row.nis, 0.01));
    }
    json["rows"].push_back(std::move(line));
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

/// The paper's figures beside ours.
ResultJson figures_table(const std::vector<ConstellationFigure>& figures, const char* caption) {
  ResultJson json = {{"title", "The paper's figures, and ours"},
                     {"caption", caption},
                     {"label", "The paper's figures beside ours"},
                     {"columns",
                      {{{"name", "What"}, {"text", true}, {"narrow", true}},
                       {{"name", "Paper"}, {"text", true}, {"narrow", true}},
                       {{"name", "Here"}, {"text", true}, {"narrow", true}}}},
                     {"rows", ResultJson::array()}};
  for (const ConstellationFigure& figure : figures) json["rows"].push_back({figure.what, figure.paper, figure.ours});
  return json;
}

ResultJson study_table(const ConstellationStudy& study) {
  ResultJson json = {{"label", "Results"}, {"columns", ResultJson::array()}, {"rows", study.cells}};
  for (const ConstellationStudy::Column& column : study.columns) {
    ResultJson head = {{"name", column.name}};
    if (column.unit.empty()) {
      head["text"] = true;
    } else {
      head["unit"] = column.unit;
    }
    json["columns"].push_back(std::move(head));
  }
  return json;
}

}  // namespace

ResultJson constellation_page(const ConstellationFacts& facts, const std::vector<ConstellationTrack>& tracks,
                              const std::vector<ConstellationFigure>& figures) {
  ResultJson page;
  page["eyebrow"] = "tracking by sound and inertia";
  const bool faults = facts.scenario == "faults";
  double peak_m = 0.0;
  for (const ConstellationTrack& track : tracks) peak_m = std::max(peak_m, track.row.position.peak());
  page["title"] =
      faults ? text_of("Whatever fails, the track stays within %.0f mm", 1e3 * peak_m)
             : text_of("Under eight beacons the track is %.1f mm off (RMS)", 1e3 * tracks.front().row.position.rms());
  page["paragraphs"] = {
      "Gyros and accelerometers on the head are integrated, and each reading's pose goes out at once. Beacons on the "
      "ceiling click one after another; the time that sound takes to three microphones gives ranges, and each range by "
      "itself corrects what the integrals have gathered.",
      text_of("Simulated: %s, %.0f s. Errors are counted after 2 s, at each reading, against the truth. Latency is the "
              "effective one. ",
              facts.motion.c_str(), facts.seconds) +
          (faults ? "A fault lasts for the middle third. Each of the six axes is judged by itself; what is not "
                    "believed is "
                    "stood in for, with the uncertainty of a head that may do anything."
                  : "NEES and NIS compare errors with what the filter believes, 1 is honest; a run of one installation "
                    "says little of it. NIS is of the ranges that were let in.")};
  page["table"] = table(tracks, faults);
  page["charts"] = ResultJson::array({error_chart(tracks)});
  page["pictures"] = ResultJson::array();
  if (!figures.empty()) {
    page["tables"] = {figures_table(figures,
                                    "Foxlin, Harrington and Pfeifer measured a tracker; ours is simulated with their "
                                    "errors (table 1).")};
  }
  page["command"] = facts.command;
  return {{"page", page}};
}

ResultJson constellation_page(const ConstellationFacts& facts, const ConstellationStudy& study) {
  ResultJson page;
  page["eyebrow"] = "tracking by sound and inertia";
  page["title"] = study.title;
  page["paragraphs"] = study.paragraphs;
  page["table"] = study_table(study);
  page["charts"] = study.charts;
  page["tables"] = {figures_table(study.figures, "Foxlin, Harrington and Pfeifer (1998), and this simulation.")};
  page["pictures"] = ResultJson::array();
  page["command"] = facts.command;
  return {{"page", page}};
}

}  // namespace swimlab
