/// An SVG picture of a rectangle of any unit, Y up, shown as large as fits: what the pictures of a lens are drawn on.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include <holdfast/geometry/types.hpp>
#include <holdfast/optics/tangents.hpp>

#include "text.hpp"

namespace swimlab {

class LensCanvas {
 public:
  using Line = std::vector<holdfast::Vector2>;
  /// Where, and its label.
  using Ticks = std::vector<std::pair<double, std::string>>;

  LensCanvas(const holdfast::FieldTangents& shown, const std::string& title, const std::string& subtitle);

  /// In pixels of the picture, Y down.
  [[nodiscard]] holdfast::Vector2 place(const holdfast::Vector2& p) const;
  [[nodiscard]] bool holds(const holdfast::Vector2& p) const;

  void add(const std::string& element) { svg_ += element; }
  void add_lines(const std::vector<Line>& lines, const std::string& style);
  /// In steps of a tenth of a pixel; points nearer than a pixel to the one before are left out, but for a line's last.
  [[nodiscard]] std::string path_of(const Line& line) const;
  /// Ticks below and left of the picture, where a line of the grid leaves it.
  void add_ticks(const Ticks& x, const Ticks& y);
  [[nodiscard]] std::string finished() && { return std::move(svg_) + "</svg>\n"; }

 private:
  void add_label(const holdfast::Vector2& at, const std::string& text, const char* anchor, double dx, double dy);

  holdfast::FieldTangents shown_;
  double scale_ = 1.0, width_ = 0.0, height_ = 0.0, left_ = 0.0;
  std::string svg_;
};

}  // namespace swimlab
