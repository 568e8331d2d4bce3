// The set of a frame's issues.
#include <set>
#include <string>

#include <doctest/doctest.h>

#include <holdfast/pipeline/frame_issues.hpp>

using namespace holdfast;

TEST_CASE("every issue is a bit of its own with a name of its own") {
  std::set<std::string> names;
  FrameIssues all;
  CHECK(all.none());
  for (const FrameIssue issue : frame_issues) {
    FrameIssues one;
    one.add(issue);
    for (const FrameIssue other : frame_issues) CHECK(one.has(other) == (other == issue));
    CHECK(one.bits() == std::uint32_t{1} << names.size());
    names.insert(std::string(to_string(issue)));
    all.add(one);
  }
  CHECK(names.size() == frame_issues.size());
  for (const FrameIssue issue : frame_issues) CHECK(all.has(issue));
  CHECK_FALSE(all == FrameIssues{});
}

TEST_CASE("a prediction's status is an issue unless it is ok") {
  FrameIssues issues;
  issues.add(PredictionStatus::ok);
  CHECK(issues.none());
  issues.add(PredictionStatus::clamped);
  CHECK(issues.has(FrameIssue::clamped));
  issues.add(PredictionStatus::no_velocity);
  issues.add(PredictionStatus::backwards);
  issues.add(PredictionStatus::not_finite);
  for (const FrameIssue issue : frame_issues) {
    const bool expected = issue == FrameIssue::clamped || issue == FrameIssue::no_velocity ||
                          issue == FrameIssue::backwards || issue == FrameIssue::not_finite;
    CHECK(issues.has(issue) == expected);
  }
}
