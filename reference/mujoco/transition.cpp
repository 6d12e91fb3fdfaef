#include "mujoco/transition.hpp"

#include <algorithm>
#include <stdexcept>

#include "mujoco/mechanism.hpp"
#include "mujoco/model.hpp"
#include "mujoco/mujoco.hpp"
#include "mujoco/mujoco_world.hpp"

namespace atwood::mujoco {
namespace {

// MuJoCo's default handlers write to a file in the working directory, and end the process on an error.
void hear(const char*) {}
void fail(const char* text) { throw std::invalid_argument(std::string("MuJoCo gave up: ") + text); }

std::string refusal_of(const Scene& scene, const Settings& settings) {
  if (const auto fault = refusal(scene, settings)) return fault->reason;
  for (const JointForce& force : scene.joint_forces)
    if (std::holds_alternative<JointTorque>(force))
      return "MuJoCo's derivatives are of its own forces; motors are evaluated by the adapter";
  return "";
}

// Sets the start of a body that floats; MuJoCo's first rate of it.
int place_free_body(const Body& body, int id, const mjModel* model, mjData* data) {
  const int joint = model->body_jntadr[id], first = model->jnt_dofadr[joint];
  mjtNum *q = data->qpos + model->jnt_qposadr[joint], *v = data->qvel + first;
  const bool turns = model->jnt_type[joint] == mjJNT_FREE;  // else three slides from the start
  for (int k = 0; k < 3; ++k) {
    q[k] = turns ? body.position_m[k] : 0;
    v[k] = body.velocity_m_per_s[k];
    if (turns) v[3 + k] = body.angular_velocity_body_rad_per_s[k];
  }
  if (turns) std::copy(body.orientation_wxyz.begin(), body.orientation_wxyz.end(), q + 3);
  return first;
}

// Puts the scene's start into `data`; MuJoCo's numbers of the rates, in the order of Transition.
std::vector<int> place_all(const Scene& scene, const mjModel* model, mjData* data) {
  std::vector<int> dofs;
  const std::vector<int> placing = rivals::placing_joints(scene);
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    if (scene.bodies[i].fixed || placing[i] >= 0) continue;
    const int id = mj_name2id(model, mjOBJ_BODY, ("b" + std::to_string(i)).c_str());
    const int first = place_free_body(scene.bodies[i], id, model, data);
    for (int k = 0; k < model->body_dofnum[id]; ++k) dofs.push_back(first + k);
  }
  const std::vector<int> ids = joint_ids(scene, model);
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    if (ids[j] < 0) continue;
    const Joint& joint = scene.joints[j];
    set_joint(joint.kind, ids[j], {joint.coordinates, joint.rates}, model, data);
    for (int k = 0; k < rate_count(joint.kind); ++k) dofs.push_back(model->jnt_dofadr[ids[j]] + k);
  }
  return dofs;
}

}  // namespace

Transitions transitions(const Scene& scene, double h_s, const std::vector<double>& steps) {
  mju_user_warning = hear;
  mju_user_error = fail;
  const Settings settings = mujoco_engine().methods.front().settings;
  if (const std::string reason = refusal_of(scene, settings); !reason.empty()) return {reason, {}};
  const Model model = compile(xml_of(scene, settings, std::vector<bool>(scene.bodies.size(), false)));
  const Data data(mj_makeData(model.get()));
  if (!data) return {"MuJoCo could not allocate its buffers", {}};
  model->opt.timestep = h_s;
  const std::vector<int> dofs = place_all(scene, model.get(), data.get());
  mj_forward(model.get(), data.get());
  if (data->nefc > 0)
    return {"contacts or stops act at this instant: MuJoCo's derivatives have them, the exact ones have not", {}};
  const std::size_t n = dofs.size(), nv = static_cast<std::size_t>(model->nv);
  if (n != nv) return {"MuJoCo's model has other rates than the scene", {}};
  const auto place = [&](std::size_t i) { return (i < n ? 0 : n) + static_cast<std::size_t>(dofs[i % n]); };
  Transitions found;
  for (const bool centred : {false, true})
    for (const double step : steps) {
      std::vector<mjtNum> A(4 * n * n), sorted(4 * n * n);
      mj_resetData(model.get(), data.get());
      place_all(scene, model.get(), data.get());
      mjd_transitionFD(model.get(), data.get(), step, centred, A.data(), nullptr, nullptr, nullptr);
      for (std::size_t i = 0; i < 2 * n; ++i)
        for (std::size_t k = 0; k < 2 * n; ++k) sorted[i * 2 * n + k] = A[place(i) * 2 * n + place(k)];
      found.all.push_back({step, centred, std::move(sorted)});
    }
  return found;
}

}  // namespace atwood::mujoco
