// The two implicit discrete tops: each solves one vector equation for the Cayley vector of the step.
#include "rigid/free_top.hpp"

namespace atwood {
namespace {

template <class S> Vec3<S> times(const Vec3<S>& I, const Vec3<S>& c) { return {I.x * c.x, I.y * c.y, I.z * c.z}; }

template <class S> Vec3<S> solve3(const Vec3<S> (&column)[3], const Vec3<S>& b) {  // Cramer
  const Vec3<S> yz = cross(column[1], column[2]);
  const S determinant = dot(column[0], yz);
  return (S(1) / determinant) *
         Vec3<S>{dot(b, yz), dot(column[0], cross(b, column[2])), dot(column[0], cross(column[1], b))};
}

}  // namespace

// The step rotates the body by F = cay(c), c = tan(theta / 2) n, and L_new = F^T L. With g = h L / 2:
//   midpoint        I c + c x I c = g                  from  L_m = L + h/2 L_m x w_m, c = h/2 w_m
//   Moser-Veselov   I c + c x I c = g (1 + |c|^2)      from  h L^ = F J - J F^T, J = tr(I)/2 - I
// solved by Newton's method from c = I^-1 g until round-off stops it.
template <class S> bool implicit_turn(FreeTop top, const Vec3<S>& I, S h_s, const Vec3<S>& L, FreeTurn<S>& turn) {
  const Vec3<S> g = (h_s / S(2)) * L;
  const S bend = top == FreeTop::moser_veselov ? S(1) : S(0);
  Vec3<S> c{g.x / I.x, g.y / I.y, g.z / I.z};
  bool solved = false;
  S before = S(1e30f);
  for (int k = 0; k < 60 && !solved; ++k) {
    const Vec3<S> Ic = times(I, c);
    const Vec3<S> residual = Ic + cross(c, Ic) - (S(1) + bend * dot(c, c)) * g;
    Vec3<S> column[3];  // d/dc_j: I_j e_j + e_j x I c + c x I_j e_j - 2 bend c_j g
    for (int j = 0; j < 3; ++j) {
      Vec3<S> e;
      (&e.x)[j] = S(1);
      const S I_j = (&I.x)[j];
      column[j] = I_j * e + cross(e, Ic) + I_j * cross(c, e) - (S(2) * bend * (&c.x)[j]) * g;
    }
    const Vec3<S> change = solve3(column, residual);
    c -= change;
    const S now = norm(change), size = norm(c);
    turn.solve = {k + 1, static_cast<double>(size > S(0) ? now / size : now), SolveEnd::capped};
    if (!real::is_finite(now)) return false;
    const bool converged = now <= S(2) * real::epsilon<S>() * size;
    solved = converged || (now <= S(256) * real::epsilon<S>() * size && now >= before / S(2));
    if (solved) turn.solve.ended = converged ? SolveEnd::converged : SolveEnd::stagnated;
    before = now;
  }
  const S square = dot(c, c), length = real::sqrt(S(1) + square);
  const S w = S(1) / length;
  const Vec3<S> u = w * c, uL = cross(u, L);
  turn.minus_one = {-square / (length * (S(1) + length)), u.x, u.y, u.z};
  turn.dw_B = S(2) * (cross(u, uL) - w * uL);
  return solved;
}

template bool implicit_turn<float>(FreeTop, const Vec3<float>&, float, const Vec3<float>&, FreeTurn<float>&);
template bool implicit_turn<double>(FreeTop, const Vec3<double>&, double, const Vec3<double>&, FreeTurn<double>&);
template bool implicit_turn<long double>(FreeTop, const Vec3<long double>&, long double, const Vec3<long double>&,
                                         FreeTurn<long double>&);
template bool implicit_turn<Quad>(FreeTop, const Vec3<Quad>&, Quad, const Vec3<Quad>&, FreeTurn<Quad>&);

}  // namespace atwood
