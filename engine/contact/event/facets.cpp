// Where surfaces end. A contact that lasts leaves its facet there: a ball that rolls off the end of a sheet goes on
// about the edge, or flies; a box goes on where its edges cross those that it slides over (edges.hpp). Other bodies'
// corners see faces alone, so what lies over an end without a contact there, or is larger than the whole sheet, is
// refused.
#include <algorithm>
#include <cmath>

#include "collision/contacts.hpp"
#include "contact/event/run.hpp"

namespace atwood::event {

namespace {

template <class S> S component(const Vec3<S>& v, int i) { return i == 0 ? v.x : i == 1 ? v.y : v.z; }

// A face of a mesh goes on over all triangles of its plane: inner edges are no ends. The greatest of the distances
// within them; where c is within one, that one's, and `over` is which: where it is looked for first.
template <class S>
S within_face(const std::vector<Triangle<S>>& mesh, const Facet<S>& facet, const Vec3<S>& c, S tiny, int& over) {
  const int count = static_cast<int>(mesh.size());
  const auto on_the_face = [&](const Triangle<S>& triangle) {
    return std::all_of(triangle.corner_B, triangle.corner_B + 3, [&](const Vec3<S>& corner) {
      return real::abs(dot(corner - facet.point_B, facet.direction_B)) <= tiny;
    });
  };
  if (over < count && on_the_face(mesh[over]))
    if (const S in = within_triangle(mesh[over], c); in > S(0)) return in;
  S most = S(-1);
  bool any = false;
  for (int i = 0; i < count; ++i) {
    if (!on_the_face(mesh[i])) continue;
    const S in = within_triangle(mesh[i], c);
    if (!any || in > most) {
      most = in;
      over = i;
    }
    any = true;
  }
  return most;
}

// Of a box or a sheet: on a face c lies between its sides; beside an edge or a corner it lies outside along the axes
// that meet there.
template <class S> S within_slab(const Vec3<S>& half, const Facet<S>& facet, const Vec3<S>& c) {
  S least{};
  bool any = false;
  for (int i = 0; i < 3; ++i) {
    const bool along = component(facet.direction_B, i) != S(0);
    if (facet.dimension == 2 && along) continue;
    const S inside = component(half, i) - real::abs(component(c, i));
    const S value = facet.dimension == 2 || along ? inside : -inside;
    least = any ? real::min(least, value) : value;
    any = true;
  }
  return least;
}

template <class S> bool same_facet(const Facet<S>& a, const Facet<S>& b) {
  return a.dimension == b.dimension && norm(a.point_B - b.point_B) == S(0) &&
         norm(a.direction_B - b.direction_B) == S(0);
}

template <class S> bool sees_faces_alone(const Surface<S>& surface, const Knob<S>& knob) {
  return surface.radius + knob.radius == S(0) || !knob.centered;  // as facet_under() has it
}

}  // namespace

template <class S> bool has_ends(const EventRun<S>& run, const Contact<S>& contact) {
  return run.surfaces[run.features[contact.feature].surface].kind > SurfaceKind::point;
}

template <class S> S within_facet(const EventRun<S>& run, Contact<S>& contact) {
  const Feature<S>& feature = run.features[contact.feature];
  if (feature.knob.edge) return within_edges_of(run, contact);
  const Surface<S>& surface = run.surfaces[feature.surface];
  const Facet<S>& facet = contact.facet;
  const Pose<S>& on = run.poses[feature.surface_body];
  const Vec3<S> c = turned_back(on, outermost_of(run, feature) - on.p);
  switch (surface.kind) {
    case SurfaceKind::segment: {
      const S inside = surface.half_extents.z - real::abs(c.z);
      return facet.dimension == 1 ? inside : -inside;
    }
    case SurfaceKind::slab: return within_slab(surface.half_extents, facet, c);
    case SurfaceKind::mesh: {
      if (facet.dimension == 2) return within_face(surface.mesh, facet, c, run.gap_round_off(), contact.over_triangle);
      S beside{};
      const Facet<S> nearest = facet_under(run, feature, beside);
      if (same_facet(nearest, facet)) return run.length_scale;
      return nearest.dimension == 2 ? -within_face(surface.mesh, nearest, c, run.gap_round_off(), contact.over_triangle)
                                    : -run.length_scale;
    }
    default: return S(1);
  }
}

template <class S> bool leave_facet(EventRun<S>& run, Contact<S>& contact) {
  // A corner or an edge that leaves: what its body comes to stand on then is another feature, if any.
  if (has_edges(run, run.features[contact.feature].pair)) {
    list_edges(run, run.features[contact.feature].pair);
    run.features[contact.feature].lasting = false;
    contact.left = true;
    return true;
  }
  const Feature<S>& feature = run.features[contact.feature];
  if (sees_faces_alone(run.surfaces[feature.surface], feature.knob)) {
    run.outcome = {Status::unsupported, run.pairs[feature.pair].past_the_end, 0, 0, {}};
    return false;
  }
  // By round-off it is still on the old one: what lies a little ahead.
  const Pose<S>&of = run.poses[feature.knob_body], &on = run.poses[feature.surface_body];
  const Vec3<S> arm = feature.knob.centered ? Vec3<S>{} : turned(of, feature.knob.center_B), center = of.p + arm;
  const Vec3<S> drift = of.v + cross(of.w, arm) - on.v - cross(on.w, center - on.p);
  const S speed = norm(drift), ahead_m = S(2) * run.gap_round_off();
  const Vec3<S> ahead = speed > S(0) ? center + (ahead_m / speed) * drift : center;
  S beside{};
  contact.facet = nearest_facet(run.surfaces[feature.surface], turned_back(on, ahead - on.p), false,
                                turned_back(on, of.p - on.p), beside);
  return true;
}

namespace {

template <class S> Placement<S> placed(const EventRun<S>& run, int body, const S* y) {
  const Pose<S> pose = pose_of(run, body, y);
  return {pose.p, {pose.axis[0], pose.axis[1], pose.axis[2]}};
}

}  // namespace

template <class S> S held_at(const EventRun<S>& run, int pair, const S* y) {
  S deepest = S(0);
  for (const Contact<S>& contact : run.contacts) {
    const Feature<S>& f = run.features[contact.feature];
    if (f.pair != pair) continue;
    deepest = real::min(deepest, contact.rest_gap);
    if (!contact.carries) continue;
    const Pose<S> of = pose_of(run, f.knob_body, y), on = pose_of(run, f.surface_body, y);
    deepest = real::min(deepest, look(f.knob, of, run.surfaces[f.surface], contact.facet, on).gap);
  }
  return deepest;
}

template <class S> bool clear_of_end(EventRun<S>& run, const SheetEnds<S>& ends, const S* y) {
  const ShapePair<S>& pair = run.pairs[ends.pair];
  if (std::find(run.near.begin(), run.near.end(), ends.pair) == run.near.end()) return true;
  const Placement<S> knob = placed(run, ends.knob_body, y), sheet = placed(run, ends.surface_body, y);
  if (norm(knob.p_W - sheet.p_W) > pair.reach) return true;
  // The distance between shapes is found by iteration, not to the last place.
  const S iterated = S(std::pow(static_cast<double>(real::epsilon<S>()), 0.6));
  const S tolerance = S(64) * run.gap_round_off() + iterated * pair.reach;
  return separation(ends.knob, knob, ends.surface, sheet).gap >= held_at(run, ends.pair, y) - tolerance;
}

template <class S> bool clear_of_ends(EventRun<S>& run, const S* y) {
  for (const SheetEnds<S>& ends : run.ends) {
    if (clear_of_end(run, ends, y)) continue;
    run.outcome = {Status::unsupported, run.pairs[ends.pair].past_the_end, 0, 0, {}};
    return false;
  }
  return true;
}

template <class S> bool passes_a_sheet(const EventRun<S>& run, const S* y, const S* y_end) {
  // Next to each other, has one turned? A body that tips over an end may be clear of it again.
  const auto turned_much = [&](int body) {
    const Pose<S> from = pose_of(run, body, y), to = pose_of(run, body, y_end);
    S most = S(0);
    for (int k = 0; k < 3; ++k) most = real::max(most, norm(to.axis[k] - from.axis[k]));
    return most > S(0.05);
  };
  return std::any_of(run.ends.begin(), run.ends.end(), [&](const SheetEnds<S>& ends) {
    const Placement<S> one = placed(run, ends.knob_body, y), other = placed(run, ends.surface_body, y);
    if (norm(one.p_W - other.p_W) < run.pairs[ends.pair].reach &&
        (turned_much(ends.knob_body) || turned_much(ends.surface_body)))
      return true;
    const auto side = [&](const S* at) {
      const Placement<S> sheet = placed(run, ends.surface_body, at);
      return dot(turned(sheet, ends.normal_B), placed(run, ends.knob_body, at).p_W - sheet.p_W) -
             dot(ends.normal_B, ends.on_it_B);
    };
    // Has their place to each other changed by much of the smaller one's size? An end of a body may have passed alone.
    const auto apart = [&](const S* at) {
      return placed(run, ends.knob_body, at).p_W - placed(run, ends.surface_body, at).p_W;
    };
    const S size = real::min(run.reach[ends.knob_body], run.reach[ends.surface_body]);
    if (ends.thick || has_edges(run, ends.pair))
      if (norm(apart(y_end) - apart(y)) > size / S(32) && norm(apart(y)) < S(2) * run.pairs[ends.pair].reach)
        return true;
    if (ends.thick) return false;
    return side(y) * side(y_end) < S(0);
  });
}

#define ATWOOD_FACETS(S)                                                      \
  template S held_at<S>(const EventRun<S>&, int, const S*);                   \
  template bool clear_of_end<S>(EventRun<S>&, const SheetEnds<S>&, const S*); \
  template bool clear_of_ends<S>(EventRun<S>&, const S*);                     \
  template bool passes_a_sheet<S>(const EventRun<S>&, const S*, const S*);    \
  template bool has_ends<S>(const EventRun<S>&, const Contact<S>&);           \
  template S within_facet<S>(const EventRun<S>&, Contact<S>&);                \
  template bool leave_facet<S>(EventRun<S>&, Contact<S>&);
ATWOOD_FACETS(float)
ATWOOD_FACETS(double)
ATWOOD_FACETS(long double)
#undef ATWOOD_FACETS

}  // namespace atwood::event
