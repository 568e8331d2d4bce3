#include <memory>
#include <thread>

#include <doctest/doctest.h>

#include <holdfast/rendering/make_context.hpp>
#include <holdfast/rendering/render_target.hpp>

using namespace holdfast;
using namespace holdfast::rendering;

TEST_CASE("both backends give OpenGL 4.5 core and say what they are") {
  REQUIRE(!built_backends().empty());
  for (const Backend backend : built_backends()) {
    CAPTURE(backend_name(backend));
    const std::unique_ptr<Context> context = make_context(backend);
    CHECK(context->is_current());
    CHECK(context->info().backend == backend);
    CHECK(context->info().major == 4);
    CHECK(context->info().minor >= 5);
    CHECK(context->info().gl_version.find("4.5") != std::string::npos);
    CHECK(!context->info().gl_renderer.empty());
    CHECK(context->info().max_samples >= 4);
    MESSAGE(std::string(backend_name(backend)), ": ", context->info().gl_version, ", ", context->info().gl_renderer);
  }
}

TEST_CASE("names of backends are read back, and no other word is") {
  for (const Backend backend : {Backend::osmesa, Backend::egl}) CHECK(parse_backend(backend_name(backend)) == backend);
  CHECK(!parse_backend("OSMesa"));
  CHECK(!parse_backend(""));
  CHECK(!parse_backend("glx"));
}

TEST_CASE("two contexts in one process keep their own pictures") {
  for (const Backend first : built_backends()) {
    for (const Backend second : built_backends()) {
      CAPTURE(backend_name(first));
      CAPTURE(backend_name(second));
      const auto a = make_context(first);
      const auto b = make_context(second);
      CHECK(!a->is_current());
      RenderTarget red(*a, 8, 8);
      RenderTarget green(*b, 8, 8);
      red.clear({1, 0, 0, 1});
      green.clear({0, 1, 0, 1});
      CHECK(red.read_rgba() == io::Image(8, 8, {255, 0, 0, 255}));
      CHECK(green.read_rgba() == io::Image(8, 8, {0, 255, 0, 255}));
    }
  }
}

TEST_CASE("a context outlives another of the same backend") {
  for (const Backend backend : built_backends()) {
    const auto kept = make_context(backend);
    { const auto gone = make_context(backend); }
    RenderTarget target(*kept, 4, 4);
    target.clear({0, 0, 1, 1});
    CHECK(target.read_rgba().at(3, 3) == io::Rgba{0, 0, 255, 255});
  }
}

TEST_CASE("a moved target owns what it was given; a destroyed one frees it in its own context") {
  const auto a = make_context();
  const auto b = make_context();
  RenderTarget target(*a, 4, 4);
  {
    RenderTarget inner(*a, 2, 2, 4);
    inner.clear({1, 1, 1, 1});
    target = std::move(inner);
    b->make_current();
  }
  CHECK(target.width() == 2);
  CHECK(target.read_rgba().at(1, 1) == io::Rgba{255, 255, 255, 255});
}

TEST_CASE("a context moves to another thread once it is let go") {
  for (const Backend backend : built_backends()) {
    CAPTURE(backend_name(backend));
    const auto context = make_context(backend);
    RenderTarget target(*context, 4, 4);
    context->release_current();
    CHECK(!context->is_current());
    io::Image image;
    std::thread([&] {
      target.clear({0, 1, 0, 1});
      image = target.read_rgba();
      context->release_current();
    }).join();
    CHECK(image == io::Image(4, 4, {0, 255, 0, 255}));
    target.clear({0, 0, 1, 1});  // and back
    CHECK(target.read_rgba() == io::Image(4, 4, {0, 0, 255, 255}));
  }
}
