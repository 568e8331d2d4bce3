#include "lens_canvas.hpp"

#include <algorithm>
#include <cmath>

namespace swimlab {

using namespace holdfast;

namespace {

constexpr double margin = 56.0, heading = 64.0, longest_side = 880.0;

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

}  // namespace

LensCanvas::LensCanvas(const FieldTangents& shown, const std::string& title, const std::string& subtitle)
    : shown_(shown) {
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

Vector2 LensCanvas::place(const Vector2& p) const {
  return {left_ + (p.x() - shown_.left) / (shown_.right - shown_.left) * width_,
          heading + (shown_.up - p.y()) / (shown_.up - shown_.down) * height_};
}

bool LensCanvas::holds(const Vector2& p) const {
  const Vector2 at = place(p);
  return at.x() >= left_ - 0.5 && at.x() <= left_ + width_ + 0.5 && at.y() >= heading - 0.5 &&
         at.y() <= heading + height_ + 0.5;
}

void LensCanvas::add_lines(const std::vector<Line>& lines, const std::string& style) {
  svg_ += "<path fill='none' " + style + " d='";
  for (const Line& line : lines) svg_ += path_of(line);
  svg_ += "'/>\n";
}

std::string LensCanvas::path_of(const Line& line) const {
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

void LensCanvas::add_ticks(const Ticks& x, const Ticks& y) {
  for (const auto& [value, label] : x) add_label(Vector2(value, shown_.down), label, "middle", 0.0, 18.0);
  for (const auto& [value, label] : y) add_label(Vector2(shown_.left, value), label, "end", -7.0, 4.5);
}

void LensCanvas::add_label(const Vector2& at, const std::string& text, const char* anchor, double dx, double dy) {
  const Vector2 p = place(at);
  svg_ += text_of("<text x='%.1f' y='%.1f' text-anchor='%s' fill='#444'>%s</text>\n", p.x() + dx, p.y() + dy, anchor,
                  text.c_str());
}

}  // namespace swimlab
