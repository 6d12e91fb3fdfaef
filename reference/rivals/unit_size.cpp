#include "rivals/unit_size.hpp"

#include "rivals/vector.hpp"
#include "scene/pair_sweep.hpp"

namespace atwood::rivals {
namespace {

struct Scale {
  double k;  // units a metre
  Real3 origin_m;

  void operator()(std::monostate&) const {}
  void operator()(Sphere& s) const { s.radius_m *= k; }
  void operator()(Plane& s) const { s.offset_m = k * (s.offset_m - dot(s.normal, origin_m)); }
  void operator()(Rectangle& s) const {
    for (double& h : s.half_extents_m) h *= k;
  }
  void operator()(Box& s) const { s.half_extents_m = k * s.half_extents_m; }
  void operator()(Capsule& s) const { s.radius_m *= k, s.half_length_m *= k; }
  void operator()(Cylinder& s) const { s.radius_m *= k, s.half_length_m *= k; }
  void operator()(Convex& s) const {
    for (Real3& p : s.points_m) p = k * p;
  }
  void operator()(Mesh& s) const {
    for (Real3& p : s.points_m) p = k * p;
  }
  void operator()(Compound& s) const {
    for (auto& box : s.boxes)
      box.half_extents_m = k * box.half_extents_m, box.position_body_m = k * box.position_body_m;
  }
};

}  // namespace

ContactTest at_unit_size(ContactTest find) {
  return [find](const Scene& scene, const ContactQuery& query) {
    const double unit_m = pair_size_m(scene);
    if (!(unit_m > 0) || !std::isfinite(unit_m)) return find(scene, query);
    Scale scale{1 / unit_m, {}};
    for (auto body = scene.bodies.rbegin(); body != scene.bodies.rend(); ++body)
      if (!body->fixed) scale.origin_m = body->position_m;
    Scene scaled = scene;
    for (Body& body : scaled.bodies) {
      std::visit(scale, body.shape);
      body.position_m = scale.k * (body.position_m - scale.origin_m);
      body.velocity_m_per_s = scale.k * body.velocity_m_per_s;
    }
    ContactAnswer answer = find(scaled, query);
    const auto back = [&](std::array<Wide, 3>& x) {
      for (std::size_t i = 0; i < 3; ++i) x[i] = scale.origin_m[i] + unit_m * x[i];
    };
    for (FoundContact& c : answer.contacts) back(c.x_m), c.depth_m *= unit_m;
    for (FoundTouch& t : answer.touches) back(t.x_m);
    return answer;
  };
}

}  // namespace atwood::rivals
