#include "joints/mass_matrix.hpp"

namespace atwood {
namespace {

// A rigid body about a point A: its mass, m times the way from A to its centre, its inertia about A.
template <class S> struct Composite {
  S mass{};
  Vec3<S> first;
  Sym3<S> J;
};

// The same about a point from which A is at d, added: J' = J + (2 h . d + m d^2) 1 - h d^T - d h^T - m d d^T.
template <class S> void add_about(const Composite<S>& of, const Vec3<S>& d, Composite<S>& to) {
  const Vec3<S> e = S(2) * of.first + of.mass * d;  // h d^T + d h^T + m d d^T = (e d^T + d e^T) / 2
  const S trace = dot(e, d), half = S(0.5);
  to.mass += of.mass;
  to.first += of.first + of.mass * d;
  to.J += of.J;
  to.J += Sym3<S>{trace - e.x * d.x, -half * (e.x * d.y + d.x * e.y), -half * (e.x * d.z + d.x * e.z),
                  trace - e.y * d.y, -half * (e.y * d.z + d.y * e.z), trace - e.z * d.z};
}

}  // namespace

template <class S> std::vector<S> mass_matrix(const Tree<S>& tree) {
  const auto& links = tree.links();
  const int count = static_cast<int>(links.size()), n = tree.rate_count();
  std::vector<Composite<S>> composite(links.size());
  for (int i = count - 1; i >= 0; --i) {  // a link's own children have been added
    const LinkMotion<S>& m = tree.motion(i);
    const Composite<S> own{links[i].mass_kg, links[i].mass_kg * m.r, rotated(m.R_WB, links[i].J_B)};
    add_about(own, Vec3<S>{}, composite[i]);
    if (links[i].parent >= 0) add_about(composite[i], m.d, composite[links[i].parent]);
  }
  std::vector<S> M(static_cast<std::size_t>(n) * n, S(0));
  for (int i = 0; i < count; ++i)
    for (int k = links[i].first_rate; k < links[i].first_rate + links[i].rates; ++k) {
      const Column<S>& column = tree.column(k);
      const Composite<S>& c = composite[i];
      // The wrench about A that accelerates the composite body by a unit of this rate.
      Vec3<S> force = column.angular ? cross(column.s, c.first) : c.mass * column.s;
      Vec3<S> moment = column.angular ? c.J * column.s : cross(c.first, column.s);
      for (int j = i; j >= 0; j = links[j].parent) {
        for (int l = links[j].first_rate; l < links[j].first_rate + links[j].rates; ++l) {
          const Column<S>& other = tree.column(l);
          M[static_cast<std::size_t>(k) * n + l] = M[static_cast<std::size_t>(l) * n + k] =
              dot(other.s, other.angular ? moment : force);
        }
        moment += cross(tree.motion(j).d, force);
      }
    }
  return M;
}

template std::vector<float> mass_matrix(const Tree<float>&);
template std::vector<double> mass_matrix(const Tree<double>&);
template std::vector<long double> mass_matrix(const Tree<long double>&);
template std::vector<Quad> mass_matrix(const Tree<Quad>&);

}  // namespace atwood
