#include "dynamics/contacts.hpp"

#include "dynamics/arithmetic.hpp"

namespace atwood::dynamics {

namespace {

const char* const shape_names[] = {"no shape", "sphere", "plane", "rectangle", "box",
                                   "capsule",  "cylinder", "convex", "mesh", "compound"};

bool is_sphere(const Body& body) { return std::holds_alternative<Sphere>(body.shape); }
bool is_plane(const Body& body) { return std::holds_alternative<Plane>(body.shape); }

template <class S>
Triple<S> position(const Scene& scene, const Layout& layout, int body, const S* y) {
  const Slot& slot = layout.slots[body];
  return slot.position >= 0 ? read3(y + slot.position) : widen<S>(scene.bodies[body].position_m);
}

template <class S>
Triple<S> velocity(const Layout& layout, int body, const S* y) {
  const Slot& slot = layout.slots[body];
  return slot.velocity >= 0 ? read3(y + slot.velocity) : Triple<S>{};
}

}  // namespace

bool has_gap(const Scene& scene, const ContactPair& pair) {
  const Body &a = scene.bodies[pair.a], &b = scene.bodies[pair.b];
  return (is_sphere(a) && (is_sphere(b) || is_plane(b))) || (is_plane(a) && is_sphere(b));
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
      found.pairs.push_back({a, b, law.restitution, law.friction});
    }
  return found;
}

template <class S>
Gap<S> gap(const Scene& scene, const Layout& layout, const ContactPair& pair, const S* y) {
  Gap<S> made;
  const Body &a = scene.bodies[pair.a], &b = scene.bodies[pair.b];
  const Triple<S> v = velocity(layout, pair.b, y) - velocity(layout, pair.a, y);
  if (is_plane(a) || is_plane(b)) {
    // n . x = offset; the doubles of n are unit to round-off only, so distances are divided by |n|.
    const int ball = is_plane(a) ? pair.b : pair.a;
    const Plane& plane = std::get<Plane>(is_plane(a) ? a.shape : b.shape);
    const S radius = std::get<Sphere>(scene.bodies[ball].shape).radius_m;
    Triple<S> out = widen<S>(plane.normal);
    const S inverse = inverse_root(dot(out, out));
    out = inverse * out;
    const Triple<S> center = position(scene, layout, ball, y);
    const S height = dot(out, center) - S(plane.offset_m) * inverse;
    made.gap_m = height - radius;
    made.normal = ball == pair.b ? out : S(-1) * out;
    made.x_m = center - ((height + radius) / 2) * out;
  } else {
    const S radius_a = std::get<Sphere>(a.shape).radius_m, radius_b = std::get<Sphere>(b.shape).radius_m;
    const Triple<S> center = position(scene, layout, pair.a, y), d = position(scene, layout, pair.b, y) - center;
    const S distance = root(dot(d, d));
    made.gap_m = distance - radius_a - radius_b;
    made.normal = (1 / distance) * d;
    made.x_m = center + (radius_a + made.gap_m / 2) * made.normal;
  }
  made.rate_m_per_s = dot(v, made.normal);
  return made;
}

// m_a, m_b free spheres hit centrally along n: J = -(1 + e) vn / (1/m_a + 1/m_b); the arm of a smooth sphere's contact
// force passes through its centre, so no spin is exchanged.
template <class S>
S strike(const Scene& scene, const Layout& layout, const ContactPair& pair, S* y) {
  const Gap<S> now = gap(scene, layout, pair, y);
  if (!(now.rate_m_per_s < 0)) return S(0);
  const Slot &a = layout.slots[pair.a], &b = layout.slots[pair.b];
  const S inverse_a = a.velocity >= 0 ? 1 / S(scene.bodies[pair.a].mass_kg) : S(0);
  const S inverse_b = b.velocity >= 0 ? 1 / S(scene.bodies[pair.b].mass_kg) : S(0);
  const S impulse = -(1 + S(pair.restitution)) * now.rate_m_per_s / (inverse_a + inverse_b);
  for (int k = 0; k < 3; ++k) {
    if (a.velocity >= 0) y[a.velocity + k] -= impulse * inverse_a * now.normal[k];
    if (b.velocity >= 0) y[b.velocity + k] += impulse * inverse_b * now.normal[k];
  }
  return impulse;
}

template Gap<double> gap(const Scene&, const Layout&, const ContactPair&, const double*);
template Gap<Wide> gap(const Scene&, const Layout&, const ContactPair&, const Wide*);
template double strike(const Scene&, const Layout&, const ContactPair&, double*);
template Wide strike(const Scene&, const Layout&, const ContactPair&, Wide*);

}  // namespace atwood::dynamics
