#include "closed_form/solution.hpp"

#include <algorithm>

namespace atwood::closed_form {

namespace {
const char* const force_names[] = {"gravity", "attractor", "drag",     "drag",        "spring",         "drive",
                                   "lorentz", "coulomb",   "thruster", "point-force", "rotating-frame", "potential"};
}

std::string force_name(const Force& force) { return force_names[force.index()]; }

bool acts_on(const Force& force, int body) {
  return std::visit(
      [&](const auto& f) {
        using F = std::decay_t<decltype(f)>;
        if constexpr (std::is_same_v<F, RotatingFrame>) return true;
        else if constexpr (std::is_same_v<F, Thruster> || std::is_same_v<F, PointForce>) return f.body == body;
        else return std::find(f.bodies.begin(), f.bodies.end(), body) != f.bodies.end();
      },
      force);
}

std::string force_on_body(const Scene& scene, const Force& force, int body) {
  return "the force `" + force_name(force) + "` on `" + scene.bodies[body].name + "`";
}

std::string possible_contact(const Scene& scene) {
  const Body* first = nullptr;
  for (const Body& body : scene.bodies) {
    if (body.shape.index() == 0) continue;
    if (first != nullptr && !(first->fixed && body.fixed))
      return "`" + first->name + "` and `" + body.name + "` have shapes and could touch";
    if (first == nullptr || !body.fixed) first = &body;
  }
  return "";
}

bool has_spherical_inertia(const Body& body) {
  const Real33& I = body.inertia_kg_m2;
  return body.fixed || (I[0] == I[4] && I[4] == I[8] && I[1] == 0 && I[2] == 0 && I[5] == 0);
}

// |a + s u - c - t v|^2 is convex in (s, t): its least value over the square lies inside it, or on one of four sides,
// where it is the distance of an end to the other segment.
double segment_distance(const Vec<double>& a, const Vec<double>& b, const Vec<double>& c, const Vec<double>& d) {
  const auto to_segment = [](const Vec<double>& p, const Vec<double>& from, const Vec<double>& to) {
    const Vec<double> u = to - from;
    const double length2 = dot(u, u);
    const double s = length2 > 0 ? std::clamp(dot(p - from, u) / length2, 0.0, 1.0) : 0.0;
    const Vec<double> left = p - from - s * u;
    return std::sqrt(dot(left, left));
  };
  const double at_ends =
      std::min(std::min(to_segment(a, c, d), to_segment(b, c, d)), std::min(to_segment(c, a, b), to_segment(d, a, b)));
  const Vec<double> u = b - a, v = d - c, w = c - a;
  const double uu = dot(u, u), uv = dot(u, v), vv = dot(v, v), bend = uu * vv - uv * uv;
  if (!(bend > 1e-14 * uu * vv)) return at_ends;
  const double s = (dot(u, w) * vv - dot(v, w) * uv) / bend, t = (dot(u, w) * uv - dot(v, w) * uu) / bend;
  if (!(s > 0 && s < 1 && t > 0 && t < 1)) return at_ends;
  const Vec<double> left = s * u - w - t * v;
  return std::min(at_ends, std::sqrt(dot(left, left)));
}

template <class S> Pose<S> initial_pose(const Body& body) {
  Pose<S> pose;
  pose.p_WB = vec<S>(body.position_m);
  pose.q_WB = quat<S>(body.orientation_wxyz);
  if (body.fixed) return pose;
  pose.v_WB = vec<S>(body.velocity_m_per_s);
  if (rotates(body)) pose.w_WB_B = vec<S>(body.angular_velocity_body_rad_per_s);
  return pose;
}

template <class S>
Motion<S> solve_each_body(const Scenario& scenario, const std::vector<S>& t_s,
                          const std::function<Translation<S>(const Scene&, int body)>& translation) {
  Motion<S> motion;
  const Scene& scene = scenario.scene;
  motion.refusal = possible_contact(scene);
  if (!motion.refusal.empty()) return motion;
  motion.poses.assign(t_s.size(), std::vector<Pose<S>>(scene.bodies.size()));
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    const Pose<S> start = initial_pose<S>(body);
    for (auto& poses : motion.poses) poses[i] = start;
    if (body.fixed) continue;
    const Translation<S> flies = translation(scene, static_cast<int>(i));
    S angular_drag = 0;
    for (const Force& force : scene.forces) {
      if (!acts_on(force, static_cast<int>(i))) continue;
      if (const auto* drag = std::get_if<LinearDrag>(&force)) angular_drag += S(drag->angular_coefficient_N_m_s);
      if (const auto* drag = std::get_if<QuadraticDrag>(&force)) angular_drag += S(drag->angular_coefficient_N_m_s);
    }
    const RotationSolution<S> turns = free_rotation<S>(body, angular_drag);
    motion.refusal = !flies.refusal.empty() ? flies.refusal : turns.refusal;
    if (!motion.refusal.empty()) return motion;
    const S end_s = S(body.release_s) + flies.end_s;
    if (end_s <= S(scenario.t_end_s) && (motion.undecided.empty() || end_s < motion.end_s)) {
      motion.undecided = flies.end_why;
      motion.end_s = end_s;
    }
    for (std::size_t k = 0; k < t_s.size(); ++k) {
      const S since = t_s[k] - S(body.release_s);
      if (!(since > 0) || since >= flies.end_s) continue;
      const CenterMotion<S> flight = flies.at(since);
      if (flight.failure != nullptr) {
        motion.refusal = std::string(flight.failure) + " for `" + body.name + "`";
        return motion;
      }
      const Rotation<S> spin = turns.at(since);
      motion.poses[k][i] = {flight.p, flight.v, spin.w, spin.q};
    }
  }
  return motion;
}

template Pose<Narrow> initial_pose(const Body&);
template Pose<Wide> initial_pose(const Body&);
template Motion<Narrow> solve_each_body(const Scenario&, const std::vector<Narrow>&,
                                        const std::function<Translation<Narrow>(const Scene&, int)>&);
template Motion<Wide> solve_each_body(const Scenario&, const std::vector<Wide>&,
                                      const std::function<Translation<Wide>(const Scene&, int)>&);

}  // namespace atwood::closed_form
