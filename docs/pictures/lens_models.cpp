// Draws docs/pictures/lens_models.svg: how strongly real lenses distort, and where one polynomial's fit folds over.
//     g++ -std=c++20 -O1 -Iinclude -Itests -I/usr/include/eigen3 docs/pictures/lens_models.cpp -o /tmp/lens_models
//     /tmp/lens_models > docs/pictures/lens_models.svg
#include <array>
#include <cmath>
#include <cstdio>
#include <string>
#include <vector>

#include <holdfast/optics/optics.hpp>

#include "optics/published_lenses.hpp"

using namespace holdfast;

namespace {

struct Chart {
  double left, top, width, height, x_max, y_max;
  [[nodiscard]] double x(double value) const { return left + width * value / x_max; }
  [[nodiscard]] double y(double value) const { return top + height * (1.0 - value / y_max); }
};

void axes(const Chart& c, double x_step, double y_step, const char* x_name, const char* y_name, const char* title) {
  for (double v = 0.0; v <= c.x_max + 1e-9; v += x_step) {
    std::printf("<line x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", c.x(v), c.x(v), c.top,
                c.top + c.height);
    std::printf("<text x='%.1f' y='%.1f' text-anchor='middle' fill='#444'>%g</text>\n", c.x(v), c.top + c.height + 18,
                v);
  }
  for (double v = 0.0; v <= c.y_max + 1e-9; v += y_step) {
    std::printf("<line x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", c.left, c.left + c.width, c.y(v),
                c.y(v));
    std::printf("<text x='%.1f' y='%.1f' text-anchor='end' fill='#444'>%g</text>\n", c.left - 6, c.y(v) + 5, v);
  }
  std::printf("<text x='%.1f' y='%.1f' text-anchor='middle' fill='#444'>%s</text>\n", c.left + c.width / 2,
              c.top + c.height + 38, x_name);
  std::printf("<text x='%.1f' y='%.1f' fill='#444'>%s</text>\n", c.left - 30, c.top - 10, y_name);
  std::printf("<text x='%.1f' y='%.1f' text-anchor='end' fill='#000' font-weight='bold'>%s</text>\n", c.left + c.width,
              c.top - 10, title);
}

struct Strength {
  const char* name;
  Lens lens;
  const char* color;
};

/// How much farther out a point is seen than it lies on the panel, in percent of the slope at the centre.
void strengths(const Chart& c) {
  const std::vector<Strength> lenses{
      {"Flight Helmet", Lens(RadialLens{0.1933}, placed_at(0.504)), "#b00020"},
      {"Cardboard v1", PolynomialLens(std::array{0.441, 0.156}), "#c77700"},
      {"Cardboard v2", PolynomialLens(std::array{0.34, 0.55}), "#8a6d00"},
      {"Rift DK2", CatmullRomLens({test::dk2_knots, 1.0, {0.0, 0.0}}), "#1a4fb5"},
      {"Rift DK1, SDK 0.2", Lens(PolynomialLens(std::array{0.22, 0.24}), placed_at(0.913)), "#6a1b9a"},
      {"Rift DK1, SDK 0.4, nearest", CatmullRomLens({test::dk1_near_knots, std::sqrt(1.8), {0.0, 0.0}}), "#00695c"},
  };
  int row = 0;
  for (const Strength& s : lenses) {
    const double slope = s.lens.distort_jacobian(Vector2::Zero())(0, 0);
    std::printf("<polyline fill='none' stroke='%s' stroke-width='2' points='", s.color);
    for (double degree = 0.5; degree <= c.x_max; degree += 0.5) {
      const double seen = std::tan(degrees(degree).radians());
      const auto panel = s.lens.undistort(Vector2(seen, 0.0));
      if (!panel) break;
      const double percent = 100.0 * (seen / (slope * panel->x()) - 1.0);
      if (percent > c.y_max) break;
      std::printf("%.1f,%.1f ", c.x(degree), c.y(percent));
    }
    std::printf("'/>\n<line x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f' stroke='%s' stroke-width='3'/>\n", c.left + 12,
                c.left + 36, c.top + 15.0 + 20 * row, c.top + 15.0 + 20 * row, s.color);
    std::printf("<text x='%.1f' y='%.1f' fill='%s'>%s</text>\n", c.left + 42, c.top + 20.0 + 20 * row, s.color, s.name);
    ++row;
  }
}

/// The HDK 1.1's polynomial, past its domain too.
void fold(const Chart& c) {
  const PowerSeries series(test::osvr_hdk_1_1);
  const PowerSeriesLens lens(test::osvr_hdk_1_1);
  const auto polyline = [&](double from, double to, const char* style) {
    std::printf("<polyline fill='none' stroke-width='2' %s points='", style);
    for (int i = 0; i <= 200; ++i) {
      const double r = from + (to - from) * i / 200;
      const double seen = series.at(r).seen;
      if (seen >= 0.0) std::printf("%.1f,%.1f ", c.x(r), c.y(seen));
    }
    std::printf("'/>\n");
  };
  const double end = lens.valid_radius();
  polyline(0.0, end, "stroke='#1a4fb5'");
  polyline(end, 1.45, "stroke='#b00020' stroke-dasharray='5 4'");
  const double corner = std::hypot(0.5, 0.5);
  std::printf("<circle cx='%.1f' cy='%.1f' r='5' fill='#b00020'/>\n", c.x(end), c.y(lens.valid_image_radius()));
  std::printf("<text x='%.1f' y='%.1f' text-anchor='end' fill='#b00020'>folds at %.3f: the domain's end</text>\n",
              c.x(end) - 12, c.y(lens.valid_image_radius()) + 5, end);
  std::printf("<line x1='%.1f' x2='%.1f' y1='%.1f' y2='%.1f' stroke='#666' stroke-dasharray='2 3'/>\n", c.x(corner),
              c.x(corner), c.top, c.top + c.height);
  std::printf("<text x='%.1f' y='%.1f' text-anchor='end' fill='#666'>the panel's corner</text>\n", c.x(corner) - 6,
              c.top + 200);
}

}  // namespace

int main() {
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 860 400' font-family='sans-serif' font-size='13'>\n"
      "<rect width='860' height='400' fill='white'/>\n");
  const Chart strength{60, 45, 340, 290, 60, 100};
  axes(strength, 10, 20, "seen at (degrees from the axis)", "%", "farther out than without distortion");
  strengths(strength);
  const Chart folding{480, 45, 340, 290, 1.5, 8};
  axes(folding, 0.25, 1, "radius on the panel", "seen radius", "OSVR HDK 1.1's polynomial");
  fold(folding);
  std::printf("</svg>\n");
}
