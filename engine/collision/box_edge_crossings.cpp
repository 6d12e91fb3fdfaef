#include "collision/box_edge_crossings.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <vector>

#include "collision/geometry.hpp"
#include "protocol/refusal.hpp"

namespace atwood {

namespace {

using Vec = Vec3<double>;

struct PosedBox {
  std::array<double, 3> h;
  Transform<double> pose;
};

PosedBox posed_box(const Body& body) {
  const Real4& q = body.orientation_wxyz;
  const Real3& h = std::get<Box>(body.shape).half_extents_m;
  return {h, transform(narrow3<double>(body.position_m), Quat<double>{q[0], q[1], q[2], q[3]})};
}

Vec corner(const PosedBox& box, int bits) {
  Vec x = box.pose.p_W;
  for (std::size_t k = 0; k < 3; ++k) x += ((bits >> k) & 1 ? box.h[k] : -box.h[k]) * box.pose.axis_W[k];
  return x;
}

struct EdgeCrossing {
  Vec x_W, outward_W;
  double depth;
};

// Where the segment from `from` to `to` passes through faces of the box.
void cross_faces(const Vec& from_W, const Vec& to_W, const PosedBox& box, std::vector<EdgeCrossing>& out) {
  const Vec from = to_body(box.pose, from_W - box.pose.p_W), to = to_body(box.pose, to_W - box.pose.p_W);
  const std::array<double, 3> p{from.x, from.y, from.z}, q{to.x, to.y, to.z};
  for (std::size_t k = 0; k < 3; ++k) {
    for (const double sign : {-1.0, 1.0}) {
      const double above = sign * p[k] - box.h[k], below = sign * q[k] - box.h[k];
      if ((above > 0) == (below > 0)) continue;
      const double part = above / (above - below);
      const std::size_t i = (k + 1) % 3, j = (k + 2) % 3;
      if (std::abs(p[i] + part * (q[i] - p[i])) > box.h[i] || std::abs(p[j] + part * (q[j] - p[j])) > box.h[j])
        continue;
      out.push_back({from_W + part * (to_W - from_W), sign * box.pose.axis_W[k], -std::min(above, below)});
    }
  }
}

std::vector<EdgeCrossing> crossings(const PosedBox& edges_of, const PosedBox& faces_of) {
  std::vector<EdgeCrossing> out;
  for (int bits = 0; bits < 8; ++bits)
    for (int k = 0; k < 3; ++k)
      if (!((bits >> k) & 1)) cross_faces(corner(edges_of, bits), corner(edges_of, bits | (1 << k)), faces_of, out);
  return out;
}

std::array<Wide, 3> widened(const Vec& v) { return {Wide(v.x), Wide(v.y), Wide(v.z)}; }

}  // namespace

ContactAnswer find_contacts_by_box_edges(const Scene& scene, const ContactQuery& query) {
  if (query.swept) return refused<ContactAnswer>("box-edges has no swept test");
  for (const Body& body : scene.bodies)
    if (!std::holds_alternative<Box>(body.shape))
      return refused<ContactAnswer>("box-edges tests boxes only; `" + body.name + "` is not a box");
  ContactAnswer answer;
  for (std::size_t a = 0; a < scene.bodies.size(); ++a) {
    for (std::size_t b = a + 1; b < scene.bodies.size(); ++b) {
      if (scene.bodies[a].fixed && scene.bodies[b].fixed) continue;
      const PosedBox box_a = posed_box(scene.bodies[a]), box_b = posed_box(scene.bodies[b]);
      const auto add = [&](const EdgeCrossing& c, const Vec& normal_W) {
        answer.contacts.push_back(
            {static_cast<int>(a), static_cast<int>(b), widened(c.x_W), widened(normal_W), Wide(c.depth)});
      };
      for (const EdgeCrossing& c : crossings(box_a, box_b)) add(c, -c.outward_W);
      for (const EdgeCrossing& c : crossings(box_b, box_a)) add(c, c.outward_W);
    }
  }
  return answer;
}

}  // namespace atwood
