// The trees of a scene's joints as btMultiBody, and motions of bodies from their coordinates.
#pragma once

#include <BulletDynamics/Featherstone/btMultiBody.h>

#include <memory>
#include <vector>

#include "rivals/joints.hpp"

namespace atwood::bullet {

// Where a scene's body is: its multibody, null for fixed bodies and the world (-1), and its link there, -1: the base.
struct MultibodyLink {
  btMultiBody* tree = nullptr;
  int link = -1;
};

class MultibodyTrees {
 public:
  explicit MultibodyTrees(const Scene& scene);  // at the scene's start

  const std::vector<std::unique_ptr<btMultiBody>>& bodies() const { return bodies_; }
  MultibodyLink link_of(int body) const;
  // Turns vectors in the axes of a scene's body into the axes of its link, which are principal; of the world: none.
  Real4 turn_to_link(int body) const;

  void moved() { known_ = false; }  // the coordinates changed
  rivals::Motion motion(int body) const;
  rivals::JointState joint(int j) const;  // of a joint in a tree
  Real3 link_to_world(int body, const Real3& v) const;

 private:
  struct Frame {  // of a link or base: world poses, velocities in its own axes
    Real3 p_WL{};
    Real4 q_WL{1, 0, 0, 0};
    Real3 v_L{}, w_L{};
  };
  void find_axes();
  void plan();
  void build();
  void set_up(int j);
  void start(int j);
  void update() const;
  const Frame& frame_of(int body) const;

  const Scene& scene_;
  std::vector<Real4> q_BL_;  // link axes in body axes
  std::vector<int> tree_;    // of each body; -1: none
  std::vector<int> link_;    // of each body
  std::vector<int> roots_;   // of each tree: the body that is its base, -1: the world
  std::vector<int> sizes_;   // of each tree: links
  std::vector<std::unique_ptr<btMultiBody>> bodies_;
  mutable std::vector<std::vector<Frame>> frames_;  // of each tree: base, links
  mutable bool known_ = false;
  mutable std::vector<btVector3> omega_, velocity_;
};

}  // namespace atwood::bullet
