#include "contact/penalty_force.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include "math/elementary.hpp"

#include "math/bracketed_root.hpp"
#include "scene/joined.hpp"

namespace atwood {

namespace {

const double infinity = std::numeric_limits<double>::infinity();

// The radius of curvature in a Hertzian contact: infinite for planes, 0 for shapes with vertices.
double round_radius(const Shape& shape) {
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return sphere->radius_m;
  return std::holds_alternative<Plane>(shape) || std::holds_alternative<Rectangle>(shape) ? infinity : 0;
}

// Rocking on four corners a box of mass m swings with up to 12 k / m: 4 k b^2 about an axis with I = m (b^2 + c^2) / 3.
double rocking_factor(ShapeKind a, ShapeKind b) {
  const auto one_point = [](ShapeKind kind) { return kind == ShapeKind::sphere; };
  return one_point(a) || one_point(b) ? 1 : 12;
}

template <class S> Aabb<double> grown(const Aabb<S>& box) {
  const auto low = [](S x) { return static_cast<double>(x) - 1e-6 * std::fabs(static_cast<double>(x)); };
  const auto high = [](S x) { return static_cast<double>(x) + 1e-6 * std::fabs(static_cast<double>(x)); };
  return {{low(box.low.x), low(box.low.y), low(box.low.z)}, {high(box.high.x), high(box.high.y), high(box.high.z)}};
}

template <class S> std::array<Wide, 3> wide3(const Vec3<S>& v) { return {Wide(v.x), Wide(v.y), Wide(v.z)}; }
template <class S> std::array<double, 3> double3(const Vec3<S>& v) {
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.z)};
}

}  // namespace

double damping_ratio_of(double restitution) {
  const auto restitution_of = [](double z) {
    if (std::fabs(z - 1) < 1e-6) return real::exp(-2 * z);  // acos(z) / sqrt(1 - z^2) -> 1
    return z < 1 ? real::exp(-2 * z * real::atan2(std::sqrt((1 - z) * (1 + z)), z) / std::sqrt(1 - z * z))
                 : real::exp(-2 * z * real::log(z + std::sqrt((z - 1) * (z + 1))) / std::sqrt(z * z - 1));
  };
  double low = 0, high = 1;  // halved until no double lies between
  while (restitution_of(high) > restitution) high *= 2;
  const auto root = bisect([&](double z) { return restitution_of(z) > restitution; }, low, high, 0.0, 1200);
  return restitution >= 1 ? 0 : (root.low + root.high) / 2;
}

double scene_speed(const Scene& scene) {
  const auto& g = scene.gravity_m_per_s2;
  const double gravity = std::sqrt(g[0] * g[0] + g[1] * g[1] + g[2] * g[2]);
  double fastest = 0, low = infinity, high = -infinity;
  for (const Body& body : scene.bodies) {
    const auto& v = body.velocity_m_per_s;
    fastest = std::max(fastest, std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]));
    if (body.fixed && std::holds_alternative<Plane>(body.shape)) continue;
    double height = 0;
    for (int k = 0; k < 3 && gravity > 0; ++k) height -= g[k] / gravity * body.position_m[k];
    low = std::min(low, height);
    high = std::max(high, height);
  }
  for (const Body& body : scene.bodies)
    if (const auto* plane = std::get_if<Plane>(&body.shape); plane != nullptr && gravity > 0) {
      double up = 0;
      for (int k = 0; k < 3; ++k) up -= g[k] / gravity * plane->normal[k];
      if (up > 0.1) low = std::min(low, plane->offset_m / up);
    }
  return 2 * fastest + std::sqrt(2 * gravity * std::max(high - low, 0.0));
}

template <class S>
PenaltyForce<S>::PenaltyForce(const Scene& scene, const PenaltyOptions& options)
    : scene_(scene), options_(options), broad_(make_broad_phase<double>(BroadPhaseKind::sweep_and_prune)) {
  speed_ = S(options.impact_speed_m_per_s > 0 ? options.impact_speed_m_per_s : scene_speed(scene));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    shapes_.push_back(make_geometry<S>(body.shape));
    inverse_mass_.push_back(body.fixed ? S(0) : S(1) / S(body.mass_kg));
    if (body.shape.index() == 0) continue;
    (shapes_.back().kind == ShapeKind::plane ? planes_ : bounded_).push_back(static_cast<int>(i));
  }
  for (const PairLaw& law : scene.pairs) {
    const bool compliant = law.contact_law != ContactLaw::rigid;
    const double asked = options.damping_ratio;
    const double ratio = compliant                           ? 0
                         : asked > 0                         ? asked
                         : law.restitution < kMinRestitution ? -1
                                                             : damping_ratio_of(law.restitution);
    damping_ratio_.push_back(S(ratio));
  }
  const auto check_pair = [&](int a, int b) {
    const Body &first = scene.bodies[a], &second = scene.bodies[b];
    if (!refusal_.empty() || (first.fixed && second.fixed)) return;
    const PairLaw& law = pair_law(scene, a, b);
    const std::string both = "`" + first.name + "` and `" + second.name + "`";
    if (const char* missing = missing_contact_test(shapes_[a].kind, shapes_[b].kind))
      refusal_ = both + ": no contact test for " + missing;
    else if (law.contact_law == ContactLaw::hertz && !(round_radius(first.shape) > 0 && round_radius(second.shape) > 0))
      refusal_ = "Hertz's law needs spheres, planes or rectangles: " + both;
    else if (law.rolling_friction_m != 0) refusal_ = "+penalty has no rolling friction: " + both;
    else if (damping_ratio_[static_cast<std::size_t>(&law - scene.pairs.data())] < S(0))
      refusal_ = "a linear contact without adhesion cannot have a restitution of " + format_double(law.restitution) +
                 " (" + both + "): set damping_ratio=1, critical damping";
  };
  // Pairs of a large scene have few materials and shapes: one body of each kind is checked for all.
  std::vector<int> kinds;
  for (const auto* list : {&bounded_, &planes_})
    for (const int body : *list) {
      const auto same = [&](int other) {
        const Body &a = scene.bodies[body], &b = scene.bodies[other];
        return a.material == b.material && a.fixed == b.fixed && shapes_[body].kind == shapes_[other].kind;
      };
      for (const int other : kinds) check_pair(other, body);
      if (std::count_if(kinds.begin(), kinds.end(), same) < 2) kinds.push_back(body);
    }
}

template <class S> ContactSpring<S> PenaltyForce<S>::spring_of(int a, int b) const {
  const PairLaw& law = pair_law(scene_, a, b);
  ContactSpring<S> spring;
  spring.law = law.contact_law == ContactLaw::rigid ? ContactLaw::linear : law.contact_law;
  spring.friction = S(law.friction);
  spring.tangential_ratio = S(options_.tangential_ratio);
  if (law.contact_law == ContactLaw::linear) {
    spring.stiffness = S(law.stiffness_N_per_m);
    spring.damping = S(law.damping_N_s_per_m);
    spring.pull = law.pull;
  } else if (law.contact_law == ContactLaw::hertz) {
    const S curvature = S(1) / S(round_radius(scene_.bodies[a].shape)) + S(1) / S(round_radius(scene_.bodies[b].shape));
    spring.stiffness = S(4) / S(3) * S(law.modulus_Pa) / real::sqrt(curvature);
    spring.damping = S(law.damping_s_per_m);
  } else {  // m v^2 = k d^2 at the depth d
    const S mass = S(1) / (inverse_mass_[a] + inverse_mass_[b]);
    const S depth = S(options_.overlap) * real::min(shapes_[a].bounding_radius, shapes_[b].bounding_radius);
    spring.stiffness = mass * speed_ * speed_ / (depth * depth);
    spring.damping = S(2) * damping_ratio_[static_cast<std::size_t>(&law - scene_.pairs.data())] *
                     real::sqrt(spring.stiffness * mass);
  }
  return spring;
}

// Hertz: an impact at speed v sinks in by d with 2/5 K d^(5/2) = 1/2 m v^2, where the slope of the force is 3/2 K
// sqrt(d).
template <class S> typename PenaltyForce<S>::Stiffest PenaltyForce<S>::stiffest() const {
  Stiffest found;
  std::vector<int> kinds;
  for (const auto* list : {&bounded_, &planes_})
    for (const int body : *list) {
      const auto same = [&](int other) {
        return scene_.bodies[body].material == scene_.bodies[other].material &&
               inverse_mass_[body] == inverse_mass_[other] && shapes_[body].kind == shapes_[other].kind &&
               shapes_[body].bounding_radius == shapes_[other].bounding_radius;
      };
      for (const int other : kinds) {
        const double inverse_mass = static_cast<double>(inverse_mass_[body] + inverse_mass_[other]);
        if (!(inverse_mass > 0)) continue;
        const ContactSpring<S> spring = spring_of(std::min(body, other), std::max(body, other));
        double k = static_cast<double>(spring.stiffness), c = static_cast<double>(spring.damping);
        if (spring.law == ContactLaw::hertz) {
          const double v = static_cast<double>(speed_), depth = real::power(1.25 * v * v / (inverse_mass * k), 0.4);
          c = k * real::power(depth, 1.5) * c;
          k = 1.5 * k * std::sqrt(depth);
        }
        const double more = rocking_factor(shapes_[body].kind, shapes_[other].kind),
                     w = std::sqrt(more * k * inverse_mass);
        if (w > found.angular_frequency_rad_per_s) found = {w, w > 0 ? more * c * inverse_mass / (2 * w) : 0};
      }
      if (std::count_if(kinds.begin(), kinds.end(), same) < 2) kinds.push_back(body);
    }
  return found;
}

template <class S> Vec3<S> PenaltyForce<S>::velocity_at(const Motion<S>& motion, int body, const Vec3<S>& x_W) const {
  if (!moving(motion, body)) return {};
  const Vec3<S> w_W = rotate(motion.q_WB(body), motion.w_WB_B(body));
  return motion.v_WB(body) + cross(w_W, x_W - motion.p_WB(body));
}

template <class S> void PenaltyForce<S>::add_contact_points(const Motion<S>& motion, int a, int b) const {
  if (!moving(motion, a) && !moving(motion, b)) return;
  if (!scene_.joints.empty() && joined(scene_, a, b)) return;
  manifolds_.clear();
  find_contacts(shapes_[a], places_[a], shapes_[b], places_[b], S(0), manifolds_);
  if (manifolds_.empty()) return;
  for (const Manifold<S>& manifold : manifolds_) add_convex_solves(manifold.solve, solvers_);
  const ContactSpring<S> spring = spring_of(a, b);
  for (const Manifold<S>& manifold : manifolds_)
    for (int i = 0; i < manifold.count; ++i) {
      const ContactPoint<S>& at = manifold.points[i];
      if (!(at.gap < S(0))) continue;
      Point point{{a, b, manifold.part_a, manifold.part_b, at.id},
                  at.x_W,
                  manifold.normal_W,
                  {},
                  -at.gap,
                  {},
                  {},
                  {},
                  {},
                  false};
      const Vec3<S> v = velocity_at(motion, b, at.x_W) - velocity_at(motion, a, at.x_W);
      point.closing = -dot(v, manifold.normal_W);
      point.u_W = v + point.closing * manifold.normal_W;
      const S d = point.overlap;
      if (spring.law == ContactLaw::hertz)
        point.force_N = spring.stiffness * d * real::sqrt(d) * (S(1) + spring.damping * point.closing);
      else point.force_N = spring.stiffness * d + spring.damping * point.closing;
      if (!spring.pull) point.force_N = real::max(point.force_N, S(0));
      if (spring.friction > S(0)) apply_friction(point, spring);
      points_.push_back(point);
    }
}

template <class S> void PenaltyForce<S>::apply_friction(Point& point, const ContactSpring<S>& spring) const {
  const auto known = std::lower_bound(memory_.begin(), memory_.end(), point.key,
                                      [](const Memory& m, const Key& key) { return m.key < key; });
  const auto& n = point.normal_W;
  if (known != memory_.end() && known->key == point.key) {
    const int a = point.key.a, b = point.key.b;
    const Vec3<S> on_a = places_[a].p_W + to_world(places_[a], known->on_a_B),
                  on_b = places_[b].p_W + to_world(places_[b], known->on_b_B);
    point.stretch_W = known->stretch_W + (on_b - on_a);
    point.stretch_W -= dot(point.stretch_W, n) * n;
  }
  const S k = spring.tangential_ratio * point.force_N / point.overlap;  // secant stiffness: it grows with the load
  const S c = spring.law == ContactLaw::linear ? spring.tangential_ratio * spring.damping : S(0);
  point.friction_W = -(k * point.stretch_W) - c * point.u_W;
  const S size = norm(point.friction_W), most = spring.friction * real::max(point.force_N, S(0));
  point.slides = size > most;
  if (!point.slides) return;
  point.friction_W = (most / size) * point.friction_W;
  point.stretch_W = k > S(0) ? -(S(1) / k) * point.friction_W : Vec3<S>{};
}

template <class S> void PenaltyForce<S>::find_points(const Motion<S>& motion) const {
  places_.resize(shapes_.size());
  points_.clear();
  items_.clear();
  for (const int body : bounded_) {
    places_[body] = transform(motion.p_WB(body), motion.q_WB(body));
    const Vec3<S>& p = places_[body].p_W;
    items_.push_back({grown(bounds(shapes_[body], places_[body])),
                      {static_cast<double>(p.x), static_cast<double>(p.y), static_cast<double>(p.z)},
                      1.000001 * static_cast<double>(shapes_[body].bounding_radius),
                      moving(motion, body)});
  }
  broad_->find(items_, near_);
  for (const auto& [i, j] : near_) add_contact_points(motion, bounded_[i], bounded_[j]);
  for (const int plane : planes_)
    for (const int body : bounded_) add_contact_points(motion, std::min(body, plane), std::max(body, plane));
}

template <class S> void PenaltyForce<S>::add_loads(const Motion<S>& motion, Load<S>* loads) const {
  find_points(motion);
  for (const Point& point : points_) {
    const Vec3<S> on_b = point.force_N * point.normal_W + point.friction_W;
    for (const int body : {point.key.a, point.key.b}) {
      if (!moving(motion, body)) continue;
      const Vec3<S> force = body == point.key.b ? on_b : -on_b;
      loads[body].force_W += force;
      if (motion.slots[body].rotates)
        loads[body].torque_B += to_body(places_[body], cross(point.x_W - places_[body].p_W, force));
    }
  }
}

template <class S> void PenaltyForce<S>::reset(const Motion<S>& motion) {
  memory_.clear();
  impacts_.clear();
  events_.clear();
  solvers_ = {};
  accept_step(motion);
}

template <class S> bool PenaltyForce<S>::accept_step(const Motion<S>& motion) {
  find_points(motion);
  std::sort(points_.begin(), points_.end(), [](const Point& p, const Point& q) { return p.key < q.key; });
  bool slides = false;
  next_memory_.clear();
  for (const Point& point : points_) {
    const auto held = [&](int body) { return to_body(places_[body], point.x_W - places_[body].p_W); };
    next_memory_.push_back({point.key, point.stretch_W, held(point.key.a), held(point.key.b)});
    slides = slides || point.slides;
  }
  memory_.swap(next_memory_);
  update_impacts(motion);
  return slides;
}

// Integrates each point's impulses since its first touch by the trapezoidal rule. A point that has separated becomes an
// impact event at the time of its first touch.
template <class S> void PenaltyForce<S>::update_impacts(const Motion<S>& motion) {
  next_impacts_.clear();
  auto old = impacts_.begin();
  for (const Point& point : points_) {
    for (; old != impacts_.end() && old->key < point.key; ++old) report_impact(motion, *old);
    const S n = point.force_N, t = norm(point.friction_W);
    ImpactRecord record{point.key, motion.t_s, -point.closing, {}, {}, motion.t_s, n, t, point.x_W, point.normal_W};
    if (old != impacts_.end() && old->key == point.key) {
      const S half = (motion.t_s - old->last_s) / S(2);
      record = *old++;
      record.impulse_n += half * (n + record.last_n);
      record.impulse_t += half * (t + record.last_t);
      record.last_s = motion.t_s;
      record.last_n = n;
      record.last_t = t;
    } else if (point.closing > S(0)) {
      record.begin_s = real::max(S(0), motion.t_s - point.overlap / point.closing);
    }
    next_impacts_.push_back(record);
  }
  for (; old != impacts_.end(); ++old) report_impact(motion, *old);
  impacts_.swap(next_impacts_);
}

template <class S> void PenaltyForce<S>::report_impact(const Motion<S>& motion, const ImpactRecord& record) {
  const Key& key = record.key;
  Event event;
  event.t_s = Wide(record.begin_s);
  event.body_a = key.a;
  event.body_b = key.b;
  event.x_m = wide3(record.x_W);
  event.normal = wide3(record.normal_W);
  event.impulse_n_N_s = Wide(record.impulse_n);
  event.impulse_t_N_s = Wide(record.impulse_t);
  event.vn_before_m_per_s = Wide(record.vn_before);
  event.vn_after_m_per_s =
      Wide(dot(velocity_at(motion, key.b, record.x_W) - velocity_at(motion, key.a, record.x_W), record.normal_W));
  events_.push_back(event);
}

template <class S> void PenaltyForce<S>::report(const Motion<S>& motion, Sample& sample, const Observer& observer) {
  find_points(motion);
  sample.contacts.clear();
  for (const Point& point : points_) {
    sample.contacts.push_back({point.key.a, point.key.b, double3(point.x_W), double3(point.normal_W),
                               -static_cast<double>(point.overlap), static_cast<double>(point.force_N),
                               double3(point.friction_W)});
  }
  if (observer.event)
    for (const Event& event : events_) observer.event(event);
  events_.clear();
}

template class PenaltyForce<float>;
template class PenaltyForce<double>;
template class PenaltyForce<long double>;

}  // namespace atwood
