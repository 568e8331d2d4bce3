#include <doctest/doctest.h>

#include <holdfast/rendering/composition.hpp>
#include <holdfast/rendering/image_compare.hpp>

using namespace holdfast;
using namespace holdfast::rendering;

TEST_CASE("equal pictures are equal; the largest difference is found with its place and values") {
  io::Image a(8, 4, {10, 20, 30, 255});
  CHECK(compare(a, a).within(0));
  CHECK(describe(compare(a, a)) == "the pictures are identical");
  io::Image b = a;
  b.set(3, 1, {10, 22, 30, 255});
  b.set(5, 2, {10, 20, 25, 255});
  const ImageDifference d = compare(a, b);
  CHECK(d.max == 5);
  CHECK(d.x == 5);
  CHECK(d.y == 2);
  CHECK(d.channel == 2);
  CHECK(d.a == 30);
  CHECK(d.b == 25);
  CHECK(d.differing_pixels == 2);
  CHECK(d.mean == doctest::Approx(7.0 / (8 * 4 * 4)));
  CHECK(d.within(5));
  CHECK(!d.within(4));
  CHECK(describe(d).find("pixel (5, 2) blue: 30 against 25") != std::string::npos);
}

TEST_CASE("pictures of different size are not within any tolerance") {
  CHECK(!compare(io::Image(2, 3), io::Image(3, 2)).within(255));
  CHECK(describe(compare(io::Image(2, 3), io::Image(3, 2))) == "the pictures differ in size");
  CHECK(compare(io::Image(), io::Image()).within(0));
}

TEST_CASE("overlay adds light and saturates; difference is black where pictures agree") {
  const io::Image a(2, 1, {100, 200, 0, 255}), b(2, 1, {50, 100, 7, 255});
  CHECK(overlay(a, b) == io::Image(2, 1, {150, 255, 7, 255}));
  CHECK(difference(a, b) == io::Image(2, 1, {50, 100, 7, 255}));
  CHECK(difference(b, a) == difference(a, b));
  CHECK(difference(a, a) == io::Image(2, 1, {0, 0, 0, 255}));
}
