#include "closed_form/equilibrium.hpp"

#include <algorithm>
#include <vector>

#include "closed_form/solution.hpp"

namespace atwood::closed_form {

namespace {

using V = Vec<double>;
constexpr double kTouching = 1e-11;  // of the larger of the bodies' places and sizes
constexpr double kNearness = 1e-7;   // of the thinner body: no place is so far off that a gap of its size is none
constexpr double kMargin = 1e-5;     // forces are looked for inside the cones and within the surfaces by this part
constexpr int kMostSweeps = 20000;
constexpr double kBalanced = 1e-7;  // of gravity
constexpr double kRoundOff = 1e-14;

// A box, a rectangle (a box of thickness 0), a ball (a box of no extent with a radius), a plane.
struct Solid {
  V center{}, axis[3]{};
  double half[3]{}, radius = 0, offset = 0;
  bool plane = false, free = false;
  double inverse_mass = 0;
  Real33 inertia_inverse{};  // diagonal, body axes
};

double length(const V& v) { return std::sqrt(dot(v, v)); }

// n from a to b
struct Touch {
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
    return name + " is none of a box, a ball, a plane and a rectangle";
  }
  made.free = !body.fixed;
  if (body.fixed) return "";
  if (body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{})
    return name + " moves at the start";
  if (body.release_s > 0) return name + " is released late";
  const Real33& I = body.inertia_kg_m2;
  if (!rotates(body) || I[1] != 0 || I[2] != 0 || I[5] != 0) return "the inertia of " + name + " is not diagonal";
  for (std::size_t i = 0; i < scene.forces.size(); ++i)
    if (acts_on(scene.forces[i], static_cast<int>(&body - scene.bodies.data()))) return "a force acts on " + name;
  made.inverse_mass = 1 / body.mass_kg;
  for (int k = 0; k < 3; ++k) made.inertia_inverse[4 * k] = 1 / I[4 * k];
  return "";
}

double reach(const Solid& solid, const V& n) {  // of the solid along n, from its centre
  double sum = solid.radius;
  for (int k = 0; k < 3; ++k) sum += solid.half[k] * std::fabs(dot(solid.axis[k], n));
  return sum;
}

// Of its farthest point from its centre, at most.
double extent(const Solid& solid) { return length(V{solid.half[0], solid.half[1], solid.half[2]}) + solid.radius; }

double thinnest(const Solid& solid) {  // of what it has of extents
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

// Where edges of `from` enter and leave `in`, blown up by `tolerance`: corners of the polygon that two boxes share.
void shared_points(const Solid& from, const Solid& in, double tolerance, std::vector<V>& points) {
  for (int index = 0; index < 8; ++index)
    for (int k = 0; k < 3; ++k) {
      if ((index >> k & 1) != 0) continue;
      const V start = corner(from, index), way = corner(from, index | 1 << k) - start;
      double enter = 0, leave = 1;
      for (int i = 0; i < 3; ++i) {
        const double p = dot(in.axis[i], start - in.center), u = dot(in.axis[i], way), wide = in.half[i] + tolerance;
        if (std::fabs(u) < 1e-14) {
          if (std::fabs(p) > wide) leave = -1;
          continue;
        }
        enter = std::max(enter, ((u > 0 ? -wide : wide) - p) / u);
        leave = std::min(leave, ((u > 0 ? wide : -wide) - p) / u);
      }
      if (enter > leave) continue;
      for (const V& x : {start + enter * way, start + leave * way})
        if (std::none_of(points.begin(), points.end(),
                         [&](const V& known) { return length(x - known) < 8 * tolerance; }))
          points.push_back(x);
    }
}

// Every one of the 15 axes that parts the two within the tolerance is a normal of the contact.
double box_box(const Solid& a, const Solid& b, double tolerance, std::vector<V>& normals) {
  std::vector<V> axes(a.axis, a.axis + 3);
  axes.insert(axes.end(), b.axis, b.axis + 3);
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j)
      if (const V c = cross(a.axis[i], b.axis[j]); length(c) > 1e-6) axes.push_back((1 / length(c)) * c);
  double widest = -HUGE_VAL;
  for (const V& axis : axes) {
    const double along = dot(axis, b.center - a.center), gap = std::fabs(along) - reach(a, axis) - reach(b, axis);
    widest = std::max(widest, gap);
    const V n = (along < 0 ? -1.0 : 1.0) * axis;
    const bool known = std::any_of(normals.begin(), normals.end(), [&](const V& m) { return length(n - m) < 1e-9; });
    if (std::fabs(gap) <= tolerance && !known) normals.push_back(n);
  }
  return widest;
}

// Appends the contacts of a pair; the gap that counts is returned.
double touch(const Solid& a, const Solid& b, double tolerance, std::vector<Touch>& touches) {
  std::vector<V> points, normals;
  double gap = 0;
  if (b.plane) {
    gap = dot(b.axis[2], a.center) - b.offset - reach(a, b.axis[2]);
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
    shared_points(a, b, 4 * tolerance, points);
    shared_points(b, a, 4 * tolerance, points);
  }
  for (const V& n : normals)
    for (const V& x : points) touches.push_back({0, 0, x, n, 0});
  return gap;
}

std::string find_touches(const Scene& scene, const std::vector<Solid>& solids, std::vector<Touch>& touches,
                         Equilibrium& made) {
  for (std::size_t i = 0; i < solids.size(); ++i)
    for (std::size_t j = 0; j < solids.size(); ++j) {
      // The first is free, or a ball against what is none: each pair once.
      const Solid &a = solids[i], &b = solids[j];
      if (i == j || !(a.free || b.free) || a.plane || scene.bodies[i].shape.index() == 0 ||
          scene.bodies[j].shape.index() == 0)
        continue;
      if (!b.plane && (a.radius > 0) == (b.radius > 0) && j < i) continue;
      if (!b.plane && a.radius == 0 && b.radius > 0) continue;
      const double size = length(a.center) + (b.plane ? 0 : length(b.center)) + extent(a);
      const std::size_t before = touches.size();
      const double tolerance =
          std::min(kTouching * size, kNearness * std::min(thinnest(a), b.plane ? HUGE_VAL : thinnest(b)));
      const double gap = touch(a, b, tolerance, touches);
      if (gap < -tolerance) return "`" + scene.bodies[i].name + "` and `" + scene.bodies[j].name + "` overlap";
      if (touches.size() > before) made.open_m = std::max(made.open_m, std::fabs(gap));
      for (std::size_t k = before; k < touches.size(); ++k) {
        touches[k].a = static_cast<int>(i);
        touches[k].b = static_cast<int>(j);
        touches[k].friction = (1 - kMargin) * pair_law(scene, touches[k].a, touches[k].b).friction;
      }
      V middle{};
      for (std::size_t k = before; k < touches.size(); ++k)
        middle = middle + (1.0 / double(touches.size() - before)) * touches[k].x;
      for (std::size_t k = before; k < touches.size(); ++k)
        touches[k].x = touches[k].x + kMargin * (middle - touches[k].x);
    }
  return "";
}

struct Moving {
  V v{}, w_B{};
};

// A second of gravity's impulse, undone by the contacts' impulses. First by those of least sum of squares that stop all
// bodies, cones or not (conjugate gradients): of stacks and walls they often lie in the cones as they are. Then, from
// what the cones leave of them, by sweeps until no body moves.
class Sweeps {
 public:
  Sweeps(const std::vector<Solid>& solids, const std::vector<Touch>& touches, const V& g)
      : solids_(solids), touches_(touches), moving_(solids.size()), given_(touches.size()) {
    for (std::size_t i = 0; i < solids.size(); ++i)
      if (solids[i].free) moving_[i].v = g;
    for (const Touch& touch : touches) {
      const V t = std::fabs(touch.n[0]) < 0.6 ? cross(touch.n, V{1, 0, 0}) : cross(touch.n, V{0, 1, 0});
      const V t0 = (1 / length(t)) * t, t1 = cross(touch.n, t0);
      along_.push_back({t0, t1});
      yields_.push_back({mobility(touch, touch.n), mobility(touch, t0) + mobility(touch, t1)});
    }
  }
  void start() {
    const std::size_t count = touches_.size();
    std::vector<V> x(count), residual(count), way(count), answer(count);
    for (std::size_t k = 0; k < count; ++k) residual[k] = way[k] = -1.0 * components(k, closing(touches_[k], moving_));
    double square = sum(residual, residual);
    const double enough = 1e-24 * square;
    for (std::size_t tries = 0; tries < 6 * count && square > enough; ++tries) {
      std::vector<Moving> response(solids_.size());
      for (std::size_t k = 0; k < count; ++k) push(touches_[k], impulse_of(k, way[k]), response);
      for (std::size_t k = 0; k < count; ++k) answer[k] = components(k, closing(touches_[k], response));
      const double step = square / sum(way, answer);
      for (std::size_t k = 0; k < count; ++k) {
        x[k] = x[k] + step * way[k];
        residual[k] = residual[k] - step * answer[k];
      }
      const double left = sum(residual, residual);
      for (std::size_t k = 0; k < count; ++k) way[k] = residual[k] + (left / square) * way[k];
      square = left;
    }
    for (std::size_t k = 0; k < count; ++k) {
      given_[k] = into_cone(touches_[k].friction, {std::max(0.0, x[k][0]), x[k][1], x[k][2]});
      push(touches_[k], impulse_of(k, given_[k]), moving_);
    }
  }
  // There and back again: loads go down a stack in one of them, reactions up in the other.
  void sweep() {
    const std::size_t count = touches_.size();
    for (std::size_t step = 0; step < 2 * count; ++step) {
      const std::size_t k = step < count ? step : 2 * count - 1 - step;
      const Touch& touch = touches_[k];
      V& impulse = given_[k];  // along n, t0, t1
      const double n = std::max(0.0, impulse[0] - dot(closing(touch, moving_), touch.n) / yields_[k][0]);
      push(touch, (n - impulse[0]) * touch.n, moving_);
      const V u = closing(touch, moving_);
      const V next = into_cone(touch.friction, {n, impulse[1] - dot(u, along_[k][0]) / yields_[k][1],
                                                impulse[2] - dot(u, along_[k][1]) / yields_[k][1]});
      push(touch, (next[1] - impulse[1]) * along_[k][0] + (next[2] - impulse[2]) * along_[k][1], moving_);
      impulse = next;
    }
  }
  // The body that moves fastest, its spin counted at its farthest point.
  std::pair<std::size_t, double> fastest() const {
    std::pair<std::size_t, double> worst{0, 0};
    for (std::size_t i = 0; i < solids_.size(); ++i) {
      const Solid& s = solids_[i];
      // A ball has but one foot: what does not balance it to round-off rolls it away.
      const double speed =
          (length(moving_[i].v) + length(moving_[i].w_B) * extent(s)) * (s.radius > 0 ? kBalanced / kRoundOff : 1);
      if (speed > worst.second) worst = {i, speed};
    }
    return worst;
  }

 private:
  V to_body(const Solid& s, const V& v) const { return {dot(s.axis[0], v), dot(s.axis[1], v), dot(s.axis[2], v)}; }
  V to_world(const Solid& s, const V& v) const { return v[0] * s.axis[0] + v[1] * s.axis[1] + v[2] * s.axis[2]; }
  V turned(const Solid& s, const V& arm, const V& impulse) const {
    const V moment = to_body(s, cross(arm, impulse));
    return {moment[0] * s.inertia_inverse[0], moment[1] * s.inertia_inverse[4], moment[2] * s.inertia_inverse[8]};
  }
  static double sum(const std::vector<V>& a, const std::vector<V>& b) {
    double all = 0;
    for (std::size_t k = 0; k < a.size(); ++k) all += dot(a[k], b[k]);
    return all;
  }
  static V into_cone(double friction, V impulse) {
    const double size = std::hypot(impulse[1], impulse[2]), most = friction * impulse[0];
    if (size > most) impulse[1] *= most / size, impulse[2] *= most / size;
    return impulse;
  }
  V components(std::size_t k, const V& u) const {
    return {dot(u, touches_[k].n), dot(u, along_[k][0]), dot(u, along_[k][1])};
  }
  V impulse_of(std::size_t k, const V& parts) const {
    return parts[0] * touches_[k].n + parts[1] * along_[k][0] + parts[2] * along_[k][1];
  }
  V closing(const Touch& touch, const std::vector<Moving>& moving) const {  // velocity of b against a
    V u{};
    for (const auto& [at, side] : {std::pair{touch.a, -1.0}, {touch.b, 1.0}})
      if (solids_[at].free)
        u = u + side * (moving[at].v + cross(to_world(solids_[at], moving[at].w_B), touch.x - solids_[at].center));
    return u;
  }
  double mobility(const Touch& touch, const V& d) const {
    double sum = 0;
    for (const int at : {touch.a, touch.b}) {
      if (!solids_[at].free) continue;
      const V arm = touch.x - solids_[at].center;
      sum += solids_[at].inverse_mass + dot(d, cross(to_world(solids_[at], turned(solids_[at], arm, d)), arm));
    }
    return sum;
  }
  void push(const Touch& touch, const V& impulse, std::vector<Moving>& moving) const {
    for (const auto& [at, side] : {std::pair{touch.a, -1.0}, {touch.b, 1.0}}) {
      if (!solids_[at].free) continue;
      moving[at].v = moving[at].v + (side * solids_[at].inverse_mass) * impulse;
      moving[at].w_B = moving[at].w_B + side * turned(solids_[at], touch.x - solids_[at].center, impulse);
    }
  }

  const std::vector<Solid>& solids_;
  const std::vector<Touch>& touches_;
  std::vector<Moving> moving_;
  std::vector<V> given_;
  std::vector<std::array<V, 2>> along_;
  std::vector<std::array<double, 2>> yields_;  // along the normal, along the surface (a bound)
};

}  // namespace

Equilibrium find_equilibrium(const Scene& scene) {
  Equilibrium made;
  made.least_m = HUGE_VAL;
  std::vector<Solid> solids(scene.bodies.size());
  for (std::size_t i = 0; i < solids.size() && made.misfit.empty(); ++i) {
    made.misfit = make_solid(scene, scene.bodies[i], solids[i]);
    for (const double half : solids[i].half)
      if (half > 0) made.least_m = std::min(made.least_m, half);
    if (solids[i].radius > 0) made.least_m = std::min(made.least_m, solids[i].radius);
  }
  std::vector<Touch> touches;
  if (made.misfit.empty()) made.misfit = find_touches(scene, solids, touches, made);
  if (!made.misfit.empty()) return made;
  const V g = vec<double>(scene.gravity_m_per_s2);
  Sweeps sweeps(solids, touches, g);
  sweeps.start();
  for (int k = 0; k < kMostSweeps; ++k) {
    if (k % 16 == 0 && sweeps.fastest().second <= kBalanced * length(g)) return made;
    sweeps.sweep();
  }
  made.misfit = "no contact forces were found that hold `" + scene.bodies[sweeps.fastest().first].name + "`";
  return made;
}

}  // namespace atwood::closed_form
