// Draws docs/pictures/lens_residual.svg: what is left of the Flight Helmet's distortion after each kind of correction.
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/lens_residual.cpp -o /tmp/lens_residual
//     /tmp/lens_residual > docs/pictures/lens_residual.svg
#include <cmath>
#include <cstdio>
#include <optional>

#include <holdfast/optics/optics.hpp>

using namespace holdfast;

namespace {

constexpr double left = 80, top = 20, width = 600, height = 330;
constexpr double r_max = 2.0, lowest = -14, highest = 3;  // decades of pixels

double x_of(double r) {
  return left + width * r / r_max;
}
double y_of(double px) {
  return top + height * (highest - std::log10(std::max(px, 1e-14))) / (highest - lowest);
}

void curve(const Lens& lens, LensMode mode, const char* color, const char* name, int row) {
  const auto residual = [&](double r) -> std::optional<double> {
    const Vector2 ideal = r * Vector2(0.6, 0.8).cwiseProduct(lens.placement().scale);
    const auto seen = seen_tangent(lens, mode, ideal);
    return seen ? std::optional<double>((*seen - ideal).norm()) : std::nullopt;
  };
  std::printf("<polyline fill='none' stroke='%s' stroke-width='2' points='", color);
  double last = 0.0;
  for (int i = 1; i <= 400; ++i) {
    const double r = r_max * i / 400;
    const auto px = residual(r);
    if (!px) break;
    last = r;
    std::printf("%.1f,%.1f ", x_of(r), y_of(*px));
  }
  std::printf("'/>\n");
  if (last < r_max)
    std::printf("<circle cx='%.1f' cy='%.1f' r='4' fill='%s'/>\n", x_of(last), y_of(*residual(last)), color);
  const double y = y_of(3e-8) + 22 * row;
  std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='%s' stroke-width='3'/>\n", left + 40, left + 70,
              y - 5, y - 5, color);
  std::printf("<text x='%.0f' y='%.1f' fill='%s'>%s</text>\n", left + 80, y, color, name);
}

}  // namespace

int main() {
  const Lens lens(RadialLens{0.1933}, placed_at(256.0), -0.1);  // table 8.1, in pixels
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 720 410' font-family='sans-serif' font-size='14'>\n"
      "<rect width='720' height='410' fill='white'/>\n");
  for (int decade = static_cast<int>(lowest); decade <= highest; decade += 2) {
    const double y = y_of(std::pow(10.0, decade));
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", left, left + width, y, y);
    std::printf("<text x='%.0f' y='%.1f' text-anchor='end' fill='#444'>1e%d</text>\n", left - 8, y + 5, decade);
  }
  for (int i = 0; i <= 4; ++i) {
    const double r = 0.5 * i;
    std::printf("<line x1='%.1f' x2='%.1f' y1='%.0f' y2='%.0f' stroke='#ddd'/>\n", x_of(r), x_of(r), top, top + height);
    std::printf("<text x='%.1f' y='%.0f' text-anchor='middle' fill='#444'>%.1f</text>\n", x_of(r), top + height + 20,
                r);
  }
  std::printf(
      "<text x='%.0f' y='%.0f' text-anchor='middle' fill='#444'>radius r (1 = half the picture's height; its farthest "
      "corner is "
      "1.84)</text>\n",
      left + width / 2, top + height + 44);
  std::printf(
      "<text x='20' y='%.0f' text-anchor='middle' fill='#444' transform='rotate(-90 20 %.0f)'>error left (px)</text>\n",
      top + height / 2, top + height / 2);
  const double tolerance_y = y_of(1e-6);
  std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#888' stroke-dasharray='6 4'/>\n", left,
              left + width, tolerance_y, tolerance_y);
  std::printf("<text x='%.0f' y='%.1f' fill='#666'>what we allow: 1e-6 px</text>\n", left + 8, tolerance_y - 6);
  curve(lens, LensMode::uncorrected, "#b00020", "uncorrected", 0);
  curve(lens, LensMode::cubic, "#c77700", "the paper's cubic, k_pd = -0.1: folds over at 1.826", 1);
  curve(with_best_cubic(lens), LensMode::cubic, "#00695c",
        "the best cubic up to r = 1, k_pd = -0.134: folds over at 1.578", 2);
  curve(lens, LensMode::exact, "#1a4fb5", "exact inverse", 3);
  std::printf("</svg>\n");
}
