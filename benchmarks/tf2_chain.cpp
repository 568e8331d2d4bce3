#include "tf2_chain.hpp"

#include <utility>
#include <vector>

#include <geometry_msgs/TransformStamped.h>
#include <tf2/buffer_core.h>

namespace {

ros::Time ros_time(std::int64_t nanoseconds) {
  ros::Time t;
  t.fromNSec(static_cast<std::uint64_t>(nanoseconds));
  return t;
}

}  // namespace

struct Tf2Chain::Impl {
  tf2::BufferCore buffer{ros::Duration(10.0)};
  std::vector<std::pair<std::string, std::string>> chains;
  std::vector<ros::Time> times;
};

Tf2Chain::Tf2Chain() : impl_(std::make_unique<Impl>()) {}
Tf2Chain::~Tf2Chain() = default;

void Tf2Chain::set(const std::string& parent, const std::string& child, std::int64_t nanoseconds, const RigidNumbers& X,
                   bool is_static) {
  geometry_msgs::TransformStamped m;
  m.header.frame_id = parent;
  m.child_frame_id = child;
  m.header.stamp = ros_time(nanoseconds);
  m.transform.translation.x = X.px;
  m.transform.translation.y = X.py;
  m.transform.translation.z = X.pz;
  m.transform.rotation.w = X.qw;
  m.transform.rotation.x = X.qx;
  m.transform.rotation.y = X.qy;
  m.transform.rotation.z = X.qz;
  impl_->buffer.setTransform(m, "benchmark", is_static);
}

void Tf2Chain::add_chain(const std::string& target, const std::string& source) {
  impl_->chains.emplace_back(target, source);
}

void Tf2Chain::add_time(std::int64_t nanoseconds) {
  impl_->times.push_back(ros_time(nanoseconds));
}

RigidNumbers Tf2Chain::ask(std::size_t k, std::size_t c) const {
  const auto& [target, source] = impl_->chains[c];
  const geometry_msgs::Transform m = impl_->buffer.lookupTransform(target, source, impl_->times[k]).transform;
  return {m.translation.x, m.translation.y, m.translation.z, m.rotation.w, m.rotation.x, m.rotation.y, m.rotation.z};
}
