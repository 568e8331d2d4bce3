#include "lens_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <iterator>
#include <map>
#include <optional>
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
    const double whole_width = std::max(width_ + 2.0 * margin, 880.0);
    left_ = (whole_width - width_) / 2.0;
    svg_ = text_of(
        "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 %.0f %.0f' font-family='sans-serif' font-size='13'>\n"
        "<rect width='100%%' height='100%%' fill='white'/>\n"
        "<rect x='%.1f' y='%.1f' width='%.1f' height='%.1f' fill='black'/>\n",
        whole_width, height_ + heading + margin, left_, heading, width_, height_);
    svg_ += text_of("<text x='%.1f' y='27' font-size='18' fill='#111'>", margin) + escaped(title) + "</text>\n";
    svg_ += text_of("<text x='%.1f' y='48' fill='#555'>", margin) + escaped(subtitle) + "</text>\n";
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
  void add_lines(const std::vector<std::vector<Vector2>>& lines, const std::string& style) {
    svg_ += "<path fill='none' " + style + " d='";
    for (const std::vector<Vector2>& line : lines) svg_ += path_of(line);
    svg_ += "'/>\n";
  }
  /// In steps of a tenth of a pixel; points nearer than a pixel to the one before are left out, but for a line's last.
  [[nodiscard]] std::string path_of(const std::vector<Vector2>& line) const {
    std::string path;
    long x = 0, y = 0;
    for (std::size_t i = 0; i < line.size(); ++i) {
      const Vector2 p = place(line[i]);
      const long dx = std::lround(10.0 * p.x()) - x, dy = std::lround(10.0 * p.y()) - y;
      if (i > 0 && i + 1 < line.size() && dx * dx + dy * dy < 100) continue;
      const double step_x = static_cast<double>(dx) / 10.0, step_y = static_cast<double>(dy) / 10.0;
      path += text_of("%c%g %g", i == 0 ? 'M' : 'l', step_x, step_y);
      x += dx;
      y += dy;
    }
    return path;
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

/// A point of the mesh: on the panel, 0 to 1, and the tangent that a colour shows there.
struct MeshPoint {
  Vector2 panel, tangent;
};
MeshPoint between(const MeshPoint& a, const MeshPoint& b, double t) {
  return {a.panel + t * (b.panel - a.panel), a.tangent + t * (b.tangent - a.tangent)};
}

/// Where a point of the mesh is shown.
using Placing = std::function<Vector2(const MeshPoint&, Color)>;
using Line = std::vector<Vector2>;

MeshPoint mesh_point(const PredistortionVertex& v, std::size_t c) {
  return {Vector2(static_cast<double>(v.panel_x), static_cast<double>(v.panel_y)),
          Vector2(static_cast<double>(v.tangent[c][0]), static_cast<double>(v.tangent[c][1]))};
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

using MeshEdge = std::pair<std::uint32_t, std::uint32_t>;

MeshEdge sorted(const MeshEdge& edge) {
  return std::minmax(edge.first, edge.second);
}

/// The edge after corner i of the list of triangles, as it runs round its triangle.
MeshEdge edge_after(const PredistortionMesh& mesh, std::size_t i) {
  return {mesh.triangles[i], mesh.triangles[i % 3 == 2 ? i - 2 : i + 1]};
}

/// The pieces of lines that triangles hold, joined where they meet on the mesh's edges.
class Contour {
 public:
  void add(const std::array<MeshEdge, 2>& edges, const std::array<MeshPoint, 2>& points) {
    for (const MeshEdge& edge : edges) at_edge_.emplace(edge, pieces_.size());
    pieces_.push_back({edges, points, false});
  }
  [[nodiscard]] std::vector<std::vector<MeshPoint>> lines() && {
    std::vector<std::vector<MeshPoint>> lines;
    for (const bool closed : {false, true}) {  // first the lines that begin at the mesh's border
      for (std::size_t i = 0; i < pieces_.size(); ++i) {
        for (std::size_t end = 0; end < 2; ++end) {
          if (pieces_[i].used || (!closed && at_edge_.count(pieces_[i].edges[end]) > 1)) continue;
          lines.push_back(line_from(i, end));
        }
      }
    }
    return lines;
  }

 private:
  struct Piece {
    std::array<MeshEdge, 2> edges;
    std::array<MeshPoint, 2> points;
    bool used;
  };

  std::vector<MeshPoint> line_from(std::size_t i, std::size_t end) {
    std::vector<MeshPoint> line{pieces_[i].points[end]};
    while (!pieces_[i].used) {
      pieces_[i].used = true;
      line.push_back(pieces_[i].points[1 - end]);
      const MeshEdge edge = pieces_[i].edges[1 - end];
      const auto [first, last] = at_edge_.equal_range(edge);
      for (auto next = first; next != last; ++next) {
        if (pieces_[next->second].used) continue;
        i = next->second;
        end = pieces_[i].edges[0] == edge ? 0 : 1;
        break;
      }
    }
    return line;
  }

  std::vector<Piece> pieces_;
  std::multimap<MeshEdge, std::size_t> at_edge_;
};

/// Where the mesh's tangents along `axis` are `value`.
std::vector<std::vector<MeshPoint>> contour(const PredistortionMesh& mesh, std::size_t colour, std::size_t axis,
                                            double value) {
  Contour contour;
  for (std::size_t t = 0; t < mesh.triangles.size(); t += 3) {
    std::array<MeshEdge, 2> edges;
    std::array<MeshPoint, 2> points;
    std::size_t count = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      const MeshEdge edge = sorted(edge_after(mesh, t + k));
      const double a = static_cast<double>(mesh.vertices[edge.first].tangent[colour][axis]) - value;
      const double b = static_cast<double>(mesh.vertices[edge.second].tangent[colour][axis]) - value;
      if ((a < 0.0) == (b < 0.0)) continue;
      edges[count] = edge;
      points[count++] = between(mesh_point(mesh.vertices[edge.first], colour),
                                mesh_point(mesh.vertices[edge.second], colour), a / (a - b));
    }
    if (count == 2) contour.add(edges, points);
  }
  return std::move(contour).lines();
}

/// The mesh's outline as closed rings of vertices.
std::vector<std::vector<std::uint32_t>> outline(const PredistortionMesh& mesh) {
  std::set<MeshEdge> edges;
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i) {
    const auto [a, b] = edge_after(mesh, i);
    if (edges.erase({b, a}) == 0) edges.insert({a, b});
  }
  std::unordered_multimap<std::uint32_t, std::uint32_t> next;  // several where rings touch
  for (const auto& [a, b] : edges) next.emplace(a, b);
  std::vector<std::vector<std::uint32_t>> rings;
  while (!next.empty()) {
    std::vector<std::uint32_t>& ring = rings.emplace_back();
    for (auto at = next.begin(); at != next.end();) {
      ring.push_back(at->first);
      const std::uint32_t to = at->second;
      next.erase(at);
      at = next.find(to);
    }
  }
  return rings;
}

/// The colours to draw.
std::vector<Color> colors_of(const PredistortionMesh& mesh) {
  return mesh.per_color ? std::vector{Color::red, Color::green, Color::blue} : std::vector{Color::green};
}

/// What is shown, by colours that are told apart or by green for all.
void add_shown_area(Canvas& canvas, const LensSubject& s, const std::vector<Color>& colors, const Placing& placing) {
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
void add_grid(Canvas& canvas, const LensSubject& s, const FieldTangents& field, const Placing& placing) {
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
void add_uncorrected_grid(Canvas& canvas, const EyeModel& eye, const FieldTangents& field) {
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
  const Placing placing = [&](const MeshPoint& p, Color) { return pixel_of(s.eye, p.panel); };
  add_shown_area(canvas, s, {Color::green}, placing);
  add_grid(canvas, s, field, placing);
  canvas.add_ticks(pixel_ticks(s.eye.resolution.width), pixel_ticks(s.eye.resolution.height));
  return std::move(canvas).finished();
}

std::string seen_picture(const LensSubject& s) {
  const FieldTangents field = shown_field(s.mesh).value();
  Canvas canvas(field, title_of(s, "as the eye sees it"),
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

namespace {

/// Edges that are too short to be told apart, as brightness: the share of each cell that their lines would cover.
void add_shading(Canvas& canvas, const std::vector<Line>& edges, double line_width) {
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

/// All edges, drawn with few breaks.
std::vector<std::vector<std::uint32_t>> trails(std::set<MeshEdge> edges, std::size_t vertices) {
  std::vector<std::vector<std::uint32_t>> neighbours(vertices), trails;
  for (const auto& [a, b] : edges) {
    neighbours[a].push_back(b);
    neighbours[b].push_back(a);
  }
  while (!edges.empty()) {
    std::vector<std::uint32_t>& trail = trails.emplace_back(1, edges.begin()->first);
    for (std::uint32_t at = trail.front(); !neighbours[at].empty();) {
      const std::uint32_t next = neighbours[at].back();
      neighbours[at].pop_back();
      if (edges.erase(sorted({at, next})) == 0) continue;
      trail.push_back(next);
      at = next;
    }
  }
  return trails;
}

}  // namespace

std::string mesh_picture(const LensSubject& s) {
  std::set<MeshEdge> edges;
  for (std::size_t i = 0; i < s.mesh.triangles.size(); ++i) edges.insert(sorted(edge_after(s.mesh, i)));
  constexpr std::size_t most_lines = 100'000;
  const bool is_shaded = edges.size() > most_lines;
  Canvas canvas(
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
