#include <string>
#include <type_traits>

#include <doctest/doctest.h>

#include <holdfast/deflection/deflect.hpp>
#include <holdfast/deflection/rendered_picture.hpp>

#include "deflection/setups.hpp"

using namespace holdfast;

// The wrong pose cannot be passed: a picture has no view before or apart from its own, what it is bound to cannot be
// changed, and a pose or a picture alone is nothing that deflect() takes.
using Image = RenderedPicture<std::string>;
static_assert(!std::is_default_constructible_v<Image>);
static_assert(!std::is_constructible_v<Image, std::string> && !std::is_constructible_v<Image, RenderedView>);
static_assert(!std::is_convertible_v<RenderedView, Image>);
static_assert(std::is_same_v<decltype(std::declval<Image&>().view()), const RenderedView&>);
static_assert(std::is_same_v<decltype(std::declval<Image&>().picture()), const std::string&>);
static_assert(!std::is_assignable_v<decltype(std::declval<Image&>().view()), RenderedView>);
static_assert(!std::is_assignable_v<decltype(std::declval<Image&>().picture()), std::string>);

template <typename Picture>
concept Deflectable = requires(const Picture& picture) {
  deflect(DeflectionSettings{}, picture, LatePoses{});
};
static_assert(Deflectable<Image>);
static_assert(!Deflectable<Rigid> && !Deflectable<std::string>);

TEST_CASE("a picture's view is the one it was given, and assignment takes both") {
  const RenderedView early{Rigid::translation(Vector3(1, 2, 3)), {-1, 1, -1, 1}, {640, 480}, HostTime(Duration(5))};
  const RenderedView late{Rigid::translation(Vector3(4, 5, 6)), {-1, 1, -1, 1}, {640, 480}, HostTime(Duration(9))};
  Image picture(early, "early");
  CHECK(picture.picture() == "early");
  CHECK(picture.view().X_WS.p() == Vector3(1, 2, 3));
  picture = Image(late, "late");
  CHECK(picture.picture() == "late");
  CHECK(picture.view().X_WS.p() == Vector3(4, 5, 6));
  CHECK(picture.view().t == HostTime(Duration(9)));
}

TEST_CASE("the picture's edges are its tangents, and pixels go there and back") {
  test::Random random(101);
  for (int i = 0; i < 50; ++i) {
    const RenderedView view = random.view(random.eye());
    const auto [width, height] = view.size;
    // A few roundings of numbers up to 2000: 1e-12.
    CHECK((source_pixel_of_tangent(view, {view.tangents.left, view.tangents.down}) - Vector2(0, 0)).norm() < 1e-12);
    CHECK((source_pixel_of_tangent(view, {view.tangents.right, view.tangents.up}) - Vector2(width, height)).norm() <
          1e-11);
    const Vector2 pixel(random.uniform(0, width), random.uniform(0, height));
    CHECK((source_pixel_of_tangent(view, tangent_of_source_pixel(view, pixel)) - pixel).norm() < 1e-11);
    CHECK(is_inside(view, pixel));
    CHECK_FALSE(is_inside(view, Vector2(pixel + Vector2(width, 0))));
    CHECK_FALSE(is_inside(view, Vector2(pixel - Vector2(0, height))));
  }
}
