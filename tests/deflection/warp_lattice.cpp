#include <algorithm>
#include <cmath>
#include <vector>

#include <doctest/doctest.h>

#include <holdfast/deflection/warp_lattice.hpp>

#include "deflection/lattice_error.hpp"
#include "deflection/setups.hpp"
#include "deflection/warp_pictures.hpp"

using namespace holdfast;

TEST_CASE("the lattice holds every lens and mode to its bound") {
  test::Random random(801);
  double worst = 0.0;
  for (int i = 0; i < 8; ++i) {
    EyeModel eye = random.eye();
    eye.resolution = {200 + random.index(700), 200 + random.index(700)};
    for (const LensMode mode : {LensMode::exact, LensMode::cubic}) {
      const WarpLattice lattice(eye, mode);
      CHECK(lattice.per_color() == (eye.lens_red || eye.lens_blue));
      CHECK(lattice.max_error_px() <= WarpLattice::default_max_error_px);
      const test::LatticeError error = test::lattice_error(lattice, eye, 7);
      CHECK(error.wrongly_defined == 0);
      worst = std::max(worst, error.worst_px);
    }
  }
  MESSAGE("worst of the random eyes: ", worst, " px");
  // The bound holds at a cell's 81 pixels; between them, and by float rounding (1e-4 px), it may be a little more.
  CHECK(worst < 1.2 * WarpLattice::default_max_error_px);
}

TEST_CASE("a tighter bound is kept, at the price of memory") {
  test::Random random(802);
  EyeModel eye = random.eye();
  eye.resolution = {200, 150};
  const WarpLattice loose(eye, LensMode::cubic, 0.02);
  const WarpLattice tight(eye, LensMode::cubic, 1e-5);
  CHECK(tight.max_error_px() <= 1e-5);
  CHECK(tight.bytes() >= loose.bytes());
}

TEST_CASE("an eye without a lens, or that ignores it, needs no lattice") {
  test::Random random(803);
  EyeModel eye = random.eye();
  CHECK(WarpLattice(eye, LensMode::none).is_linear());
  CHECK(WarpLattice(eye, LensMode::uncorrected).is_linear());
  CHECK_FALSE(WarpLattice(eye, LensMode::exact).is_linear());
  eye.lens = Lens();
  eye.lens_red.reset();
  eye.lens_blue.reset();
  const WarpLattice none(eye, LensMode::exact);
  CHECK(none.is_linear());
  CHECK_FALSE(none.per_color());
  CHECK(none.bytes() == 0);
}

TEST_CASE("kinks and the domain's edge are kept exactly") {
  // A barrel that folds over within the panel.
  EyeModel eye = test::plain_eye(301, 211);
  eye.lens = Lens(RadialLens{-0.2}, {Vector2(0.01, -0.02), Vector2(0.07, 0.07)});
  const WarpLattice lattice(eye, LensMode::exact);
  const test::LatticeError error = test::lattice_error(lattice, eye, 1);
  CHECK(lattice.cells(Color::green).dense_cells > 0);
  CHECK(error.undefined > 1000);
  CHECK(error.wrongly_defined == 0);
  CHECK(error.worst_px < 0.002);
}

TEST_CASE("panels that no cell divides, and the smallest") {
  test::Random random(804);
  for (const auto& [width, height] : {std::array{1, 1}, std::array{3, 70}, std::array{33, 31}, std::array{65, 2}}) {
    EyeModel eye = random.eye();
    eye.resolution = {width, height};
    const test::LatticeError error = test::lattice_error(WarpLattice(eye, LensMode::exact), eye, 1);
    CHECK(error.wrongly_defined == 0);
    CHECK(error.worst_px < 0.002);
  }
}
