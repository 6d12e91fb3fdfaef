#include "closed_form/equilibrium.hpp"

#include <algorithm>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

using V = Vec<double>;
constexpr double kSimpleContact = 1e-11;          // of the bodies' positions and sizes
constexpr double kContactToleranceOfBody = 1e-7;  // of the thinner body, however far from the origin it is
constexpr double kMargin = 1e-5;                  // the cones and the contact areas are reduced by this relative amount
constexpr int kMaxSweeps = 20000;
constexpr double kBalanced = 1e-7;  // of gravity
// What is not balanced of a body's weight must not be more than friction could still hold: the coefficients are reduced
// by this amount, too.
constexpr double kFrictionMargin = 4 * kBalanced;
constexpr double kRoundOff = 1e-14;

// A box, a rectangle (a box of thickness 0), a sphere (a box of zero extent with a radius), or a plane.
struct Solid {
  V center{}, axis[3]{};
  double half[3]{}, radius = 0, offset = 0;
  bool plane = false, free = false;
  double inverse_mass = 0;
  Real33 inertia_inverse{};  // diagonal, body axes
};

double length(const V& v) { return std::sqrt(dot(v, v)); }

// n from a to b
struct ContactPoint {
  int a = 0, b = 0;
  V x{}, n{};
  double friction = 0;
};

std::string make_solid(const Scene& scene, const Body& body, Solid& made) {
  const std::string name = "`" + body.name + "`";
  const Pose<double> pose = {vec<double>(body.position_m), {}, {}, {body.orientation_wxyz}};
  made.center = pose.p_WB;
  for (int k = 0; k < 3; ++k) {
    V unit{};
    unit[k] = 1;
    made.axis[k] = rotate(pose.q_WB, unit);
  }
  if (const auto* plane = std::get_if<Plane>(&body.shape)) {
    made.plane = true;
    made.axis[2] = vec<double>(plane->normal);
    made.offset = plane->offset_m;
  } else if (const auto* box = std::get_if<Box>(&body.shape)) {
    std::copy(box->half_extents_m.begin(), box->half_extents_m.end(), made.half);
  } else if (const auto* rectangle = std::get_if<Rectangle>(&body.shape)) {
    std::copy(rectangle->half_extents_m.begin(), rectangle->half_extents_m.end(), made.half);
  } else if (const auto* sphere = std::get_if<Sphere>(&body.shape)) {
    made.radius = sphere->radius_m;
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

double support(const Solid& solid, const V& n) {  // support function along n, from the centre
  double sum = solid.radius;
  for (int k = 0; k < 3; ++k) sum += solid.half[k] * std::fabs(dot(solid.axis[k], n));
  return sum;
}

// Bound of the distance of its points from its centre.
double bounding_radius(const Solid& solid) {
  return length(V{solid.half[0], solid.half[1], solid.half[2]}) + solid.radius;
}

double smallest_half_extent(const Solid& solid) {  // of the positive ones
  double least = solid.radius > 0 ? solid.radius : HUGE_VAL;
  for (const double half : solid.half)
    if (half > 0) least = std::min(least, half);
  return least;
}

V corner(const Solid& solid, int index) {
  V at = solid.center;
  for (int k = 0; k < 3; ++k) at = at + ((index >> k & 1) != 0 ? solid.half[k] : -solid.half[k]) * solid.axis[k];
  return at;
}

// Clips the edges of `from` against `in`, enlarged by `tolerance`: corners of the contact polygon of two boxes.
void clip_edges(const Solid& from, const Solid& in, double tolerance, std::vector<V>& points) {
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
double box_box(const Solid& a, const Solid& b, double tolerance, std::vector<V>& normals) {
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

// Appends the contacts of a pair, and returns its gap.
double find_contacts(const Solid& a, const Solid& b, double tolerance, std::vector<ContactPoint>& contacts) {
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
  for (const V& n : normals)
    for (const V& x : points) contacts.push_back({0, 0, x, n, 0});
  return gap;
}

std::string find_all_contacts(const Scene& scene, const std::vector<Solid>& solids, std::vector<ContactPoint>& contacts,
                              Equilibrium& made) {
  for (std::size_t i = 0; i < solids.size(); ++i)
    for (std::size_t j = 0; j < solids.size(); ++j) {
      // Each pair once; a sphere comes first.
      const Solid &a = solids[i], &b = solids[j];
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
      const double gap = find_contacts(a, b, tolerance, contacts);
      if (gap < -tolerance) return "`" + scene.bodies[i].name + "` and `" + scene.bodies[j].name + "` overlap";
      if (contacts.size() > before) made.largest_gap_m = std::max(made.largest_gap_m, std::fabs(gap));
      for (std::size_t k = before; k < contacts.size(); ++k) {
        contacts[k].a = static_cast<int>(i);
        contacts[k].b = static_cast<int>(j);
        const double friction = pair_law(scene, contacts[k].a, contacts[k].b).friction;
        contacts[k].friction = std::max(0.0, std::min((1 - kMargin) * friction, friction - kFrictionMargin));
        const V g = vec<double>(scene.gravity_m_per_s2), along = g - dot(g, contacts[k].n) * contacts[k].n;
        if (contacts[k].friction == 0 && length(along) > kRoundOff * length(g) && length(along) < 1e-6 * length(g))
          return "`" + scene.bodies[i].name + "` and `" + scene.bodies[j].name +
                 "` have a slope too small to tell whether they slide, and hardly any friction";
      }
      V middle{};
      for (std::size_t k = before; k < contacts.size(); ++k)
        middle = middle + (1.0 / double(contacts.size() - before)) * contacts[k].x;
      for (std::size_t k = before; k < contacts.size(); ++k)
        contacts[k].x = contacts[k].x + kMargin * (middle - contacts[k].x);
    }
  return "";
}

struct Velocity {
  V v{}, w_B{};
};

// Contact impulses that cancel gravity's impulse of one second. Conjugate gradients give those of least sum of squares
// that stop all bodies without regard to the cones; for stacks and walls they often lie in the cones. From their
// projection onto the cones, projected Gauss-Seidel sweeps continue until no body moves.
class ContactSolver {
 public:
  ContactSolver(const std::vector<Solid>& solids, const std::vector<ContactPoint>& contacts, const V& g)
      : solids_(solids), contacts_(contacts), velocities_(solids.size()), impulses_(contacts.size()) {
    for (std::size_t i = 0; i < solids.size(); ++i)
      if (solids[i].free) velocities_[i].v = g;
    for (const ContactPoint& find_contacts : contacts) {
      const V t =
          std::fabs(find_contacts.n[0]) < 0.6 ? cross(find_contacts.n, V{1, 0, 0}) : cross(find_contacts.n, V{0, 1, 0});
      const V t0 = (1 / length(t)) * t, t1 = cross(find_contacts.n, t0);
      tangents_.push_back({t0, t1});
      inverse_mass_.push_back(
          {mobility(find_contacts, find_contacts.n), mobility(find_contacts, t0) + mobility(find_contacts, t1)});
    }
  }
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
      const ContactPoint& find_contacts = contacts_[k];
      V& impulse = impulses_[k];  // along n, t0, t1
      const double n = std::max(
          0.0, impulse[0] - dot(relative_velocity(find_contacts, velocities_), find_contacts.n) / inverse_mass_[k][0]);
      apply_impulse(find_contacts, (n - impulse[0]) * find_contacts.n, velocities_);
      const V u = relative_velocity(find_contacts, velocities_);
      const V next =
          project_to_cone(find_contacts.friction, {n, impulse[1] - dot(u, tangents_[k][0]) / inverse_mass_[k][1],
                                                   impulse[2] - dot(u, tangents_[k][1]) / inverse_mass_[k][1]});
      apply_impulse(find_contacts, (next[1] - impulse[1]) * tangents_[k][0] + (next[2] - impulse[2]) * tangents_[k][1],
                    velocities_);
      impulse = next;
    }
  }
  // The body with the largest speed of a point, and this speed.
  std::pair<std::size_t, double> fastest() const {
    std::pair<std::size_t, double> worst{0, 0};
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const Solid& s = solids_[i];
      // A sphere has one contact point: a moment that is not balanced to round-off makes it roll.
      const double speed = (length(velocities_[i].v) + length(velocities_[i].w_B) * bounding_radius(s)) *
                           (s.radius > 0 ? kBalanced / kRoundOff : 1);
      if (speed > worst.second) worst = {i, speed};
    }
    return worst;
  }

 private:
  V to_body(const Solid& s, const V& v) const { return {dot(s.axis[0], v), dot(s.axis[1], v), dot(s.axis[2], v)}; }
  V to_world(const Solid& s, const V& v) const { return v[0] * s.axis[0] + v[1] * s.axis[1] + v[2] * s.axis[2]; }
  V spin_change(const Solid& s, const V& arm, const V& impulse) const {
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
  V relative_velocity(const ContactPoint& find_contacts,
                      const std::vector<Velocity>& velocities) const {  // of b relative to a
    V u{};
    for (const auto& [at, side] : {std::pair{find_contacts.a, -1.0}, {find_contacts.b, 1.0}})
      if (solids_[at].free)
        u = u + side * (velocities[at].v +
                        cross(to_world(solids_[at], velocities[at].w_B), find_contacts.x - solids_[at].center));
    return u;
  }
  double mobility(const ContactPoint& find_contacts, const V& d) const {
    double sum = 0;
    for (const int at : {find_contacts.a, find_contacts.b}) {
      if (!solids_[at].free) continue;
      const V arm = find_contacts.x - solids_[at].center;
      sum += solids_[at].inverse_mass + dot(d, cross(to_world(solids_[at], spin_change(solids_[at], arm, d)), arm));
    }
    return sum;
  }
  void apply_impulse(const ContactPoint& find_contacts, const V& impulse, std::vector<Velocity>& velocities) const {
    for (const auto& [at, side] : {std::pair{find_contacts.a, -1.0}, {find_contacts.b, 1.0}}) {
      if (!solids_[at].free) continue;
      velocities[at].v = velocities[at].v + (side * solids_[at].inverse_mass) * impulse;
      velocities[at].w_B =
          velocities[at].w_B + side * spin_change(solids_[at], find_contacts.x - solids_[at].center, impulse);
    }
  }

  const std::vector<Solid>& solids_;
  const std::vector<ContactPoint>& contacts_;
  std::vector<Velocity> velocities_;
  std::vector<V> impulses_;
  std::vector<std::array<V, 2>> tangents_;
  std::vector<std::array<double, 2>> inverse_mass_;  // along the normal; bound along the tangents
};

}  // namespace

Equilibrium find_equilibrium(const Scene& scene) {
  Equilibrium made;
  made.smallest_extent_m = HUGE_VAL;
  std::vector<Solid> solids(scene.bodies.size());
  for (std::size_t i = 0; i < solids.size() && made.refusal.empty(); ++i) {
    made.refusal = make_solid(scene, scene.bodies[i], solids[i]);
    for (const double half : solids[i].half)
      if (half > 0) made.smallest_extent_m = std::min(made.smallest_extent_m, half);
    if (solids[i].radius > 0) made.smallest_extent_m = std::min(made.smallest_extent_m, solids[i].radius);
  }
  std::vector<ContactPoint> contacts;
  if (made.refusal.empty()) made.refusal = find_all_contacts(scene, solids, contacts, made);
  if (!made.refusal.empty()) return made;
  const V g = vec<double>(scene.gravity_m_per_s2);
  ContactSolver solver(solids, contacts, g);
  solver.start();
  for (int k = 0; k < kMaxSweeps; ++k) {
    if (k % 16 == 0 && solver.fastest().second <= kBalanced * length(g)) return made;
    solver.sweep();
  }
  made.refusal = "no contact forces within the friction cones were found that hold `" +
                 scene.bodies[solver.fastest().first].name + "`";
  return made;
}

}  // namespace atwood::closed_form
