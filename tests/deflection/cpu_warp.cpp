#include <cstring>
#include <limits>
#include <numbers>

#include <doctest/doctest.h>

#include <holdfast/deflection/cpu_warp.hpp>
#include <holdfast/deflection/deflect.hpp>

#include "deflection/warp_pictures.hpp"

using namespace holdfast;
using test::Picture;

namespace {

constexpr WarpFilter filters[] = {WarpFilter::bilinear, WarpFilter::bicubic};

RenderedView own_view(const EyeModel& eye) {
  return {Rigid(), panel_tangents(eye), eye.resolution, {}};
}

// A view that shows the eye's panel, whole pixels of it cut off or added at each side.
RenderedView view_with_margins(const EyeModel& eye, int left, int right, int down, int up) {
  const Vector2 scale = pixels_per_tangent(eye);
  FieldTangents t = eye.tangents;
  t.left -= left / scale.x();
  t.right += right / scale.x();
  t.down -= down / scale.y();
  t.up += up / scale.y();
  return {Rigid(), t, {eye.resolution.width + left + right, eye.resolution.height + down + up}, {}};
}

ScanHomography random_motion(test::Random& random, const RenderedView& view) {
  const LatePoses late{view.X_WS * random.pose(0.15, 0.0), view.X_WS * random.pose(0.15, 0.0)};
  const DeflectionResult result = deflect({}, view, late);
  REQUIRE(result.ok());
  return result.H_SE;
}

template <typename Channel>
Picture<Channel> drawn(CpuWarp& warp, const WarpLattice& lattice, const ComposedWarp& composed,
                       const Picture<Channel>& source, int padding = 0) {
  Picture<Channel> target(lattice.size().width, lattice.size().height, padding);
  target.fill([](double, double, int) { return 77; });
  REQUIRE(warp.draw(lattice, composed, source.span(), target.span()) == CpuWarpProblem::none);
  return target;
}

template <typename Channel>
double greatest_difference(const Picture<Channel>& a, const Picture<Channel>& b) {
  double worst = 0.0;
  for (int y = 0; y < a.height; ++y) {
    for (int x = 0; x < a.width; ++x) {
      for (int c = 0; c < 4; ++c) {
        worst = std::max(worst, std::abs(static_cast<double>(a.at(x, y, c)) - static_cast<double>(b.at(x, y, c))));
      }
    }
  }
  return worst;
}

template <typename Channel>
void check_identity(int width, int height) {
  const EyeModel eye = test::plain_eye(width, height);
  const Picture<Channel> source = test::noise<Channel>(width, height, 1, false, 4 * (width % 3));
  const ComposedWarp composed(eye, LensMode::none, {}, own_view(eye), {});
  const WarpLattice lattice(eye, LensMode::none);
  CHECK(lattice.is_linear());
  for (const bool vectors : {false, true}) {
    for (const WarpFilter filter : filters) {
      CpuWarp warp({2, filter, vectors});
      CAPTURE(width);
      CAPTURE(vectors);
      CHECK(greatest_difference(drawn(warp, lattice, composed, source, 4), source) == 0.0);
    }
  }
}

// A pixel outside the source comes out as the border, any other bit by bit as in the source.
template <typename Channel>
void check_shift(const RenderedView& view, const EyeModel& eye, int dx, int dy) {
  const Picture<Channel> source = test::noise<Channel>(view.size.width, view.size.height, 2, true);
  const ComposedWarp composed(eye, LensMode::none, {}, view, {});
  for (const bool vectors : {false, true}) {
    for (const WarpFilter filter : filters) {
      CpuWarp warp({1, filter, vectors});
      const Picture<Channel> target = drawn(warp, WarpLattice(eye, LensMode::none), composed, source);
      int wrong = 0;
      for (int y = 0; y < target.height; ++y) {
        for (int x = 0; x < target.width; ++x) {
          const bool inside = x + dx >= 0 && y + dy >= 0 && x + dx < source.width && y + dy < source.height;
          for (int c = 0; c < 4; ++c) {
            wrong += target.at(x, y, c) != (inside ? source.at(x + dx, y + dy, c) : Channel{0});
          }
        }
      }
      CAPTURE(vectors);
      CHECK(wrong == 0);
    }
  }
}

}  // namespace

TEST_CASE("without motion and lens the picture comes out to the last bit, whatever its size") {
  for (const auto& [width, height] : {std::array{1, 1}, std::array{2, 2}, std::array{7, 3}, std::array{64, 16},
                                      std::array{257, 19}, std::array{300, 33}, std::array{5, 200}}) {
    check_identity<std::uint8_t>(width, height);
    check_identity<float>(width, height);
  }
}

TEST_CASE("a shift by whole pixels is exact to the last bit, and what comes in from outside is transparent") {
  const EyeModel eye = test::plain_eye(150, 45);
  for (const auto& [left, right, down, up] :
       {std::array{3, 5, 2, 7}, std::array{-4, 9, -1, 3}, std::array{-20, -30, -3, -5}, std::array{17, -17, 0, 0}}) {
    const RenderedView view = view_with_margins(eye, left, right, down, up);
    check_shift<std::uint8_t>(view, eye, left, down);
    check_shift<float>(view, eye, left, down);
  }
}

TEST_CASE("linear ramps come out exact, bilinear and bicubic, and quadratics bicubic") {
  test::Random random(701);
  for (int i = 0; i < 12; ++i) {
    const EyeModel eye = test::plain_eye(60 + random.index(200), 50 + random.index(60));
    const RenderedView view = view_with_margins(eye, 40, 40, 40, 40);
    const ComposedWarp composed(eye, LensMode::none, random.timing(true), view, random_motion(random, view));
    const WarpLattice lattice(eye, LensMode::none);
    Picture<float> ramp(view.size.width, view.size.height);
    ramp.fill([](double x, double y, int c) { return c == 0 ? x : c == 1 ? y : c == 2 ? x - 2 * y + 7 : 1.0; });
    Picture<float> square(view.size.width, view.size.height);
    square.fill([](double x, double y, int c) { return c == 0 ? x * x : c == 1 ? y * y : c == 2 ? x * y : 1.0; });
    for (const bool vectors : {false, true}) {
      CpuWarp bilinear({1, WarpFilter::bilinear, vectors});
      CpuWarp bicubic({1, WarpFilter::bicubic, vectors});
      const Picture<float> by_two = drawn(bilinear, lattice, composed, ramp);
      const Picture<float> by_four = drawn(bicubic, lattice, composed, ramp);
      const Picture<float> squares = drawn(bicubic, lattice, composed, square);
      double worst_two = 0.0, worst_four = 0.0, worst_square = 0.0;
      for (int y = 0; y < lattice.size().height; ++y) {
        for (int x = 0; x < lattice.size().width; ++x) {
          const auto p = composed.source_pixel(Vector2(x + 0.5, y + 0.5));
          if (!p || p->x() < 2 || p->y() < 2 || p->x() > ramp.width - 2 || p->y() > ramp.height - 2) continue;
          const double lines[] = {p->x(), p->y(), p->x() - 2 * p->y() + 7, 1.0};
          const double parabolas[] = {p->x() * p->x(), p->y() * p->y(), p->x() * p->y(), 1.0};
          for (int c = 0; c < 4; ++c) {
            worst_two = std::max(worst_two, std::abs(static_cast<double>(by_two.at(x, y, c)) - lines[c]));
            worst_four = std::max(worst_four, std::abs(static_cast<double>(by_four.at(x, y, c)) - lines[c]));
            worst_square = std::max(worst_square, std::abs(static_cast<double>(squares.at(x, y, c)) - parabolas[c]));
          }
        }
      }
      // Positions are off by a few float roundings of 400 px (3e-5 each), three times over for x - 2 y.
      CHECK(worst_two < 5e-4);
      CHECK(worst_four < 5e-4);
      // x^2 changes by 700 a pixel: 700 x 1e-4 px, and roundings of 1e5 (8e-3).
      CHECK(worst_square < 0.15);
    }
  }
}

TEST_CASE("8-bit ramps are right to their rounding") {
  test::Random random(702);
  const EyeModel eye = test::plain_eye(230, 90);
  const RenderedView view = view_with_margins(eye, 10, 12, 30, 30);
  const ComposedWarp composed(eye, LensMode::none, {}, view, random_motion(random, view));
  Picture<std::uint8_t> ramp(view.size.width, view.size.height);
  ramp.fill([](double x, double y, int c) {
    return c == 0 ? x - 0.5 : c == 1 ? y - 0.5 : c == 2 ? 200 - y + 0.5 : 255;
  });
  for (const bool vectors : {false, true}) {
    for (const WarpFilter filter : filters) {
      CpuWarp warp({1, filter, vectors});
      const Picture<std::uint8_t> target = drawn(warp, WarpLattice(eye, LensMode::none), composed, ramp);
      double worst = 0.0;
      int covered = 0;
      for (int y = 0; y < target.height; ++y) {
        for (int x = 0; x < target.width; ++x) {
          const auto p = composed.source_pixel(Vector2(x + 0.5, y + 0.5));
          if (!p || p->x() < 2 || p->y() < 2 || p->x() > ramp.width - 2 || p->y() > ramp.height - 2) continue;
          const double expected[] = {p->x() - 0.5, p->y() - 0.5, 200.5 - p->y(), 255.0};
          for (int c = 0; c < 4; ++c) worst = std::max(worst, std::abs(target.at(x, y, c) - expected[c]));
          ++covered;
        }
      }
      CHECK(covered > 10000);
      CHECK(worst < 0.52);  // half a step, and 1/2^14 of the weights of 255
    }
  }
}

TEST_CASE("every filter, channel type and code path agrees with the slow reference within 1/255") {
  test::Random random(703);
  double worst[2] = {0.0, 0.0};
  long covered = 0, bare = 0, wrongly_covered = 0;
  for (int i = 0; i < 60; ++i) {
    const EyeModel eye = test::small_eye(random);
    RenderedView view = random.view(eye);
    // Of the panel's density, more or less: the lattice's bound is in panel pixels.
    view.size = {static_cast<int>(random.uniform(0.5, 1.5) * eye.resolution.width),
                 static_cast<int>(random.uniform(0.5, 1.5) * eye.resolution.height)};
    const LensMode mode = std::array{LensMode::exact, LensMode::cubic, LensMode::none}[static_cast<std::size_t>(i % 3)];
    const ComposedWarp composed(eye, mode, random.timing(i % 4 != 0), view, random_motion(random, view));
    const WarpLattice lattice(eye, mode);
    const auto bytes = test::noise<std::uint8_t>(view.size.width, view.size.height, 10, true, i % 5);
    const auto floats = test::noise<float>(view.size.width, view.size.height, 11, true, i % 5);
    const WarpFilter filter = filters[i / 3 % 2];
    CpuWarp warp({1, filter, i / 6 % 2 == 0});
    const auto from_bytes = drawn(warp, lattice, composed, bytes);
    const auto from_floats = drawn(warp, lattice, composed, floats);
    for (int y = 0; y < eye.resolution.height; ++y) {
      for (int x = 0; x < eye.resolution.width; ++x) {
        const test::Expected of_bytes = test::expected_at(composed, bytes, x, y, filter);
        const test::Expected of_floats = test::expected_at(composed, floats, x, y, filter);
        if (!of_bytes.sure) continue;
        if (!of_bytes.colour) {
          ++bare;
          wrongly_covered += from_bytes.at(x, y, 3) != 0 || from_floats.at(x, y, 3) != 0.0F;
          continue;
        }
        ++covered;
        for (int c = 0; c < 4; ++c) {
          const auto k = static_cast<std::size_t>(c);
          worst[0] = std::max(worst[0], std::abs(from_bytes.at(x, y, c) - (*of_bytes.colour)[k]));
          worst[1] =
              std::max(worst[1], std::abs(static_cast<double>(from_floats.at(x, y, c)) - (*of_floats.colour)[k]));
        }
      }
    }
  }
  MESSAGE("worst of ", covered, " pixels: 8 bits ", worst[0], " / 255, float ", worst[1] * 255.0, " / 255");
  CHECK(covered > 200000);
  CHECK(bare > 20000);
  CHECK(wrongly_covered == 0);
  // Half a step of rounding; the rest is positions: the lattice's 0.002 px at most, on noise of up to 1.5 x 255 a pixel.
  CHECK(worst[0] <= 1.0);
  CHECK(worst[1] <= 0.5 / 255.0);
}

TEST_CASE("vector and portable code agree within 1/255") {
  test::Random random(704);
  if (!CpuWarp({1, WarpFilter::bilinear, true}).vectors()) MESSAGE("this processor has no AVX2 and FMA");
  for (int i = 0; i < 24; ++i) {
    EyeModel eye = random.eye();
    eye.resolution = {100 + random.index(500), 50 + random.index(200)};
    const RenderedView view = random.view(eye);
    const ComposedWarp composed(eye, LensMode::exact, random.timing(true), view, random_motion(random, view));
    const WarpLattice lattice(eye, LensMode::exact);
    const WarpFilter filter = filters[i % 2];
    CpuWarp vectors({1, filter, true});
    CpuWarp portable({1, filter, false});
    CHECK_FALSE(portable.vectors());
    const auto bytes = test::noise<std::uint8_t>(view.size.width, view.size.height, 20);
    const auto a = drawn(vectors, lattice, composed, bytes);
    const auto b = drawn(portable, lattice, composed, bytes);
    // Only where float rounding decides that a pixel at the very edge is covered may they differ by more.
    int differ = 0;
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        int most = 0;
        for (int c = 0; c < 4; ++c) most = std::max(most, std::abs(a.at(x, y, c) - b.at(x, y, c)));
        if (most > 1 && test::expected_at(composed, bytes, x, y, filter).sure) ++differ;
      }
    }
    CHECK(differ == 0);
  }
}

TEST_CASE("the number of threads changes no bit") {
  test::Random random(705);
  for (int i = 0; i < 8; ++i) {
    EyeModel eye = random.eye();
    eye.resolution = {300 + random.index(400), 100 + random.index(200)};
    const RenderedView view = random.view(eye);
    const ComposedWarp composed(eye, LensMode::exact, random.timing(true), view, random_motion(random, view));
    const WarpLattice lattice(eye, LensMode::exact);
    const auto source = test::noise<std::uint8_t>(view.size.width, view.size.height, 30);
    CpuWarp one({1, filters[i % 2]});
    const auto expected = drawn(one, lattice, composed, source);
    for (const int threads : {2, 3, 7}) {
      CpuWarp warp({threads, filters[i % 2]});
      CHECK(warp.threads() == threads);
      for (int repeat = 0; repeat < 3; ++repeat) {
        CHECK(drawn(warp, lattice, composed, source).channels == expected.channels);
      }
    }
  }
}

TEST_CASE("where the lens ends the picture ends, to the pixel") {
  // Barrel lenses fold over within the panel; each colour elsewhere.
  EyeModel eye = test::plain_eye(333, 271);
  eye.lens = Lens(RadialLens{-0.2}, {Vector2(0.01, -0.02), Vector2(0.1, 0.1)});
  eye.lens_red = Lens(RadialLens{-0.21}, {Vector2(0.01, -0.02), Vector2(0.1, 0.1)});
  eye.lens_blue = Lens(RadialLens{-0.19}, {Vector2(0.01, -0.02), Vector2(0.1, 0.1)});
  const ComposedWarp composed(eye, LensMode::exact, {}, own_view(eye), {});
  const WarpLattice lattice(eye, LensMode::exact);
  CHECK(lattice.per_color());
  const auto bytes = test::noise<std::uint8_t>(333, 271, 40, true);
  const auto floats = test::noise<float>(333, 271, 41, true);
  for (const bool vectors : {false, true}) {
    for (const WarpFilter filter : filters) {
      CpuWarp warp({1, filter, vectors});
      const auto a = drawn(warp, lattice, composed, bytes);
      const auto b = drawn(warp, lattice, composed, floats);
      int covered = 0, wrong = 0;
      for (int y = 0; y < 271; ++y) {
        for (int x = 0; x < 333; ++x) {
          const bool seen = test::expected_at(composed, bytes, x, y, filter).colour.has_value();
          covered += seen;
          wrong += (a.at(x, y, 3) == 255) != seen || (b.at(x, y, 3) > 0.99F) != seen;
          if (!seen) wrong += a.at(x, y, 0) != 0 || b.at(x, y, 0) != 0.0F;
        }
      }
      CHECK(covered > 20000);
      CHECK(covered < 60000);
      CHECK(wrong == 0);
    }
  }
}

namespace {

// Centroid of f over the pixels round `near`, each sampled at n x n points.
template <typename F>
Vector2 centroid(const Vector2& near, int n, const F& f) {
  Vector2 sum(0.0, 0.0);
  double weight = 0.0;
  const int reach = 12 * n;
  for (int j = -reach; j <= reach; ++j) {
    for (int i = -reach; i <= reach; ++i) {
      const Vector2 p((std::floor(near.x()) * n + i + 0.5) / n, (std::floor(near.y()) * n + j + 0.5) / n);
      const double value = f(p);
      sum += value * p;
      weight += value;
    }
  }
  REQUIRE(weight > 0.0);
  return sum / weight;
}

}  // namespace

TEST_CASE("a disc's centroid comes out where the composed warp says") {
  test::Random random(706);
  double worst[2] = {0.0, 0.0};
  double worst_filtered = 0.0;
  int discs = 0;
  for (int i = 0; i < 40; ++i) {
    EyeModel eye = random.eye();
    eye.resolution = {400, 300};
    const RenderedView view = view_with_margins(eye, 30, 30, 30, 30);
    const ComposedWarp composed(eye, LensMode::exact, random.timing(true), view, random_motion(random, view));
    const Vector2 centre(random.uniform(100, 360), random.uniform(80, 280));
    const auto shown = composed.panel_pixel(centre);
    if (!shown || shown->x() < 20 || shown->y() < 20 || shown->x() > 380 || shown->y() > 280) continue;
    // Green, as the eye's colours may differ. Its edge is 4 px wide, so that one sample a pixel tells its centroid also
    // where the lens shrinks it.
    const auto disc = [&centre](const Vector2& p) {
      return 0.5 + 0.5 * std::sin(std::numbers::pi * std::clamp(0.25 * (6.0 - (p - centre).norm()), -0.5, 0.5));
    };
    Picture<std::uint8_t> source(view.size.width, view.size.height);
    source.fill([&](double x, double y, int c) { return c == 1 ? std::round(255.0 * disc(Vector2(x, y))) : 0.0; });
    CpuWarp warp({1, filters[i % 2]});
    const auto target = drawn(warp, WarpLattice(eye, LensMode::exact), composed, source);
    const Vector2 expected = centroid(*shown, 2, [&](const Vector2& p) { return disc(*composed.source_pixel(p)); });
    const Vector2 found = centroid(
        *shown, 1, [&](const Vector2& p) { return target.at(static_cast<int>(p.x()), static_cast<int>(p.y()), 1); });
    const Vector2 filtered = centroid(*shown, 1, [&](const Vector2& p) {
      return test::sample_slowly(source, *composed.source_pixel(p), 1, filters[i % 2]);
    });
    worst[i % 2] = std::max(worst[i % 2], (found - expected).norm());
    worst_filtered = std::max(worst_filtered, (found - filtered).norm());
    ++discs;
  }
  MESSAGE("worst centroid of ", discs, " discs, px: bilinear ", worst[0], ", bicubic ", worst[1],
          "; against the same filter in double precision ", worst_filtered);
  CHECK(discs > 20);
  CHECK(worst_filtered < 0.004);  // positions are exact to 0.002 px, and values are rounded
  // Against the disc itself: bilinear filtering is softer between the pixels than on them, and so moves its edge.
  CHECK(worst[0] < 0.03);
  CHECK(worst[1] < 0.02);
}

TEST_CASE("a border's colour is what is asked for") {
  const EyeModel eye = test::plain_eye(40, 30);
  const RenderedView view = view_with_margins(eye, -5, -5, -5, -5);
  const ComposedWarp composed(eye, LensMode::none, {}, view, {});
  const auto source = test::noise<std::uint8_t>(30, 20, 50);
  Picture<std::uint8_t> target(40, 30);
  CpuWarp warp({1});
  REQUIRE(warp.draw(WarpLattice(eye, LensMode::none), composed, source.span(), target.span(), {9, 8, 7, 6}) ==
          CpuWarpProblem::none);
  for (int c = 0; c < 4; ++c) {
    CHECK(target.at(0, 0, c) == 9 - c);
    CHECK(target.at(4, 15, c) == 9 - c);
    CHECK(target.at(5, 5, c) == source.at(0, 0, c));
    CHECK(target.at(35, 29, c) == 9 - c);
  }
}

TEST_CASE("the bytes between rows stay untouched") {
  const EyeModel eye = test::plain_eye(37, 9);
  const ComposedWarp composed(eye, LensMode::none, {}, own_view(eye), {});
  const auto source = test::noise<std::uint8_t>(37, 9, 60);
  CpuWarp warp({2});
  Picture<std::uint8_t> target(37, 9, 11);
  std::fill(target.channels.begin(), target.channels.end(), std::uint8_t{99});
  REQUIRE(warp.draw(WarpLattice(eye, LensMode::none), composed, source.span(), target.span()) == CpuWarpProblem::none);
  for (int y = 0; y < 9; ++y) {
    for (int i = 4 * 37; i < target.stride; ++i) {
      CHECK(target.channels[static_cast<std::size_t>(target.stride * y + i)] == 99);
    }
  }
}

TEST_CASE("a picture that knows its view is warped with no other") {
  const EyeModel eye = test::plain_eye(40, 30);
  const auto source = test::noise<std::uint8_t>(40, 30, 70);
  Picture<std::uint8_t> target(40, 30);
  const WarpLattice lattice(eye, LensMode::none);
  CpuWarp warp({1});
  const RenderedPicture picture(own_view(eye), source.span());
  const ComposedWarp composed(eye, LensMode::none, {}, picture.view(), {});
  CHECK(warp.draw(lattice, composed, picture, target.span()) == CpuWarpProblem::none);
  CHECK(greatest_difference(target, source) == 0.0);
  RenderedView turned = own_view(eye);
  turned.X_WS = Rigid(so3::exp<double>(Vector3(0.0, 1e-9, 0.0)), Vector3(0, 0, 0));
  CHECK(warp.draw(lattice, composed, RenderedPicture(turned, source.span()), target.span()) ==
        CpuWarpProblem::other_view);
}

TEST_CASE("bad input is refused by name and leaves the target as it was") {
  const EyeModel eye = test::plain_eye(40, 30);
  const RenderedView view = own_view(eye);
  const ComposedWarp composed(eye, LensMode::none, {}, view, {});
  const WarpLattice lattice(eye, LensMode::none);
  Picture<std::uint8_t> source(40, 30);
  Picture<std::uint8_t> target(40, 30);
  std::fill(target.channels.begin(), target.channels.end(), std::uint8_t{5});
  CpuWarp warp({1});
  using Span = PictureSpan<std::uint8_t>;
  std::uint8_t* s = source.channels.data();
  std::uint8_t* t = target.channels.data();
  const auto result = [&](const Span& from, const Span& to) { return warp.draw(lattice, composed, from, to); };
  CHECK(result({}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result(source.span(), {}) == CpuWarpProblem::target_picture);
  CHECK(result({nullptr, 40, 30}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result({s, 0, 30}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result({s, 40, -1}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result({s, 40, 30, 159}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result({s, 40, 30, -160}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result({s, 40, 30, std::ptrdiff_t{1} << 40}, target.span()) == CpuWarpProblem::source_picture);
  CHECK(result({s, 39, 30, 160}, target.span()) == CpuWarpProblem::source_size);
  CHECK(result(source.span(), {t, 40, 29}) == CpuWarpProblem::target_size);
  CHECK(result(source.span(), source.span()) == CpuWarpProblem::overlap);
  std::vector<std::uint8_t> both(2 * 4800 - 4);
  CHECK(result({both.data(), 40, 30}, {both.data() + 4796, 40, 30}) == CpuWarpProblem::overlap);
  CHECK(result({both.data() + 4796, 40, 30}, {both.data(), 40, 30}) == CpuWarpProblem::overlap);
  CHECK(warp.draw(WarpLattice(eye, LensMode::exact), composed, source.span(), target.span()) ==
        CpuWarpProblem::other_lens);
  CHECK(warp.draw(WarpLattice(test::plain_eye(40, 31), LensMode::none), composed, source.span(), target.span()) ==
        CpuWarpProblem::other_lens);
  // Another lens before the same panel: another model, another place, another colour.
  EyeModel with_lens = eye;
  with_lens.lens = Lens(RadialLens{0.2}, placed_at(0.9));
  const auto drawn_for = [&](const EyeModel& prepared, const EyeModel& shown) {
    return warp.draw(WarpLattice(prepared, LensMode::exact), ComposedWarp(shown, LensMode::exact, {}, view, {}),
                     source.span(), target.span());
  };
  CHECK(drawn_for(with_lens, eye) == CpuWarpProblem::other_lens);
  EyeModel other = with_lens;
  other.lens = with_lens.lens.with_placement({Vector2(0.001, 0.0), with_lens.lens.placement().scale});
  CHECK(drawn_for(with_lens, other) == CpuWarpProblem::other_lens);
  other = with_lens;
  other.lens_blue = Lens(RadialLens{0.21}, placed_at(0.9));
  CHECK(drawn_for(with_lens, other) == CpuWarpProblem::other_lens);
  CHECK(drawn_for(other, with_lens) == CpuWarpProblem::other_lens);
  Matrix3 broken = Matrix3::Identity();
  broken(1, 2) = std::numeric_limits<double>::quiet_NaN();
  const ScanHomography bad(ScanMatrices{broken, broken, broken});
  const ComposedWarp not_finite(eye, LensMode::none, {}, view, bad);
  CHECK(warp.draw(lattice, not_finite, source.span(), target.span()) == CpuWarpProblem::not_finite);
  RenderedView flat = view;
  flat.tangents.up = flat.tangents.down;
  const ComposedWarp no_field(eye, LensMode::none, {}, flat, {});
  CHECK(warp.draw(lattice, no_field, source.span(), target.span()) == CpuWarpProblem::not_finite);
  for (const std::uint8_t byte : target.channels) REQUIRE(byte == 5);
  CHECK(result(source.span(), target.span()) == CpuWarpProblem::none);
  CHECK(target.at(0, 0, 0) == 0);
}

TEST_CASE("every problem has words of its own") {
  for (int i = 0; i <= static_cast<int>(CpuWarpProblem::not_finite); ++i) {
    CHECK(describe(static_cast<CpuWarpProblem>(i)) != "unknown problem");
    for (int j = 0; j < i; ++j)
      CHECK(describe(static_cast<CpuWarpProblem>(i)) != describe(static_cast<CpuWarpProblem>(j)));
  }
}

TEST_CASE("what lies behind the source eye is not covered") {
  const EyeModel eye = test::plain_eye(64, 48);
  const RenderedView view = own_view(eye);
  // Turned by 120 degrees: no panel pixel looks ahead of S, though its line through S's plane may hit the picture.
  const double turn = 2.1;
  const Quaternion q_SE = so3::exp<double>(Vector3(0.0, turn, 0.0));
  const Matrix3 H = q_SE.toRotationMatrix();
  Matrix3 flip;  // (t, 1) is the direction (t, -1)
  flip << 1, 0, 0, 0, 1, 0, 0, 0, -1;
  const Matrix3 H_SE = flip * H * flip;
  const ComposedWarp composed(eye, LensMode::none, {}, view, ScanHomography(ScanMatrices{H_SE, H_SE, H_SE}));
  REQUIRE_FALSE(composed.source_pixel(Vector2(32, 24)));
  const auto source = test::noise<std::uint8_t>(64, 48, 80, true);
  for (const bool vectors : {false, true}) {
    CpuWarp warp({1, WarpFilter::bilinear, vectors});
    const auto target = drawn(warp, WarpLattice(eye, LensMode::none), composed, source);
    CHECK(std::count(target.channels.begin(), target.channels.end(), 0) == static_cast<long>(target.channels.size()));
  }
}
