#include "scene/driven_closings.hpp"

#include <algorithm>

#include "scene/mechanism.hpp"

namespace atwood {
namespace {

const Joint& joint_at(const Scene& scene, int joint) { return scene.joints[static_cast<std::size_t>(joint)]; }
const Body& body_at(const Scene& scene, int body) { return scene.bodies[static_cast<std::size_t>(body)]; }

bool hangs_on(const Scene& scene, const std::vector<int>& placing, int body, int other) {
  while (body >= 0 && body != other) {
    const int joint = placing[static_cast<std::size_t>(body)];
    body = joint < 0 ? -1 : joint_at(scene, joint).parent;
  }
  return body == other;
}

bool is_held(const Scene& scene, int joint) {
  return std::any_of(scene.joints.begin(), scene.joints.end(), [&](const Joint& each) {
    return std::find(each.hold.begin(), each.hold.end(), joint) != each.hold.end();
  });
}

}  // namespace

std::string obstacle_to_placing(const Scene& scene, int joint) {
  const std::vector<int> placing = placing_joints(scene);
  const Joint& driven = joint_at(scene, joint);
  const std::string child = "its child `" + body_at(scene, driven.child).name + "`";
  if (!rotates(body_at(scene, driven.child))) return child + " is a point mass";
  if (hangs_on(scene, placing, driven.parent, driven.child))
    return "its parent `" + body_at(scene, driven.parent).name + "` hangs on " + child;
  const int placed_by = placing[static_cast<std::size_t>(driven.child)];
  if (placed_by < 0) return "";
  const Joint& other = joint_at(scene, placed_by);
  const std::string by = child + " is placed by the joint `" + other.name + "`";
  if (other.driven_rate) return by + ", which is driven too";
  if (other.limits) return by + ", which has limits";
  if (is_held(scene, placed_by)) return by + ", which `hold` keeps";
  return "";
}

std::vector<ExchangedJoints> let_driven_joints_place(Scene& scene) {
  std::vector<ExchangedJoints> exchanged;
  for (std::size_t j = 0; j < scene.joints.size(); ++j) {
    Joint& driven = scene.joints[j];
    if (!driven.closes_loop || !driven.driven_rate) continue;
    if (!obstacle_to_placing(scene, static_cast<int>(j)).empty()) continue;
    const int placed_by = placing_joints(scene)[static_cast<std::size_t>(driven.child)];
    exchanged.push_back({static_cast<int>(j), placed_by});
    if (placed_by >= 0) {
      Joint& closing = scene.joints[static_cast<std::size_t>(placed_by)];
      closing.closes_loop = true;
      closing.assemble = driven.assemble;
      closing.hold = driven.hold;
    }
    driven.closes_loop = driven.assemble = false;
    driven.hold.clear();
  }
  return exchanged;
}

}  // namespace atwood
