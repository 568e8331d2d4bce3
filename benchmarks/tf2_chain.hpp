// tf2::BufferCore behind plain numbers: ROS's headers need C++17, holdfast's C++20, so they meet here.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>

struct RigidNumbers {
  double px, py, pz;
  double qw, qx, qy, qz;
};

class Tf2Chain {
 public:
  Tf2Chain();
  ~Tf2Chain();

  /// A sample of the transform that hangs `child` from `parent`.
  void set(const std::string& parent, const std::string& child, std::int64_t nanoseconds,
           const RigidNumbers& X_parent_child, bool is_static);
  /// Adds a chain T_target_source, and a time, that questions can be about.
  void add_chain(const std::string& target, const std::string& source);
  void add_time(std::int64_t nanoseconds);
  /// The answer for time k and chain c.
  RigidNumbers ask(std::size_t k, std::size_t c) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
