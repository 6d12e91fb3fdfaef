// A slab that is pushed over a floor and carries round bodies, all from rest: Coulomb friction at both faces of the
// slab, Newton's and Euler's laws for each body. Along the push F (floor's friction f1, ball i's f_i, kappa_i = 1 + m_i
// r_i^2 / I_i):
//   stick:   F <= mu1 (M + sum m_i) g: nothing moves
//   slip:    M A = F - f1 - sum f_i,   ball: m_i a_i = f_i,   I_i alpha_i = -r_i f_i
//            rolls on the deck: a_i - r_i alpha_i = A, so f_i = m_i A / kappa_i, while that is mu_i m_i g at most;
//            otherwise slips: f_i = mu_i m_i g
// For n equal solid balls, kappa = 7/2: f2 = ((F - f1) / M) / (3.5 / m + n / M). All friction is along the push as long
// as nothing rotates about the vertical; this and the position of the centre of pressure are checked.
#include <algorithm>

#include "closed_form/floor.hpp"

namespace atwood::closed_form {

namespace {

template <class S> struct Rider {
  int body = -1;
  S mass{}, radius{}, kappa{}, inertia{}, grip{};  // grip: mu g
  S along{}, aside{};                              // of its contact from the slab's centre
  bool rolls = true;
  S a{};  // along the push
};

template <class S> struct Cart {
  int slab = -1;
  S mass{}, height{};  // half its thickness
  Vec<S> push{}, e{};  // e: unit, along the push
  S F{}, push_height{}, push_aside{};
  std::vector<Rider<S>> riders;
  S A{}, open{};     // open: largest gap under a carried body (round-off)
  S lift{}, veer{};  // of the push: normal component and moment about the vertical; round-off, treated as zero
  bool stands = false;
};

template <class S> std::string find_push(const Scene& scene, const Floor<S>& floor, Cart<S>& cart) {
  if (scene.forces.size() != 1 || !std::holds_alternative<PointForce>(scene.forces.front()))
    return "expected exactly one point-force";
  const auto& push = std::get<PointForce>(scene.forces.front());
  if (!push.on_s.empty()) return "the point-force has `on_s`: expected a constant force";
  cart.slab = push.body;
  cart.push = vec<S>(push.force_N);
  const S upwards = dot(cart.push, floor.n);
  if (magnitude(upwards) > S(0x1p-48) * norm(cart.push) || is_zero(cart.push))
    return "the point-force is zero or not along the floor";
  cart.lift = magnitude(upwards);
  cart.F = norm(cart.push);
  cart.e = (1 / cart.F) * cart.push;
  const Vec<S> arm = rotate(initial_pose<S>(scene.bodies[push.body]).q_WB, vec<S>(push.point_body_m));
  cart.push_height = dot(floor.n, arm);
  cart.push_aside = dot(cross(floor.n, cart.e), arm);
  return "";
}

template <class S>
std::string add_rider(const Scene& scene, const Floor<S>& floor, int at, const FloorContact<S>& slab_stance,
                      Cart<S>& cart) {
  const Body& body = scene.bodies[at];
  const std::string name = "`" + body.name + "`";
  const auto* sphere = std::get_if<Sphere>(&body.shape);
  if (sphere == nullptr || !has_spherical_inertia(body) || !rotates(body)) return name + " is not a ball on the slab";
  if (body.release_s > 0) return name + " has a later release, which is not covered";
  const Pose<S> pose = initial_pose<S>(body), slab = initial_pose<S>(scene.bodies[cart.slab]);
  if (!is_zero(pose.v_WB) || !is_zero(pose.w_WB_B)) return name + " has an initial velocity: expected rest";
  Rider<S> rider;
  rider.body = at;
  rider.mass = body.mass_kg;
  rider.radius = sphere->radius_m;
  rider.inertia = body.inertia_kg_m2[0];
  rider.kappa = 1 + rider.mass * rider.radius * rider.radius / rider.inertia;
  const PairLaw& law = pair_law(scene, at, cart.slab);
  if (law.rolling_friction_m != 0) return name + " has rolling friction";
  rider.grip = S(law.friction) * floor.g_n;
  const Vec<S> d = pose.p_WB - slab.p_WB;
  const S gap = dot(floor.n, d) - cart.height - rider.radius;
  if (magnitude(gap) > S(0x1p-49) * (norm(pose.p_WB) + cart.height))
    return name + " does not touch the upper face of the slab";
  cart.open = larger(cart.open, magnitude(gap));
  rider.along = dot(cart.e, d);
  rider.aside = dot(cross(floor.n, cart.e), d);
  for (int k = 0; k < 2; ++k)
    if (magnitude(dot(slab_stance.side[k], d)) > slab_stance.half[k]) return name + " is not over the slab";
  cart.riders.push_back(rider);
  return "";
}

// Bodies that slip hold the slab back less, so that it accelerates more: a body that slips continues to slip.
template <class S> void accelerate(Cart<S>& cart, S floor_friction) {
  for (bool changed = true; changed;) {
    changed = false;
    S pushed = cart.F - floor_friction, inertia = cart.mass;
    for (const Rider<S>& rider : cart.riders) {
      if (rider.rolls) inertia = inertia + rider.mass / rider.kappa;
      else pushed = pushed - rider.mass * rider.grip;
    }
    cart.A = pushed / inertia;
    for (Rider<S>& rider : cart.riders) {
      const bool holds = rider.rolls && cart.A / rider.kappa <= rider.grip;
      changed = changed || holds != rider.rolls;
      rider.rolls = holds;
      rider.a = holds ? cart.A / rider.kappa : rider.grip;
    }
  }
}

// Checks that the slab does not tip (the centre of pressure c, c N = h (f1 - sum f_i) + z F + sum m_i g x_i, is under
// it) or rotate, and that the carried bodies stay on it and apart from each other.
template <class S>
std::string goes_wrong(const Scene& scene, const Floor<S>& floor, const FloorContact<S>& contact, Cart<S>& cart, S f1,
                       S t_end) {
  const std::string name = "`" + scene.bodies[cart.slab].name + "`";
  const Vec<S> left = cross(floor.n, cart.e);
  S weight = cart.mass * floor.g_n, rub = 0, free_rotation = cart.F * cart.push_aside, aside = 0;
  for (const Rider<S>& r : cart.riders) {
    weight = weight + r.mass * floor.g_n;
    aside = aside + r.mass * floor.g_n * r.aside;
    rub = rub + r.mass * r.a;
    free_rotation = free_rotation - r.mass * r.a * r.aside;
  }
  free_rotation = free_rotation - f1 * aside / weight;
  if (magnitude(free_rotation) > S(0x1p-46) * cart.F * S(contact.extent_m))
    return name + " is rotated about the vertical by the forces on it, which is not covered";
  cart.veer = magnitude(free_rotation);
  for (const S t : {S(0), t_end}) {
    S moment = cart.height * (f1 - rub) + cart.push_height * cart.F;
    for (const Rider<S>& r : cart.riders) {
      const S x = r.along - (cart.A - r.a) * t * t / 2;
      moment = moment + r.mass * floor.g_n * x;
      const Vec<S> foot = x * cart.e + r.aside * left;
      for (int k = 0; k < 2; ++k)
        if (magnitude(dot(contact.side[k], foot)) > contact.half[k])
          return "`" + scene.bodies[r.body].name + "` rolls off " + name;
    }
    const Vec<S> center = (moment / weight) * cart.e + (aside / weight) * left;
    for (int k = 0; k < 2; ++k)
      if (magnitude(dot(contact.side[k], center)) > contact.half[k]) return name + " would tip";
  }
  for (const Rider<S>& r : cart.riders)
    for (const Rider<S>& s : cart.riders) {
      if (s.body >= r.body) continue;
      const Vec<S> d = initial_pose<S>(scene.bodies[r.body]).p_WB - initial_pose<S>(scene.bodies[s.body]).p_WB;
      const Vec<double> from = rounded(d), to = rounded(d + ((r.a - s.a) * t_end * t_end / 2) * cart.e);
      if (segment_distance(from, to, {0, 0, 0}, {0, 0, 0}) <= static_cast<double>(r.radius + s.radius))
        return "`" + scene.bodies[s.body].name + "` and `" + scene.bodies[r.body].name +
               "` could touch each other, which is not covered";
    }
  return "";
}

template <class S>
std::string set_up(const Scene& scene, const Floor<S>& floor, S t_end, Cart<S>& cart, FloorContact<S>& contact) {
  if (!floor.refusal.empty()) return floor.refusal;
  if (!floor.boundary.empty()) return "the floor is not a plane: expected a fixed plane";
  if (!is_zero(floor.g_t)) return "the floor is not orthogonal to gravity";
  if (std::string why = find_push(scene, floor, cart); !why.empty()) return why;
  const Body& slab = scene.bodies[cart.slab];
  if (!std::holds_alternative<Box>(slab.shape))
    return "`" + slab.name + "` has another shape: expected a box (the slab)";
  contact = floor_contact(floor, scene, cart.slab);
  if (!contact.refusal.empty()) return contact.refusal;
  const Pose<S> start = initial_pose<S>(slab);
  if (!is_zero(start.v_WB) || !is_zero(start.w_WB_B))
    return "`" + slab.name + "` has an initial velocity: expected rest";
  cart.mass = slab.mass_kg;
  cart.height = contact.height;
  S pressed = cart.mass;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const int at = static_cast<int>(i);
    if (at == cart.slab || scene.bodies[i].fixed) continue;
    if (std::string why = add_rider(scene, floor, at, contact, cart); !why.empty()) return why;
    pressed = pressed + cart.riders.back().mass;
  }
  const S f1 = S(pair_law(scene, cart.slab, floor.body).friction) * pressed * floor.g_n;
  cart.stands = cart.F <= f1;
  if (!cart.stands) accelerate(cart, f1);
  return goes_wrong(scene, floor, contact, cart, cart.stands ? cart.F : f1, t_end);
}

template <class S> Motion<S> solve_friction_cone(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  const Floor<S> floor = find_floor<S>(scene);
  Cart<S> cart;
  FloorContact<S> contact;
  motion.refusal = set_up(scene, floor, S(scenario.t_end_s), cart, contact);
  if (!motion.refusal.empty()) return motion;
  const S t_end = scenario.t_end_s;
  const Real33& I = scene.bodies[cart.slab].inertia_kg_m2;
  const S spin = 4 * t_end * cart.veer / S(std::min(I[0], std::min(I[4], I[8])));
  const S speed = 4 * t_end * cart.lift / cart.mass + spin * S(contact.extent_m) + 4 * t_end * floor.neglected;
  S least = contact.extent_m;
  for (const Rider<S>& rider : cart.riders) least = rider.radius < least ? rider.radius : least;
  motion.input_round_off = {contact.gap_error_m + 4 * cart.open + t_end * speed,
                            4 * contact.tilt + t_end * (spin + speed / least), speed, spin + speed / least};
  const Vec<S> about = cross(floor.n, cart.e);
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    const S half_t2 = t * t / 2;
    poses[cart.slab].p_WB = poses[cart.slab].p_WB + (cart.A * half_t2) * cart.e;
    poses[cart.slab].v_WB = (cart.A * t) * cart.e;
    for (const Rider<S>& rider : cart.riders) {
      Pose<S>& pose = poses[rider.body];
      const Vec<S> axis = rotate(conjugate(pose.q_WB), about);
      const S spin_up = -rider.radius * rider.mass * rider.a / rider.inertia;
      pose.p_WB = pose.p_WB + (rider.a * half_t2) * cart.e;
      pose.v_WB = (rider.a * t) * cart.e;
      pose.w_WB_B = (spin_up * t) * axis;
      pose.q_WB = pose.q_WB * turn(axis, spin_up * half_t2);
    }
  }
  return motion;
}

}  // namespace

Solution friction_cone() {
  return {"friction-cone", "a pushed slab that carries balls: Coulomb's friction, Newton's and Euler's laws",
          feature::uniform_gravity | feature::kSimpleContact | feature::point_force, solve_friction_cone<Narrow>,
          solve_friction_cone<Wide>};
}

}  // namespace atwood::closed_form
