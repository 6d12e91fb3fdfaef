// A body that floats at rest. Archimedes, On Floating Bodies, book I, proposition 5: it displaces its own weight of the
// fluid. The fluid's force on it is the opposite of its weight, at whatever height it floats; the force on the only
// fixed boundary, a plane below, is the weight of fluid and bodies (as the fluid has no other support).
#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

namespace {

template <class S> Field<S> solve_floating(const Asked& asked) {
  const Scene& scene = asked.scene;
  const Fluid& fluid = only_fluid(scene);
  const S g = upwards_of(scene).g;
  require(fluid.expansion_per_K == 0 && fluid.source.name.empty(), "expected no expansion and no source");
  require(scene.forces.empty() && scene.joints.empty() && scene.ropes.empty(),
          "expected no force but gravity and the fluid's");
  require(fluid.initial.name == "hydrostatic" && parameter(fluid.initial, "knock_m_per_s", 0) == 0,
          "expected the initial field `hydrostatic`: a fluid at rest");
  S weight = 0;
  for (const double mass : fluid.particles.mass_kg) weight += S(mass) * g;
  int floating = 0, fixed = 0;
  for (const FluidBoundary& boundary : scene.fluid_boundaries) {
    const Body& body = scene.bodies.at(static_cast<std::size_t>(boundary.body));
    if (body.fixed) {
      ++fixed;
      continue;
    }
    ++floating;
    weight += S(body.mass_kg) * g;
    require(body.velocity_m_per_s == Real3{} && body.angular_velocity_body_rad_per_s == Real3{},
            "expected the body `" + body.name + "` at rest");
    const auto* box = std::get_if<Box>(&body.shape);
    require(box != nullptr, "expected the body `" + body.name + "` to be a box");
    const Real3& a = box->half_extents_m;
    const double volume = scene.domain.dimensions == 2 ? 4 * a[0] * a[1] : 8 * a[0] * a[1] * a[2];
    require(body.mass_kg < fluid.density_kg_per_m3 * volume, "the body `" + body.name + "` sinks");
  }
  require(floating > 0 && floating + fixed == static_cast<int>(scene.bodies.size()),
          "expected a body that floats, and that every body is a boundary");
  Field<S> made;
  made.note = "the state at rest: motion that has not decayed is the method's";
  made.at = [](S) -> FieldAt<S> { return [](const Vec<S>&) { return Point<S>{}; }; };
  made.probe = [=, bodies = scene.bodies](S, const FluidProbe& probe) -> std::optional<ProbeAt<S>> {
    if (probe.kind != ProbeKind::force_on_body) return {};
    const Body& body = bodies.at(static_cast<std::size_t>(probe.body));
    if (!body.fixed) return ProbeAt<S>{S(body.mass_kg) * g, S(0)};
    if (fixed == 1) return ProbeAt<S>{weight, S(0)};
    return {};
  };
  return made;
}

}  // namespace

Solution floating() {
  return {"floating",
          "a body that floats displaces its own weight: Archimedes, On Floating Bodies, book I, proposition 5",
          {false, false, false, false},
          solve_floating<Narrow>,
          solve_floating<Wide>};
}

}  // namespace atwood::fluid_truth
