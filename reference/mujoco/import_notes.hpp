// What an import says of a model beside the scene itself: numbers that no scene can hold, flags, and what is not taken.
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

namespace atwood::mujoco {

// The name in the model, or `kind` with the number where it has none, as "joint3". `type`: mjtObj.
std::string name_of(const mjModel& model, int type, int id, const char* kind);

// Whether <option> disables a part (mjDSBL_...). `constraint` disables limits, equalities and frictionloss too.
bool disabled(const mjModel& model, int flag);

// The first number that is not finite among those that a scene is made of, as "the axis of the joint `x` is nan";
// empty: none.
std::string not_finite(const mjModel& model);

// One sentence for each flag that is not at its default, but gravity's, which the scene takes.
std::vector<std::string> flag_notes(const mjModel& model);

// What of a joint no scene has: of all kinds armature, frictionloss and the margin of a range; of a free one all of its
// forces; the range of a ball or free joint, or of one of two joints (`alone` = false); the stiffness of a ball.
std::vector<std::string> joint_notes(const mjModel& model, int joint, bool alone);

// Geoms, sites, sensors, tendons, actuators and all else outside of the bodies and joints.
std::vector<std::string> remaining_notes(const mjModel& model);

}  // namespace atwood::mujoco
