#include "lens_pictures.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
#include <set>
#include <utility>
#include <vector>

#include <holdfast/optics/mesh_overfill.hpp>
#include <holdfast/registration/metrics.hpp>

#include "lens_canvas.hpp"
#include "mesh_lines.hpp"

namespace swimlab {

using namespace holdfast;

namespace {

constexpr const char* line_colours[] = {"#ff5a4d", "#4dff6a", "#5a7dff"};  // add up to white
constexpr const char* only_colour = "#e8f1ff";

/// Where a point of the mesh is shown.
using Placing = std::function<Vector2(const MeshPoint&, Color)>;
using Line = LensCanvas::Line;
using Ticks = LensCanvas::Ticks;

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

/// The colours to draw.
std::vector<Color> colors_of(const PredistortionMesh& mesh) {
  return mesh.per_color ? std::vector{Color::red, Color::green, Color::blue} : std::vector{Color::green};
}

/// What is shown, by colours that are told apart or by green for all.
void add_shown_area(LensCanvas& canvas, const LensSubject& s, const std::vector<Color>& colors,
                    const Placing& placing) {
  std::string outlines;
  for (const Color color : colors) {
    const auto c = static_cast<std::size_t>(color);
    std::string path;
    for (const std::vector<std::uint32_t>& ring : outline(s.mesh)) {
      Line corners;
      for (std::size_t i = 0; i < ring.size(); ++i) {
        const MeshPoint a = mesh_point(s.mesh.vertices[ring[i]], c);
        const MeshPoint b = mesh_point(s.mesh.vertices[ring[(i + 1) % ring.size()]], c);
        for (int k = 0; k < 8; ++k) corners.push_back(placing(between(a, b, k / 8.0), color));
      }
      path += canvas.path_of(corners) + 'Z';
    }
    canvas.add("<path fill='#1b232d' fill-rule='evenodd' d='" + path + "'/>\n");
    outlines += std::string("<path fill='none' stroke-width='1' stroke-opacity='0.6' stroke='") +
                (colors.size() > 1 ? line_colours[c] : "#51647a") + "' d='" + path + "'/>\n";
  }
  canvas.add(outlines);
}

/// The grid through the mesh, in each colour.
void add_grid(LensCanvas& canvas, const LensSubject& s, const FieldTangents& field, const Placing& placing) {
  canvas.add("<g style='isolation:isolate'>\n");
  for (const Color color : colors_of(s.mesh)) {
    const auto c = static_cast<std::size_t>(color);
    std::vector<Line> lines;
    for (std::size_t axis = 0; axis < 2; ++axis) {
      for (const GridLine& grid_line :
           axis == 0 ? grid_lines(field.left, field.right) : grid_lines(field.down, field.up)) {
        for (const std::vector<MeshPoint>& points : contour(s.mesh, c, axis, grid_line.tangent)) {
          Line& line = lines.emplace_back();
          for (const MeshPoint& p : points) line.push_back(placing(p, color));
        }
      }
    }
    canvas.add_lines(lines,
                     std::string("stroke-width='1.5' stroke-linecap='round' style='mix-blend-mode:screen' stroke='") +
                         (s.mesh.per_color ? line_colours[c] : only_colour) + "'");
  }
  canvas.add("</g>\n");
}

/// A path over [0, 1], where it can be seen: cut where `seen` has no answer, each piece up to that place.
std::vector<Line> seen_pieces(const std::function<std::optional<Vector2>(double)>& seen) {
  constexpr int steps = 200;
  std::vector<Line> pieces;
  const auto end_between = [&](double inside, double outside) {
    for (int i = 0; i < 30; ++i) {
      const double middle = (inside + outside) / 2.0;
      (seen(middle) ? inside : outside) = middle;
    }
    return *seen(inside);
  };
  bool on = false;
  for (int i = 0; i <= steps; ++i) {
    const double now = static_cast<double>(i) / steps, before = static_cast<double>(i - 1) / steps;
    const std::optional<Vector2> p = seen(now);
    if (p && !on) {
      pieces.emplace_back();
      if (i > 0) pieces.back().push_back(end_between(now, before));
    }
    if (p) pieces.back().push_back(*p);
    if (!p && on) pieces.back().push_back(end_between(before, now));
    on = p.has_value();
  }
  return pieces;
}

/// The grid as it is seen when the application draws it straight.
void add_uncorrected_grid(LensCanvas& canvas, const EyeModel& eye, const FieldTangents& field) {
  const FieldTangents panel = panel_tangents(eye);
  std::vector<Line> all;
  for (int axis = 0; axis < 2; ++axis) {
    const auto lines = axis == 0 ? grid_lines(field.left, field.right) : grid_lines(field.down, field.up);
    const double from = axis == 0 ? panel.down : panel.left, to = axis == 0 ? panel.up : panel.right;
    const auto [low, high] = axis == 0 ? std::minmax({panel.left, panel.right}) : std::minmax({panel.down, panel.up});
    for (const GridLine& line : lines) {
      if (line.tangent < low || line.tangent > high) continue;
      const auto seen = [&](double t) -> std::optional<Vector2> {
        const double along = from + (to - from) * t;
        const auto p = eye.lens.distort(axis == 0 ? Vector2(line.tangent, along) : Vector2(along, line.tangent));
        return p && canvas.holds(*p) ? p : std::nullopt;
      };
      for (Line& piece : seen_pieces(seen)) all.push_back(std::move(piece));
    }
  }
  canvas.add_lines(all, "stroke='#71808f' stroke-width='1' stroke-dasharray='5 4' stroke-opacity='0.7'");
}

std::string title_of(const LensSubject& s, const char* what) {
  return s.hmd + ", " + std::string(name_of(s.eye.side)) + " eye: " + what;
}

Ticks pixel_ticks(int count) {
  const int step = count > 1600 ? 400 : count > 700 ? 200 : 100;
  Ticks ticks;
  for (int px = 0; px <= count; px += step) ticks.emplace_back(px, std::to_string(px) + (px == 0 ? " px" : ""));
  return ticks;
}

FieldTangents panel_in_pixels(const EyeModel& eye) {
  return {0.0, static_cast<double>(eye.resolution.width), 0.0, static_cast<double>(eye.resolution.height)};
}

}  // namespace

std::string drawn_picture(const LensSubject& s) {
  const FieldTangents field = shown_field(s.mesh).value();
  LensCanvas canvas(panel_in_pixels(s.eye), title_of(s, "as drawn on the panel"),
                    std::string("A grid of equal angles, predistorted by the mesh") +
                        (s.mesh.per_color ? " for red, green and blue" : "") + ". Black: nothing is drawn there.");
  const Placing placing = [&](const MeshPoint& p, Color) { return pixel_of(s.eye, p.panel); };
  add_shown_area(canvas, s, {Color::green}, placing);
  add_grid(canvas, s, field, placing);
  canvas.add_ticks(pixel_ticks(s.eye.resolution.width), pixel_ticks(s.eye.resolution.height));
  return std::move(canvas).finished();
}

std::string seen_picture(const LensSubject& s) {
  const FieldTangents field = shown_field(s.mesh).value();
  LensCanvas canvas(field, title_of(s, "as the eye sees it"),
                    std::string("The same picture through the lens: straight lines.") +
                        (s.mesh.per_color ? " Its colours end at different places." : "") +
                        " Dashed: the grid without correction.");
  // Rounding may put a point of the border outside the lens: there the mesh itself says where it is seen.
  const Placing placing = [&](const MeshPoint& p, Color color) {
    return s.eye.lens_of(color).distort(tangent_of_pixel(s.eye, pixel_of(s.eye, p.panel))).value_or(p.tangent);
  };
  // On the panel the colours end together, and are seen to end apart.
  add_shown_area(canvas, s, colors_of(s.mesh), placing);
  add_uncorrected_grid(canvas, s.eye, field);
  add_grid(canvas, s, field, placing);
  Ticks x, y;
  const auto add = [](Ticks& ticks, const std::vector<GridLine>& lines, double whole) {
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

namespace {

/// Edges that are too short to be told apart, as brightness: the share of each cell that their lines would cover.
void add_shading(LensCanvas& canvas, const std::vector<Line>& edges, double line_width) {
  constexpr int cell = 8, levels = 16;
  std::map<std::pair<int, int>, double> length;  // row, column
  for (const Line& edge : edges) {
    const Vector2 a = canvas.place(edge[0]), b = canvas.place(edge[1]), middle = (a + b) / 2.0;
    length[{static_cast<int>(middle.y()) / cell, static_cast<int>(middle.x()) / cell}] += (b - a).norm();
  }
  const auto level = [&](double l) {
    return static_cast<int>(std::lround(levels * std::min(1.0, l * line_width / (cell * cell))));
  };
  canvas.add("<g fill='#8fd0ff' shape-rendering='crispEdges'>\n");
  for (auto at = length.begin(); at != length.end();) {
    auto [row, column] = at->first;
    const int shade = level(at->second), first = column;
    // Equal neighbours in a row are one rectangle.
    for (; at != length.end() && at->first == std::pair(row, column) && level(at->second) == shade; ++at) ++column;
    canvas.add(text_of("<path fill-opacity='%.2g' d='M%d %dh%dv%dh-%dz'/>\n", static_cast<double>(shade) / levels,
                       first * cell, row * cell, (column - first) * cell, cell, (column - first) * cell));
  }
  canvas.add("</g>\n");
}

}  // namespace

std::string mesh_picture(const LensSubject& s) {
  std::set<MeshEdge> edges = edges_of(s.mesh);
  constexpr std::size_t most_lines = 100'000;
  const bool is_shaded = edges.size() > most_lines;
  LensCanvas canvas(
      panel_in_pixels(s.eye), title_of(s, "the predistortion mesh"),
      text_of("%zu vertices, %zu triangles, at most %.3g px from the exact lens%s", s.mesh.vertices.size(),
              s.mesh.triangle_count(), s.mesh.max_error_px, is_shaded ? ". Short edges are drawn as brightness." : ""));
  const Placing placing = [&](const MeshPoint& p, Color) { return pixel_of(s.eye, p.panel); };
  add_shown_area(canvas, s, {Color::green}, placing);
  const auto pixel = [&](std::uint32_t v) { return pixel_of(s.eye, mesh_point(s.mesh.vertices[v], 1).panel); };
  std::vector<Line> fine;
  for (auto edge = edges.begin(); is_shaded && edge != edges.end();) {
    const Vector2 a = pixel(edge->first), b = pixel(edge->second);
    const bool is_short = (canvas.place(b) - canvas.place(a)).norm() < 10.0;
    if (is_short) fine.push_back({a, b});
    edge = is_short ? edges.erase(edge) : std::next(edge);
  }
  std::vector<Line> lines;
  for (const std::vector<std::uint32_t>& trail : trails(std::move(edges), s.mesh.vertices.size())) {
    Line& line = lines.emplace_back();
    for (const std::uint32_t v : trail) line.push_back(pixel(v));
  }
  // Thinner where the mesh is finer, so that its density shows as brightness.
  const double width = s.mesh.triangle_count() > 8000 ? 0.35 : s.mesh.triangle_count() > 1500 ? 0.6 : 1.0;
  if (is_shaded) add_shading(canvas, fine, width);
  canvas.add_lines(lines, text_of("stroke='#8fd0ff' stroke-width='%.2f'", width));
  canvas.add_ticks(pixel_ticks(s.eye.resolution.width), pixel_ticks(s.eye.resolution.height));
  return std::move(canvas).finished();
}

}  // namespace swimlab
