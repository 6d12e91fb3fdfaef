// The second invariant of the swinging Atwood machine with the mass ratio 3.
//
// N. B. Tufillaro, Integrable motion of a swinging Atwood's machine, Am. J. Phys. 54 (1986) 142. A bob of mass m hangs
// on a rope over two fixed points, a counterweight of 3 m at the other end; r is the bob's distance from its point, th
// its angle from the downward vertical. Beside the energy,
//   I = r^2 th' (r' cos(th/2) - r th'/2 sin(th/2)) + g r^2 sin(th/2) cos^2(th/2)
// stays constant. A turn by 2 pi changes its sign, so that its size is compared.
#pragma once

#include "protocol/sample_series.hpp"
#include "scene/scene.hpp"

namespace atwood::dynamics {

// Two bodies on one rope over points (pulleys of radius 0) or pulleys without size, held at their centres of mass, one
// three times as heavy as the other, under gravity alone; the heavy one hangs vertically, the other moves in a vertical
// plane.
bool is_swinging_atwood_machine(const Scene& scene);

struct SwingingAtwood {
  Wide invariant = 0;  // |I| [m^3/s^2]
  Wide size = 0;       // sum of the sizes of its three terms
};
SwingingAtwood swinging_atwood(const Scene& scene, const SampleView& sample);

}  // namespace atwood::dynamics
