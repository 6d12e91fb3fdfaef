#include "closed_form/resting_contacts.hpp"

#include <algorithm>
#include <cmath>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

using V = Vec<double>;
constexpr double kSimpleContact = 1e-11;          // of the bodies' positions and sizes
constexpr double kContactToleranceOfBody = 1e-7;  // of the thinner body, however far from the origin it is
constexpr double kMargin = 1e-5;                  // the cones and the contact areas are reduced by this relative amount
// What is not balanced of a body's weight must not be more than friction could still hold: the coefficients are reduced
// by this amount, too.
constexpr double kFrictionMargin = 4 * kBalanced;
constexpr double kSameNormal = 1e-9;  // normals that the contacts of a pair do not distinguish
constexpr double kRoundOffOfNormals = 1e-14;

std::string make_solid(const Scene& scene, const Body& body, RestingBody& made) {
  const std::string name = "`" + body.name + "`";
  const Pose<double> pose = {vec<double>(body.position_m), {}, {}, {body.orientation_wxyz}};
  made.center = pose.p_WB;
  for (int k = 0; k < 3; ++k) {
    V unit{};
    unit[k] = 1;
    made.axis[k] = rotate(pose.q_WB, unit);
    Vec<Wide> unit_wide{};
    unit_wide[k] = 1;
    made.faces.push_back(rotate(quat<Wide>(body.orientation_wxyz), unit_wide));
  }
  if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    made.plane = true;
    made.axis[2] = vec<double>(plane->normal);
    const Vec<Wide> normal = vec<Wide>(plane->normal);
    made.faces = {(1 / norm(normal)) * normal};
    made.offset = plane->offset_m;
  } else if (const auto* box = std::get_if<Box>(&body.shape)) {
    std::copy(box->half_extents_m.begin(), box->half_extents_m.end(), made.half);
  } else if (const auto* rectangle = std::get_if<Rectangle>(&body.shape)) {
    std::copy(rectangle->half_extents_m.begin(), rectangle->half_extents_m.end(), made.half);
  } else if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    made.radius = sphere->radius_m;
    made.faces.clear();
  } else if (body.shape.index() != 0 || !body.fixed) {
    return name + " has another shape: expected a box, a sphere, a plane or a rectangle";
  }
  made.free = !body.fixed;
  if (body.fixed) return "";
  if (body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{})
    return name + " has an initial velocity: expected rest";
  if (body.release_s > 0) return name + " has a later release, which is not covered";
  const Real33& I = body.inertia_kg_m2;
  if (!rotates(body) || I[1] != 0 || I[2] != 0 || I[5] != 0) return "the inertia of " + name + " is not diagonal";
  for (std::size_t i = 0; i < scene.forces.size(); ++i)
    if (acts_on(scene.forces[i], static_cast<int>(&body - scene.bodies.data())))
      return "a force acts on " + name + ", which is not covered";
  made.inverse_mass = 1 / body.mass_kg;
  for (int k = 0; k < 3; ++k) made.inertia_inverse[4 * k] = 1 / I[4 * k];
  return "";
}

double support(const RestingBody& solid, const V& n) {  // support function along n, from the centre
  double sum = solid.radius;
  for (int k = 0; k < 3; ++k) sum += solid.half[k] * std::fabs(dot(solid.axis[k], n));
  return sum;
}

double smallest_half_extent(const RestingBody& solid) {  // of the positive ones
  double least = solid.radius > 0 ? solid.radius : HUGE_VAL;
  for (const double half : solid.half)
    if (half > 0) least = std::min(least, half);
  return least;
}

V corner(const RestingBody& solid, int index) {
  V at = solid.center;
  for (int k = 0; k < 3; ++k) at = at + ((index >> k & 1) != 0 ? solid.half[k] : -solid.half[k]) * solid.axis[k];
  return at;
}

// Clips the edges of `from` against `in`, enlarged by `tolerance`: corners of the contact polygon of two boxes.
void clip_edges(const RestingBody& from, const RestingBody& in, double tolerance, std::vector<V>& points) {
  for (int index = 0; index < 8; ++index)
    for (int k = 0; k < 3; ++k) {
      if ((index >> k & 1) != 0) continue;
      const V start = corner(from, index), direction = corner(from, index | 1 << k) - start;
      double enter = 0, leave = 1;
      for (int i = 0; i < 3; ++i) {
        const double p = dot(in.axis[i], start - in.center), u = dot(in.axis[i], direction),
                     wide = in.half[i] + tolerance;
        if (std::fabs(u) < 1e-14) {
          if (std::fabs(p) > wide) leave = -1;
          continue;
        }
        enter = std::max(enter, ((u > 0 ? -wide : wide) - p) / u);
        leave = std::min(leave, ((u > 0 ? wide : -wide) - p) / u);
      }
      if (enter > leave) continue;
      for (const V& x : {start + enter * direction, start + leave * direction})
        if (std::none_of(points.begin(), points.end(),
                         [&](const V& known) { return length(x - known) < 8 * tolerance; }))
          points.push_back(x);
    }
}

// Separating axes: each of the 15 axes with |gap| <= tolerance is a contact normal. Returns the largest gap.
double box_box(const RestingBody& a, const RestingBody& b, double tolerance, std::vector<V>& normals) {
  std::vector<V> axes(a.axis, a.axis + 3);
  axes.insert(axes.end(), b.axis, b.axis + 3);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (const V c = cross(a.axis[i], b.axis[j]); length(c) > 1e-6) axes.push_back((1 / length(c)) * c);
  double widest = -HUGE_VAL;
  for (const V& axis : axes) {
    const double along = dot(axis, b.center - a.center), gap = std::fabs(along) - support(a, axis) - support(b, axis);
    widest = std::max(widest, gap);
    const V n = (along < 0 ? -1.0 : 1.0) * axis;
    const bool known = std::any_of(normals.begin(), normals.end(), [&](const V& m) { return length(n - m) < 1e-9; });
    if (std::fabs(gap) <= tolerance && !known) normals.push_back(n);
  }
  return widest;
}

// What the contact of two faces, or of an edge and a face, leaves open where they are parallel to round-off only.
double open_by_tilt(const RestingBody& a, const RestingBody& b, const V& n) {
  double open_m = 0;
  for (const RestingBody* body : {&a, &b})
    for (int k = 0; k < 3; ++k)
      if (const double tilt = std::fabs(dot(body->axis[k], n)); tilt < kSameNormal) open_m += 2 * body->half[k] * tilt;
  return open_m;
}

// Appends the contacts of a pair, and returns its gap. `open_m`: the largest deviation from a contact of exact
// surfaces.
double find_contacts(const RestingBody& a, const RestingBody& b, double tolerance,
                     std::vector<RestingContact>& contacts, double& open_m) {
  std::vector<V> points, normals;
  double gap = 0;
  if (b.plane) {
    gap = dot(b.axis[2], a.center) - b.offset - support(a, b.axis[2]);
    if (std::fabs(gap) > tolerance) return gap;
    normals.push_back(-1.0 * b.axis[2]);
    for (int index = 0; index < 8; ++index)
      if (const V x = corner(a, index) - a.radius * b.axis[2]; dot(b.axis[2], x) - b.offset <= tolerance)
        points.push_back(x);
  } else if (a.radius > 0) {
    V beyond = a.center - b.center, nearest = b.center;
    for (int k = 0; k < 3; ++k)
      nearest = nearest + std::clamp(dot(b.axis[k], beyond), -b.half[k], b.half[k]) * b.axis[k];
    beyond = nearest - a.center;
    gap = length(beyond) - a.radius - b.radius;
    if (std::fabs(gap) > tolerance) return gap;
    normals.push_back((1 / length(beyond)) * beyond);
    points.push_back(a.center + a.radius * normals.back());
  } else {
    gap = box_box(a, b, tolerance, normals);
    if (std::fabs(gap) > tolerance) return gap;
    clip_edges(a, b, 4 * tolerance, points);
    clip_edges(b, a, 4 * tolerance, points);
  }
  open_m = std::fabs(gap);
  for (const V& n : normals) {
    open_m = std::max(open_m, std::fabs(gap) + open_by_tilt(a, b, n));
    for (const V& x : points) contacts.push_back({0, 0, x, n, 0, 0, 0});
  }
  return gap;
}

// The slope of a contact, of the steepest of the faces that its normal stands for. Of other normals, which are known in
// double only, the round-off is added.
Wide slope_of(const RestingBody& a, const RestingBody& b, const V& n, const Vec<Wide>& g) {
  if (is_zero(g)) return 0;
  const auto tangent = [&](const Vec<Wide>& m) { return norm(cross(g, m)) / magnitude(dot(g, m)); };
  Wide steepest = 0;
  bool known = false;
  for (const RestingBody* solid : {&a, &b})
    for (const Vec<Wide>& face : solid->faces) {
      const V m = rounded(face);
      if (std::min(length(m - n), length(m + n)) > kSameNormal) continue;
      steepest = larger(steepest, tangent(face));
      known = true;
    }
  const Vec<Wide> m{n[0], n[1], n[2]};
  return known ? steepest : tangent((1 / norm(m)) * m) + Wide(kRoundOffOfNormals);
}

std::string find_all_contacts(const Scene& scene, const std::vector<RestingBody>& solids,
                              std::vector<RestingContact>& contacts, Equilibrium& made) {
  for (std::size_t i = 0; i < solids.size(); ++i)
    for (std::size_t j = 0; j < solids.size(); ++j) {
      // Each pair once; a sphere comes first.
      const RestingBody &a = solids[i], &b = solids[j];
      if (i == j || !(a.free || b.free) || a.plane || scene.bodies[i].shape.index() == 0 ||
          scene.bodies[j].shape.index() == 0)
        continue;
      if (!b.plane && (a.radius > 0) == (b.radius > 0) && j < i) continue;
      if (!b.plane && a.radius == 0 && b.radius > 0) continue;
      const double size = length(a.center) + (b.plane ? 0 : length(b.center)) + bounding_radius(a);
      const std::size_t before = contacts.size();
      const double tolerance = std::min(
          kSimpleContact * size,
          kContactToleranceOfBody * std::min(smallest_half_extent(a), b.plane ? HUGE_VAL : smallest_half_extent(b)));
      double open_m = 0;
      const double gap = find_contacts(a, b, tolerance, contacts, open_m);
      if (gap < -tolerance) return "`" + scene.bodies[i].name + "` and `" + scene.bodies[j].name + "` overlap";
      if (contacts.size() > before) made.largest_gap_m = std::max(made.largest_gap_m, open_m);
      for (std::size_t k = before; k < contacts.size(); ++k) {
        contacts[k].a = static_cast<int>(i);
        contacts[k].b = static_cast<int>(j);
        const double friction = pair_law(scene, contacts[k].a, contacts[k].b).friction;
        contacts[k].friction = std::max(0.0, std::min((1 - kMargin) * friction, friction - kFrictionMargin));
        contacts[k].limit = friction;
        contacts[k].slope = slope_of(a, b, contacts[k].n, vec<Wide>(scene.gravity_m_per_s2));
      }
      V middle{};
      for (std::size_t k = before; k < contacts.size(); ++k)
        middle = middle + (1.0 / double(contacts.size() - before)) * contacts[k].x;
      for (std::size_t k = before; k < contacts.size(); ++k)
        contacts[k].x = contacts[k].x + kMargin * (middle - contacts[k].x);
    }
  return "";
}

}  // namespace

double bounding_radius(const RestingBody& body) {
  return length(V{body.half[0], body.half[1], body.half[2]}) + body.radius;
}

std::string find_contacts_at_rest(const Scene& scene, std::vector<RestingBody>& bodies,
                                  std::vector<RestingContact>& contacts, Equilibrium& made) {
  made.smallest_extent_m = HUGE_VAL;
  bodies.resize(scene.bodies.size());
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (std::string refusal = make_solid(scene, scene.bodies[i], bodies[i]); !refusal.empty()) return refusal;
    made.smallest_extent_m = std::min(made.smallest_extent_m, smallest_half_extent(bodies[i]));
  }
  return find_all_contacts(scene, bodies, contacts, made);
}

}  // namespace atwood::closed_form
