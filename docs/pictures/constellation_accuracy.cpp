// Draws docs/pictures/constellation_accuracy.svg: how far the errors of 003's table 1 put a receiver off, each alone and all
// together, at each height under a ceiling at 3 m.
//     g++ -std=c++20 -O2 -Iinclude -I/usr/include/eigen3 docs/pictures/constellation_accuracy.cpp -o /tmp/constellation_accuracy
//     /tmp/constellation_accuracy > docs/pictures/constellation_accuracy.svg
// The table goes to the error output.
#include <cstdio>
#include <string>
#include <vector>

#include <holdfast/registration/range_sensitivity.hpp>

using namespace holdfast;

namespace {

constexpr double left = 70, top = 24, width = 430, height = 330, highest_m = 2.5, most_mm = 5.0;

double x_of(double height_m) {
  return left + width * height_m / highest_m;
}
double y_of(double mm) {
  return top + height * (1.0 - mm / most_mm);
}

std::vector<SensitivityRow> rows_of(const std::string& name, const UltrasonicErrors& errors) {
  std::vector<SensitivityRow> rows;
  std::fprintf(stderr, "%-28s", name.c_str());
  for (int i = 0; i <= 10; ++i) {
    rows.push_back(range_sensitivity(errors, 0.25 * i));
    if (i % 2 == 0) std::fprintf(stderr, " %5.2f", rows.back().error_mm);
  }
  std::fprintf(stderr, "\n");
  return rows;
}

/// `lift` moves the label off its neighbours.
void curve(const std::vector<SensitivityRow>& rows, double SensitivityRow::*value, const char* color, double thick,
           const char* dashes, const std::string& label, double lift = 0.0) {
  std::printf("<polyline fill='none' stroke='%s' stroke-width='%.1f' stroke-dasharray='%s' points='", color, thick,
              dashes);
  for (const SensitivityRow& row : rows) std::printf("%.1f,%.1f ", x_of(row.height_m), y_of(row.*value));
  std::printf("'/>\n<text x='%.0f' y='%.1f' fill='%s'>%s</text>\n", left + width + 10,
              y_of(rows.back().*value) + 5.0 - lift, color, label.c_str());
}

}  // namespace

int main() {
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 720 420' font-family='sans-serif' font-size='14'>\n"
      "<rect width='720' height='420' fill='white'/>\n"
      "<rect x='%.0f' y='%.1f' width='%.0f' height='%.1f' fill='#f3e6ea'/>\n"
      "<text x='%.0f' y='%.1f' fill='#a07080'>003, figure 7: 2.3 to 4.7 mm</text>\n",
      left, y_of(4.7), width, y_of(2.3) - y_of(4.7), left + 10, y_of(4.7) + 18);
  for (int i = 0; i <= 5; ++i) {
    std::printf("<line x1='%.0f' x2='%.0f' y1='%.1f' y2='%.1f' stroke='#ddd'/>\n", left, left + width, y_of(i),
                y_of(i));
    std::printf("<text x='%.0f' y='%.1f' text-anchor='end' fill='#444'>%d</text>\n", left - 8, y_of(i) + 5, i);
    const double x = x_of(0.5 * i);
    std::printf("<line x1='%.1f' x2='%.1f' y1='%.0f' y2='%.0f' stroke='#ddd'/>\n", x, x, top, top + height);
    std::printf("<text x='%.1f' y='%.0f' text-anchor='middle' fill='#444'>%.1f</text>\n", x, top + height + 20,
                0.5 * i);
  }
  std::printf(
      "<text x='%.0f' y='398' text-anchor='middle' fill='#444'>height above the floor (m)</text>\n"
      "<text x='24' y='190' text-anchor='middle' fill='#444' transform='rotate(-90 24 190)'>mean position error "
      "(mm)</text>\n",
      left + width / 2);

  const std::vector<SensitivityRow> all = rows_of("all of table 1", table_1_errors());
  curve(all, &SensitivityRow::error_mm, "#d1495b", 3.5, "none", "all of table 1", 8);
  const auto improved = rows_of("improved compensation", improved_compensation_errors());
  curve(improved, &SensitivityRow::error_mm, "#1a4fb5", 3.0, "none", "improved compensation");
  const char* colors[] = {"#7b1fa2", "#b26a00", "#557a2b", "#8a6d5a", "#00798c"};
  const char* labels[] = {"beacon positions", "temperature", "beacon delays", "receiver delays", "transducer angles"};
  const double lifts[] = {0, -14, -8, 8, -6};
  int i = 0;
  for (const UltrasonicErrorSource& source : each_alone(table_1_errors())) {
    curve(rows_of(labels[i], source.errors), &SensitivityRow::error_mm, colors[i], 1.5, "none", labels[i], lifts[i]);
    ++i;
  }
  curve(all, &SensitivityRow::resolution_mm, "#888", 1.5, "6 4", "noise alone (resolution)");
  std::fprintf(stderr, "%-28s", "resolution");
  for (std::size_t row = 0; row < all.size(); row += 2) std::fprintf(stderr, " %5.2f", all[row].resolution_mm);
  std::fprintf(stderr, "\nGDOP (horizontal, vertical) ");
  for (std::size_t row = 0; row < all.size(); row += 2) {
    std::fprintf(stderr, " %.2f (%.2f, %.2f)", all[row].gdop, all[row].horizontal_dop, all[row].vertical_dop);
  }
  std::fprintf(stderr, "\n");
  std::printf("</svg>\n");
}
