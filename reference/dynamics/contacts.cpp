#include "dynamics/contacts.hpp"

#include <algorithm>

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {

namespace {

const char* const shape_names[] = {"no shape", "sphere",   "plane",  "rectangle", "box",
                                   "capsule",  "cylinder", "convex", "mesh",      "compound"};

bool is_sphere(const Body& body) { return std::holds_alternative<Sphere>(body.shape); }
bool is_plane(const Body& body) { return std::holds_alternative<Plane>(body.shape); }
bool is_wall(const Body& body) {
  return body.fixed && (std::holds_alternative<Box>(body.shape) || std::holds_alternative<Rectangle>(body.shape));
}

template <class S> Triple<S> position(const Scene& scene, const Layout& layout, int body, const S* y) {
  const Slot& slot = layout.slots[body];
  return slot.position >= 0 ? read3(y + slot.position) : widen<S>(scene.bodies[body].position_m);
}

template <class S> Triple<S> velocity(const Layout& layout, int body, const S* y) {
  const Slot& slot = layout.slots[body];
  return slot.velocity >= 0 ? read3(y + slot.velocity) : Triple<S>{};
}

template <class S> std::array<S, 4> attitude(const Layout& layout, int body, const S* y) {
  std::array<S, 4> q;
  std::copy_n(y + layout.slots[body].attitude, 4, q.begin());
  return q;
}

template <class S> S radius_of(const Body& body) { return std::get<Sphere>(body.shape).radius_m; }

// Signed distance from a surface to a point (negative inside), the unit outward normal, and the closest point.
template <class S> struct SurfaceDistance {
  S distance{};
  Triple<S> out{}, foot{};
};

// The plane is n . x = offset; the doubles of n are unit to round-off only, so distances are divided by |n|.
template <class S> SurfaceDistance<S> distance_to_plane(const Plane& plane, const Triple<S>& point) {
  Triple<S> out = widen<S>(plane.normal);
  const S inverse = rsqrt(dot(out, out));
  out = inverse * out;
  const S distance = dot(out, point) - S(plane.offset_m) * inverse;
  return {distance, out, point - distance * out};
}

// The closest point of a box has each coordinate of the point clamped to the half extents; a rectangle is a box without
// thickness. For a point inside, the normal is that of the closest face.
template <class S> SurfaceDistance<S> distance_to_wall(const Body& wall, const Triple<S>& point) {
  const auto* box = std::get_if<Box>(&wall.shape);
  const Real3 half = box != nullptr ? box->half_extents_m
                                    : Real3{std::get<Rectangle>(wall.shape).half_extents_m[0],
                                            std::get<Rectangle>(wall.shape).half_extents_m[1], 0};
  std::array<S, 4> q;
  S length2 = 0;
  for (int k = 0; k < 4; ++k) {
    q[k] = wall.orientation_wxyz[k];
    length2 += q[k] * q[k];
  }
  for (S& x : q) x *= rsqrt(length2);
  const Triple<S> origin = widen<S>(wall.position_m), local = rotate_back(q, point - origin);
  Triple<S> foot = local;
  for (int k = 0; k < 3; ++k) foot[k] = std::clamp(local[k], S(-half[k]), S(half[k]));
  const Triple<S> away = local - foot;
  const S distance2 = dot(away, away);
  if (distance2 > 0) {
    const S distance = sqrt(distance2);
    return {distance, rotate(q, (1 / distance) * away), origin + rotate(q, foot)};
  }
  int face = 2;  // of a rectangle the only one
  for (int k = 0; k < 2; ++k)
    if (S(half[k]) - magnitude(local[k]) < S(half[face]) - magnitude(local[face]) && half[2] > 0) face = k;
  Triple<S> out{};
  out[face] = local[face] < 0 ? -1 : 1;
  foot[face] = out[face] * S(half[face]);
  return {-(S(half[face]) - magnitude(local[face])), rotate(q, out), origin + rotate(q, foot)};
}

template <class S> SurfaceDistance<S> distance_to(const Body& body, const Triple<S>& point) {
  return is_plane(body) ? distance_to_plane(std::get<Plane>(body.shape), point) : distance_to_wall(body, point);
}

// From a sphere's centre to the contact: its radius along or against the normal. Zero for bodies that do not rotate.
template <class S>
Triple<S> lever_arm(const Scene& scene, const Layout& layout, const ContactPair& pair, int body,
                    const Triple<S>& normal) {
  if (layout.slots[body].rate < 0) return {};
  return (body == pair.a ? radius_of<S>(scene.bodies[body]) : -radius_of<S>(scene.bodies[body])) * normal;
}

}  // namespace

bool contacts_possible(const Scene& scene) {
  int shaped = 0, mobile = 0;
  for (const Body& body : scene.bodies) {
    shaped += body.shape.index() != 0;
    mobile += body.shape.index() != 0 && !body.fixed;
  }
  return shaped >= 2 && mobile >= 1;
}

bool has_gap(const Scene& scene, const ContactPair& pair) {
  const Body &a = scene.bodies[pair.a], &b = scene.bodies[pair.b];
  const auto surface = [](const Body& body) { return is_sphere(body) || is_plane(body) || is_wall(body); };
  return (is_sphere(a) && surface(b)) || (surface(a) && is_sphere(b));
}

int plane_of(const Scene& scene, const ContactPair& pair) {
  for (const int body : {pair.a, pair.b})
    if (is_plane(scene.bodies[body])) return body;
  return -1;
}

int ball_of(const Scene& scene, const ContactPair& pair) {
  const int plane = plane_of(scene, pair);
  return plane < 0 ? -1 : plane == pair.a ? pair.b : pair.a;
}

ContactPairs contact_pairs(const Scene& scene) {
  ContactPairs found;
  const int n = static_cast<int>(scene.bodies.size());
  for (int a = 0; a < n; ++a)
    for (int b = a + 1; b < n; ++b) {
      const Body &first = scene.bodies[a], &second = scene.bodies[b];
      if (first.shape.index() == 0 || second.shape.index() == 0 || (first.fixed && second.fixed)) continue;
      if (!has_gap(scene, {a, b, 0, 0})) {
        if (found.unsupported.empty())
          found.unsupported = std::string("contact of ") + shape_names[first.shape.index()] + " `" + first.name +
                              "` with " + shape_names[second.shape.index()] + " `" + second.name + "`";
        continue;
      }
      const PairLaw& law = pair_law(scene, a, b);
      if (law.rolling_friction_m > 0 && found.unsupported.empty())
        found.unsupported = "rolling friction of `" + first.name + "` and `" + second.name + "`";
      found.pairs.push_back({a, b, law.restitution, law.friction, law.contact_law != ContactLaw::rigid});
    }
  return found;
}

template <class S> Gap<S> gap(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y) {
  Gap<S> made;
  const Body &a = scene.bodies[pair.a], &b = scene.bodies[pair.b];
  const Triple<S> v = velocity(layout, pair.b, y) - velocity(layout, pair.a, y);
  if (is_sphere(a) && is_sphere(b)) {
    const S radius_a = radius_of<S>(a);
    const Triple<S> center = position(scene, layout, pair.a, y), d = position(scene, layout, pair.b, y) - center;
    const S distance = sqrt(dot(d, d));
    made.gap_m = distance - radius_a - radius_of<S>(b);
    made.normal = (1 / distance) * d;
    made.x_m = center + (radius_a + made.gap_m / 2) * made.normal;
  } else {
    const int ball = is_sphere(a) ? pair.a : pair.b;
    const SurfaceDistance<S> h =
        distance_to(scene.bodies[ball == pair.a ? pair.b : pair.a], position(scene, layout, ball, y));
    made.gap_m = h.distance - radius_of<S>(scene.bodies[ball]);
    made.normal = ball == pair.b ? h.out : S(-1) * h.out;
    made.x_m = h.foot + (made.gap_m / 2) * h.out;
  }
  made.rate_m_per_s = dot(v, made.normal);
  return made;
}

template <class S> Triple<S> slip(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y) {
  const Triple<S> normal = gap(scene, layout, pair, y).normal;
  Triple<S> sliding = velocity(layout, pair.b, y) - velocity(layout, pair.a, y);
  for (const int body : {pair.a, pair.b}) {
    if (layout.slots[body].rate < 0) continue;
    const Triple<S> w = rotate(attitude(layout, body, y), read3(y + layout.slots[body].rate));
    const Triple<S> turning = cross(w, lever_arm(scene, layout, pair, body, normal));
    if (body == pair.a) sliding -= turning;
    else sliding += turning;
  }
  sliding -= dot(sliding, normal) * normal;
  return sliding;
}

template <class S>
bool friction_acts(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y, const S* dydt,
                   S tiny_m_per_s) {
  const int ball = ball_of(scene, pair);
  if (pair.friction == 0 || ball < 0) return false;
  const Triple<S> normal = gap(scene, layout, pair, y).normal, sliding = slip(scene, layout, pair, y);
  Triple<S> acceleration = read3(dydt + layout.slots[ball].velocity);
  acceleration -= dot(acceleration, normal) * normal;
  return dot(sliding, sliding) > tiny_m_per_s * tiny_m_per_s ||
         dot(acceleration, acceleration) > tiny_m_per_s * tiny_m_per_s;
}

std::string impact_unsupported(const Scene& scene, const ContactPair& pair) {
  if (pair.friction == 0) return "";
  for (const int at : {pair.a, pair.b}) {
    const Body& body = scene.bodies[at];
    const Real33& I = body.inertia_kg_m2;
    const bool spherical = I[0] == I[4] && I[4] == I[8] && I[1] == 0 && I[2] == 0 && I[5] == 0;
    if (!body.fixed && !spherical) return "friction on `" + body.name + "`, whose principal moments of inertia differ,";
  }
  return "";
}

// Impact of spheres of mass m_a, m_b along the line of centres n: J_n = -(1 + e) vn / (1/m_a + 1/m_b). The inverse
// effective mass along the tangent is 1/m_a + 1/m_b + r_a^2/I_a + r_b^2/I_b, and the slip keeps its direction:
// Coulomb's impulse is the lesser of mu J_n (slip until the end) and the impulse that stops the slip (stick).
template <class S>
Impulse<S> apply_impact_law(const Scene& scene, const Layout& layout, const ContactPair& pair, S* y) {
  const Gap<S> now = gap(scene, layout, pair, y);
  if (!(now.rate_m_per_s < 0)) return {};
  S inverse_mass_n = 0, inverse_mass_t = 0;
  for (const int at : {pair.a, pair.b}) {
    const Body& body = scene.bodies[at];
    if (layout.slots[at].velocity < 0) continue;
    inverse_mass_n += 1 / S(body.mass_kg);
    if (layout.slots[at].rate >= 0)
      inverse_mass_t += radius_of<S>(body) * radius_of<S>(body) / S(body.inertia_kg_m2[0]);
  }
  inverse_mass_t += inverse_mass_n;
  Impulse<S> made;
  made.normal_N_s = -(1 + S(pair.restitution)) * now.rate_m_per_s / inverse_mass_n;
  Triple<S> impulse = made.normal_N_s * now.normal;  // on b
  const Triple<S> sliding = slip(scene, layout, pair, y);
  const S speed2 = dot(sliding, sliding);
  if (pair.friction > 0 && speed2 > 0) {
    const S speed = sqrt(speed2);
    made.tangential_N_s = std::min(S(pair.friction) * made.normal_N_s, speed / inverse_mass_t);
    impulse -= (made.tangential_N_s / speed) * sliding;
  }
  for (const int at : {pair.a, pair.b}) {
    const Slot& slot = layout.slots[at];
    if (slot.velocity < 0) continue;
    const S sign = at == pair.a ? -1 : 1;
    for (int k = 0; k < 3; ++k) y[slot.velocity + k] += sign * impulse[k] / S(scene.bodies[at].mass_kg);
    if (slot.rate < 0 || made.tangential_N_s == 0) continue;
    const Triple<S> turn =
        rotate_back(attitude(layout, at, y), cross(lever_arm(scene, layout, pair, at, now.normal), sign * impulse));
    for (int k = 0; k < 3; ++k) y[slot.rate + k] += turn[k] / S(scene.bodies[at].inertia_kg_m2[0]);
  }
  return made;
}

#define ATWOOD_CONTACTS(S)                                                                             \
  template Gap<S> gap(const Scene&, const Layout&, const ContactPair&, const S*);                      \
  template Triple<S> slip(const Scene&, const Layout&, const ContactPair&, const S*);                  \
  template bool friction_acts(const Scene&, const Layout&, const ContactPair&, const S*, const S*, S); \
  template Impulse<S> apply_impact_law(const Scene&, const Layout&, const ContactPair&, S*);
ATWOOD_CONTACTS(double)
ATWOOD_CONTACTS(Wide)
#undef ATWOOD_CONTACTS

}  // namespace atwood::dynamics
