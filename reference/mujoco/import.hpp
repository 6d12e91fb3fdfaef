// A scene from an MJCF (or URDF) file, through MuJoCo's own parser and compiler: defaults, compiler options and
// included files are resolved by MuJoCo itself.
//
// Taken: gravity; bodies with their masses, inertias and poses at qpos0; joints hinge, slide, ball and free, two hinges
// of orthogonal axes through one point as a universal joint, a hinge and a slide of one axis as a cylindrical one;
// ranges of hinges and slides as stops; stiffness, springref and damping; the equality constraints connect and weld as
// joints that close loops. A body without joints is fixed to its parent; one without mass becomes a part of its parent;
// bodies fixed to the world are the world. What a flag of <option> disables is not taken: gravity, ranges, springs and
// dampers, equality constraints.
#pragma once

#include <string>
#include <vector>

#include "protocol/fault.hpp"

namespace atwood::mujoco {

struct ImportedScene {
  std::string toml;                // a scenario file, with what is not taken in its first comment
  std::vector<std::string> notes;  // what is not taken or changed, in sentences
};

// Fails for a file that MuJoCo's compiler refuses, for numbers that are not finite, and for a model
// that cannot be a scene: other combinations of joints on one body, equality constraints between joints or tendons, no
// body that moves.
Result<ImportedScene> import_model(const std::string& path);

}  // namespace atwood::mujoco
