#include "contact/options.hpp"

#include "contact/stepping_options.hpp"
#include "integrators/responses.hpp"

namespace atwood {

namespace {

std::vector<MethodInfo> make_responses() {
  MethodInfo impulse;
  impulse.id = "+impulse";
  impulse.doc =
      "Time stepping in small substeps. Fast approaches of contacts with restitution are resolved as impacts, one after "
      "another in the order of their times; all other contacts are solved at the level of velocities, with a round "
      "friction cone. Overlap is corrected only in the positions. Few contacts are solved together by Newton's method, "
      "many by warm-started sweeps of projected Gauss-Seidel. Where no contact is possible, the scheme is used without the response.";
  impulse.doc +=
      " A scene's simultaneous_impacts must suit all its pairs: sequential if all have restitution (at one instant the "
      "fastest approach first, ties in the scene's order), together if none has; otherwise the scene is refused. "
      "Cylinders and capsules that roll are stepped by leapfrog: contacts are detected and Euler's equations are stepped "
      "in every substep.";
  impulse.doc +=
      " Mechanisms with contacts are stepped only by symplectic-euler: bodies in their own coordinates, contacts, stops "
      "and joints in one solve of every substep (SHAKE), by at least 30 sweeps. Claims: order 1; joints without gap, to "
      "round-off; momenta kept; no drift of the energy between contacts; dampers along joints implicit, springs explicit. "
      "Ropes and sleeping are refused.";
  impulse.source =
      "Moreau (1988); Stewart and Trinkle (1996); Alart and Curnier (1991); Macklin et al., Small Steps (2019); mechanisms: Ryckaert, Ciccotti, "
      "Berendsen, J. Comput. Phys. 23 (1977) 327";
  impulse.formula =
      "M (v_new - v) = h F + G^T P, where u = G v_new and b is the velocity bias\n"
      "contact: P_n >= 0, u_n + b >= 0, P_n (u_n + b) = 0\n"
      "friction: |P_t| <= mu P_n; where it slips P_t = -mu P_n u_t / |u_t|\n"
      "impact: u_n = -e u_n before it";
  declare_settings(impulse, stepping::setting_table());
  MethodInfo event;
  event.id = "+event";
  event.doc =
      "Impacts located to round-off on the method's own numerical flow; between them, lasting contacts as constrained "
      "motion.";
  event.doc +=
      " restitution: newton (speeds; can gain energy in eccentric impacts with friction), poisson (impulses), stronge "
      "(work). simultaneous: sequential (the pair that approaches fastest first, ties in the scene's order, until none "
      "approaches; points of one pair at once) or together (one complementarity problem; there Stronge's law is taken "
      "as Poisson's). A scene's simultaneous_impacts overrides the default, and a setting that contradicts it is "
      "refused. Where Coulomb's law has no contact force (Painleve), an impact without collision follows under poisson "
      "and stronge; under newton, and where the law has several solutions, the run ends unsupported. For methods that "
      "split forces or expand them in series, rk4 (with a tolerance: dopri5) integrates lasting contacts.";
  event.doc += " Scenes in which bodies on joints or ropes may touch something are refused.";
  event.source = "Hairer, Norsett, Wanner (1993), II.6; Pfeiffer and Glocker (1996); Stronge, Impact Mechanics (2000)";
  event.formula =
      "impact at g(t) = 0: M (v_after - v_before) = G^T P, |P_t| <= mu P_n\n"
      "  newton: u_n after = -e u_n before\n"
      "  poisson: P_r = e P_c, of the impulses of compression (c) and restitution (r)\n"
      "  stronge: W_r = -e^2 W_c, of their work\n"
      "between impacts: M v' = F + G^T f\n"
      "  f_n >= 0, g'' >= 0, f_n g'' = 0";
  declare_settings(
      event, {{"restitution", std::string("newton"), {one_of({"newton", "poisson", "stronge"}), "Law of restitution."}},
              {"simultaneous",
               std::string("sequential"),
               {one_of({"sequential", "together"}),
                "How impacts at one instant are solved: one after another, or as one "
                "problem. A scene's simultaneous_impacts goes before the default."}}});
  MethodInfo penalty;
  penalty.id = "+penalty";
  penalty.doc =
      "Contacts as springs and dashpots: forces for any integrator. A pair with a contact_law uses that law; any other "
      "a linear one, so stiff that an impact at `impact_speed_m_per_s` (0: the scene's largest) has a depth of "
      "`overlap` of the smaller body, and damped to give the pair's restitution (or by `damping_ratio`, if above 0). "
      "Friction: a tangential spring of `tangential_ratio` of the normal stiffness, limited by Coulomb's cone. Steps "
      "beyond the method's stability limit on the stiffest contact are refused. Impacts last and have no instant: a "
      "scene with simultaneous_impacts is refused, unless all its pairs have a contact_law.";
  penalty.doc += " Mechanisms, ropes and closed loops are supported; bodies that a joint ties together do not collide.";
  penalty.source =
      "Cundall and Strack, Geotechnique 29 (1979) 47; Hunt and Crossley, J. Appl. Mech. 42 (1975) 440; "
      "Schwager and Poeschel, Granular Matter 9 (2007) 465";
  penalty.formula =
      "linear: f_n = k d + c d', of the depth d\n"
      "Hertz: f_n = k d^(3/2) (1 + c d')\n"
      "f_n = 0 where that pulls and the law has no `pull`\n"
      "f_t = -k_t s - c_t u_t, shortened to |f_t| <= mu f_n, of the tangential displacement s and velocity u_t\n"
      "k_t = tangential_ratio f_n / d\n"
      "c_t = tangential_ratio c (Hertz: 0)\n"
      "c = 2 zeta sqrt(k m) where the pair names no law, m its reduced mass";
  declare_settings(
      penalty,
      {{"overlap", 1e-3, {between(1e-9, 0.5), "Depth of an impact at impact_speed_m_per_s, over the smaller body."}},
       {"impact_speed_m_per_s",
        0.0,
        {between(0, 1e6), "Speed of the impact that sets the stiffness; 0: the scene's own.", "m/s"}},
       {"damping_ratio", 0.0, {between(0, 100), "Damping over critical damping; 0: by the pair's restitution."}},
       {"tangential_ratio", 2.0 / 7, {between(0, 100), "Tangential over normal stiffness."}}});
  return {impulse, event, penalty};
}

}  // namespace

const std::vector<MethodInfo>& contact_responses() {
  static const std::vector<MethodInfo> all = make_responses();
  return all;
}

const MethodInfo* find_response(const std::string& name) { return find_response_in(contact_responses(), name); }

Result<Settings> response_settings(const MethodId& id) {
  const MethodInfo* response = find_response(id.response);
  if (response == nullptr) return Settings{};
  return settings_of_response(*response, id);
}

MethodId integrator_part(const MethodId& id) {
  const MethodInfo* response = find_response(id.response);
  return response == nullptr ? id : without_settings_of(*response, id);
}

}  // namespace atwood
