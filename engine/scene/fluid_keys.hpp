// The keys of fluids, of the domain they fill, of their boundaries and probes, in both forms, and the checks that span
// keys.
#pragma once

#include "scene/scenario_keys.hpp"

namespace atwood {

const Keys<Domain>& domain_keys();
const Keys<Fluid>& fluid_keys();
const Keys<FluidBoundary>& fluid_boundary_keys();
const Keys<FluidProbe>& fluid_probe_keys();

// A list of 2 numbers in a domain of two dimensions (the third is 0), or of 3.
Codec<Real3> domain_vector(Range range = any_number());

// [domain], [[fluid]], [[fluid_boundary]], [[probe]] of a file, once its bodies are there; places the particles. Throws
// InputError.
void resolve_fluids(Reading& r, const Value& document, FileDraft& draft);

// The checks of one part that need no other resolution: both forms.
void check_fluid(Reading& r, const Value& table, Fluid& fluid);
void check_boundary(Reading& r, const Value& table, const FluidBoundary& boundary);
void check_probe(Reading& r, const Value& table, const FluidProbe& probe);
// A fixed body has a velocity only as the wall of a fluid, whose surface slides in itself.
void check_sliding_walls(Reading& r, SourceLocation at);
void check_plane_scene(Reading& r, const Value& location);  // what moves stays in the plane of two dimensions

}  // namespace atwood
