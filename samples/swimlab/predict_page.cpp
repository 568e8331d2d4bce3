#include "predict_page.hpp"

#include <array>
#include <cmath>
#include <functional>

#include "text.hpp"

namespace swimlab {

using holdfast::io::ResultJson;

namespace {

/// Of the charts: the predictor, its style in report.js, and words. The largest errors first.
struct PredictorLook {
  const char *predictor, *style, *words;
};
constexpr std::array looks{PredictorLook{"none", "a", "none"},
                           PredictorLook{"constant_velocity", "b", "constant velocity"},
                           PredictorLook{"constant_acceleration", "d", "constant acceleration"},
                           PredictorLook{"gyro", "e", "gyro"},
                           PredictorLook{"kalman", "c", "Kalman, without inertial"},
                           PredictorLook{"kalman_inertial", "P3", "Kalman, with inertial"}};

const ResultJson* row_of(const ResultJson& block, const char* predictor) {
  for (const ResultJson& row : block["rows"]) {
    if (row["predictor"] == predictor) return &row;
  }
  return nullptr;
}

/// Four digits that count.
ResultJson rounded(const ResultJson& number) {
  if (!number.is_number()) return nullptr;
  const double value = number.get<double>();
  if (value == 0.0 || !std::isfinite(value)) return value;
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return std::round(value / unit) * unit;
}

ResultJson chart_of(const ResultJson& block, const char* id, const char* title, const char* unit, const char* label,
                    const std::string& caption) {
  ResultJson chart{{"id", id},
                   {"title", title},
                   {"caption", caption},
                   {"x", {{"label", "interval"}, {"unit", "ms"}}},
                   {"y", {{"label", label}, {"unit", unit}}},
                   {"logToggle", true},
                   {"series", ResultJson::array()},
                   {"rows", ResultJson::array()}};
  for (const PredictorLook& look : looks) {
    if (row_of(block, look.predictor)) chart["series"].push_back({{"name", look.words}, {"style", look.style}});
  }
  return chart;
}

using Pick = std::function<ResultJson(const ResultJson& row)>;

/// A row of the chart: `x`, and of each predictor the number that `pick` takes from its row.
ResultJson chart_row(double x, const ResultJson& block, const Pick& pick) {
  ResultJson row = ResultJson::array({x});
  for (const PredictorLook& look : looks) {
    if (const ResultJson* found = row_of(block, look.predictor)) row.push_back(rounded(pick(*found)));
  }
  return row;
}

ResultJson against_interval(const std::vector<ResultJson>& sweep, ResultJson chart, const Pick& pick) {
  for (const ResultJson& block : sweep)
    chart["rows"].push_back(chart_row(block["interval_ms"].get<double>(), block, pick));
  return chart;
}

ResultJson spectrum_chart(const ResultJson& asked) {
  ResultJson chart = chart_of(asked, "spectrum", "Where the error is in frequency", "arcmin/\u221aHz", "error",
                              text_of("Orientation error at %g ms. Almost all movement of a head is below 2 Hz: what "
                                      "stands between 3 and 12 Hz is jitter that the prediction made.",
                                      asked["interval_ms"].get<double>()));
  chart["x"] = {{"label", "frequency"}, {"unit", "Hz"}};
  chart["logarithmic"] = true;
  const ResultJson& frequencies = asked["spectrum_hz"];
  for (std::size_t k = 0; k < frequencies.size(); ++k) {
    chart["rows"].push_back(chart_row(frequencies[k].get<double>(), asked, [k](const ResultJson& row) -> ResultJson {
      const ResultJson& power = row["spectrum_arcmin2_per_hz"];
      if (k >= power.size() || !power[k].is_number()) return nullptr;
      return std::sqrt(power[k].get<double>());
    }));
  }
  return chart;
}

ResultJson table_of(const ResultJson& block) {
  ResultJson table{{"label", text_of("Predictors, %g ms ahead", block["interval_ms"].get<double>())},
                   {"columns",
                    {{{"name", "Predictor"}, {"text", true}},
                     {{"name", "Angle, mean"}, {"unit", "deg"}},
                     {{"name", "95 %"}, {"unit", "deg"}},
                     {{"name", "peak"}, {"unit", "deg"}},
                     {{"name", "Position, mean"}, {"unit", "mm"}},
                     {{"name", "95 %"}, {"unit", "mm"}},
                     {{"name", "peak"}, {"unit", "mm"}},
                     {{"name", "Screen, mean"}, {"unit", "px"}},
                     {{"name", "Jitter"}, {"unit", "arcmin"}},
                     {{"name", "Inside 95 %"}, {"unit", "%"}}}},
                   {"rows", ResultJson::array()}};
  for (const PredictorLook& look : looks) {
    const ResultJson* row = row_of(block, look.predictor);
    if (!row) continue;
    ResultJson cells = ResultJson::array({look.words});
    for (const char* of : {"mean", "p95", "peak"}) cells.push_back(rounded((*row)["angle_deg"][of]));
    for (const char* of : {"mean", "p95", "peak"}) cells.push_back(rounded((*row)["position_mm"][of]));
    for (const ResultJson& number : {(*row)["screen_px"]["mean"], (*row)["jitter_arcmin"], (*row)["inside_95_pct"]})
      cells.push_back(rounded(number));
    table["rows"].push_back(cells);
  }
  return table;
}

std::string title_of(const ResultJson& block) {
  const double ms = block["interval_ms"].get<double>();
  const ResultJson* inertial = row_of(block, "kalman_inertial");
  const ResultJson& best = inertial ? *inertial : *row_of(block, "kalman");
  const double none = (*row_of(block, "none"))["angle_deg"]["mean"].get<double>();
  const double ours = best["angle_deg"]["mean"].get<double>();
  return text_of("%g ms ahead, prediction is off by %.2g\u00b0; without it, %.2g\u00b0 are missing", ms, ours, none);
}

}  // namespace

ResultJson predict_page(const PredictPageFacts& facts, const ResultJson& asked, const std::vector<ResultJson>& sweep) {
  ResultJson page;
  page["eyebrow"] = "prediction";
  page["title"] = title_of(asked);
  page["paragraphs"] = {
      "At every sample of the recording the past alone is known. Each predictor says where the head will be, and the "
      "recording says later where it was. Recording: " +
          facts.recording + ".",
      "Inertial readings: " + facts.readings + "."};
  page["table"] = table_of(asked);
  page["charts"] = ResultJson::array(
      {against_interval(sweep,
                        chart_of(asked, "angle", "Orientation error against the interval", "deg", "mean error",
                                 "The farther ahead, the worse; how much worse depends on the predictor. Figure 7 of "
                                 "Azuma and Bishop's paper of 1994, on this recording."),
                        [](const ResultJson& row) { return row["angle_deg"]["mean"]; }),
       against_interval(sweep,
                        chart_of(asked, "position", "Position error against the interval", "mm", "mean error",
                                 "Constant velocity and gyro draw one line: a gyro does not feel where a head goes."),
                        [](const ResultJson& row) { return row["position_mm"]["mean"]; }),
       against_interval(sweep,
                        chart_of(asked, "jitter", "Jitter against the interval", "arcmin", "RMS from 3 to 12 Hz",
                                 "Orientation error between 3 and 12 Hz while the head moves. What predicts makes it "
                                 "grow faster than the error: long predictions are restless before they are wrong."),
                        [](const ResultJson& row) { return row["jitter_arcmin"]; }),
       spectrum_chart(asked)});
  page["pictures"] = ResultJson::array();
  page["command"] = facts.command;
  return {{"page", page}};
}

}  // namespace swimlab
