#include "range_page.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <holdfast/registration/metrics.hpp>

#include "text.hpp"

namespace swimlab {

using namespace holdfast;
using io::ResultJson;

namespace {

/// Of the charts, in the order of range_variants: style in report.js, colour in the picture, words.
struct VariantLook {
  const char *style, *colour, *words;
};
constexpr std::array looks{VariantLook{"P0", "#c2492f", "neither"}, VariantLook{"c", "#8a5fb0", "gate"},
                           VariantLook{"d", "#b98a16", "bias states"},
                           VariantLook{"P1", "#0f7285", "bias states and gate"}};

/// Of so many places one is drawn: 1500 points make a curve.
std::size_t stride_of(const RangeTrack& track) {
  return std::max<std::size_t>(1, (track.places.size() + 1499) / 1500);
}

/// To a tenth of a millimetre: charts need no more.
ResultJson to_tenth_of_mm(double value) {
  return io::number_or_null(std::round(1e4 * value) / 1e4);
}

ResultJson time_chart(const char* id, const char* title, const char* label, const std::string& caption) {
  return {{"id", id},
          {"title", title},
          {"caption", caption},
          {"x", {{"label", "time"}, {"unit", "s"}}},
          {"y", {{"label", label}, {"unit", "m"}}},
          {"series", ResultJson::array()},
          {"rows", ResultJson::array()}};
}

ResultJson error_chart(const std::vector<RangeTrack>& tracks) {
  ResultJson chart = time_chart("error", "Position error", "error", "Distance of the track from the truth.");
  chart["logToggle"] = true;
  for (const VariantLook& look : looks) chart["series"].push_back({{"name", look.words}, {"style", look.style}});
  for (std::size_t i = 0; i < tracks.front().places.size(); i += stride_of(tracks.front())) {
    ResultJson row = ResultJson::array({to_tenth_of_mm(tracks.front().places[i].t_s)});
    for (const RangeTrack& track : tracks)
      row.push_back(to_tenth_of_mm((track.places[i].p_W - track.places[i].true_W).norm()));
    chart["rows"].push_back(std::move(row));
  }
  return chart;
}

ResultJson height_chart(const std::vector<RangeTrack>& tracks, const Vector3& up_W) {
  ResultJson chart = time_chart("height", "Height", "height",
                                "Height hangs most on the anchors' biases: all anchors are seen at a flat angle.");
  for (const VariantLook& look : looks) chart["series"].push_back({{"name", look.words}, {"style", look.style}});
  chart["series"].push_back({{"name", "truth"}, {"style", "ink"}, {"dashed", true}});
  for (std::size_t i = 0; i < tracks.front().places.size(); i += stride_of(tracks.front())) {
    ResultJson row = ResultJson::array({to_tenth_of_mm(tracks.front().places[i].t_s)});
    for (const RangeTrack& track : tracks) row.push_back(to_tenth_of_mm(track.places[i].p_W.dot(up_W)));
    row.push_back(to_tenth_of_mm(tracks.front().places[i].true_W.dot(up_W)));
    chart["rows"].push_back(std::move(row));
  }
  return chart;
}

/// Seen from above, with `up` towards the reader.
class TopView {
 public:
  explicit TopView(const Vector3& up_W)
      : right_W_(up_W.cross(std::abs(up_W.x()) > 0.5 ? Vector3::UnitZ() : Vector3::UnitX()).cross(up_W).normalized()),
        forward_W_(up_W.cross(right_W_)) {}

  using Line = std::vector<Vector2>;
  [[nodiscard]] Vector2 place(const Vector3& p_W) const { return {p_W.dot(right_W_), p_W.dot(forward_W_)}; }

  void add(Line line, const std::string& look, const std::string& words) {
    for (const Vector2& p : line) {
      low_ = low_.cwiseMin(p);
      high_ = high_.cwiseMax(p);
    }
    lines_.push_back({std::move(line), look, words});
  }

  [[nodiscard]] std::string svg() const {
    constexpr double longest = 640.0, margin = 40.0, top = 60.0;
    const Vector2 low = low_.array() - 0.2, high = high_.array() + 0.2, size = high - low;
    const double scale = longest / size.maxCoeff(), width = scale * size.x(), height = scale * size.y();
    std::string svg = text_of(
        "<svg xmlns='http://www.w3.org/2000/svg' width='%.0f' height='%.0f' font-family='sans-serif' font-size='14'>"
        "<rect width='100%%' height='100%%' fill='white'/>",
        std::max(width, 480.0) + 2.0 * margin, height + top + margin);
    const auto on_page = [&](const Vector2& p) {
      return Vector2(margin + scale * (p.x() - low.x()), top + scale * (high.y() - p.y()));
    };
    svg += grid(low, high, on_page);
    double legend = margin;
    for (const Drawn& drawn : lines_) {
      svg += "<path fill='none' stroke-linejoin='round' " + drawn.look + " d='";
      for (std::size_t i = 0; i < drawn.line.size(); ++i) {
        const Vector2 p = on_page(drawn.line[i]);
        svg += text_of("%c%.1f %.1f", i == 0 ? 'M' : 'L', p.x(), p.y());
      }
      svg += "'/>" + text_of("<path %s d='M%.0f 27h26'/><text x='%.0f' y='32' fill='#222'>%s</text>",
                             drawn.look.c_str(), legend, legend + 33.0, drawn.words.c_str());
      legend += 60.0 + 8.0 * static_cast<double>(drawn.words.size());
    }
    return svg + "</svg>";
  }

 private:
  struct Drawn {
    Line line;
    std::string look, words;
  };

  /// Lines 1, 10, 100 ... m apart.
  template <typename OnPage>
  [[nodiscard]] static std::string grid(const Vector2& low, const Vector2& high, const OnPage& on_page) {
    const double step = std::pow(10.0, std::max(0.0, std::ceil(std::log10((high - low).maxCoeff() / 20.0))));
    std::string svg;
    for (int axis = 0; axis < 2; ++axis) {
      for (double x = step * std::ceil(low[axis] / step) + 0.0; x <= high[axis]; x += step) {
        Vector2 from = low, to = high;
        from[axis] = to[axis] = x;
        const Vector2 a = on_page(from), b = on_page(to);
        svg += text_of("<path stroke='#ddd' d='M%.1f %.1fL%.1f %.1f'/>", a.x(), a.y(), b.x(), b.y());
        svg += text_of("<text x='%.1f' y='%.1f' fill='#666' text-anchor='%s'>%.0f m</text>",
                       axis == 0 ? a.x() : a.x() - 6.0, axis == 0 ? a.y() + 18.0 : a.y() + 5.0,
                       axis == 0 ? "middle" : "end", x);
      }
    }
    return svg;
  }

  Vector3 right_W_, forward_W_;
  Vector2 low_ = Vector2::Constant(1e9), high_ = Vector2::Constant(-1e9);
  std::vector<Drawn> lines_;
};

ResultJson path_picture(const std::vector<RangeTrack>& tracks, const Vector3& up_W) {
  TopView view(up_W);
  const auto line = [&](const RangeTrack& track, Vector3 RangeTrack::Place::*p) {
    TopView::Line points;
    for (std::size_t i = 0; i < track.places.size(); i += stride_of(track))
      points.push_back(view.place(track.places[i].*p));
    return points;
  };
  for (const std::size_t i : {std::size_t(1), std::size_t(3)}) {
    view.add(line(tracks[i], &RangeTrack::Place::p_W), text_of("stroke='%s' stroke-width='1.6'", looks[i].colour),
             looks[i].words);
  }
  view.add(line(tracks[3], &RangeTrack::Place::true_W), "stroke='#111' stroke-width='1.2' stroke-dasharray='5 3'",
           "truth");
  return {{"title", "The path from above"},
          {"svg", view.svg()},
          {"caption",
           "A gate without states for biases turns good ranges away when they are biased, and trusts "
           "those that happen to fit."}};
}

ResultJson table(const std::vector<RangeTrack>& tracks) {
  ResultJson json = {{"label", "The four variants"},
                     {"columns",
                      {{{"name", "Filter has"}, {"text", true}},
                       {{"name", "Position RMS"}, {"unit", "m"}},
                       {{"name", "peak"}, {"unit", "m"}},
                       {{"name", "Horizontal RMS"}, {"unit", "m"}},
                       {{"name", "Height RMS"}, {"unit", "m"}},
                       {{"name", "Angle RMS"}, {"unit", "deg"}},
                       {{"name", "Ranges turned away"}, {"unit", "%"}}}},
                     {"rows", ResultJson::array()}};
  for (std::size_t i = 0; i < tracks.size(); ++i) {
    const RangeRow& row = tracks[i].row;
    json["rows"].push_back({looks[i].words, to_tenth_of_mm(row.position.rms()), to_tenth_of_mm(row.position.peak()),
                            to_tenth_of_mm(row.horizontal.rms()), to_tenth_of_mm(row.height.rms()),
                            to_tenth_of_mm(degrees_per_rad * row.angle.rms()),
                            to_tenth_of_mm(100.0 * static_cast<double>(row.gated) / static_cast<double>(row.ranges))});
  }
  return json;
}

}  // namespace

ResultJson range_page(const std::vector<RangeTrack>& tracks, const Vector3& up_W, const std::string& motion,
                      const std::string& command) {
  ResultJson page;
  page["eyebrow"] = "tracking by ranges";
  page["title"] = text_of("Range by range, the track is %.2f m off (RMS)", tracks.back().row.position.rms());
  page["paragraphs"] = {
      "A body measures its distance to one anchor after another, many times a second, and feels its own "
      "turning and acceleration. Each distance alone corrects the filter. Distances by radio are too long or too short "
      "by "
      "something that each anchor keeps (its bias), and some are much too long, for the direct way was blocked.",
      "The same filter, with the same settings, four times: with and without states that learn the biases, with and "
      "without a gate that turns away what is too unlikely. Recording: " +
          motion + "."};
  page["table"] = table(tracks);
  page["charts"] = ResultJson::array({error_chart(tracks), height_chart(tracks, up_W)});
  page["pictures"] = ResultJson::array({path_picture(tracks, up_W)});
  page["command"] = command;
  return {{"page", page}};
}

}  // namespace swimlab
