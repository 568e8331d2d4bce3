#include "track_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <map>
#include <optional>

#include <holdfast/registration/metrics.hpp>

#include "text.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

/// Of the charts, in the order of TrackMethod: style in report.js, and words.
struct MethodLook {
  const char *style, *words;
};
constexpr std::array<MethodLook, track_methods.size()> method_looks{MethodLook{"e", "SCAAT, learns nothing"},
                                                                    MethodLook{"b", "SCAAT, learns LEDs"},
                                                                    MethodLook{"P3", "SCAAT, second run"},
                                                                    MethodLook{"c", "Joint"},
                                                                    MethodLook{"f", "Joint, second run"},
                                                                    MethodLook{"ink", "Joint, two models"},
                                                                    MethodLook{"d", "MCAAT 3"},
                                                                    MethodLook{"theory", "MCAAT 10"},
                                                                    MethodLook{"a", "Collinearity 10"}};
/// Of curves that differ by case.
constexpr std::array case_styles{"b", "a", "c", "d", "e", "f"};

const MethodLook& look_of(TrackMethod method) {
  return method_looks[static_cast<std::size_t>(method)];
}

/// Two or three digits that count.
std::string short_number(double value) {
  if (!std::isfinite(value)) return "-";
  const double size = std::abs(value);
  if (size == 0.0) return "0";
  const int digits = size >= 100.0 ? 0
                     : size >= 1.0 ? 1
                                   : std::min(6, 1 - static_cast<int>(std::floor(std::log10(size))));
  return text_of("%.*f", digits, value);
}

/// Four digits that count: charts need no more.
ResultJson rounded(double value) {
  if (!std::isfinite(value) || value == 0.0) return io::number_or_null(value);
  const double unit = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return io::number_or_null(std::round(value / unit) * unit);
}

double figure(const TrackCaseRow& row, std::string_view key) {
  const auto found = std::ranges::find(row.more, key, &MoreFigure::first);
  return found == row.more.end() ? std::nan("") : found->second.value_or(std::nan(""));
}

double three_point_mm(const TrackCaseRow& row) {
  return 1e3 * row.row.three_point.rms();
}

/// Whether the largest is ten times the smallest or more, so that a linear axis would hide the small ones.
bool differ_by_ten(const std::vector<double>& values) {
  double least = std::numeric_limits<double>::infinity(), most = 0.0;
  for (const double value : values) {
    if (!(value > 0.0) || !std::isfinite(value)) continue;
    least = std::min(least, value);
    most = std::max(most, value);
  }
  return most >= 10.0 * least;
}

/// A number of a row, for tables and bars.
struct Figure {
  std::string name, unit;
  std::function<double(const TrackCaseRow&)> of;
};

Figure more_figure(const std::string& name, const std::string& unit, const std::string& key) {
  return {name, unit, [key](const TrackCaseRow& row) { return figure(row, key); }};
}

class Page {
 public:
  Page(const TrackPageFacts& facts, const std::vector<TrackCaseRow>& rows) : facts_(facts), rows_(rows) {
    for (const TrackCaseRow& row : rows) {
      if (std::ranges::find(cases_, row.case_name) == cases_.end()) cases_.push_back(row.case_name);
      if (std::ranges::find(methods_, row.row.method) == methods_.end()) methods_.push_back(row.row.method);
    }
  }

  [[nodiscard]] ResultJson json() {
    add_charts();
    ResultJson page;
    page["eyebrow"] = "tracking by a simulated HiBall";
    page["title"] = title();
    page["paragraphs"] = paragraphs();
    page["table"] = table();
    page["charts"] = std::move(charts_);
    page["pictures"] = ResultJson::array();
    page["command"] = facts_.command;
    return {{"page", page}};
  }

 private:
  [[nodiscard]] bool searches() const {
    return facts_.scenario == TrackScenario::cold_start || facts_.scenario == TrackScenario::blocked;
  }
  [[nodiscard]] bool has_cases() const { return cases_.size() > 1; }

  [[nodiscard]] static std::string words(const TrackCaseRow& row) { return look_of(row.row.method).words; }

  // ---- words

  [[nodiscard]] const TrackCaseRow& extreme(bool best) const {
    const auto less = [](const TrackCaseRow& a, const TrackCaseRow& b) {
      return three_point_mm(a) < three_point_mm(b);
    };
    return best ? *std::ranges::min_element(rows_, less) : *std::ranges::max_element(rows_, less);
  }

  [[nodiscard]] std::string title() const {
    if (rows_.empty()) return "No method was asked for";
    const TrackCaseRow &first = rows_.front(), &last = rows_.back(), &best = extreme(true), &worst = extreme(false);
    const auto mm = [](double value) { return short_number(value) + " mm"; };
    switch (facts_.scenario) {
      case TrackScenario::cold_start:
        return short_number(figure(first, "within_50_ms_pct")) + " % of cold starts are right within 50 ms";
      case TrackScenario::blocked:
        return "After two blind seconds, " + short_number(figure(first, "within_50_ms_pct")) +
               " % are right again within 50 ms";
      case TrackScenario::low_rate:
        return words(first) + ": " + mm(three_point_mm(first)) + " at " + first.case_name + ", " +
               mm(three_point_mm(of_method(first.row.method, last.case_name))) + " at " + last.case_name;
      case TrackScenario::faults:
        return "One wrong sighting in five: " + mm(three_point_mm(first)) + " become " +
               mm(three_point_mm(of_method(first.row.method, cases_[std::min<std::size_t>(1, cases_.size() - 1)])));
      case TrackScenario::ordering:
        return "Which camera comes next: the order changes the noise above 100 Hz from " +
               mm(figure(first, "noise_above_100_hz_mm")) + " to " +
               mm(figure(of_method(first.row.method, cases_[std::min<std::size_t>(1, cases_.size() - 1)]),
                         "noise_above_100_hz_mm"));
      case TrackScenario::spectra: {
        const auto noise = [](const TrackCaseRow& row) { return figure(row, "held_noise_above_100_hz_mm"); };
        const auto less = [&](const TrackCaseRow& a, const TrackCaseRow& b) { return noise(a) < noise(b); };
        const auto [least, most] = std::ranges::minmax_element(rows_, less);
        return "Noise above 100 Hz: " + words(*least) + " " + mm(noise(*least)) +
               (rows_.size() > 1 ? ". " + words(*most) + " " + mm(noise(*most)) : "");
      }
      default:
        if (rows_.size() < 2) return words(first) + " is " + mm(three_point_mm(first)) + " off (RMS)";
        return words(best) + ": " + mm(three_point_mm(best)) + " off. " + words(worst) + ": " +
               mm(three_point_mm(worst));
    }
  }

  [[nodiscard]] const TrackCaseRow& of_method(TrackMethod method, const std::string& case_name) const {
    for (const TrackCaseRow& row : rows_) {
      if (row.row.method == method && row.case_name == case_name) return row;
    }
    return rows_.back();
  }

  [[nodiscard]] std::string about() const {
    switch (facts_.scenario) {
      case TrackScenario::typical:
        return "A head in motion, 1000 sightings a second, one at a time.";
      case TrackScenario::still:
        return "A HiBall at rest, 2000 sightings a second. Each method is tuned once for motion, and once for rest.";
      case TrackScenario::cold_start:
        return "The tracker starts anew 40 times, each time without any idea of where it is. With a search it first "
               "finds "
               "a pose that fits its first sightings. Without one the filter starts 4 m off, turned anyhow, and has "
               "only "
               "its corrections.";
      case TrackScenario::blocked:
        return "For two of every six seconds, nothing is seen. Then the tracker has to be right again.";
      case TrackScenario::low_rate:
        return "The same motion with 1000, 100, 20 and 10 sightings a second.";
      case TrackScenario::simultaneous:
        return "Sightings come one, three or ten of the same time. With one at a time, methods that use several "
               "together "
               "take them for simultaneous, which they are not.";
      case TrackScenario::spectra:
        return "How restless the output is: the errors' noise at each frequency. Heads hardly move above 10 Hz, so "
               "noise "
               "there is the tracker's own.";
      case TrackScenario::ordering:
        return "The same number of sightings, taken in another order: cameras by turns, at random, each LED that was "
               "used "
               "longest ago, or what tells most about the direction in which the pose is known least.";
      case TrackScenario::faults:
        return "One sighting in five names the wrong LED. A gate turns away what is too unlikely. Where the sighting "
               "lies "
               "tells whose it is, and under that name it counts after all.";
    }
    return "";
  }

  [[nodiscard]] ResultJson paragraphs() const {
    return {
        about() +
            " Right is who knows where three points are that stand 1 m ahead: position and direction count "
            "together, as for what a headset draws there.",
        "A HiBall looks up at a ceiling of LEDs, which hang 1.7 mm off their places (RMS). All methods get the same "
        "sightings. SCAAT corrects its pose with each sighting, MCAAT with 3 or 10 at once; Collinearity fits a pose "
        "to each 10 and does not filter. Joint is SCAAT that keeps what the newest LEDs have to do with the pose. "
        "Second runs begin with the LEDs as learnt in the first. Motion: " +
            facts_.motion + ", " + short_number(facts_.seconds) + " s."};
  }

  // ---- the table

  [[nodiscard]] std::vector<Figure> columns() const {
    std::vector<Figure> all;
    if (facts_.scenario != TrackScenario::cold_start) {
      all = {{"Three points RMS", "mm", three_point_mm},
             {"peak", "mm", [](const TrackCaseRow& r) { return 1e3 * r.row.three_point.peak(); }}};
    }
    if (searches()) {
      all.push_back(more_figure("Trials", "", "trials"));
      all.push_back(more_figure("Right within 50 ms", "%", "within_50_ms_pct"));
      all.push_back(more_figure("Median", "ms", "median_ms"));
      all.push_back(more_figure("Right in the end", "%", "recovered_pct"));
      return all;
    }
    all.push_back({"Position RMS", "mm", [](const TrackCaseRow& r) { return 1e3 * r.row.position.rms(); }});
    all.push_back({"Angle RMS", "deg", [](const TrackCaseRow& r) { return degrees_per_rad * r.row.angle.rms(); }});
    all.push_back({"Turned away", "%", [](const TrackCaseRow& r) {
                     return 100.0 * static_cast<double>(r.row.gated) / static_cast<double>(r.row.sightings);
                   }});
    all.push_back({"NEES", "1 is right", [](const TrackCaseRow& r) { return r.row.nees; }});
    all.push_back({"NIS", "1 is right", [](const TrackCaseRow& r) { return r.row.nis; }});
    return all;
  }

  [[nodiscard]] ResultJson table() const {
    const std::vector<Figure> figures = columns();
    ResultJson json = {{"label", "Every row"},
                       {"columns", ResultJson::array({{{"name", "Method"}, {"text", true}}})},
                       {"rows", ResultJson::array()}};
    if (has_cases()) json["columns"].push_back({{"name", "Case"}, {"text", true}});
    for (const Figure& f : figures) json["columns"].push_back({{"name", f.name}, {"unit", f.unit}});
    for (const TrackCaseRow& row : rows_) {
      ResultJson cells = ResultJson::array({words(row)});
      if (has_cases()) cells.push_back(row.case_name);
      for (const Figure& f : figures) cells.push_back(rounded(f.of(row)));
      json["rows"].push_back(std::move(cells));
    }
    return json;
  }

  // ---- bars

  struct Bars {
    const char *id, *title, *label, *unit;
    std::string caption;
    std::vector<Figure> figures;
    bool half = false;  ///< two of them side by side, where there is room
    std::array<const char*, 3> styles{"b", "theory", "d"};
  };

  /// A group for each case, in it a line for each method. Rows without any of the figures are left out.
  void add_bars(const Bars& bars) {
    std::vector<double> values;
    ResultJson rows = ResultJson::array();
    for (const std::string& name : cases_) {
      for (const TrackCaseRow& row : rows_) {
        if (row.case_name != name) continue;
        ResultJson cells = ResultJson::array();
        bool some = false;
        for (const Figure& f : bars.figures) {
          values.push_back(f.of(row));
          some = some || std::isfinite(values.back());
          cells.push_back(rounded(values.back()));
        }
        if (some) rows.push_back({{"group", name}, {"label", words(row)}, {"values", cells}});
      }
    }
    if (rows.empty()) return;
    const bool log = std::string_view(bars.unit) != "%" && differ_by_ten(values);
    ResultJson series = ResultJson::array();
    for (std::size_t i = 0; i < bars.figures.size(); ++i) {
      series.push_back({{"name", bars.figures[i].name}, {"style", bars.styles[i]}, {"area", true}});
    }
    charts_.push_back(
        {{"id", bars.id},
         {"title", bars.title},
         {"caption", bars.caption + (log ? " The axis is logarithmic: each line is ten times the one before." : "")},
         {"bars", true},
         {"half", bars.half},
         {"x", {{"label", bars.label}, {"unit", bars.unit}, {"log", log}}},
         {"series", std::move(series)},
         {"rows", std::move(rows)}});
  }

  void add_error_bars() {
    const auto two = [](RmsAndPeak TrackRow::*of, double scale) {
      return std::vector<Figure>{{"RMS", "", [=](const TrackCaseRow& r) { return scale * (r.row.*of).rms(); }},
                                 {"peak", "", [=](const TrackCaseRow& r) { return scale * (r.row.*of).peak(); }}};
    };
    add_bars({"three_points",
              "Error of three points, by method",
              "error",
              "mm",
              "Shorter is better. RMS over all estimates, and the worst one.",
              {{"RMS", "", three_point_mm},
               {"peak", "", [](const TrackCaseRow& r) { return 1e3 * r.row.three_point.peak(); }}}});
    add_bars({"position", "Position", "error", "mm", "How far off the HiBall itself was.",
              two(&TrackRow::position, 1e3), true});
    add_bars({"angle", "Angle", "error", "deg", "How far off its direction was: 0.01 deg are 0.17 mm at 1 m.",
              two(&TrackRow::angle, degrees_per_rad), true});
  }

  void add_beacon_bars() {
    const auto of = [](BeaconErrors::Group BeaconErrors::*group, double BeaconErrors::Group::*value) {
      return [=](const TrackCaseRow& r) {
        const bool some = r.row.beacons && ((*r.row.beacons).*group).beacons > 0;
        return some ? 1e3 * (((*r.row.beacons).*group).*value) : std::nan("");
      };
    };
    using Group = BeaconErrors::Group;
    add_bars({"leds",
              "LEDs, before and after",
              "error",
              "mm",
              "Who learns LEDs brings them closer to where they hang, and most those seen often.",
              {{"before", "", of(&BeaconErrors::seen, &Group::before)},
               {"after, all that were seen", "", of(&BeaconErrors::seen, &Group::after)},
               {"after, seen 20 times or more", "", of(&BeaconErrors::seen_often, &Group::after)}},
              false,
              {"theory", "d", "b"}});
  }

  // ---- curves

  /// Of one chart: its rows, named and coloured by method, or by case where it shows one method.
  struct Curves {
    std::string id, title, caption;
    const char *x_label, *x_unit, *y_label, *y_unit;
    bool x_log = false, y_log = false;
  };

  [[nodiscard]] static const TrackCurve* curve_of(const TrackCaseRow& row, TrackCurveKind kind) {
    const auto found = std::ranges::find(row.curves, kind, &TrackCurve::kind);
    return found == row.curves.end() || found->points.empty() ? nullptr : &*found;
  }

  class Sheet {
   public:
    void add(const std::string& name, const std::string& style, const TrackCurve& curve, bool dashed = false) {
      series_.push_back({{"name", name}, {"style", style}, {"dashed", dashed}});
      for (const TrackCurve::Point& p : curve.points) values_[p.x].emplace_back(series_.size() - 1, p.y);
    }
    [[nodiscard]] bool empty() const { return series_.empty(); }

    [[nodiscard]] ResultJson json(const Curves& c) const {
      ResultJson rows = ResultJson::array();
      for (const auto& [x, values] : values_) {
        ResultJson row = ResultJson::array({rounded(x)});
        for (std::size_t i = 0; i < series_.size(); ++i) row.push_back(nullptr);
        for (const auto& [series, y] : values) {
          // A logarithm has no zero.
          row[series + 1] = rounded(c.y_log ? std::max(y, 1e-6) : y);
        }
        rows.push_back(std::move(row));
      }
      return {{"id", c.id},
              {"title", c.title},
              {"caption", c.caption},
              {"x", {{"label", c.x_label}, {"unit", c.x_unit}, {"log", c.x_log}}},
              {"y", {{"label", c.y_label}, {"unit", c.y_unit}, {"log", c.y_log}}},
              {"series", series_},
              {"rows", std::move(rows)}};
    }

   private:
    ResultJson series_ = ResultJson::array();
    std::map<double, std::vector<std::pair<std::size_t, double>>> values_;
  };

  /// One chart of all methods, or, where there are cases, one for each method with a curve for each case.
  void add_curves(TrackCurveKind kind, const Curves& curves) {
    if (!has_cases()) {
      Sheet sheet;
      for (const TrackCaseRow& row : rows_) {
        const MethodLook& look = look_of(row.row.method);
        if (const TrackCurve* curve = curve_of(row, kind)) sheet.add(look.words, look.style, *curve);
      }
      if (!sheet.empty()) charts_.push_back(sheet.json(curves));
      return;
    }
    for (const TrackMethod method : methods_) {
      Sheet sheet;
      for (std::size_t i = 0; i < cases_.size(); ++i) {
        for (const TrackCaseRow& row : rows_) {
          if (row.row.method != method || row.case_name != cases_[i]) continue;
          if (const TrackCurve* curve = curve_of(row, kind)) {
            sheet.add(cases_[i], case_styles[i % case_styles.size()], *curve);
          }
        }
      }
      Curves named = curves;
      named.id += "-" + std::string(name_of(method));
      named.title += ": " + std::string(look_of(method).words);
      if (sheet.empty()) continue;
      charts_.push_back(sheet.json(named));
      charts_.back()["half"] = methods_.size() > 1;
    }
  }

  void add_errors_in_time() {
    std::vector<double> rms;
    for (const TrackCaseRow& row : rows_) rms.push_back(three_point_mm(row));
    const std::string gaps = facts_.scenario == TrackScenario::blocked
                                 ? " Nothing is estimated while nothing is seen: the line only joins what is beside."
                                 : "";
    add_curves(TrackCurveKind::error,
               {"error", "Error in time", "Of each three-hundredth of the run the worst estimate." + gaps, "time", "s",
                "error of three points", "mm", false, differ_by_ten(rms)});
  }

  void add_noise() {
    const auto caption = [&]() -> std::string {
      switch (facts_.scenario) {
        case TrackScenario::ordering:
          return "Peaks come from an order that repeats.";
        case TrackScenario::low_rate:
          return "Where lines overlap they show one frequency's noise at several rates.";
        case TrackScenario::still:
          return "Filters that are tuned for rest let less noise through.";
        default:
          return "A filter's noise falls towards high frequencies; Collinearity does not filter. Each estimate's error "
                 "at "
                 "its own time.";
      }
    };
    add_curves(TrackCurveKind::noise, {"noise", "Spectrum of the error", caption(), "frequency", "Hz", "noise",
                                       "mm/\u221aHz", facts_.scenario != TrackScenario::ordering, true});
    if (facts_.scenario != TrackScenario::spectra) return;
    add_curves(
        TrackCurveKind::held_noise,
        {"held_noise", "Spectrum of the error as shown",
         "The newest estimate against where the head is by now. Estimates that come every 10 ms make a staircase: "
         "noise that an eye would see.",
         "frequency", "Hz", "noise", "mm/\u221aHz", true, true});
  }

  void add_recovery() {
    for (const TrackMethod method : methods_) {
      Sheet sheet;
      for (std::size_t i = 0; i < cases_.size(); ++i) {
        const TrackCaseRow& row = of_method(method, cases_[i]);
        const char* style = case_styles[i % case_styles.size()];
        if (const TrackCurve* half = curve_of(row, TrackCurveKind::half_recovered)) {
          sheet.add(cases_[i] + ", half of the trials", style, *half);
        }
        if (const TrackCurve* most = curve_of(row, TrackCurveKind::most_recovered)) {
          sheet.add(cases_[i] + ", nine of ten", style, *most, true);
        }
      }
      if (sheet.empty()) continue;
      sheet.add("right: 10 mm", "theory", {TrackCurveKind::error, {{2.0, 10.0}, {300.0, 10.0}}}, true);
      const std::string which = methods_.size() > 1 ? ": " + std::string(look_of(method).words) : "";
      charts_.push_back(
          sheet.json({"recovery-" + std::string(name_of(method)), "Until it is right again" + which,
                      "Half of the trials are below the full line, nine of ten below the broken one. A line "
                      "begins when so many have an estimate.",
                      "time since there is something to see", "ms", "error of three points", "mm", false, true}));
    }
  }

  void add_charts() {
    if (searches()) {
      add_bars(
          {"recovered",
           "Right again",
           "trials",
           "%",
           "Longer is better: trials whose three points were less than 10 mm off, and stayed so.",
           {more_figure("within 50 ms", "%", "within_50_ms_pct"), more_figure("in the end", "%", "recovered_pct")}});
      add_recovery();
    }
    if (facts_.scenario == TrackScenario::cold_start) return;
    if (!searches()) add_error_bars();
    switch (facts_.scenario) {
      case TrackScenario::spectra:
      case TrackScenario::ordering:
        add_bars({"noise_above",
                  "Noise above 100 Hz",
                  "noise (RMS)",
                  "mm",
                  "Shorter is better. As shown: with the staircase of estimates that are held until the next.",
                  {more_figure("at estimates", "mm", "noise_above_100_hz_mm"),
                   more_figure("as shown", "mm", "held_noise_above_100_hz_mm")}});
        break;
      case TrackScenario::still:
        add_bars({"drift",
                  "Drift",
                  "error of three points (RMS)",
                  "mm",
                  "Bars of one length: what is learnt of the LEDs does not carry the pose away.",
                  {more_figure("first tenth of the run", "mm", "first_tenth_mm"),
                   more_figure("last tenth", "mm", "last_tenth_mm")}});
        break;
      case TrackScenario::faults:
        add_bars({"gate",
                  "What the gate turned away",
                  "sightings",
                  "%",
                  "It should turn away what is wrong, and keep what is good.",
                  {more_figure("good sightings", "%", "good_gated_pct"),
                   more_figure("wrong sightings", "%", "wrong_gated_pct")}});
        break;
      default:
        break;
    }
    add_noise();
    add_errors_in_time();
    add_beacon_bars();
  }

  const TrackPageFacts& facts_;
  const std::vector<TrackCaseRow>& rows_;
  std::vector<std::string> cases_;
  std::vector<TrackMethod> methods_;
  ResultJson charts_ = ResultJson::array();
};

}  // namespace

ResultJson track_page(const TrackPageFacts& facts, const std::vector<TrackCaseRow>& rows) {
  return Page(facts, rows).json();
}

}  // namespace swimlab
