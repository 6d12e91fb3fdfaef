#include "scene/orientation.hpp"

#include <cmath>

namespace atwood {
namespace {

using Real = long double;  // rounded to double once, at the end
using Quaternion = std::array<Real, 4>;

struct SineCosine {
  Real sine, cosine;
};

// The angle is reduced in degrees, where multiples of 90 are exact: |rest| <= 45.
SineCosine sine_cosine_deg(Real angle_deg) {
  int quadrant = 0;
  const Real rest = std::remquo(angle_deg, Real(90), &quadrant);
  const Real radians = rest * (3.14159265358979323846264338327950288L / 180);
  Real sine = std::sin(radians), cosine = std::cos(radians);
  if (std::abs(rest) == 30) sine = std::copysign(Real(0.5), rest);
  if (std::abs(rest) == 45) cosine = std::sqrt(Real(0.5)), sine = std::copysign(cosine, rest);
  switch (quadrant & 3) {
    case 0: return {sine, cosine};
    case 1: return {cosine, -sine};
    case 2: return {-sine, -cosine};
    default: return {-cosine, sine};
  }
}

Real half_turns_removed(double angle_deg) { return std::remainder(Real(angle_deg), Real(360)) / 2; }

Quaternion product(const Quaternion& a, const Quaternion& b) {
  return {a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3], a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
          a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1], a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0]};
}

Real4 rounded(const Quaternion& q) {
  Real4 out{};
  for (std::size_t i = 0; i < 4; ++i) out[i] = static_cast<double>(q[i]);
  double sign = 1;
  for (const double x : out) {
    if (x == 0) continue;
    sign = x < 0 ? -1 : 1;
    break;
  }
  for (double& x : out) x = x * sign + 0.0;  // no -0
  return out;
}

}  // namespace

Real4 axis_angle_quaternion(const Real3& axis, double angle_deg) {
  Real largest = 0;
  for (const double x : axis) largest = std::max(largest, std::abs(Real(x)));
  Real square = 0;
  for (const double x : axis) square += (Real(x) / largest) * (Real(x) / largest);
  const Real length = largest * std::sqrt(square);
  const auto [sine, cosine] = sine_cosine_deg(half_turns_removed(angle_deg));
  Quaternion q{cosine};
  for (std::size_t i = 0; i < 3; ++i) q[i + 1] = sine * (Real(axis[i]) / length);
  return rounded(q);
}

Real4 euler_xyz_quaternion(const Real3& angles_deg) {
  Quaternion q{1};
  for (std::size_t i = 0; i < 3; ++i) {
    const auto [sine, cosine] = sine_cosine_deg(half_turns_removed(angles_deg[i]));
    Quaternion turn{cosine};
    turn[i + 1] = sine;
    q = product(q, turn);
  }
  return rounded(q);
}

Codec<Real4> axis_angle_degrees() {
  struct AxisAngle {
    Real3 axis{};
    double angle_deg = 0;
  };
  const Keys<AxisAngle> keys = {
      required(key<AxisAngle>("axis", &AxisAngle::axis, vector3(), "[x, y, z] of any length but 0")),
      required(key<AxisAngle>("angle_deg", &AxisAngle::angle_deg, number(), "the angle [degrees]"))};
  Codec<Real4> c;
  const Value four =
      table_of({{"type", "array"}, {"items", table_of({{"type", "number"}})}, {"minItems", 4}, {"maxItems", 4}});
  c.schema = table_of({{"oneOf", Value::List{object_schema(keys, Form::file), four}}});
  c.read = [keys](Reading& r, const Value& v, Real4& out) {
    AxisAngle read;
    const auto* items = v.list();
    if (v.table()) {
      const std::string outer = r.where, outer_key = r.key;
      r.where = "`" + r.key + "` of " + outer;
      read_table(r, v, keys, {}, read);
      r.where = outer, r.key = outer_key;
    } else if (items && items->size() == 4) {
      for (std::size_t i = 0; i < 3; ++i) read.axis[i] = read_number(r, (*items)[i], any_number());
      read.angle_deg = read_number(r, items->back(), any_number());
    } else {
      fail_value(r, v, "{ axis = [x, y, z], angle_deg = ... } or [x, y, z, degrees]");
    }
    if (read.axis == Real3{})
      fail(r, v.location,
           "the axis of `" + r.key + "` in " + r.where + " is [0, 0, 0]; expected an axis that is not 0");
    out = axis_angle_quaternion(read.axis, read.angle_deg);
  };
  return c;
}

Codec<Real4> euler_xyz_degrees() {
  Codec<Real4> c;
  const Codec<Real3> angles = vector3();
  c.schema = angles.schema;
  c.read = [angles](Reading& r, const Value& v, Real4& out) {
    Real3 read{};
    angles.read(r, v, read);
    out = euler_xyz_quaternion(read);
  };
  return c;
}

void require_one_orientation(const Reading& r, const Value& table) {
  const Member* first = nullptr;
  for (const Member& member : *table.table()) {
    if (member.key != "orientation_wxyz" && member.key != "axis_angle_deg" && member.key != "euler_xyz_deg") continue;
    if (first != nullptr)
      fail(r, member.location,
           "`" + member.key + "` in " + r.where + " is given beside `" + first->key +
               "`; expected one of orientation_wxyz, axis_angle_deg and euler_xyz_deg");
    first = &member;
  }
}

}  // namespace atwood
