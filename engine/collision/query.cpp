// Questions about contacts, answered by the narrow phase: all pairs of bodies, by bounding spheres first.
#include "collision/query.hpp"

#include <cmath>
#include <stdexcept>
#include <string>

#include "collision/contacts.hpp"
#include "collision/time_of_impact.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

namespace {

std::array<Wide, 3> widened(const Vec3<double>& v) { return {Wide(v.x), Wide(v.y), Wide(v.z)}; }

SweptBody<double> swept_body(const Body& body) {
  const Real4& q = body.orientation_wxyz;
  const Quat<double> q_WB{q[0], q[1], q[2], q[3]};
  const Vec3<double> v_W = narrow3<double>(body.velocity_m_per_s);
  const Vec3<double> w_W = rotate(q_WB, narrow3<double>(body.angular_velocity_body_rad_per_s));
  if (body.fixed) return {narrow3<double>(body.position_m), q_WB, {}, {}};
  return {narrow3<double>(body.position_m), q_WB, v_W, w_W};
}

// A body with a shape, prepared for the query.
struct QueryBody {
  int index;
  bool fixed;
  Geometry<double> shape;
  SweptBody<double> motion;
  Transform<double> pose;
};

std::vector<QueryBody> query_bodies(const Scene& scene) {
  std::vector<QueryBody> out;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
    const Body& body = scene.bodies[i];
    if (std::holds_alternative<std::monostate>(body.shape)) continue;
    const SweptBody<double> motion = swept_body(body);
    const Transform<double> pose = transform(motion.p_W, motion.q_WB);
    out.push_back({static_cast<int>(i), body.fixed, make_geometry<double>(body.shape), motion, pose});
  }
  return out;
}

bool bounding_spheres_are_apart(const QueryBody& a, const QueryBody& b, double margin) {
  if (a.shape.kind == ShapeKind::plane || b.shape.kind == ShapeKind::plane) return false;
  const double max_distance = a.shape.bounding_radius + b.shape.bounding_radius + margin;
  return norm(b.pose.p_W - a.pose.p_W) > max_distance * (1 + 8 * real::epsilon<double>());
}

// Triangles and parts that share a corner each find the same contact: it is reported once.
bool is_duplicate(const std::vector<FoundContact>& contacts, std::size_t first_new, const FoundContact& contact,
                  double round_off) {
  const auto near = [](const std::array<Wide, 3>& x, const std::array<Wide, 3>& y, double least) {
    bool all = true;
    for (std::size_t i = 0; i < 3; ++i) all = all && std::abs(static_cast<double>(x[i] - y[i])) <= least;
    return all;
  };
  constexpr double same_direction = 1e-9;
  for (std::size_t i = first_new; i < contacts.size(); ++i) {
    const FoundContact& c = contacts[i];
    if (near(c.x_m, contact.x_m, round_off) && near(c.normal, contact.normal, same_direction) &&
        std::abs(static_cast<double>(c.depth_m - contact.depth_m)) <= round_off)
      return true;
  }
  return false;
}

void add_contacts(const QueryBody& a, const QueryBody& b, std::vector<Manifold<double>>& manifolds,
                  SolverTallies& solvers, ContactAnswer& answer) {
  const double round_off = touch_round_off(a.shape, a.pose.p_W, b.shape, b.pose.p_W);
  if (bounding_spheres_are_apart(a, b, round_off)) return;
  manifolds.clear();
  find_contacts(a.shape, a.pose, b.shape, b.pose, round_off, manifolds);
  const std::size_t first_new = answer.contacts.size();
  for (const Manifold<double>& m : manifolds) {
    add_convex_solves(m.solve, solvers);
    for (int k = 0; k < m.count; ++k) {
      const ContactPoint<double>& point = m.points[static_cast<std::size_t>(k)];
      const Wide depth = point.gap < 0 ? -Wide(point.gap) : Wide(0);
      const FoundContact contact{a.index, b.index, widened(point.x_W), widened(m.normal_W), depth};
      if (manifolds.size() == 1 || !is_duplicate(answer.contacts, first_new, contact, 16 * round_off))
        answer.contacts.push_back(contact);
    }
  }
}

void add_time_of_impact(const QueryBody& a, const QueryBody& b, double t_end_s, SolverTallies& solvers,
                        ContactAnswer& answer) {
  const auto touch = time_of_impact(a.shape, a.motion, b.shape, b.motion, t_end_s);
  if (!touch) return;
  if (touch->solve.iterations > 0) solvers.add(IterativeSolver::conservative_advancement, touch->solve);
  answer.touches.push_back({a.index, b.index, Wide(touch->t_s), widened(touch->x_W), widened(touch->normal_W)});
}

}  // namespace

ContactAnswer find_scene_contacts(const Scene& scene, const ContactQuery& query) {
  ContactAnswer answer;
  const std::vector<QueryBody> bodies = query_bodies(scene);
  std::vector<Manifold<double>> manifolds;
  SolverTallies solvers;
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    for (std::size_t j = i + 1; j < bodies.size(); ++j) {
      const QueryBody &a = bodies[i], &b = bodies[j];
      if (a.fixed && b.fixed) continue;
      if (const char* missing = missing_contact_test(a.shape.kind, b.shape.kind)) {
        return refused<ContactAnswer>(std::string("atwood has no contact test of ") + missing);
      }
      if (query.swept) add_time_of_impact(a, b, query.t_end_s, solvers, answer);
      else add_contacts(a, b, manifolds, solvers, answer);
    }
  }
  answer.outcome.solvers = named_tallies(solvers);
  return answer;
}

PairGap find_pair_gap(const Scene& scene, int a, int b) {
  const auto geometry = [&scene](int i) {
    return make_geometry<double>(scene.bodies.at(static_cast<std::size_t>(i)).shape);
  };
  const auto pose = [&scene](int i) {
    const SweptBody<double> at = swept_body(scene.bodies.at(static_cast<std::size_t>(i)));
    return transform(at.p_W, at.q_WB);
  };
  const Geometry<double> shape_a = geometry(a), shape_b = geometry(b);
  if (const char* missing = missing_contact_test(shape_a.kind, shape_b.kind))
    throw std::invalid_argument(std::string("atwood has no contact test of ") + missing);
  const Separation<double> found = separation(shape_a, pose(a), shape_b, pose(b));
  PairGap gap;
  gap.gap_m = found.gap;
  gap.normal = widened(found.normal_W);
  gap.x_m = widened(0.5 * (found.on_a_W + found.on_b_W));
  return gap;
}

}  // namespace atwood
