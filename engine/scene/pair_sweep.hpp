// Seeded scenes of two bodies near each other, for comparing contact queries: the same poses for every engine, made
// where they are asked for.
//
// Sizes run over six decades (1e-3 to 1e3 m, two more between the two bodies); of boxes and hulls one in five is a slab
// and one in five a needle, a thousand times thinner. A direction n is drawn (often a face's normal), the supports of
// both bodies along it are brought to a distance g, and g is positive for half of the poses: then n separates them and
// g is the distance. Else they overlap, by about |g|. |g| runs from 1e-8 of the smaller body's size up to it; one pose
// in ten lies deep inside.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "scene/scene.hpp"

namespace atwood {

const std::vector<std::string>& sweep_pairs();  // "sphere-sphere", "box-box", ...
const std::vector<std::string>& touch_pairs();  // those that are swept in time

inline constexpr double kSweepEndS = 1;  // of swept poses

// Pose `index` of a pair, bodies "a" and "b" in the pair's order; depends on nothing but its arguments. Swept: the
// bodies would come to the pose at some time within kSweepEndS, on straight lines, and everything but planes spins.
// Throws std::invalid_argument on an unknown pair, naming the known ones.
Scene sweep_scene(const std::string& pair, std::uint64_t seed, std::int64_t index, bool swept);

// Bounding radius of the smaller bounded body about its origin [m]: what depths and distances are compared with.
double pair_size_m(const Scene& scene);
double largest_radius_m(const Scene& scene);  // of the bounded bodies

}  // namespace atwood
