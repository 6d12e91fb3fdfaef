// Joints and ropes in the lines of samples. Members, all optional:
//
//   "joints":[[q...,u...,fx,fy,fz,tx,ty,tz],...]   in the order of the scene's joints; coordinates and rates as many as
//   the
//                                                  joint has (fixed 0 and 0; hinge, slider 1 and 1; cylindrical,
//                                                  universal
//                                                  2 and 2; ball 4 and 3), or 4 and 3 padded by zeros; without
//                                                  reactions
//                                                  [q...,u...] alone
//   "joint_bars":[[...],...]                       of a truth, in the same layout
//   "joint_applied":[[...],...]                    springs, dampers and motors along each rate
//   "joint_stops":[[...],...]                      what stops exert along each rate, 0 away from them; absent: not
//                                                  reported
//   "not_unique":[0,...]                           bits 0 to 2: components of the force that the constraints leave
//   open; 3
//                                                  to 5: of the torque
//   "ropes":[[tension_N,pulley0_rad,...],...]      in the order of the scene's ropes; "rope_bars" of a truth
#pragma once

#include <string>
#include <vector>

#include "protocol/json_lines.hpp"

namespace atwood::wire {

// Appends the members that the sample has. `joints` are the scene's, for the number of their coordinates; null: padded.
void append_joints(std::string& line, const SampleView& sample, const SampleView* bar,
                   const std::vector<Joint>* joints);

// What a line says of joints, as it comes: members of a JSON object have no order.
struct JointMembers {
  std::vector<std::array<Wide, 3>> applied, stops;
  std::vector<unsigned> not_unique;
  std::vector<int> coordinates;  // of each row of "joints"
};
bool is_joint_member(const std::string& member);
// Takes one element of such a member. Throws Garbage, also beyond the limits.
void take_joint_element(const std::string& member, const Json& value, const Limits& most, Answer& answer,
                        JointMembers& members);
// Joins the members. Throws Garbage where they differ in number.
void join_joint_members(const JointMembers& members, Answer& answer);

}  // namespace atwood::wire
