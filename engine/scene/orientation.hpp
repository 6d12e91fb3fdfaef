// Orientations of scenario files in degrees, converted to unit quaternions. All other quantities are in SI and radians.
#pragma once

#include "scene/keys.hpp"

namespace atwood {

// The unit quaternion (w, x, y, z) of a turn by `angle_deg` about `axis`, which has any finite length but 0.
// Right-handed. Each component is the exact one rounded to double, to one unit in the last place; multiples of 90
// degrees about a coordinate axis are exact (0, 1, sqrt(1/2)). w >= 0: the result is the same of the two quaternions of
// an orientation for every number of full turns in the angle.
Real4 axis_angle_quaternion(const Real3& axis, double angle_deg);
// Intrinsic x-y'-z'': first about the body's x, then about its turned y, then about its twice turned z;
// R = R_x(rx) R_y(ry) R_z(rz), body to world.
Real4 euler_xyz_quaternion(const Real3& angles_deg);

// { axis = [0, 0, 1], angle_deg = 30 }, or [0, 0, 1, 30].
Codec<Real4> axis_angle_degrees();
// [rx, ry, rz]
Codec<Real4> euler_xyz_degrees();

// The two keys besides `orientation_wxyz`, in files only.
template <class T, class B> void add_degree_keys(Keys<T>& keys, Real4 B::*orientation) {
  keys.push_back(only(In::file, key<T>("axis_angle_deg", orientation, axis_angle_degrees(),
                                       "in place of orientation_wxyz: { axis = [x, y, z], angle_deg = ... } or "
                                       "[x, y, z, degrees]; right-handed, the axis of any length but 0 [degrees]")));
  keys.push_back(only(In::file, key<T>("euler_xyz_deg", orientation, euler_xyz_degrees(),
                                       "in place of orientation_wxyz: [rx, ry, rz], intrinsic x-y'-z'' (about the "
                                       "body's x, then its turned y, then its turned z): R = Rx Ry Rz [degrees]")));
}
// Fails at the second of the three keys.
void require_one_orientation(const Reading& r, const Value& table);

}  // namespace atwood
