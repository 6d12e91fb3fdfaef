#include "closed_form/equilibrium.hpp"

#include <algorithm>
#include <vector>

#include "closed_form/resting_contacts.hpp"
#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

using V = Vec<double>;
constexpr int kMaxSweeps = 20000;
constexpr double kRoundOff = 1e-14;
constexpr double kIndependent = 1e-3;  // of unit normals: what is left of one beside the others
constexpr double kSmallSlope = 1e-6;   // below it a contact without friction may seem balanced

struct Velocity {
  V v{}, w_B{};
};

// Contact impulses that cancel gravity's impulse of one second. Conjugate gradients give those of least sum of squares
// that stop all bodies without regard to the cones; for stacks and walls they often lie in the cones. From their
// projection onto the cones, projected Gauss-Seidel sweeps continue until no body moves.
class ContactSolver {
 public:
  ContactSolver(const std::vector<RestingBody>& solids, const std::vector<RestingContact>& contacts, const V& g)
      : solids_(solids), contacts_(contacts), velocities_(solids.size()), impulses_(contacts.size()) {
    for (std::size_t i = 0; i < solids.size(); ++i)
      if (solids[i].free) velocities_[i].v = g;
    for (const RestingContact& contact : contacts) {
      const V t = std::fabs(contact.n[0]) < 0.6 ? cross(contact.n, V{1, 0, 0}) : cross(contact.n, V{0, 1, 0});
      const V t0 = (1 / length(t)) * t, t1 = cross(contact.n, t0);
      tangents_.push_back({t0, t1});
      inverse_mass_.push_back({mobility(contact, contact.n), mobility(contact, t0) + mobility(contact, t1)});
    }
  }
  // A first guess: where conjugate gradients do not converge, the sweeps have more to do, and balances() judges the
  // end.
  void start() {
    const std::size_t count = contacts_.size();
    std::vector<V> x(count), residual(count), direction(count), answer(count);
    for (std::size_t k = 0; k < count; ++k)
      residual[k] = direction[k] = -1.0 * components(k, relative_velocity(contacts_[k], velocities_));
    double square = sum(residual, residual);
    const double tolerance = 1e-24 * square;
    for (std::size_t tries = 0; tries < 6 * count && square > tolerance; ++tries) {
      std::vector<Velocity> response(solids_.size());
      for (std::size_t k = 0; k < count; ++k) apply_impulse(contacts_[k], impulse_of(k, direction[k]), response);
      for (std::size_t k = 0; k < count; ++k) answer[k] = components(k, relative_velocity(contacts_[k], response));
      const double step = square / sum(direction, answer);
      for (std::size_t k = 0; k < count; ++k) {
        x[k] = x[k] + step * direction[k];
        residual[k] = residual[k] - step * answer[k];
      }
      const double left = sum(residual, residual);
      for (std::size_t k = 0; k < count; ++k) direction[k] = residual[k] + (left / square) * direction[k];
      square = left;
    }
    for (std::size_t k = 0; k < count; ++k) {
      impulses_[k] = project_to_cone(contacts_[k].friction, {std::max(0.0, x[k][0]), x[k][1], x[k][2]});
      apply_impulse(contacts_[k], impulse_of(k, impulses_[k]), velocities_);
    }
  }
  // One sweep in each direction: loads propagate down a stack in one, reactions up in the other.
  void sweep() {
    const std::size_t count = contacts_.size();
    for (std::size_t step = 0; step < 2 * count; ++step) {
      const std::size_t k = step < count ? step : 2 * count - 1 - step;
      const RestingContact& contact = contacts_[k];
      V& impulse = impulses_[k];  // along n, t0, t1
      const double n =
          std::max(0.0, impulse[0] - dot(relative_velocity(contact, velocities_), contact.n) / inverse_mass_[k][0]);
      apply_impulse(contact, (n - impulse[0]) * contact.n, velocities_);
      const V u = relative_velocity(contact, velocities_);
      const V next = project_to_cone(contact.friction, {n, impulse[1] - dot(u, tangents_[k][0]) / inverse_mass_[k][1],
                                                        impulse[2] - dot(u, tangents_[k][1]) / inverse_mass_[k][1]});
      apply_impulse(contact, (next[1] - impulse[1]) * tangents_[k][0] + (next[2] - impulse[2]) * tangents_[k][1],
                    velocities_);
      impulse = next;
    }
  }
  // Largest speed of a point of a ball, which friction does not keep from rolling. Normal forces take up what is left
  // along the normals of its contacts.
  double fastest_ball() const {
    double most = 0;
    for (std::size_t i = 0; i < solids_.size(); ++i)
      if (solids_[i].free && solids_[i].radius > 0)
        most = std::max(most, length(beside_normals(i)) + length(velocities_[i].w_B) * solids_[i].radius);
    return most;
  }
  // The body with the largest speed of a point, and this speed.
  std::pair<std::size_t, double> fastest() const {
    std::pair<std::size_t, double> worst{0, 0};
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const RestingBody& s = solids_[i];
      // A sphere has one contact point: a moment that is not balanced to round-off makes it roll.
      const double speed = (length(velocities_[i].v) + length(velocities_[i].w_B) * bounding_radius(s)) *
                           (s.radius > 0 ? kBalanced / kRoundOff : 1);
      if (speed > worst.second) worst = {i, speed};
    }
    return worst;
  }

 private:
  V beside_normals(std::size_t body) const {
    V v = velocities_[body].v;
    std::vector<V> known;  // orthonormal
    for (const RestingContact& contact : contacts_) {
      if (static_cast<std::size_t>(contact.a) != body && static_cast<std::size_t>(contact.b) != body) continue;
      V n = contact.n;
      for (const V& other : known) n = n - dot(n, other) * other;
      if (length(n) < kIndependent) continue;
      known.push_back((1 / length(n)) * n);
      v = v - dot(v, known.back()) * known.back();
    }
    return v;
  }
  V to_body(const RestingBody& s, const V& v) const {
    return {dot(s.axis[0], v), dot(s.axis[1], v), dot(s.axis[2], v)};
  }
  V to_world(const RestingBody& s, const V& v) const { return v[0] * s.axis[0] + v[1] * s.axis[1] + v[2] * s.axis[2]; }
  V spin_change(const RestingBody& s, const V& arm, const V& impulse) const {
    const V moment = to_body(s, cross(arm, impulse));
    return {moment[0] * s.inertia_inverse[0], moment[1] * s.inertia_inverse[4], moment[2] * s.inertia_inverse[8]};
  }
  static double sum(const std::vector<V>& a, const std::vector<V>& b) {
    double all = 0;
    for (std::size_t k = 0; k < a.size(); ++k) all += dot(a[k], b[k]);
    return all;
  }
  static V project_to_cone(double friction, V impulse) {
    const double size = std::hypot(impulse[1], impulse[2]), most = friction * impulse[0];
    if (size > most) impulse[1] *= most / size, impulse[2] *= most / size;
    return impulse;
  }
  V components(std::size_t k, const V& u) const {
    return {dot(u, contacts_[k].n), dot(u, tangents_[k][0]), dot(u, tangents_[k][1])};
  }
  V impulse_of(std::size_t k, const V& parts) const {
    return parts[0] * contacts_[k].n + parts[1] * tangents_[k][0] + parts[2] * tangents_[k][1];
  }
  V relative_velocity(const RestingContact& contact,
                      const std::vector<Velocity>& velocities) const {  // of b relative to a
    V u{};
    for (const auto& [at, side] : {std::pair{contact.a, -1.0}, {contact.b, 1.0}})
      if (solids_[at].free)
        u = u + side * (velocities[at].v +
                        cross(to_world(solids_[at], velocities[at].w_B), contact.x - solids_[at].center));
    return u;
  }
  double mobility(const RestingContact& contact, const V& d) const {
    double sum = 0;
    for (const int at : {contact.a, contact.b}) {
      if (!solids_[at].free) continue;
      const V arm = contact.x - solids_[at].center;
      sum += solids_[at].inverse_mass + dot(d, cross(to_world(solids_[at], spin_change(solids_[at], arm, d)), arm));
    }
    return sum;
  }
  void apply_impulse(const RestingContact& contact, const V& impulse, std::vector<Velocity>& velocities) const {
    for (const auto& [at, side] : {std::pair{contact.a, -1.0}, {contact.b, 1.0}}) {
      if (!solids_[at].free) continue;
      velocities[at].v = velocities[at].v + (side * solids_[at].inverse_mass) * impulse;
      velocities[at].w_B =
          velocities[at].w_B + side * spin_change(solids_[at], contact.x - solids_[at].center, impulse);
    }
  }

  const std::vector<RestingBody>& solids_;
  const std::vector<RestingContact>& contacts_;
  std::vector<Velocity> velocities_;
  std::vector<V> impulses_;
  std::vector<std::array<V, 2>> tangents_;
  std::vector<std::array<double, 2>> inverse_mass_;  // along the normal; bound along the tangents
};

bool balances(ContactSolver& solver, double gravity) {
  solver.start();
  for (int k = 0; k < kMaxSweeps; ++k) {
    if (k % 16 == 0 && solver.fastest().second <= kBalanced * gravity) return true;
    solver.sweep();
  }
  return false;
}

// Contacts whose friction cone holds a weight, each with forces along gravity alone. Where such forces balance the
// scene, nothing pulls a body aside, and whether friction holds does not depend on the accuracy of their search.
std::vector<RestingContact> along_gravity(const std::vector<RestingContact>& contacts, const V& g) {
  std::vector<RestingContact> made;
  for (RestingContact contact : contacts) {
    if (!contact.holds_weight()) continue;
    contact.n = ((dot(contact.n, g) < 0 ? -1 : 1) / length(g)) * g;
    contact.friction = 0;
    made.push_back(contact);
  }
  return made;
}

// Slopes that the margins of friction and of balance do not tell from level ground: above round-off the reason for a
// refusal, else what pulls the bodies along them is added to `made`. `falls`: the body that forces along gravity do not
// hold.
std::string find_small_slopes(const Scene& scene, const std::vector<RestingContact>& contacts, const std::string& falls,
                              Equilibrium& made) {
  const Wide g = norm(vec<Wide>(scene.gravity_m_per_s2));
  for (const RestingContact& contact : contacts) {
    if (contact.friction > 0 || contact.slope >= Wide(kSmallSlope)) continue;
    if (contact.slope > Wide(kRoundOff))
      return "`" + scene.bodies[contact.a].name + "` and `" + scene.bodies[contact.b].name + "` have a slope of " +
             format_double(static_cast<double>(contact.slope)) + " and friction of " +
             format_double(static_cast<double>(contact.limit)) + ": " +
             (contact.holds_weight() ? "forces along gravity do not hold " + falls + ", and whether others do"
                                     : "whether another contact keeps them from sliding") +
             " is too small to tell";
    if (!contact.holds_weight())
      made.unheld_m_per_s2 =
          std::max(made.unheld_m_per_s2, 2 * static_cast<double>(g * (contact.slope - contact.limit)));
  }
  return "";
}

}  // namespace

Equilibrium find_equilibrium(const Scene& scene) {
  Equilibrium made;
  std::vector<RestingBody> solids;
  std::vector<RestingContact> contacts;
  made.refusal = find_contacts_at_rest(scene, solids, contacts, made);
  if (!made.refusal.empty()) return made;
  const V g = vec<double>(scene.gravity_m_per_s2);
  const bool near_limit = std::any_of(contacts.begin(), contacts.end(), [](const RestingContact& contact) {
    return contact.holds_weight() && contact.slope > Wide(contact.friction);
  });
  std::string falls;
  if (near_limit) {
    const std::vector<RestingContact> holding = along_gravity(contacts, g);
    ContactSolver solver(solids, holding, g);
    if (balances(solver, length(g))) {
      made.unheld_m_per_s2 = solver.fastest_ball();
      return made;
    }
    falls = "`" + scene.bodies[solver.fastest().first].name + "`";
  }
  made.refusal = find_small_slopes(scene, contacts, falls, made);
  if (!made.refusal.empty()) return made;
  ContactSolver solver(solids, contacts, g);
  if (balances(solver, length(g))) {
    made.unheld_m_per_s2 = std::max(made.unheld_m_per_s2, solver.fastest_ball());
    return made;
  }
  made.refusal = "no contact forces within the friction cones were found that hold `" +
                 scene.bodies[solver.fastest().first].name + "`";
  return made;
}

}  // namespace atwood::closed_form
