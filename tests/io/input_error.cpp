#include <string>

#include <doctest/doctest.h>

#include <holdfast/io/input_error.hpp>

using holdfast::io::InputError;

TEST_CASE("the message names file, line, key, what was found and what was expected") {
  const InputError error({.file = "hmd.json",
                          .line = 7,
                          .key = "eyes.left.fov",
                          .problem = "not a number",
                          .value = "wide",
                          .expected = "degrees"});
  CHECK(std::string(error.what()) == "hmd.json:7: eyes.left.fov: not a number (found 'wide'); expected degrees");
  CHECK(error.file() == "hmd.json");
  CHECK(error.line() == 7);
  CHECK(error.key() == "eyes.left.fov");
  CHECK(error.value() == "wide");
  CHECK(error.expected() == "degrees");
}

TEST_CASE("unknown parts leave no trace") {
  CHECK(std::string(InputError({.problem = "is empty"}).what()) == "is empty");
  CHECK(std::string(InputError({.key = "--latency-ms", .problem = "is negative", .value = "-3"}).what()) ==
        "--latency-ms: is negative (found '-3')");
  CHECK(std::string(InputError({.line = 3, .problem = "bad"}).what()) == "line 3: bad");
}

TEST_CASE("a long or binary value does not flood or harm a terminal") {
  const std::string value = "\x1b[31m" + std::string(500, 'a');
  const std::string message = InputError({.problem = "bad", .value = value}).what();
  CHECK(message.size() < 100);
  CHECK(message.find('\x1b') == std::string::npos);
}
