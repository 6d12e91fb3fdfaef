// The start of mechanisms with loops and ropes: coordinates and rates are moved onto the constraints by the least
// change in the metric of the mass matrix.
//
// Positions by Newton's method: each step dq minimises dq^T M(q) dq subject to G(q) dq = -g(q), where g are the gaps of
// the closing joints (lengths over the mechanism's size) and G their derivatives. With M = L L^T and A = G L^-T the
// step is dq = -L^-T A^+ g, the pseudo-inverse from a QR decomposition of A^T with column pivoting, so that redundant
// and singular loops have a step as well. Rates by such steps, du = -L^-T A^+ (G u - b), with the ropes among the rows.
// Both take one step more than their tolerance asks for, down to round-off. Held and driven joints keep their
// coordinates and rates. The order of the bodies and joints does not matter to more than round-off. Ropes have the
// length of the start and take no part in the positions.
#pragma once

#include "scene/mechanism.hpp"

namespace atwood {

// Moves coordinates and rates of placing joints, and poses and velocities of the mechanism's free bodies; bodies and
// joints of mechanisms without loops and ropes stay, to the bit. Throws MechanismError where Newton's method does not
// converge (the loop cannot be closed with these lengths) or no rates satisfy the constraints.
void project_start(const Scene& scene, MechanismStart& start);

// How far the closing joint `joint` is from being satisfied: its gap over the mechanism's size, and its tilt [rad],
// which ever is larger; and their rates (over the larger of the mechanism's size per second and its fastest anchor's
// speed; rad/s over the larger of 1 rad/s and the fastest body's rate). Of a rope: its rate of length.
struct LoopGap {
  double gap = 0, rate = 0;
};
// Of a closing joint, and of a rope, at the start.
LoopGap joint_gap(const Scene& scene, const MechanismStart& start, int joint);
LoopGap rope_gap(const Scene& scene, const MechanismStart& start, int rope);
// Throws MechanismError where a rope does not bend around one of its pulleys as its axis says. A course that is found
// from the places of its ends cannot tell a bend by 330 degrees from one by -30: from 315 degrees on it is the latter.
void require_bends(const Scene& scene, const MechanismStart& start);

}  // namespace atwood
