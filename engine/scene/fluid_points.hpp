// Particles at one spacing: where a fluid's region puts them, their masses and their initial state.
//
// Boxes hold a lattice at the centres of cells of the spacing, x the slowest index, then y, then z; the spacing divides
// every edge (to 1e-9 of it). Circles, ellipses and balls hold the points of such a lattice around their middle that
// lie inside, or rings. `disturbed` moves every coordinate of a lattice by disturbance spacing u, u uniform in [0, 1)
// from SplitMix64 with the fluid's seed, in the order of the particles and for each in the order x, y, z.
//
// Rings of a circle (two dimensions): ring k = 1..radius / spacing has the radius (k - 1/2) spacing and 6 k - 3
// particles at the angles 2 pi (j + (k mod 2) / 2) / (6 k - 3): all have the same area, pi spacing^2 / 3. Those of an
// ellipse are the circle's of radius sqrt(a b), stretched along the axes.
//
// The mass of a particle is the initial density there times its volume: spacing^dimensions in boxes and files, the
// region's volume over the count in the others. Lattice points inside a boundary body of finite extent are left out.
#pragma once

#include <string>

#include "scene/scene.hpp"

namespace atwood {

inline constexpr std::size_t kMaxParticles = 4'000'000;

// Fills Fluid::particles of all fluids from their regions, spacings and initial fields. Positions of a fluid that came
// from a file stay. Throws InputError: a spacing that does not divide a region, no particle or more than
// kMaxParticles, fluids that overlap (particles nearer than half the smaller spacing), a fluid behind a plane that
// bounds it, a density that is not positive.
void place_particles(Scene& scene);

// The scene of a scenario at this spacing and sound speed, with its particles. A value of 0: as the fluids say. Throws
// InputError: as place_particles, and a boundary that leaks at this spacing.
Scene at_resolution(const Scenario& scenario, double spacing_m, double sound_speed_m_per_s);

// Why the spacing does not fill the fluid's region: "1 m along x is 33 spacings of 0.03 m and 0.01 m more"; empty: it
// does.
std::string unfilled(const Fluid& fluid, int dimensions, double spacing_m);

// Why a boundary of the scene lets particles act through it at the spacing of its fluids, with the figures: a solid
// thinner than two spacings, a rectangle. Empty: it does not.
std::string leaking(const Scene& scene, std::size_t boundary);

// The thinnest extent of a body's solid [m]: 0 for a rectangle, infinite for a plane and for shapes that are not
// bounded by a formula (convex, mesh, compound). In two dimensions of its section.
double thickness_m(const Body& body, int dimensions);

// How far the point lies outside a plane, sphere, capsule, cylinder or box (negative inside); infinite for other
// shapes.
double distance_outside_m(const Body& body, const Real3& x);

}  // namespace atwood
