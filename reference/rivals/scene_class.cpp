#include "rivals/scene_class.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "geometry/geometry.hpp"
#include "rivals/vector.hpp"
#include "rivals/world.hpp"
#include "scene/bounding_radius.hpp"
#include "scene/contact_laws.hpp"

namespace atwood::rivals {
namespace {

constexpr int kMaxInStack = 128, kMinInHeap = 16;
constexpr double kTouching = 1e-3;  // of the smaller body's radius

bool touch(const Scene& scene, int a, int b) {
  const Body &one = scene.bodies[static_cast<std::size_t>(a)], &other = scene.bodies[static_cast<std::size_t>(b)];
  const double r = bounding_radius_m(one.shape), s = bounding_radius_m(other.shape),
               near_m = kTouching * std::min(r, s);
  const double apart_m = length(one.position_m - other.position_m);
  if (std::isfinite(r) && std::isfinite(s) && apart_m > r + s + near_m) return false;
  if (geometry::no_separation(one.shape, other.shape).empty()) {
    try {
      return static_cast<double>(geometry::separation_between(scene, a, b).gap_m) <= near_m;
    } catch (const std::invalid_argument&) {  // not covered (a flat hull, for instance): bounding spheres
    }
  }
  if (std::isfinite(r) && std::isfinite(s)) return true;
  // A plane and a shape without exact geometry: does its bounding sphere touch the plane?
  const Body& body = std::isfinite(r) ? one : other;
  const Plane& plane = std::get<Plane>((std::isfinite(r) ? other : one).shape);
  const double norm = length(plane.normal);
  return (dot(plane.normal, body.position_m) - plane.offset_m) / norm <= bounding_radius_m(body.shape) + near_m;
}

bool still(const Body& body) {
  return length(body.velocity_m_per_s) == 0 && length(body.angular_velocity_body_rad_per_s) == 0;
}

}  // namespace

SceneClass scene_class(const Scene& scene) {
  if (has_mechanism(scene)) return SceneClass::mechanism;
  if (!shapes_matter(scene)) return SceneClass::free_flight;
  std::vector<int> movable, fixed;
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i) {
    const Body& body = scene.bodies[static_cast<std::size_t>(i)];
    if (has_shape(body)) (body.fixed ? fixed : movable).push_back(i);
  }
  const int count = static_cast<int>(movable.size());
  const bool gravity = length(scene.gravity_m_per_s2) > 0;
  if (count > kMaxInStack) return gravity ? SceneClass::heap : SceneClass::bounce;
  bool restitution = false, friction = false;
  for (const PairLaw& law : laws_in_play(scene)) {
    restitution = restitution || law.restitution > 0;
    friction = friction || law.friction > 0 || law.rolling_friction_m > 0;
  }
  const bool at_rest = std::all_of(movable.begin(), movable.end(),
                                   [&](int i) { return still(scene.bodies[static_cast<std::size_t>(i)]); });
  if (count >= 2 && at_rest && !restitution) {
    for (std::size_t i = 0; i < movable.size(); ++i)
      for (std::size_t j = i + 1; j < movable.size(); ++j)
        if (touch(scene, movable[i], movable[j])) return SceneClass::stack;
  }
  const auto grounded = std::count_if(movable.begin(), movable.end(), [&](int i) {
    return std::any_of(fixed.begin(), fixed.end(), [&](int j) { return touch(scene, std::min(i, j), std::max(i, j)); });
  });
  if (gravity && count >= kMinInHeap && 2 * grounded < count) return SceneClass::heap;
  if (friction && grounded > 0 && 2 * grounded >= count) return SceneClass::friction;
  return SceneClass::bounce;
}

namespace {

constexpr std::array<std::pair<SceneClass, const char*>, 6> kNames{{{SceneClass::free_flight, "free-flight"},
                                                                    {SceneClass::bounce, "bounce"},
                                                                    {SceneClass::friction, "friction"},
                                                                    {SceneClass::stack, "stack"},
                                                                    {SceneClass::heap, "heap"},
                                                                    {SceneClass::mechanism, "mechanism"}}};

}  // namespace

std::string to_string(SceneClass scene_class) {
  for (const auto& [each, name] : kNames)
    if (each == scene_class) return name;
  return "";
}

std::optional<SceneClass> scene_class_of(const std::string& name) {
  for (const auto& [each, known] : kNames)
    if (name == known) return each;
  return std::nullopt;
}

const std::vector<SceneClass>& all_scene_classes() {
  static const std::vector<SceneClass> all = [] {
    std::vector<SceneClass> made;
    for (const auto& entry : kNames) made.push_back(entry.first);
    return made;
  }();
  return all;
}

}  // namespace atwood::rivals
