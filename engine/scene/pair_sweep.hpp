// Seeded scenes of two bodies close to each other, for the comparison of contact queries. Each process generates the
// same poses.
//
// Sizes run over six decades (1e-3 to 1e3 m, two more between the two bodies); of boxes and hulls one in five is a slab
// and one in five a needle, a thousand times thinner. A direction n is drawn (often a face's normal), the supports of
// both bodies along it are brought to a distance g, and g is positive for half of the poses: then n separates them and
// g is the distance. Otherwise they overlap by about |g|. |g| is from 1e-8 to 1 of the smaller body's size; one pose in
// ten has a deep overlap.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

const std::vector<std::string>& sweep_pairs();  // "sphere-sphere", "box-box", ...
const std::vector<std::string>& touch_pairs();  // those that are swept in time

inline constexpr double kSweepEndS = 1;  // of swept poses

// Pose `index` of a pair, bodies "a" and "b" in the pair's order; depends on its arguments only. Swept: the
// bodies reach the pose at some time within kSweepEndS on straight lines, and all bodies except planes rotate. Throws
// std::invalid_argument for an unknown pair, with a list of the known ones.
Scene sweep_scene(const std::string& pair, std::uint64_t seed, std::int64_t index, bool swept);

// Bounding radius of the smaller bounded body about its origin [m], the scale of depths and distances.
double pair_size_m(const Scene& scene);
double largest_radius_m(const Scene& scene);  // of the bounded bodies

}  // namespace atwood
