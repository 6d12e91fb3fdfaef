#include "collision/contacts.hpp"

#include <algorithm>
#include <array>
#include <limits>
#include <string>
#include <utility>

#include "collision/compound_pairs.hpp"
#include "collision/convex_contacts.hpp"
#include "collision/pair_tests.hpp"
#include "collision/triangle_mesh.hpp"

namespace atwood {

namespace {

constexpr std::size_t kKinds = static_cast<std::size_t>(ShapeKind::compound) + 1;
constexpr std::size_t at(ShapeKind kind) { return static_cast<std::size_t>(kind); }

template <class S> struct PairTest {
  ContactTest<S> contacts = nullptr;  // null: no test
  SeparationTest<S> separation = nullptr;
  bool symmetric = false;  // both of one kind: the order is chosen by comes_first
};
template <class S> using PairTable = std::array<std::array<PairTest<S>, kKinds>, kKinds>;  // [a][b] with a <= b

template <class S> void by_support(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  convex_contacts(a.shape, a.pose, b.shape, b.pose, margin, out);
}
template <class S> Separation<S> by_support_separation(const Posed<S>& a, const Posed<S>& b) {
  return convex_separation(a.shape, a.pose, b.shape, b.pose);
}
template <class S>
void plane_hull_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  hull_plane_contacts(a.shape, b.shape, b.pose, margin, out);
}
template <class S> Separation<S> plane_hull_separation(const Posed<S>& a, const Posed<S>& b) {
  return hull_plane_separation(a.shape, b.shape, b.pose);
}

// The mesh is the second.
template <class S> void mesh_second(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out) {
  const std::size_t from = out.size();
  mesh_contacts(b.shape, b.pose, a.shape, a.pose, margin, out);
  for (std::size_t i = from; i < out.size(); ++i) {
    out[i].normal_W = -out[i].normal_W;
    std::swap(out[i].part_a, out[i].part_b);
  }
}
template <class S> Separation<S> mesh_second_separation(const Posed<S>& a, const Posed<S>& b) {
  const Separation<S> s = mesh_separation(b.shape, b.pose, a.shape, a.pose);
  return {s.gap, -s.normal_W, s.on_b_W, s.on_a_W, s.solve};
}

template <class S> constexpr PairTable<S> pair_table() {
  using enum ShapeKind;
  PairTable<S> table{};
  const auto set = [&table](ShapeKind a, ShapeKind b, ContactTest<S> contacts, SeparationTest<S> gap,
                            bool symmetric = false) {
    table[at(a)][at(b)] = {contacts, gap, symmetric};
  };
  set(sphere, sphere, sphere_sphere_contacts<S>, sphere_sphere_separation<S>);
  set(sphere, plane, sphere_plane_contacts<S>, sphere_plane_separation<S>);
  set(sphere, rectangle, sphere_box_contacts<S>, sphere_box_separation<S>);
  set(sphere, box, sphere_box_contacts<S>, sphere_box_separation<S>);
  set(sphere, capsule, sphere_capsule_contacts<S>, sphere_capsule_separation<S>);
  set(sphere, cylinder, sphere_cylinder_contacts<S>, sphere_cylinder_separation<S>);
  set(plane, rectangle, plane_box_contacts<S>, plane_box_separation<S>);
  set(plane, box, plane_box_contacts<S>, plane_box_separation<S>);
  set(plane, capsule, plane_capsule_contacts<S>, plane_capsule_separation<S>);
  set(plane, cylinder, plane_cylinder_contacts<S>, plane_cylinder_separation<S>);
  for (const ShapeKind a : {rectangle, box, capsule})
    for (const ShapeKind b : {rectangle, box, capsule})
      if (a <= b) set(a, b, box_box_contacts<S>, box_box_separation<S>, a == b);
  for (const ShapeKind a : {rectangle, box, capsule, cylinder})
    set(a, cylinder, by_support<S>, by_support_separation<S>, a == cylinder);
  for (const ShapeKind a : {sphere, rectangle, box, capsule, cylinder, convex})
    set(a, convex, by_support<S>, by_support_separation<S>, a == convex);
  set(plane, convex, plane_hull_contacts<S>, plane_hull_separation<S>);
  for (const ShapeKind a : {sphere, plane, rectangle, box, capsule, cylinder, convex, mesh})
    set(a, mesh, mesh_second<S>, mesh_second_separation<S>, a == mesh);
  for (const ShapeKind other : {sphere, plane, rectangle, box, capsule, cylinder, convex, mesh, compound})
    set(other, compound, compound_contacts<S>, compound_separation<S>, other == compound);
  return table;
}
template <class S> constexpr PairTable<S> kPairs = pair_table<S>();

// A canonical order of two shapes of one kind, so that swapping the arguments repeats the same arithmetic.
template <class S> bool comes_first(const Posed<S>& a, const Posed<S>& b) {
  const auto less = [](const Vec3<S>& x, const Vec3<S>& y, bool& decided) {
    decided = true;
    if (x.x != y.x) return x.x < y.x;
    if (x.y != y.y) return x.y < y.y;
    if (x.z != y.z) return x.z < y.z;
    return decided = false;
  };
  bool decided = false;
  const bool by_size = less(a.shape.half_extents, b.shape.half_extents, decided);
  if (decided) return by_size;
  if (a.shape.radius != b.shape.radius) return a.shape.radius < b.shape.radius;
  if (a.shape.half_length != b.shape.half_length) return a.shape.half_length < b.shape.half_length;
  const bool by_place = less(a.pose.p_W, b.pose.p_W, decided);
  if (decided) return by_place;
  for (int k = 0; k < 3; ++k) {
    const bool by_axis = less(a.pose.axis_W[k], b.pose.axis_W[k], decided);
    if (decided) return by_axis;
  }
  return true;
}

template <class S> struct Ordered {
  const PairTest<S>* test;
  bool swapped;
};
template <class S> Ordered<S> in_order(const Posed<S>& a, const Posed<S>& b) {
  if (at(a.shape.kind) > at(b.shape.kind)) return {&kPairs<S>[at(b.shape.kind)][at(a.shape.kind)], true};
  const PairTest<S>* test = &kPairs<S>[at(a.shape.kind)][at(b.shape.kind)];
  return {test, test->symmetric && !comes_first(a, b)};
}

}  // namespace

template <class S>
void find_contacts(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b, const Transform<S>& pose_b,
                   S margin, std::vector<Manifold<S>>& out) {
  const Posed<S> first{a, pose_a}, second{b, pose_b};
  const Ordered<S> order = in_order(first, second);
  if (!order.test->contacts) return;
  if (!order.swapped) return order.test->contacts(first, second, margin, out);
  const std::size_t from = out.size();
  order.test->contacts(second, first, margin, out);
  for (std::size_t i = from; i < out.size(); ++i) {
    out[i].normal_W = -out[i].normal_W;
    std::swap(out[i].part_a, out[i].part_b);
  }
}

template <class S>
Separation<S> separation(const Geometry<S>& a, const Transform<S>& pose_a, const Geometry<S>& b,
                         const Transform<S>& pose_b) {
  const Posed<S> first{a, pose_a}, second{b, pose_b};
  const Ordered<S> order = in_order(first, second);
  if (!order.test->separation) return {std::numeric_limits<S>::infinity(), {S(0), S(0), S(1)}, pose_a.p_W, pose_b.p_W};
  if (!order.swapped) return order.test->separation(first, second);
  const Separation<S> other = order.test->separation(second, first);
  return {other.gap, -other.normal_W, other.on_b_W, other.on_a_W, other.solve};
}

template <class S>
S touch_round_off(const Geometry<S>& a, const Vec3<S>& p_a, const Geometry<S>& b, const Vec3<S>& p_b) {
  const auto along = [](const Vec3<S>& n, const Vec3<S>& p) {
    return real::abs(n.x * p.x) + real::abs(n.y * p.y) + real::abs(n.z * p.z);
  };
  const auto size = [](const Geometry<S>& g) {
    return g.kind == ShapeKind::plane ? real::abs(g.offset) : g.bounding_radius;
  };
  const S sizes = S(4) * (size(a) + size(b));
  if (a.kind == ShapeKind::plane) return real::epsilon<S>() * (sizes + S(4) * along(a.normal_W, p_b));
  if (b.kind == ShapeKind::plane) return real::epsilon<S>() * (sizes + S(4) * along(b.normal_W, p_a));
  return real::epsilon<S>() * (sizes + norm(p_a) + norm(p_b));
}

const char* missing_contact_test(ShapeKind a, ShapeKind b) {
  static const auto reasons = [] {
    constexpr const char* names[] = {"point",   "sphere",   "plane",  "rectangle", "box",
                                     "capsule", "cylinder", "convex", "mesh",      "compound"};
    std::array<std::array<std::string, kKinds>, kKinds> table;
    for (std::size_t i = 0; i < kKinds; ++i) {
      for (std::size_t j = 0; j < kKinds; ++j) {
        const auto missing = [](std::size_t x, std::size_t y) {
          return !kPairs<double>[std::min(x, y)][std::max(x, y)].contacts;
        };
        const auto part = [](std::size_t kind) { return kind == at(ShapeKind::compound) ? at(ShapeKind::box) : kind; };
        if (missing(i, j) || missing(part(i), part(j))) table[i][j] = std::string(names[i]) + " against " + names[j];
      }
    }
    return table;
  }();
  const std::string& reason = reasons[at(a)][at(b)];
  return reason.empty() ? nullptr : reason.c_str();
}

#define ATWOOD_CONTACTS(S)                                                                                            \
  template void find_contacts<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&, const Transform<S>&, S, \
                                 std::vector<Manifold<S>>&);                                                          \
  template S touch_round_off<S>(const Geometry<S>&, const Vec3<S>&, const Geometry<S>&, const Vec3<S>&);              \
  template Separation<S> separation<S>(const Geometry<S>&, const Transform<S>&, const Geometry<S>&,                   \
                                       const Transform<S>&);
ATWOOD_CONTACTS(float)
ATWOOD_CONTACTS(double)
ATWOOD_CONTACTS(long double)
#undef ATWOOD_CONTACTS

}  // namespace atwood
