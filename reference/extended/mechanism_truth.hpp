// The certified truth of scenes with joints and ropes.
#pragma once

#include "protocol/truth.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Two formulations by two methods, in quad: coordinates of the spanning tree by extrapolation of order up to 24 (which
// gives the values, and, for up to 12 rates, again with a tolerance a thousand times larger), and maximal coordinates
// with multipliers by Gauss collocation of order 20; both are projected onto the constraints after each step. All start
// from mechanism_start(). The bar of each value is twice the largest difference, plus round-off of quad. Values: poses,
// velocities, coordinates, rates, reactions, applied forces, tensions, angles of pulleys. Components of reactions that
// the constraints leave open are marked (JointSample::not_unique) in values and bars.
//
// Stops of joints are located; their bounces are summed as a series once they would end within 1e-12 of the run. The
// truth ends, with Status::unsupported and the time in the reason, where the mechanism becomes singular, a rope slack,
// or the outcome of simultaneous impacts would depend on a convention. What is not covered at all (contacts of bodies
// in scenes with joints, prescribed motion of bodies in a mechanism, ...) is refused by name. Never throws on a scene.
Truth mechanism_truth(const Scenario& scenario, std::int64_t samples);

}  // namespace atwood
