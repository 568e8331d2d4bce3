#include "lens_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <set>
#include <unordered_map>
#include <utility>
#include <vector>

#include <holdfast/io/results.hpp>
#include <holdfast/optics/mesh_overfill.hpp>

namespace swimlab {

using namespace holdfast;

namespace {

constexpr double margin = 56.0, heading = 64.0, longest_side = 880.0;
constexpr const char* line_colours[] = {"#ff5a4d", "#4dff6a", "#5a7dff"};  // add up to white
constexpr const char* only_colour = "#e8f1ff";

std::string text_of(const char* format, auto... values) {
  char text[512];
  std::snprintf(text, sizeof text, format, values...);
  return text;
}

std::string escaped(const std::string& plain) {
  std::string out;
  for (const char c : plain) {
    if (c == '&') {
      out += "&amp;";
    } else if (c == '<') {
      out += "&lt;";
    } else if (static_cast<unsigned char>(c) >= ' ') {
      out += c;
    }
  }
  return out;
}

/// A rectangle of any unit, Y up, shown as large as fits.
class Canvas {
 public:
  Canvas(const FieldTangents& shown, const std::string& title, const std::string& subtitle) : shown_(shown) {
    const double w = std::abs(shown.right - shown.left), h = std::abs(shown.up - shown.down);
    scale_ = longest_side / std::max(w, h);
    width_ = w * scale_;
    height_ = h * scale_;
    const double whole_width = std::max(width_ + 2.0 * margin, 720.0);
    left_ = (whole_width - width_) / 2.0;
    svg_ = text_of(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' font-family='sans-serif' font-size='13'>\n"
        "<rect width='100%%' height='100%%' fill='white'/>\n"
        "<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='black'/>\n",
        whole_width, height_ + heading + margin, left_, heading, width_, height_);
    svg_ += text_of("<text x='%.1f' y='27' font-size='18' fill='#111'>", left_) + escaped(title) + "</text>\n";
    svg_ += text_of("<text x='%.1f' y='48' fill='#555'>", left_) + escaped(subtitle) + "</text>\n";
  }

  [[nodiscard]] Vector2 place(const Vector2& p) const {
    return {left_ + (p.x() - shown_.left) / (shown_.right - shown_.left) * width_,
            heading + (shown_.up - p.y()) / (shown_.up - shown_.down) * height_};
  }
  [[nodiscard]] bool holds(const Vector2& p) const {
    const Vector2 at = place(p);
    return at.x() >= left_ - 0.5 && at.x() <= left_ + width_ + 0.5 && at.y() >= heading - 0.5 &&
           at.y() <= heading + height_ + 0.5;
  }

  void add(const std::string& element) { svg_ += element; }
  /// Lines from each even to each odd point.
  void add_segments(const std::vector<Vector2>& ends, const std::string& style) {
    svg_ += "<path fill='none' " + style + " d='";
    for (std::size_t i = 0; i + 1 < ends.size(); i += 2) {
      const Vector2 a = place(ends[i]), b = place(ends[i + 1]);
      // A line that goes on is one line, for its dashes.
      if (i == 0 || ends[i] != ends[i - 1]) svg_ += text_of("M%.1f %.1f", a.x(), a.y());
      svg_ += text_of("L%.1f %.1f", b.x(), b.y());
    }
    svg_ += "'/>\n";
  }
  void add_polygon(const std::vector<Vector2>& corners, std::string& path) const {
    for (std::size_t i = 0; i < corners.size(); ++i) {
      const Vector2 p = place(corners[i]);
      path += text_of("%c%.1f %.1f", i == 0 ? 'M' : 'L', p.x(), p.y());
    }
    path += 'Z';
  }
  void add_label(const Vector2& at, const std::string& text, const char* anchor, double dx, double dy,
                 const char* colour) {
    const Vector2 p = place(at);
    svg_ += text_of("<text x='%.1f' y='%.1f' text-anchor='%s' fill='%s'>%s</text>\n", p.x() + dx, p.y() + dy, anchor,
                    colour, text.c_str());
  }
  /// Ticks below and left of the picture, where a line of the grid leaves it.
  void add_ticks(const std::vector<std::pair<double, std::string>>& x,
                 const std::vector<std::pair<double, std::string>>& y) {
    for (const auto& [value, label] : x) add_label(Vector2(value, shown_.down), label, "middle", 0.0, 18.0, "#444");
    for (const auto& [value, label] : y) add_label(Vector2(shown_.left, value), label, "end", -7.0, 4.5, "#444");
  }
  [[nodiscard]] std::string finished() && { return std::move(svg_) + "</svg>\n"; }

 private:
  FieldTangents shown_;
  double scale_ = 1.0, width_ = 0.0, height_ = 0.0, left_ = 0.0;
  std::string svg_;
};

/// From a panel point, 0 to 1, and a colour to where it is shown; nothing where the lens has no domain.
using Placing = std::function<std::optional<Vector2>(const Vector2&, Color)>;

Vector2 panel_point(const PredistortionVertex& v) {
  return {static_cast<double>(v.panel_x), static_cast<double>(v.panel_y)};
}

Vector2 pixel_of(const EyeModel& eye, const Vector2& panel) {
  return {panel.x() * eye.resolution.width, panel.y() * eye.resolution.height};
}

/// Tangents of a grid's lines, every 10 degrees, or 5 when the field is small, within the field; mirrored fields too.
struct GridLine {
  double tangent;
  int degrees;
};
std::vector<GridLine> grid_lines(double from, double to) {
  const auto [low, high] = std::minmax({from, to});
  const double whole = (std::atan(high) - std::atan(low)) * degrees_per_rad;
  const int step = whole < 45.0 ? 5 : 10;
  std::vector<GridLine> lines;
  for (int d = -80; d <= 80; d += step) {
    const double t = tan(degrees(d));
    if (t >= low && t <= high) lines.push_back({t, d});
  }
  return lines;
}

std::string degree_label(int d) {
  return text_of("%d\u00b0", d);
}

/// Where the mesh's tangents along `axis` are `value`, as pairs of panel points.
std::vector<Vector2> contour(const PredistortionMesh& mesh, std::size_t colour, std::size_t axis, double value) {
  std::vector<Vector2> ends;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    std::array<Vector2, 3> met;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const PredistortionVertex& a = mesh.vertices[mesh.triangles[t + k]];
      const PredistortionVertex& b = mesh.vertices[mesh.triangles[t + (k + 1) % 3]];
      const double da = static_cast<double>(a.tangent[colour][axis]) - value;
      const double db = static_cast<double>(b.tangent[colour][axis]) - value;
      if ((da < 0.0) == (db < 0.0)) continue;
      met[count++] = panel_point(a) + da / (da - db) * (panel_point(b) - panel_point(a));
    }
    if (count == 2) ends.insert(ends.end(), {met[0], met[1]});
  }
  return ends;
}

/// The mesh's outline as closed rings of panel points.
std::vector<std::vector<Vector2>> outline(const PredistortionMesh& mesh) {
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const std::uint32_t a = mesh.triangles[i], b = mesh.triangles[i % 3 == 2 ? i - 2 : i + 1];
    if (edges.erase({b, a}) == 0) edges.insert({a, b});
  }
  std::unordered_map<std::uint32_t, std::uint32_t> next;
  for (const auto& [a, b] : edges) next.emplace(a, b);
  std::vector<std::vector<Vector2>> rings;
  while (!next.empty()) {
    std::vector<Vector2>& ring = rings.emplace_back();
    for (auto at = next.begin(); at != next.end();) {
      ring.push_back(panel_point(mesh.vertices[at->first]));
      const std::uint32_t to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  return rings;
}

void add_shown_area(Canvas& canvas, const LensSubject& s, const Placing& placing) {
  std::string path;
  for (const std::vector<Vector2>& ring : outline(s.mesh)) {
    std::vector<Vector2> corners;
    for (std::size_t i = 0; i < ring.size(); ++i) {
      const Vector2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
      for (int k = 0; k < 8; ++k) {
        if (const auto p = placing(Vector2(a + k / 8.0 * (b - a)), Color::green)) corners.push_back(*p);
      }
    }
    canvas.add_polygon(corners, path);
  }
  canvas.add("<path fill='#1b232d' fill-rule='evenodd' stroke='#51647a' stroke-width='1' d='" + path + "'/>\n");
}

/// The grid through the mesh, in each colour.
void add_grid(Canvas& canvas, const LensSubject& s, const FieldTangents& field, const Placing& placing) {
  const bool colours = s.mesh.per_color;
  canvas.add("<g style='isolation:isolate'>\n");
  for (std::size_t c = colours ? 0 : 1; c < (colours ? 3u : 2u); ++c) {
    std::vector<Vector2> ends;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const auto lines = axis == 0 ? grid_lines(field.left, field.right) : grid_lines(field.down, field.up);
      for (const GridLine& line : lines) {
        const std::vector<Vector2> met = contour(s.mesh, c, axis, line.tangent);
        for (std::size_t i = 0; i + 1 < met.size(); i += 2) {
          const auto a = placing(met[i], static_cast<Color>(c)), b = placing(met[i + 1], static_cast<Color>(c));
          if (a && b) ends.insert(ends.end(), {*a, *b});
        }
      }
    }
    canvas.add_segments(
        ends, std::string("stroke-width='1.5' stroke-linecap='round' style='mix-blend-mode:screen' stroke='") +
                  (colours ? line_colours[c] : only_colour) + "'");
  }
  canvas.add("</g>\n");
}

/// The grid as it is seen when the application draws it straight.
void add_uncorrected_grid(Canvas& canvas, const EyeModel& eye, const FieldTangents& field) {
  const FieldTangents panel = panel_tangents(eye);
  std::vector<Vector2> ends;
  constexpr int steps = 200;
  for (int axis = 0; axis < 2; ++axis) {
    const auto lines = axis == 0 ? grid_lines(field.left, field.right) : grid_lines(field.down, field.up);
    const double from = axis == 0 ? panel.down : panel.left, to = axis == 0 ? panel.up : panel.right;
    const auto [low, high] = axis == 0 ? std::minmax({panel.left, panel.right}) : std::minmax({panel.down, panel.up});
    for (const GridLine& line : lines) {
      if (line.tangent < low || line.tangent > high) continue;
      std::optional<Vector2> last;
      for (int i = 0; i <= steps; ++i) {
        const double along = from + (to - from) * i / steps;
        const auto seen = eye.lens.distort(axis == 0 ? Vector2(line.tangent, along) : Vector2(along, line.tangent));
        if (seen && last && canvas.holds(*seen) && canvas.holds(*last)) ends.insert(ends.end(), {*last, *seen});
        last = seen;
      }
    }
  }
  canvas.add_segments(ends, "stroke='#71808f' stroke-width='1' stroke-dasharray='5 4' stroke-opacity='0.7'");
}

std::string title_of(const LensSubject& s, const char* what) {
  return s.hmd + ", " + std::string(io::name_of(s.eye.side)) + " eye: " + what;
}

std::vector<std::pair<double, std::string>> pixel_ticks(int count) {
  const int step = count > 1600 ? 400 : count > 700 ? 200 : 100;
  std::vector<std::pair<double, std::string>> ticks;
  for (int px = 0; px <= count; px += step) ticks.emplace_back(px, std::to_string(px) + (px == 0 ? " px" : ""));
  return ticks;
}

FieldTangents panel_in_pixels(const EyeModel& eye) {
  return {0.0, static_cast<double>(eye.resolution.width), 0.0, static_cast<double>(eye.resolution.height)};
}

}  // namespace

std::string drawn_picture(const LensSubject& s) {
  const FieldTangents field = shown_field(s.mesh).value();
  Canvas canvas(panel_in_pixels(s.eye), title_of(s, "as drawn on the panel"),
                std::string("A grid of equal angles, predistorted by the mesh") +
                    (s.mesh.per_color ? " for red, green and blue" : "") + ". Black: nothing is drawn there.");
  const Placing placing = [&](const Vector2& p, Color) { return std::optional(pixel_of(s.eye, p)); };
  add_shown_area(canvas, s, placing);
  add_grid(canvas, s, field, placing);
  canvas.add_ticks(pixel_ticks(s.eye.resolution.width), pixel_ticks(s.eye.resolution.height));
  return std::move(canvas).finished();
}

std::string seen_picture(const LensSubject& s) {
  const FieldTangents field = shown_field(s.mesh).value();
  Canvas canvas(field, title_of(s, "as the eye sees it"),
                "The same picture through the lens: straight lines. Dashed: the grid without correction.");
  const Placing placing = [&](const Vector2& p, Color color) {
    return s.eye.lens_of(color).distort(tangent_of_pixel(s.eye, pixel_of(s.eye, p)));
  };
  add_shown_area(canvas, s, placing);
  add_uncorrected_grid(canvas, s.eye, field);
  add_grid(canvas, s, field, placing);
  std::vector<std::pair<double, std::string>> x, y;
  const auto add = [](std::vector<std::pair<double, std::string>>& ticks, const std::vector<GridLine>& lines,
                      double whole) {
    double last = -1e9;
    for (const GridLine& line : lines) {
      if (line.tangent - last < 0.035 * whole) continue;  // too near for a label of its own
      ticks.emplace_back(line.tangent, degree_label(line.degrees));
      last = line.tangent;
    }
  };
  const double whole = std::max(field.right - field.left, field.up - field.down);
  add(x, grid_lines(field.left, field.right), whole);
  add(y, grid_lines(field.down, field.up), whole);
  canvas.add_ticks(x, y);
  return std::move(canvas).finished();
}

std::string mesh_picture(const LensSubject& s) {
  Canvas canvas(panel_in_pixels(s.eye), title_of(s, "the predistortion mesh"),
                text_of("%zu vertices, %zu triangles, at most %.3g px from the exact lens in the source picture",
                        s.mesh.vertices.size(), s.mesh.triangle_count(), s.mesh.max_error_px));
  const Placing placing = [&](const Vector2& p, Color) { return std::optional(pixel_of(s.eye, p)); };
  add_shown_area(canvas, s, placing);
  std::set<std::pair<std::uint32_t, std::uint32_t>> edges;
  for (std::size_t i = 0; i < s.mesh.triangles.size(); ++i) {
    const std::uint32_t a = s.mesh.triangles[i], b = s.mesh.triangles[i % 3 == 2 ? i - 2 : i + 1];
    edges.insert(std::minmax(a, b));
  }
  std::vector<Vector2> ends;
  for (const auto& [a, b] : edges) {
    for (const std::uint32_t v : {a, b}) ends.push_back(pixel_of(s.eye, panel_point(s.mesh.vertices[v])));
  }
  // Thinner where the mesh is finer, so that its density shows as brightness.
  const double width = s.mesh.triangle_count() > 8000 ? 0.35 : s.mesh.triangle_count() > 1500 ? 0.6 : 1.0;
  canvas.add_segments(ends, text_of("stroke='#8fd0ff' stroke-width='%.2f'", width));
  canvas.add_ticks(pixel_ticks(s.eye.resolution.width), pixel_ticks(s.eye.resolution.height));
  return std::move(canvas).finished();
}

}  // namespace swimlab
