// Mirtich (1996) bounds how fast a gap can close by the speed of the fastest point; near a graze, or under a spin that
// moves little of the body along the normal, that bound makes the steps shrink with the gap itself. Here the speed is
// the support function's and the bend of the points' paths is bounded instead, so that steps shrink with the gap's
// root.
#include "collision/stay_apart.hpp"

#include <limits>

#include "collision/convex_piece.hpp"
#include "collision/mesh_queries.hpp"
#include "collision/nearest_features.hpp"

namespace atwood {
namespace {

template <class S> S box_support(const Vec3<S>& h, const Vec3<S>& d) {
  return h.x * real::abs(d.x) + h.y * real::abs(d.y) + h.z * real::abs(d.z);
}

// max of d . x over the shape's core (no spin moves the radius around it); d in the body's axes, of any length.
template <class S> S core_support(const Geometry<S>& g, const Vec3<S>& d) {
  switch (g.kind) {
    case ShapeKind::rectangle:
    case ShapeKind::box: return box_support(g.half_extents, d);
    case ShapeKind::capsule: return g.half_length * real::abs(d.z);
    case ShapeKind::cylinder: return g.half_length * real::abs(d.z) + g.radius * norm(Vec3<S>{d.x, d.y, S(0)});
    case ShapeKind::convex: return dot(d, g.hull->vertices[farthest_vertex(*g.hull, d)]);
    case ShapeKind::mesh:
    case ShapeKind::compound: {
      S most = -std::numeric_limits<S>::infinity();
      if (g.mesh)
        for (const Vec3<S>& p : g.mesh->points) most = real::max(most, dot(d, p));
      for (const auto& part : g.parts) {
        const Placement<S> place = placement(part.p_B, part.q_BP);
        most = real::max(most, dot(d, place.p_W) + box_support(part.half_extents, turned_back(place, d)));
      }
      return most;
    }
    default: return S(0);
  }
}

template <class S> S box_off_axis(const Vec3<S>& h, const Placement<S>& place, const Vec3<S>& u) {
  S most = S(0);
  for (int i = 0; i < 8; ++i) {
    const Vec3<S> corner{i & 1 ? h.x : -h.x, i & 2 ? h.y : -h.y, i & 4 ? h.z : -h.z};
    most = real::max(most, norm(cross(u, placed(place, corner))));
  }
  return most;
}

// How far the core reaches from a line along unit u through the body's origin; u in the body's axes.
template <class S> S core_off_axis(const Geometry<S>& g, const Vec3<S>& u) {
  S most = S(0);
  switch (g.kind) {
    case ShapeKind::rectangle:
    case ShapeKind::box: return box_off_axis(g.half_extents, Placement<S>{}, u);
    case ShapeKind::capsule: return g.half_length * norm(Vec3<S>{u.x, u.y, S(0)});
    case ShapeKind::cylinder: {  // of a rim's point r: |r|^2 - (u . r)^2, and u . r within half_length u.z +- radius
                                 // |u_xy|
      const S nearest = real::max(S(0), g.half_length * real::abs(u.z) - g.radius * norm(Vec3<S>{u.x, u.y, S(0)}));
      return real::sqrt(real::max(S(0), g.half_length * g.half_length + g.radius * g.radius - nearest * nearest));
    }
    case ShapeKind::convex:
      for (const Vec3<S>& v : g.hull->vertices) most = real::max(most, norm(cross(u, v)));
      break;
    case ShapeKind::mesh:
    case ShapeKind::compound:
      if (g.mesh)
        for (const Vec3<S>& p : g.mesh->points) most = real::max(most, norm(cross(u, p)));
      for (const auto& part : g.parts)
        most = real::max(most, box_off_axis(part.half_extents, placement(part.p_B, part.q_BP), u));
      break;
    default: break;
  }
  return most;
}

// Farthest point of the core from the body's origin.
template <class S> S core_reach(const Geometry<S>& g) {
  if (g.kind == ShapeKind::sphere || g.kind == ShapeKind::plane) return S(0);
  return g.kind == ShapeKind::capsule ? g.half_length : g.bounding_radius;
}

// The spin as far as it moves the shape: none of a sphere, or of what is round about the axis it turns about.
template <class S> Vec3<S> moving_spin(const Spinning<S>& body) {
  const ShapeKind kind = body.shape.kind;
  if (kind == ShapeKind::sphere || kind == ShapeKind::plane) return {};
  const bool round = kind == ShapeKind::capsule || kind == ShapeKind::cylinder;
  const Vec3<S>&axis = body.place.axis_W[2], &w = body.w_W;
  return round && norm(cross(w, axis)) <= S(4) * real::epsilon<S>() * norm(w) ? Vec3<S>{} : w;
}

// A convex part of a spinning body: `support(d_W)` is its core's about the body's origin, `support.off_axis(u_W)` how
// far it reaches from an axis there.
template <class S, class Support> struct Part {
  Vec3<S> w_W;
  S reach;
  const Support& support;

  bool turns(const Vec3<S>& n) const {
    const Vec3<S> turn = cross(n, w_W);
    return reach > S(0) && dot(turn, turn) > S(0);
  }
  S bend(const Vec3<S>& n) const { return norm(w_W) * norm(cross(n, w_W)) * reach; }
  // The support of all that a whole turn passes through: of a point r it takes (u . r) u along and |u x r| across the
  // axis u.
  S in_any_turn(const Vec3<S>& n) const {
    if (!turns(n)) return support(n);
    const Vec3<S> u = (S(1) / norm(w_W)) * w_W;
    const S along = dot(n, u);
    return real::abs(along) * support(along < S(0) ? -u : u) + norm(cross(n, u)) * support.off_axis(u);
  }
};
template <class S, class Support> Part(Vec3<S>, S, const Support&) -> Part<S, Support>;

// How long a gap that closes at this speed stays more than round-off; infinite: to the end.
template <class S> S time_to_close(S gap, S closing, S most_s, S round_off) {
  if (!(gap > round_off)) return S(0);
  return gap - most_s * closing > round_off ? std::numeric_limits<S>::infinity() : (gap - round_off) / closing;
}

// With v that of a relative to b and unit n from a to b, after a time h the parts are at least
//   f(h) = gap - h v.n - [s_a(n + h n x w_a) - s_a(n)] - [s_b(-n - h n x w_b) - s_b(-n)] - h^2/2 (bend_a + bend_b)
// apart along n: a point r goes along n by h n.(w x r) = h (n x w).r and, from there on its circle, by |w| |n x w| |r|
// h^2/2 at most. f is concave, so where it is positive at both ends it is between, and the root of a chord comes before
// its own. Nor does any spin take a part beyond what its whole turn passes through: gap - h v.n less what the turns add
// holds for all h.
template <class S, class PartA, class PartB>
S time_apart(S gap, const Vec3<S>& n, const Vec3<S>& v_W, const PartA& a, const PartB& b, S most_s, S round_off) {
  const Vec3<S> turn_a = cross(n, a.w_W), turn_b = cross(n, b.w_W);
  const bool turns_a = a.turns(n), turns_b = b.turns(n);
  const S bend = (turns_a ? a.bend(n) : S(0)) + (turns_b ? b.bend(n) : S(0));
  const S closing = dot(v_W, n), now_a = turns_a ? a.support(n) : S(0), now_b = turns_b ? b.support(-n) : S(0);
  const auto f = [&](S h) {
    const S by_a = turns_a ? a.support(n + h * turn_a) - now_a : S(0);
    const S by_b = turns_b ? b.support(-(n + h * turn_b)) - now_b : S(0);
    return gap - h * closing - by_a - by_b - S(0.5) * bend * h * h;
  };
  constexpr S kAlways = std::numeric_limits<S>::infinity();
  S low = S(0), f_low = gap, high = most_s, f_high = f(most_s);
  if (f_high > round_off) return kAlways;
  if (f_high >= S(0)) return most_s;
  S whatever_the_spin = S(0);
  if (turns_a || turns_b) {
    const S left = gap - (turns_a ? a.in_any_turn(n) - now_a : S(0)) - (turns_b ? b.in_any_turn(-n) - now_b : S(0));
    whatever_the_spin = time_to_close(left, closing, most_s, round_off);
    if (whatever_the_spin == kAlways) return kAlways;
  }
  constexpr int kMostRounds = 100;
  for (int round = 0; round < kMostRounds; ++round) {
    const S chord = low + (high - low) * (f_low / (f_low - f_high));
    const S f_chord = f(chord);
    if (!(chord > low) || !(f_chord > S(0))) return real::max(whatever_the_spin, real::max(low, chord));
    low = chord, f_low = f_chord;
    if (f_low <= gap / S(8)) break;
    const S twice = S(2) * low;
    if (!(twice < high)) continue;
    if (const S f_twice = f(twice); f_twice > S(0)) low = twice, f_low = f_twice;
    else high = twice, f_high = f_twice;
  }
  return real::max(whatever_the_spin, low);
}

template <class S> struct Look {
  const Spinning<S>&a, &b;
  Vec3<S> w_a, w_b, v_W;
  S most_s, round_off;
  S fastest{};  // no gap closes faster
  Stay<S> stay{};

  Look(const Spinning<S>& of_a, const Spinning<S>& of_b, const Vec3<S>& v, S left_s, S touch)
      : a(of_a), b(of_b), w_a(moving_spin(a)), w_b(moving_spin(b)), v_W(v), most_s(left_s), round_off(touch) {
    fastest = norm(v_W) + norm(w_a) * core_reach(a.shape) + norm(w_b) * core_reach(b.shape);
    stay.until_s = std::numeric_limits<S>::infinity();
  }
  // Parts farther apart than this do not matter any more.
  S enough() const { return fastest * real::min(stay.until_s, most_s) + round_off; }

  // `face` is a direction that may part them for longer than the one between their nearest points, as a floor's does
  // beside what spins low over it, and `skins` the radius around their cores.
  template <class SupportA, class SupportB>
  void parts(S gap, const Vec3<S>& n, const SupportA& of_a, S reach_a, const SupportB& of_b, S reach_b,
             Vec3<S> face = {}, S skins = S(0)) {
    const bool nearest = gap < stay.gap;
    stay.gap = real::min(stay.gap, gap);
    if (gap <= round_off) {
      if (nearest || !stay.touching) stay.normal_W = n;
      stay.touching = true;
      stay.until_s = S(0);
      return;
    }
    const Part<S, SupportA> part_a{w_a, reach_a, of_a};
    const Part<S, SupportB> part_b{w_b, reach_b, of_b};
    S until = time_apart(gap, n, v_W, part_a, part_b, most_s, round_off);
    if (until < stay.until_s && until < most_s && dot(face, face) > S(0)) {
      if (dot(face, n) < S(0)) face = -face;
      const S left =
          dot(face, b.place.p_W - a.place.p_W) - part_a.in_any_turn(face) - part_b.in_any_turn(-face) - skins;
      until = real::max(until, time_to_close(left, dot(v_W, face), most_s, round_off));
    }
    if (until < stay.until_s) stay.until_s = until, stay.normal_W = n;
  }
};

// ---- supports of parts about their bodies' origins ----------------------------------------------------------------
template <class S> struct BodySupport {
  const Spinning<S>& body;
  S operator()(const Vec3<S>& d_W) const { return core_support(body.shape, turned_back(body.place, d_W)); }
  S off_axis(const Vec3<S>& u_W) const { return core_off_axis(body.shape, turned_back(body.place, u_W)); }
};
template <class S> BodySupport<S> support_of(const Spinning<S>& body) { return {body}; }

template <class S> struct BoxSupport {
  Vec3<S> half_extents;
  Placement<S> from_origin_W;  // its axes, and its centre from the body's origin
  S operator()(const Vec3<S>& d_W) const {
    return dot(d_W, from_origin_W.p_W) + box_support(half_extents, turned_back(from_origin_W, d_W));
  }
  S off_axis(const Vec3<S>& u_W) const { return box_off_axis(half_extents, from_origin_W, u_W); }
};

template <class S> struct TriangleSupport {
  const TriangleMesh<S>& mesh;
  int t;
  const Placement<S>& place;
  const Vec3<S>& corner(int k) const { return mesh.points[mesh.triangles[t].corner[k]]; }
  S operator()(const Vec3<S>& d_W) const {
    const Vec3<S> d = turned_back(place, d_W);
    return real::max(dot(d, corner(0)), real::max(dot(d, corner(1)), dot(d, corner(2))));
  }
  S off_axis(const Vec3<S>& u_W) const {
    const Vec3<S> u = turned_back(place, u_W);
    return real::max(norm(cross(u, corner(0))), real::max(norm(cross(u, corner(1))), norm(cross(u, corner(2)))));
  }
};
template <class S> TriangleSupport<S> triangle_support(const TriangleMesh<S>& mesh, int t, const Placement<S>& place) {
  return {mesh, t, place};
}

// A body's convex parts but those of meshes: itself, or a compound's boxes. visit(shape, placement, support, reach).
template <class S, class Visit> void each_part(const Spinning<S>& body, const Visit& visit) {
  if (body.shape.kind != ShapeKind::compound)
    return visit(body.shape, body.place, support_of(body), core_reach(body.shape));
  for (const auto& part : body.shape.parts) {
    Geometry<S> box;
    box.kind = ShapeKind::box;
    box.half_extents = part.half_extents;
    box.bounding_radius = (S(1) + S(4) * real::epsilon<S>()) * norm(part.half_extents);
    const Placement<S> place = part_placement(body.place, part);
    BoxSupport<S> support{part.half_extents, place};
    support.from_origin_W.p_W = turned(body.place, part.p_B);
    visit(box, place, support, norm(part.p_B) + box.bounding_radius);
  }
}

template <class S> void look_at_convex(Look<S>& look) {
  each_part(look.a, [&](const Geometry<S>& of_a, const Placement<S>& place_a, const auto& support_a, S reach_a) {
    each_part(look.b, [&](const Geometry<S>& of_b, const Placement<S>& place_b, const auto& support_b, S reach_b) {
      if (norm(place_b.p_W - place_a.p_W) - of_a.bounding_radius - of_b.bounding_radius > look.enough()) return;
      const Separation<S> s = separation(of_a, place_a, of_b, place_b);
      look.parts(s.gap, s.normal_W, support_a, reach_a, support_b, reach_b);
    });
  });
}

// `mesh_is_a`: the mesh is the look's a, else its b.
template <class S> void look_at_mesh(Look<S>& look, bool mesh_is_a) {
  const Spinning<S>&solid = mesh_is_a ? look.a : look.b, &other = mesh_is_a ? look.b : look.a;
  const TriangleMesh<S>& mesh = *solid.shape.mesh;
  each_part(other, [&](const Geometry<S>& shape, const Placement<S>& place, const auto& support, S reach) {
    ConvexPiece<S> piece;
    if (!convex_piece(shape, piece)) return;
    const Placement<S> in_mesh = relative_placement(solid.place, place);
    nearest_triangles(mesh, bounds_of(piece, in_mesh), look.enough(), [&](int t) {
      const Meet<S> meet = nearest_features(piece_of(mesh, t), piece, in_mesh, look.enough() + piece.radius);
      if (meet.beyond) return look.enough();
      const Vec3<S> n = turned(solid.place, meet.normal);
      const auto of_triangle = triangle_support(mesh, t, solid.place);
      const S gap = meet.gap - piece.radius;
      const Vec3<S> face = turned(solid.place, mesh.triangles[t].normal);
      if (mesh_is_a) look.parts(gap, n, of_triangle, solid.shape.bounding_radius, support, reach, face, piece.radius);
      else look.parts(gap, -n, support, reach, of_triangle, solid.shape.bounding_radius, face, piece.radius);
      return look.enough();
    });
  });
}

template <class S> void look_at_meshes(Look<S>& look) {
  const TriangleMesh<S>&a = *look.a.shape.mesh, &b = *look.b.shape.mesh;
  const Placement<S> b_in_a = relative_placement(look.a.place, look.b.place);
  const auto wanted = [&](const Aabb<S>& of_a, const Aabb<S>& of_b) {
    return distance_between(of_a, of_b) <= look.enough();
  };
  each_pair_of_triangles(a, b, b_in_a, wanted, [&](int t, int u) {
    const Meet<S> meet = nearest_features(piece_of(a, t), placed_piece(b, u, b_in_a), Placement<S>{}, look.enough());
    if (meet.beyond) return;
    const auto of_a = triangle_support(a, t, look.a.place), of_b = triangle_support(b, u, look.b.place);
    const bool still_a = !(dot(look.w_a, look.w_a) > S(0));  // the floor of the two, if there is one
    const Vec3<S> face =
        still_a ? turned(look.a.place, a.triangles[t].normal) : turned(look.b.place, b.triangles[u].normal);
    look.parts(meet.gap, turned(look.a.place, meet.normal), of_a, look.a.shape.bounding_radius, of_b,
               look.b.shape.bounding_radius, face);
  });
}

}  // namespace

template <class S>
Stay<S> stay_apart(const Spinning<S>& a, const Spinning<S>& b, const Vec3<S>& v_W, S most_s, S round_off) {
  Look<S> look(a, b, v_W, most_s, round_off);
  const auto is = [](const Spinning<S>& body, ShapeKind kind) { return body.shape.kind == kind; };
  const auto without = [&](const Spinning<S>& body) {
    return (is(body, ShapeKind::mesh) && (!body.shape.mesh || body.shape.mesh->nodes.empty())) ||
           (is(body, ShapeKind::convex) && (!body.shape.hull || body.shape.hull->vertices.empty()));
  };
  if (without(a) || without(b)) return look.stay;
  if (is(a, ShapeKind::plane) || is(b, ShapeKind::plane)) {  // one direction for all parts
    const Separation<S> s = separation(a.shape, a.place, b.shape, b.place);
    look.parts(s.gap, s.normal_W, support_of(a), core_reach(a.shape), support_of(b), core_reach(b.shape));
  } else if (is(a, ShapeKind::mesh) && is(b, ShapeKind::mesh)) {
    look_at_meshes(look);
  } else if (is(a, ShapeKind::mesh) || is(b, ShapeKind::mesh)) {
    look_at_mesh(look, is(a, ShapeKind::mesh));
  } else {
    look_at_convex(look);
  }
  return look.stay;
}

#define ATWOOD_STAY_APART(S) \
  template Stay<S> stay_apart<S>(const Spinning<S>&, const Spinning<S>&, const Vec3<S>&, S, S);
ATWOOD_STAY_APART(float)
ATWOOD_STAY_APART(double)
ATWOOD_STAY_APART(long double)
#undef ATWOOD_STAY_APART

}  // namespace atwood
