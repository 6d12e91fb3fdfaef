#include "collision/predicates.hpp"

#include <algorithm>
#include <cmath>

namespace atwood {
namespace {

// A sum kept exactly: terms that do not overlap, the smallest first.
template <class S> struct Expansion {
  static constexpr int kMaxTerms = 256;
  S term[kMaxTerms];
  int count = 0;

  void add(S x) {
    int kept = 0;
    for (int i = 0; i < count; ++i) {  // Knuth's exact sum of two; round-off stays behind
      const S sum = x + term[i], virtual_x = sum - term[i], low = (x - virtual_x) + (term[i] - (sum - virtual_x));
      x = sum;
      if (low != S(0)) term[kept++] = low;
    }
    if (x != S(0)) term[kept++] = x;
    count = kept;
  }
  int sign() const { return count == 0 ? 0 : term[count - 1] > S(0) ? 1 : -1; }
};

// u - v without round-off.
template <class S> struct Difference {
  S part[2];
  Difference(S u, S v) {
    const S high = u - v, virtual_v = u - high, virtual_u = high + virtual_v;
    part[0] = high;
    part[1] = (u - virtual_u) + (virtual_v - v);
  }
};

template <class S> void add_product(Expansion<S>& sum, S x, S y) {
  const S high = x * y;
  sum.add(high);
  sum.add(std::fma(x, y, -high));
}
template <class S> void add_product(Expansion<S>& sum, const Difference<S>& x, const Difference<S>& y, S sign) {
  for (const S p : x.part)
    for (const S q : y.part) add_product(sum, sign * p, q);
}
template <class S>
void add_product(Expansion<S>& sum, const Difference<S>& x, const Difference<S>& y, const Difference<S>& z, S sign) {
  for (const S p : x.part)
    for (const S q : y.part) {
      const S high = p * q, low = std::fma(p, q, -high);
      for (const S r : z.part) {
        add_product(sum, sign * high, r);
        add_product(sum, sign * low, r);
      }
    }
}

template <class S> int orient3d_exact(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, const Vec3<S>& d) {
  const Difference<S> ax(a.x, d.x), ay(a.y, d.y), az(a.z, d.z), bx(b.x, d.x), by(b.y, d.y), bz(b.z, d.z), cx(c.x, d.x),
      cy(c.y, d.y), cz(c.z, d.z);
  Expansion<S> sum;
  add_product(sum, ax, by, cz, S(1)), add_product(sum, ax, bz, cy, S(-1));
  add_product(sum, ay, bz, cx, S(1)), add_product(sum, ay, bx, cz, S(-1));
  add_product(sum, az, bx, cy, S(1)), add_product(sum, az, by, cx, S(-1));
  return sum.sign();
}

template <class S> int sign_of(S x) { return x > S(0) ? 1 : x < S(0) ? -1 : 0; }

template <class S> using Flat = std::array<S, 2>;
template <class S> Flat<S> dropped(const Vec3<S>& v, int axis) {
  return axis == 0 ? Flat<S>{v.y, v.z} : axis == 1 ? Flat<S>{v.z, v.x} : Flat<S>{v.x, v.y};
}

// x on the closed segment, when it is on its line.
template <class S> bool between(const Flat<S>& x, const Flat<S>& a, const Flat<S>& b) {
  return std::min(a[0], b[0]) <= x[0] && x[0] <= std::max(a[0], b[0]) && std::min(a[1], b[1]) <= x[1] &&
         x[1] <= std::max(a[1], b[1]);
}

template <class S> bool segments_meet(const Flat<S>& a, const Flat<S>& b, const Flat<S>& c, const Flat<S>& d) {
  const int abc = orient2d(a, b, c), abd = orient2d(a, b, d), cda = orient2d(c, d, a), cdb = orient2d(c, d, b);
  if (abc * abd < 0 && cda * cdb < 0) return true;
  return (abc == 0 && between(c, a, b)) || (abd == 0 && between(d, a, b)) || (cda == 0 && between(a, c, d)) ||
         (cdb == 0 && between(b, c, d));
}

template <class S> bool inside(const Flat<S>& x, const std::array<Flat<S>, 3>& t) {
  const int a = orient2d(t[0], t[1], x), b = orient2d(t[1], t[2], x), c = orient2d(t[2], t[0], x);
  return (a > 0 && b > 0 && c > 0) || (a < 0 && b < 0 && c < 0);
}

template <class S> bool coplanar_triangles_meet(const Corners<S>& p, const Corners<S>& q) {
  // Along an axis where one of them keeps an area; all on one line: along any that keeps its length.
  int axis = -1;
  for (int k = 0; k < 3 && axis < 0; ++k)
    for (const Corners<S>* t : {&p, &q})
      if (orient2d(dropped((*t)[0], k), dropped((*t)[1], k), dropped((*t)[2], k)) != 0) axis = k;
  if (axis < 0) {
    const auto extent = [&](auto of) {
      const auto [low, high] = std::minmax({of(p[0]), of(p[1]), of(p[2]), of(q[0]), of(q[1]), of(q[2])});
      return high - low;
    };
    const S x = extent([](const Vec3<S>&v) { return v.x; }), y = extent([](const Vec3<S>&v) { return v.y; }),
            z = extent([](const Vec3<S>&v) { return v.z; });
    axis = x <= y && x <= z ? 0 : y <= z ? 1 : 2;
  }
  std::array<Flat<S>, 3> u, v;
  for (int k = 0; k < 3; ++k) u[k] = dropped(p[k], axis), v[k] = dropped(q[k], axis);
  for (int i = 0; i < 3; ++i)
    for (int k = 0; k < 3; ++k)
      if (segments_meet(u[i], u[(i + 1) % 3], v[k], v[(k + 1) % 3])) return true;
  return inside(u[0], v) || inside(v[0], u);
}

// An edge whose ends lie on the triangle's plane or on both sides of it (not both on it).
template <class S> bool edge_meets(const Vec3<S>& s, const Vec3<S>& t, const Corners<S>& q) {
  const int a = orient3d(s, t, q[0], q[1]), b = orient3d(s, t, q[1], q[2]), c = orient3d(s, t, q[2], q[0]);
  return (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
}

template <class S> bool edges_meet(const Corners<S>& p, const std::array<int, 3>& side, const Corners<S>& q) {
  for (int k = 0; k < 3; ++k) {
    const int l = (k + 1) % 3;
    if (side[k] * side[l] > 0 || (side[k] == 0 && side[l] == 0))
      continue;  // an edge in the plane: its neighbours or q's edges decide
    if (edge_meets(p[k], p[l], q)) return true;
  }
  return false;
}

}  // namespace

template <class S> int orient3d(const Vec3<S>& a, const Vec3<S>& b, const Vec3<S>& c, const Vec3<S>& d) {
  const Vec3<S> u = a - d, v = b - d, w = c - d;
  const S vw_x = v.y * w.z, wv_x = v.z * w.y, vw_y = v.z * w.x, wv_y = v.x * w.z, vw_z = v.x * w.y, wv_z = v.y * w.x;
  const S determinant = u.x * (vw_x - wv_x) + u.y * (vw_y - wv_y) + u.z * (vw_z - wv_z);
  const S permanent = real::abs(u.x) * (real::abs(vw_x) + real::abs(wv_x)) +
                      real::abs(u.y) * (real::abs(vw_y) + real::abs(wv_y)) +
                      real::abs(u.z) * (real::abs(vw_z) + real::abs(wv_z));
  const S bound = S(4) * real::epsilon<S>() * permanent;  // (7 + 56 e) e of Shewchuk's table, e = epsilon / 2
  if (determinant > bound || determinant < -bound) return sign_of(determinant);
  if constexpr (sizeof(S) == sizeof(float)) {
    const auto widened = [](const Vec3<S>& x) { return Vec3<double>{x.x, x.y, x.z}; };
    return orient3d_exact(widened(a), widened(b), widened(c), widened(d));
  }
  return orient3d_exact(a, b, c, d);
}

template <class S> int orient2d(const std::array<S, 2>& a, const std::array<S, 2>& b, const std::array<S, 2>& c) {
  const S left = (a[0] - c[0]) * (b[1] - c[1]), right = (a[1] - c[1]) * (b[0] - c[0]), determinant = left - right;
  const S bound = S(2) * real::epsilon<S>() * (real::abs(left) + real::abs(right));
  if (determinant > bound || determinant < -bound) return sign_of(determinant);
  Expansion<S> sum;
  add_product(sum, Difference<S>(a[0], c[0]), Difference<S>(b[1], c[1]), S(1));
  add_product(sum, Difference<S>(a[1], c[1]), Difference<S>(b[0], c[0]), S(-1));
  return sum.sign();
}

template <class S> bool triangles_intersect(const Corners<S>& p, const Corners<S>& q) {
  std::array<int, 3> side_p, side_q;
  for (int k = 0; k < 3; ++k) side_p[k] = orient3d(q[0], q[1], q[2], p[k]);
  const auto one_side = [](const std::array<int, 3>& s) { return s[0] != 0 && s[0] == s[1] && s[0] == s[2]; };
  if (one_side(side_p)) return false;
  for (int k = 0; k < 3; ++k) side_q[k] = orient3d(p[0], p[1], p[2], q[k]);
  if (one_side(side_q)) return false;
  const auto flat = [](const std::array<int, 3>& s) { return s[0] == 0 && s[1] == 0 && s[2] == 0; };
  if (flat(side_p) && flat(side_q)) return coplanar_triangles_meet(p, q);
  return edges_meet(p, side_p, q) || edges_meet(q, side_q, p);
}

#define ATWOOD_PREDICATES(S)                                                                           \
  template int orient3d<S>(const Vec3<S>&, const Vec3<S>&, const Vec3<S>&, const Vec3<S>&);            \
  template int orient2d<S>(const std::array<S, 2>&, const std::array<S, 2>&, const std::array<S, 2>&); \
  template bool triangles_intersect<S>(const Corners<S>&, const Corners<S>&);
ATWOOD_PREDICATES(float)
ATWOOD_PREDICATES(double)
ATWOOD_PREDICATES(long double)
#undef ATWOOD_PREDICATES

}  // namespace atwood
