// What an adapter checks and converts before it builds its engine's world: settings, refusals, principal axes.
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "rivals/vector.hpp"
#include "rivals/world.hpp"
#include "scene/inertia.hpp"

namespace atwood::rivals {
namespace {

constexpr const char* kShapeNames[] = {"none",    "sphere",   "plane",  "rectangle", "box",
                                       "capsule", "cylinder", "convex", "mesh",      "compound"};
static_assert(std::size(kShapeNames) == std::variant_size_v<Shape>);

}  // namespace

const char* shape_name(const Shape& shape) { return kShapeNames[shape.index()]; }
bool has_shape(const Body& body) { return !std::holds_alternative<std::monostate>(body.shape); }

// True: two pairs of bodies with rigid contact laws may have impacts at one instant.
bool impacts_may_coincide(const Scene& scene) {
  const auto is_rigid = [](const PairLaw& law) { return law.contact_law == ContactLaw::rigid; };
  const std::vector<PairLaw> laws = laws_in_play(scene);
  return shapes_matter(scene) && std::any_of(laws.begin(), laws.end(), is_rigid) &&
         std::count_if(scene.bodies.begin(), scene.bodies.end(), has_shape) > 2;
}

std::string convention_note(const std::string& engine, const Scene& scene) {
  if (scene.simultaneous_impacts != SimultaneousImpacts::sequential || !impacts_may_coincide(scene)) return "";
  return engine +
         " has its own order for impacts of one instant: the scene's simultaneous_impacts = sequential is not followed";
}

std::optional<Fault> refusal(const std::string& engine, const MethodId& id, const std::string& scalar,
                             const Scene& scene, bool compliant) {
  if (id.rtol || id.atol) return Fault{engine + " has no error control: expected a method without a tolerance"};
  if (!id.response.empty())
    return Fault{engine + " has its own contact response: +" + id.response + " is not available"};
  if (!id.scalar.empty() && id.scalar != scalar)
    return Fault{engine + " computes in " + scalar + "; found the scalar `" + id.scalar + "`"};
  if (!scene.problem.empty())
    return Fault{engine + " simulates bodies and cannot integrate the bare equations `" + scene.problem + "`"};
  if (const auto reason = uncovered_force(scene); !reason.empty()) return Fault{engine + "'s adapter has " + reason};

  const bool matter = shapes_matter(scene);
  for (const auto& body : scene.bodies) {
    if (body.fixed && (body.velocity_m_per_s != Real3{} || body.angular_velocity_body_rad_per_s != Real3{}))
      return Fault{engine + "'s adapter has no prescribed motion of fixed bodies; `" + body.name + "` moves"};
    if (body.fixed) continue;
    if (!(body.mass_kg > 0)) return Fault{engine + " requires a mass of mobile bodies; `" + body.name + "` has none"};
    if (matter && std::holds_alternative<Plane>(body.shape))
      return Fault{engine + " has fixed planes only; `" + body.name + "` is mobile"};
  }
  if (scene.simultaneous_impacts == SimultaneousImpacts::together && impacts_may_coincide(scene))
    return Fault{
        engine +
        " does not solve all impacts of one instant as one problem: the scene's simultaneous_impacts is together"};
  for (const auto& law : laws_in_play(scene)) {
    if (!compliant && law.contact_law != ContactLaw::rigid)
      return Fault{engine + "'s adapter has no compliant contact laws (contact_law)"};
  }
  return {};
}

bool shapes_matter(const Scene& scene) {
  const auto shaped = std::count_if(scene.bodies.begin(), scene.bodies.end(), has_shape);
  const auto moves = [](const Body& body) { return has_shape(body) && !body.fixed; };
  return shaped > 1 && std::any_of(scene.bodies.begin(), scene.bodies.end(), moves);
}

Setting substeps_setting() {
  return {"substeps", std::int64_t{1}, {between(1, 1000), "Inner steps of a step, all of one length."}};
}

bool flag(const Settings& settings, const std::string& name) { return std::get<bool>(settings.at(name)); }
double number(const Settings& settings, const std::string& name) { return std::get<double>(settings.at(name)); }

std::int64_t count(const Settings& settings, const std::string& name) {
  return std::get<std::int64_t>(settings.at(name));
}
const std::string& word(const Settings& settings, const std::string& name) {
  return std::get<std::string>(settings.at(name));
}

// By hand, for it decides figures: Eigen's Quaternion(m) differs in last digits for six of seven random rotations.
Real4 quaternion_of(const Real33& m) {
  const double squares[4] = {1 + m[0] + m[4] + m[8], 1 + m[0] - m[4] - m[8], 1 - m[0] + m[4] - m[8],
                             1 - m[0] - m[4] + m[8]};
  const auto largest = std::max_element(squares, squares + 4) - squares;
  const double wx = m[7] - m[5], wy = m[2] - m[6], wz = m[3] - m[1];
  const double xy = m[1] + m[3], xz = m[2] + m[6], yz = m[5] + m[7];
  Real4 q{};
  if (largest == 0) q = {squares[0], wx, wy, wz};
  if (largest == 1) q = {wx, squares[1], xy, xz};
  if (largest == 2) q = {wy, xy, squares[2], yz};
  if (largest == 3) q = {wz, xz, yz, squares[3]};
  const double norm = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  for (double& x : q) x /= norm;
  return q;
}

PrincipalAxes principal_axes(const Real33& inertia_kg_m2) {
  const Diagonalised axes = diagonalise(inertia_kg_m2);
  return {axes.moments, quaternion_of(axes.axes)};
}

}  // namespace atwood::rivals
