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
  /// Questions will be T_target_source.
  Tf2Chain(std::string target, std::string source);
  ~Tf2Chain();

  /// A sample of the transform that hangs `child` from `parent`.
  void set(const std::string& parent, const std::string& child, std::int64_t nanoseconds,
           const RigidNumbers& X_parent_child, bool is_static);
  /// Adds a time to ask for.
  void add_question(std::int64_t nanoseconds);
  /// The answer to question k.
  RigidNumbers ask(std::size_t k) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};
