#include "mechanism/start.hpp"

#include "scene/mechanism.hpp"

namespace atwood::mechanism {

Sample start_sample(const Scene& scene) {
  const MechanismStart start = mechanism_start(scene);
  Sample made;
  for (const BodyMotion& body : start.bodies) {
    BodySample& at = made.bodies.emplace_back();
    for (int k = 0; k < 3; ++k) {
      at.p_m[k] = body.p_m[k];
      at.v_m_per_s[k] = body.v_m_per_s[k];
      at.w_rad_per_s[k] = body.w_rad_per_s[k];
    }
    for (int k = 0; k < 4; ++k) at.q_wxyz[k] = body.q_wxyz[k];
  }
  for (const JointMotion& joint : start.joints) {
    JointSample& at = made.joints.emplace_back();
    for (int k = 0; k < 4; ++k) at.q[k] = joint.q[k];
    for (int k = 0; k < 3; ++k) at.u[k] = joint.u[k];
  }
  return made;
}

}  // namespace atwood::mechanism
