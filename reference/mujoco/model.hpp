// A scene as the XML that MuJoCo compiles. Conventions met on the way:
//   - MuJoCo's floor under mass and inertia of what moves is 1e-15: lighter bodies its compiler refuses, in its own
//   words;
//   - a body that rotates gets a free joint (position and velocity in the world, rate in body axes), a point mass three
//   slides;
//   - every body of the scene is a <body> of the world, in the scene's order: body i is MuJoCo's i + 1;
//   - extents are half extents, a capsule's and cylinder's axis is z and its half length excludes the caps: as the
//   scene's;
//   - a mesh is collided as its convex hull;
//   - friction is one coefficient a contact, the larger of two geoms' unless priority decides (pair_laws.hpp).
#pragma once

#include <mujoco/mujoco.h>

#include <memory>
#include <string>
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

// `held[i]`: body i stands still, whatever it is in the scene.
std::string xml_of(const Scene& scene, const Settings& settings, const std::vector<bool>& held);

// Throws std::invalid_argument with MuJoCo's words.
Model compile(const std::string& xml);

// Contacts that the buffers have room for; 0: not even two a body, which one buffer of 2 GiB at most can't hold.
std::int64_t room_for_contacts(const Scene& scene, const Settings& settings);

// Rows of the constraint problem that a contact of this law takes.
int rows_of(const PairLaw& law, bool elliptic);

// Pairs of bodies that can meet; what an explicit list would hold.
std::int64_t listed_pairs(const Scene& scene);
inline constexpr std::int64_t kMostListedPairs = 5000;

}  // namespace atwood::mujoco
