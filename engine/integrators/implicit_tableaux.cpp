#include "integrators/implicit_tableaux.hpp"

// clang-format off: the rows of tables stand as they are printed in their sources

namespace atwood {
namespace {

Quad ratio(int a, int b) { return Quad(a) / Quad(b); }

}  // namespace

// 0 | 0    0
// 1 | 1/2  1/2
CollocationTableau trapezoid_tableau() {
  return {2, {Quad(0), Quad(1)}, {ratio(1, 2), ratio(1, 2)}, {Quad(0), Quad(0), ratio(1, 2), ratio(1, 2)}};
}

// g | g          g = 1 - 1/sqrt 2: a root of g^2 - 2 g + 1/2, where order 2 and damping at infinity meet
// 1 | 1 - g  g
CollocationTableau sdirk2_tableau() {
  const Quad g = Quad(1) - real::sqrt(ratio(1, 2));
  return {2, {g, Quad(1)}, {Quad(1) - g, g}, {g, Quad(0), Quad(1) - g, g}};
}

CollocationTableau sdirk4_tableau() {
  const Quad g = ratio(1, 4), o = Quad(0);
  const std::vector<Quad> last{ratio(25, 24), ratio(-49, 48), ratio(125, 16), ratio(-85, 12), g};
  CollocationTableau t{5,
                       {g, ratio(3, 4), ratio(11, 20), ratio(1, 2), Quad(1)},
                       last,
                       {g,
                        o,
                        o,
                        o,
                        o,
                        ratio(1, 2),
                        g,
                        o,
                        o,
                        o,
                        ratio(17, 50),
                        ratio(-1, 25),
                        g,
                        o,
                        o,
                        ratio(371, 1360),
                        ratio(-137, 2720),
                        ratio(15, 544),
                        g,
                        o}};
  t.a.insert(t.a.end(), last.begin(), last.end());
  return t;
}

}  // namespace atwood
