#include "mechanism/values.hpp"

#include <algorithm>
#include <cmath>

#include "dynamics/arithmetic.hpp"

namespace atwood::mechanism {

using dynamics::magnitude;

std::vector<Wide> values_of(const Scene& scene, const SampleView& sample) {
  std::vector<Wide> made;
  each_value(scene, sample, [&](const Wide& x, ValueKind) { made.push_back(x); });
  return made;
}

std::vector<char> undetermined_values(const Scene& scene, const SampleView& sample) {
  Sample marks = copy_of(sample);
  each_value(scene, marks, [](Wide& x, ValueKind) { x = 0; });
  for (JointSample& joint : marks.joints)
    for (int k = 0; k < 3; ++k) {
      joint.force_N[k] = (joint.not_unique >> k) & 1u;
      joint.torque_N_m[k] = (joint.not_unique >> (k + 3)) & 1u;
    }
  std::vector<char> made;
  each_value(scene, marks, [&](const Wide& x, ValueKind) { made.push_back(x != 0); });
  return made;
}

namespace {
Wide sign_between(const std::vector<Wide>& a, const std::vector<Wide>& b, std::size_t at) {
  Wide along = 0;
  for (std::size_t k = at; k < at + 4; ++k) along += a[k] * b[k];
  return along < 0 ? -1 : 1;
}
}  // namespace

std::vector<Wide> scales(const Scene& scene, const SampleSeries& samples) {
  std::vector<Wide> made(kinds, Wide(0));
  for (const SampleView sample : samples)
    each_value(scene, sample, [&](const Wide& x, ValueKind kind) { made[kind] = std::max(made[kind], magnitude(x)); });
  Wide size = 0;
  for (const Joint& joint : scene.joints)
    for (const auto& anchor : joint.anchors_body_m)
      for (const double x : anchor) size = std::max(size, magnitude(Wide(x)));
  if (size == 0) size = made[position];
  if (size == 0) size = 1;
  const auto share = [&](std::initializer_list<std::pair<ValueKind, bool>> group) {  // true: times a length
    Wide largest = 0;
    for (const auto& [kind, long_unit] : group) largest = std::max(largest, long_unit ? made[kind] / size : made[kind]);
    for (const auto& [kind, long_unit] : group) made[kind] = long_unit ? largest * size : largest;
  };
  made[position] = std::max(made[position], size);
  made[coordinate_length] = made[position];
  made[coordinate_angle] = std::max(made[coordinate_angle], Wide(1));
  share({{velocity, true}, {rate_speed, true}, {angular_velocity, false}, {coordinate_rate_angular, false}});
  share({{force, false}, {tension, false}, {torque, true}, {applied_load, true}});
  for (Wide& s : made)
    if (s == 0) s = 1;
  return made;
}

std::vector<Wide> differences(const Scene& scene, const SampleView& sample, std::initializer_list<SampleView> others) {
  const std::vector<Wide> value = values_of(scene, sample);
  std::vector<Wide> made(value.size(), Wide(0));
  for (const SampleView& other : others) {
    const std::vector<Wide> theirs = values_of(scene, other);
    std::size_t i = 0, in_quaternion = 0;
    Wide sign = 1;
    each_value(scene, sample, [&](const Wide&, ValueKind kind) {
      if (kind == attitude && in_quaternion++ % 4 == 0) sign = sign_between(value, theirs, i);
      const Wide apart = magnitude(value[i] - (kind == attitude ? sign : Wide(1)) * theirs[i]);
      if (!(apart <= made[i])) made[i] = apart == apart ? apart : Wide(HUGE_VAL);
      ++i;
    });
  }
  return made;
}

}  // namespace atwood::mechanism
