// A scene as the XML that MuJoCo compiles. Conventions of MuJoCo:
//   - the smallest mass and inertia of a mobile body is 1e-15: MuJoCo's compiler refuses lighter bodies;
//   - a body that rotates has a free joint (position and velocity in world axes, angular velocity in body axes), a
//     point mass has three slide joints along the world's axes;
//   - body i of the scene is the <body> "b<i>": of the world, or of the parent of the joint that places it
//     (mechanism.hpp);
//   - extents are half extents, the axis of a capsule and cylinder is z, and its half length excludes the caps, as in
//     the scene;
//   - a mesh collides as its convex hull;
//   - a contact has one friction coefficient, the larger of the two geoms' unless priorities differ (pair_laws.hpp).
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "protocol/method.hpp"

namespace atwood::mujoco {

struct FreeModel {
  void operator()(mjModel* model) const { mj_deleteModel(model); }
};
struct FreeData {
  void operator()(mjData* data) const { mj_deleteData(data); }
};
using Model = std::unique_ptr<mjModel, FreeModel>;
using Data = std::unique_ptr<mjData, FreeData>;

// A model file and those that it includes, by name. MuJoCo's reader of XML admits some hundred levels of elements in
// one file; what it includes counts from its own first level, so that longer chains of bodies go on in another file.
struct ModelFiles {
  std::string main;
  std::vector<std::pair<std::string, std::string>> included;
};

// `held[i]`: body i is at rest, also if the scene releases it later.
ModelFiles xml_of(const Scene& scene, const Settings& settings, const std::vector<bool>& held);

// Throws std::invalid_argument with MuJoCo's message.
Model compile(const ModelFiles& files);

// Number of contacts that fit into the buffers; 0: not even two per body fit into a buffer of at most 2 GiB.
std::int64_t room_for_contacts(const Scene& scene, const Settings& settings);

// Rows of the constraint problem that a contact of this law takes.
int rows_of(const PairLaw& law, bool elliptic);

// Number of pairs of bodies that can touch: the length of an explicit list.
std::int64_t listed_pairs(const Scene& scene);
inline constexpr std::int64_t kMaxListedPairs = 5000;

}  // namespace atwood::mujoco
