// What an HMD engine does each frame with Holdfast's core: measurement in; view and projection of each eye out.
#include <iostream>

#include <holdfast/holdfast.hpp>

using namespace holdfast;

int main() {
  const HmdModel hmd = default_hmd();  // or io::read_hmd("assets/hmds/rift_dk2.json")

  PoseEstimate head;  // what your tracker said last: pose of the head H in the world W, and how it moves
  head.t = time_at(2.000);
  head.X_WB = Rigid::translation({0.0, 1.7, 0.0});
  head.velocity = Twist{.v_WB = {0.2, 0.0, 0.0}, .w_WB_B = {0.0, degrees(100.0).radians(), 0.0}};
  head.covariance.diagonal().setConstant(1e-8);

  const HostTime glow = head.t + std::chrono::milliseconds(60);  // when these pixels will light
  const PredictionResult prediction = predict_constant_velocity(head, glow);
  if (prediction.status != PredictionStatus::ok) std::cerr << "prediction: " << to_string(prediction.status) << '\n';

  for (const EyeModel& eye : {hmd.left, hmd.right}) {
    const Rigid X_EW = (prediction.X_WB * eye.X_HE).inverse();
    const Matrix4 view = X_EW.matrix();
    const Matrix4 projection = projection_matrix(eye, ClipPlanes{.near_m = 0.05, .far_m = 100.0});
    std::cout << (eye.side == EyeSide::left ? "left" : "right") << " view\n"
              << view << "\nprojection\n"
              << projection << "\n\n";
  }
}
