// The depth of overlaps of shapes over the samples. Pairs whose bounding spheres are apart are skipped.
#include <algorithm>
#include <cmath>
#include <limits>

#include "dynamics/contacts.hpp"
#include "geometry/geometry.hpp"
#include "scene/joined.hpp"
#include "validation/metrics/measurements.hpp"

namespace atwood::metrics {
namespace {

double length(const Real3& a) { return std::sqrt(a[0] * a[0] + a[1] * a[1] + a[2] * a[2]); }

double farthest(const std::vector<Real3>& points) {
  double radius = 0;
  for (const Real3& p : points) radius = std::max(radius, length(p));
  return radius;
}

// Of the smallest sphere about the body's origin that holds the shape; infinite for a plane.
struct BoundingRadius {
  double operator()(std::monostate) const { return 0; }
  double operator()(const Sphere& s) const { return s.radius_m; }
  double operator()(const Plane&) const { return std::numeric_limits<double>::infinity(); }
  double operator()(const Rectangle& r) const { return std::hypot(r.half_extents_m[0], r.half_extents_m[1]); }
  double operator()(const Box& b) const { return length(b.half_extents_m); }
  double operator()(const Capsule& c) const { return c.radius_m + c.half_length_m; }
  double operator()(const Cylinder& c) const { return std::hypot(c.radius_m, c.half_length_m); }
  double operator()(const Convex& c) const { return farthest(c.points_m); }
  double operator()(const Mesh& m) const { return farthest(m.points_m); }
  double operator()(const Compound& c) const {
    double radius = 0;
    for (const Compound::Part& part : c.boxes)
      radius = std::max(radius, length(part.position_body_m) + length(part.half_extents_m));
    return radius;
  }
};

// The size of a body that a depth is relative to: a radius, the least half extent. Planes, rectangles and meshes have
// none.
double own_size(const Body& body) {
  if (const auto* sphere = std::get_if<Sphere>(&body.shape)) return sphere->radius_m;
  if (const auto* capsule = std::get_if<Capsule>(&body.shape)) return capsule->radius_m;
  if (const auto* cylinder = std::get_if<Cylinder>(&body.shape))
    return std::min(cylinder->radius_m, cylinder->half_length_m);
  if (const auto* box = std::get_if<Box>(&body.shape)) return *std::ranges::min_element(box->half_extents_m);
  if (const auto* convex = std::get_if<Convex>(&body.shape)) return farthest(convex->points_m);
  return std::numeric_limits<double>::infinity();
}

struct Ball {
  int body;
  double radius;
  Real3 center;
};

class Overlaps {
 public:
  explicit Overlaps(const Scene& scene) : scene_(scene), layout_(dynamics::layout(scene)) {
    for (std::size_t i = 0; i < scene.bodies.size(); ++i) {
      if (scene.bodies[i].shape.index() == 0) continue;
      const double radius = std::visit(BoundingRadius{}, scene.bodies[i].shape);
      (std::isfinite(radius) ? balls_ : planes_).push_back({static_cast<int>(i), radius, {}});
    }
  }

  // visit(a, b, depth) for pairs of this sample that overlap, a < b.
  template <class Visit> void each(const SampleView& sample, const Visit& visit) {
    for (Ball& ball : balls_)
      for (int k = 0; k < 3; ++k) ball.center[k] = static_cast<double>(sample.bodies[ball.body].p_m[k]);
    std::ranges::sort(balls_, {}, [](const Ball& ball) { return ball.center[0] - ball.radius; });
    y_ = dynamics::pack<Wide>(scene_, sample);
    for (std::size_t i = 0; i < balls_.size(); ++i) {
      for (const Ball& plane : planes_) look(sample, balls_[i].body, plane.body, visit);
      const double right = balls_[i].center[0] + balls_[i].radius;
      for (std::size_t j = i + 1; j < balls_.size() && balls_[j].center[0] - balls_[j].radius <= right; ++j) {
        const Real3 &a = balls_[i].center, &b = balls_[j].center;
        const double apart = length({a[0] - b[0], a[1] - b[1], a[2] - b[2]});
        if (apart <= balls_[i].radius + balls_[j].radius) look(sample, balls_[i].body, balls_[j].body, visit);
      }
    }
  }
  // Shapes that came near and have no exact gap: "box against cylinder"; empty where there are none.
  const std::string& unknown() const { return unknown_; }

 private:
  template <class Visit> void look(const SampleView& sample, int first, int second, const Visit& visit) {
    const dynamics::ContactPair pair{std::min(first, second), std::max(first, second), 0, 0};
    if (scene_.bodies[pair.a].fixed && scene_.bodies[pair.b].fixed) return;
    if (joined(scene_, pair.a, pair.b)) return;  // they do not collide
    double depth = 0;
    if (dynamics::has_gap(scene_, pair)) {
      depth = -static_cast<double>(dynamics::gap(scene_, layout_, pair, y_.data()).gap_m);
    } else if (auto shapes = geometry::no_separation(scene_.bodies[pair.a].shape, scene_.bodies[pair.b].shape);
               shapes.empty()) {
      depth = static_cast<double>(geometry::overlap_depth(scene_, sample, pair.a, pair.b));
    } else {
      unknown_ = std::move(shapes);
    }
    if (depth > 0) visit(pair.a, pair.b, depth);
  }

  const Scene& scene_;
  dynamics::Layout layout_;
  std::vector<Ball> balls_, planes_;
  std::vector<Wide> y_;
  std::string unknown_;
};

}  // namespace

void append_penetration(const Scene& scene, const Recording& run, std::vector<Row>& rows) {
  Overlaps overlaps(scene);
  double deepest = 0, relative = 0, sum = 0;
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    double now = 0;
    overlaps.each(run.values[k], [&](int a, int b, double depth) {
      now = std::max(now, depth);
      relative = std::max(relative, depth / std::min(own_size(scene.bodies[a]), own_size(scene.bodies[b])));
    });
    deepest = std::max(deepest, now);
    if (k > 0) sum += now * now;
  }
  if (!overlaps.unknown().empty()) {
    rows.push_back(row("penetration-max", std::nan(""), 0, "the reference has no depth of " + overlaps.unknown()));
    return;
  }
  rows.push_back(row("penetration-max", deepest));
  if (run.values.size() > 1)
    rows.push_back(row("penetration-rms", std::sqrt(sum / static_cast<double>(run.values.size() - 1))));
  rows.push_back(row("penetration-relative", relative));
}

}  // namespace atwood::metrics
