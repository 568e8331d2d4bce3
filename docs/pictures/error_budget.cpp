// Draws docs/pictures/error_budget.svg: sources of registration error of a swinging head, each alone and all together.
//     g++ -std=c++20 -O1 -Iinclude -I/usr/include/eigen3 docs/pictures/error_budget.cpp -o /tmp/error_budget
//     /tmp/error_budget > docs/pictures/error_budget.svg
#include <cstdio>
#include <string>

#include <holdfast/motion/generators.hpp>
#include <holdfast/registration/error_budget.hpp>

using namespace holdfast;

namespace {

constexpr double left = 150, width = 400, longest = 230.0;
int row = 0;

void bar(const std::string& name, double arcmin, const char* color) {
  const double y = 48.0 + 26.0 * row++;
  std::printf("<text x='%.0f' y='%.0f' text-anchor='end'>%s</text>\n", left - 10, y + 14, name.c_str());
  std::printf("<rect x='%.0f' y='%.0f' width='%.1f' height='18' fill='%s'/>\n", left, y, width * arcmin / longest,
              color);
  std::printf("<text x='%.1f' y='%.0f' fill='#444'>%.1f</text>\n", left + width * arcmin / longest + 6, y + 14, arcmin);
}

}  // namespace

int main() {
  BudgetSettings settings;
  settings.experiment.motion_name = "M6";
  settings.experiment.lens = LensMode::cubic;
  settings.experiment.hmd.timing.scan_out = ScanOut::rolling;
  settings.experiment.hmd.timing.scan_duration = from_milliseconds(11.1);
  const auto motion = make_motion("M6", 1);
  const RegistrationBudget budget = registration_budget(*motion, settings);
  std::printf(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 620 334' font-family='sans-serif' font-size='13'>\n");
  std::printf("<rect width='620' height='334' fill='white'/>\n");
  std::printf(
      "<text x='20' y='26' font-weight='bold'>Registration error by source (arcmin, RMS over discs and "
      "frames)</text>\n");
  for (const BudgetPart& part : budget.parts) bar(std::string(part.source), part.rms_arcmin, "#00798c");
  bar("all together", budget.all.rms_arcmin, "#d1495b");
  bar("root of squares", budget.root_of_squares_arcmin(), "#bbb");
  bar("plain sum", budget.sum_arcmin(), "#bbb");
  std::printf(
      "<text x='20' y='302' fill='#555'>Swing (M6), no prediction: tracker off by 2 mm, 20 + 40 ms late,</text>\n");
  std::printf("<text x='20' y='320' fill='#555'>rolling 11.1 ms, cubic lens, IPD wrong by 2 mm.</text>\n");
  std::printf("</svg>\n");
}
