// What an HMD engine does each frame with Holdfast's core: tracked poses in; view, projection and late correction of
// each eye out.
#include <iostream>

#include <holdfast/pipeline/pipeline.hpp>

using namespace holdfast;

int main() {
  const HmdModel hmd = default_hmd();  // or io::read_hmd("assets/hmds/rift_dk2.json")
  LatestPose latest;                   // your tracker's thread publishes into it; nobody waits
  LatestPoseSource source(latest);     // the newest pose, carried on at constant velocity
  FrameLoop loop(hmd, source);

  PoseEstimate head;  // what your tracker said last: pose of the head H in the world W, and how it moves
  head.t = time_at(2.000);
  head.X_WB = Rigid::translation({0.0, 1.7, 0.0});
  head.velocity = Twist{.v_WB = {0.2, 0.0, 0.0}, .w_WB_B = {0.0, degrees(100.0).radians(), 0.0}};
  head.covariance.diagonal().setConstant(1e-8);
  latest.publish(head);

  // A frame begins: when will its pixels light, and from where will they be seen?
  const Frame frame = loop.begin_frame(head.t + std::chrono::milliseconds(2));
  for (const EyeView& eye : frame.eyes) {
    std::cout << (eye.side == EyeSide::left ? "left" : "right") << " view\n"
              << eye.view << "\nprojection\n"
              << eye.projection << "\n\n";
  }

  // ... draw both eyes; meanwhile the tracker goes on. Just before the light: where are the eyes by now?
  head.t += std::chrono::milliseconds(15);
  head.X_WB = Rigid(so3::exp<double>(Vector3(0.0, degrees(1.8).radians(), 0.0)), Vector3(0.003, 1.7, 0.0));
  latest.publish(head);
  const FrameDeflection late = loop.deflect(frame.rendered_views(), frame.deadline - std::chrono::milliseconds(1));
  std::cout << "the pictures move by " << late.turned.degrees() << " deg; the left one's texture coordinates are\n"
            << late.eyes[0].source.middle << " * (tangents, 1)\n";
  if (!late.issues.none()) std::cerr << "the frame had to make do: see FrameIssue\n";
}
