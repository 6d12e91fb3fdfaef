#include "fluid/options.hpp"

#include "fluid/kernel.hpp"
#include "fluid/kick_drift.hpp"
#include "integrators/responses.hpp"

namespace atwood::fluid {
namespace {

// Ceilings of the order in time, by kernel: claims of the form "fluid{kernel=cubic}".
std::map<std::string, double> ceilings() {
  std::map<std::string, double> claims;
  for (const char* name : {"cubic", "quintic", "wendland-c2", "wendland-c4", "wendland-c6"})
    claims["fluid{kernel=" + std::string(name) + "}"] = time_order_ceiling(kernel_shape(name));
  return claims;
}

MethodInfo sph_info() {
  MethodInfo info;
  info.id = "+sph";
  info.claimed_order = ceilings();
  info.doc =
      "Weakly compressible smoothed particle hydrodynamics by sums over pairs; equations in docs/fluids.md. Pressures "
      "enter in the symmetric form, so that with shift=0 linear momentum is kept to round-off; angular momentum where "
      "viscosity is central or absent; kinetic and elastic energy and heat to the error of time stepping, beside the work of "
      "density_diffusion, shift, viscosity without heat, bodies, walls and sources (rows work-by-diffusion, -shift, "
      "-viscosity, -bodies, -walls, -sources; what is left: energy-unaccounted). At a fixed ratio of smoothing to spacing the error in space of "
      "disturbed particles has no fixed order: it reaches a plateau that falls with smoothing. Order in time: the "
      "method's own, at most that of the kernel (cubic 3, wendland-c2 4, quintic 5, wendland-c4 6, wendland-c6 8). "
      "Kicks and drifts (leapfrog, velocity Verlet and their compositions) need density=summation and no viscosity. "
      "Equal steps beyond the limit by sound, viscosity, conduction or gravity are refused with the limit. Walls: dummy "
      "particles that carry the fluid's values to their side. Bodies have no contact with each other: a run ends, with "
      "where and when, in the step in which one that moves begins to overlap a boundary or another body, and a scene "
      "that starts so is refused. Rows: neighbours, momenta, energy-budget, works.";
  info.source =
      "Monaghan, Rep. Prog. Phys. 68 (2005) 1703; Morris, Fox, Zhu, J. Comput. Phys. 136 (1997) 214; Cleary, Monaghan, "
      "J. Comput. Phys. 148 (1999) 227; Adami, Hu, Adams, J. Comput. Phys. 231 (2012) 7057";
  info.formula =
      "rho_i' = sum_j m_j F_ij (v_ij . x_ij)\n"
      "v_i' = -sum_j m_j (p_i / rho_i^2 + p_j / rho_j^2) F_ij x_ij + sum_j m_j A_ij + g\n"
      "grad W_ij = F_ij x_ij; A_ij: the viscous terms of docs/fluids.md";
  const SphOptions standard;
  declare_settings(
      info,
      {{"kernel",
        std::string("wendland-c2"),
        {one_of({"cubic", "quintic", "wendland-c2", "wendland-c4", "wendland-c6"}), "Smoothing kernel."}},
       {"smoothing",
        standard.smoothing,
        {between(0.6, 10), "Smoothing length over spacing; the support is 2 smoothing lengths, of the quintic 3."}},
       {"density",
        std::string("continuity"),
        {one_of({"continuity", "summation"}), "Density from its equation of motion, or by summation."}},
       {"viscosity",
        std::string("morris"),
        {one_of({"morris", "central", "none"}), "Form of the fluid's viscosity; central: Monaghan and Gingold's."}},
       {"density_diffusion",
        -1.0,
        {between(-1, 1),
         "Coefficient of Molteni and Colagrossi's diffusion of density; below 0: 0.1 with shift, else 0."}},
       {"shift",
        -1.0,
        {between(-1, 10),
         "Coefficient of the transport velocity that keeps particles in order; below 0: 1 where particles that move fill "
         "a periodic domain without markers (density=continuity, corrected=false), else 0."}},
       {"corrected", false, {{}, "First-order exact gradients; momentum is then not kept."}},
       {"reversible",
        false,
        {{},
         "Positions and velocities on an integer lattice (2^-40 of the spacing, 2^-44 of the sound speed): a symmetric "
         "method of kicks and drifts taken back returns to the same bits."}},
       {"lanes", true, {{}, "Pairs in vector lanes; false: the scalar loop, the same bits."}},
       {"skin",
        standard.skin,
        {between(0.001, 1), "Margin of the neighbour lists over the support; no effect on results."}},
       {"threads", std::int64_t(1), {between(1, 256), "Threads that share the rates of a step."}}});
  return info;
}

MethodInfo polynomial_info() {
  MethodInfo info;
  info.id = "+polynomial";
  info.claimed_order = ceilings();
  info.doc =
      "Weakly compressible flow on particles, with every derivative from a polynomial fitted by moving least squares; "
      "equations in docs/fluids.md. Orders in space of Taylor and Green's vortices on disturbed particles: 2 and 4, those of "
      "the degree; the Laplacian alone is an order lower there. Fixed planes are walls; free surfaces, which the fluid carries "
      "along as nodes of pressure 0, need degree=2. "
      "Nothing is conserved exactly: momenta, mass and energy are kept to the order of the fits (rows momenta; "
      "energy-budget where nothing is viscous). Particles are shifted towards even spacing and the fields take the fluxes of that motion; a "
      "filter, a term of its own, damps noise on the scale of the spacing. Order in time: the method's own, at most that "
      "of the kernel. A run ends where a neighbourhood does not determine its polynomial; the message has the condition "
      "number (this happens with degree 4 on a perfect lattice under strain). A breaking free surface also ends the run. Equal steps beyond the "
      "limit of the start's fastest modes (Arnoldi's method) are refused with the limit.";
  info.source =
      "Lancaster, Salkauskas, Math. Comp. 37 (1981) 141; Liszka, Orkisz, Computers & Structures 11 (1980) 83; Lind et "
      "al., J. Comput. Phys. 231 (2012) 1499; Oger et al., J. Comput. Phys. 313 (2016) 76";
  info.formula =
      "rho_i' = -rho_i div v\n"
      "v_i' = -(p'(rho_i) / rho_i) grad rho + (mu / rho_i) lap v + g\n"
      "derivatives at x_i: those of the polynomial q with q(x_i) = f_i that makes sum_j w_ij (q(x_j) - f_j)^2 least";
  declare_settings(
      info,
      {{"degree", std::int64_t(4), {one_of({"2", "4"}), "Degree of the fitted polynomials."}},
       {"kernel",
        std::string("wendland-c2"),
        {one_of({"cubic", "quintic", "wendland-c2", "wendland-c4", "wendland-c6"}), "Weight of the fits."}},
       {"smoothing",
        0.0,
        {between(0, 10),
         "Smoothing length over spacing; 0: 1.5 for degree 2 (1.75 with a free surface), 1.55 for degree 4."}},
       {"shift",
        -1.0,
        {between(-1, 10),
         "Coefficient of the velocity that keeps particles evenly spaced; below 0: 1, with a free surface 0."}},
       {"shift_speed",
        0.0,
        {between(0, 1e9), "Speed of shifting, m/s; 0: the largest initial speed, or a twentieth of the sound speed."}},
       {"filter",
        -1.0,
        {between(-1, 10),
         "Rate of the filter over sound speed / spacing; below 0: .005 and .1 by degree (4 between walls: .3), 1 with a free "
         "surface."}},
       {"lanes", true, {{}, "Fits in vector lanes; false: the scalar loop, the same bits."}},
       {"skin", 0.08, {between(0.001, 1), "Margin of the neighbour lists over the support; no effect on results."}},
       {"threads", std::int64_t(1), {between(1, 256), "Threads that share the rates of a step."}}});
  return info;
}

}  // namespace

SphOptions resolved(SphOptions options, const Scene& scene) {
  bool full = scene.fluid_boundaries.empty(), moves = false;
  for (int c = 0; c < scene.domain.dimensions; ++c) full = full && scene.domain.periodic_m[c] > 0;
  for (const FluidProbe& probe : scene.probes) full = full && probe.kind != ProbeKind::marker;
  for (const Fluid& fluid : scene.fluids)
    for (const Real3& v : fluid.particles.velocity_m_per_s) moves = moves || v != Real3{};
  if (options.shift < 0) options.shift = full && moves && !options.summation && !options.corrected ? 1 : 0;
  if (options.density_diffusion < 0) options.density_diffusion = options.shift > 0 ? 0.1 : 0;
  return options;
}

Result<PolynomialOptions> polynomial_request(const MethodId& id) {
  const Result<Settings> settings = settings_of_response(*find_response("polynomial"), id);
  if (!settings) return settings.fault();
  const auto number = [&](const char* name) { return std::get<double>(settings->at(name)); };
  const auto whole = [&](const char* name) { return static_cast<int>(std::get<std::int64_t>(settings->at(name))); };
  PolynomialOptions options;
  options.degree = whole("degree");
  options.kernel = kernel_shape(std::get<std::string>(settings->at("kernel")));
  options.smoothing = number("smoothing");
  options.shift = number("shift");
  options.shift_speed_m_per_s = number("shift_speed");
  options.filter = number("filter");
  options.skin = number("skin");
  options.lane_by_lane = !std::get<bool>(settings->at("lanes"));
  options.threads = whole("threads");
  return options;
}

std::optional<double> claimed_order(const MethodInfo& scheme) {
  const std::string name = scheme.id.substr(scheme.id.find('/') + 1);
  if (name == "rkmk4" || name == "lie4") return std::nullopt;  // their steps are rotations of bodies
  const bool kicks = is_kick_drift(name);
  const auto found = scheme.claimed_order.find(kicks ? "point-mass" : "mechanism");
  if (found == scheme.claimed_order.end()) return std::nullopt;
  if (!kicks && !scheme.claimed_order.contains("velocity-dependent")) return std::nullopt;  // mechanisms alone
  return found->second;
}

const std::vector<MethodInfo>& responses() {
  static const std::vector<MethodInfo> all{sph_info(), polynomial_info()};
  return all;
}

const MethodInfo* find_response(const std::string& name) { return find_response_in(responses(), name); }

Result<SphRequest> sph_request(const MethodId& id) {
  const Result<Settings> settings = settings_of_response(*find_response("sph"), id);
  if (!settings) return settings.fault();
  const auto number = [&](const char* name) { return std::get<double>(settings->at(name)); };
  const auto word = [&](const char* name) { return std::get<std::string>(settings->at(name)); };
  const auto flag = [&](const char* name) { return std::get<bool>(settings->at(name)); };
  SphRequest request;
  SphOptions& options = request.options;
  options.kernel = kernel_shape(word("kernel"));
  options.smoothing = number("smoothing");
  options.summation = word("density") == "summation";
  const std::string viscosity = word("viscosity");
  options.viscosity = viscosity == "morris"    ? Viscosity::morris
                      : viscosity == "central" ? Viscosity::central
                                               : Viscosity::none;
  options.density_diffusion = number("density_diffusion");
  options.shift = number("shift");
  options.corrected = flag("corrected");
  options.lane_by_lane = !flag("lanes");
  options.skin = number("skin");
  options.threads = static_cast<int>(std::get<std::int64_t>(settings->at("threads")));
  request.reversible = flag("reversible");
  return request;
}

MethodId integrator_part(const MethodId& id) {
  const MethodInfo* response = find_response(id.response);
  if (response == nullptr) return id;
  MethodId left = without_settings_of(*response, id);
  left.response.clear();
  return left;
}

}  // namespace atwood::fluid
