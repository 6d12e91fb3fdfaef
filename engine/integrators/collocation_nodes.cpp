#include "integrators/collocation_nodes.hpp"

#include <algorithm>
#include <map>
#include <mutex>
#include <stdexcept>
#include <utility>

namespace atwood {
namespace {

struct Value {
  Quad p, slope;
};

// P_s + mix P_(s-1) at x in [-1, 1], and its derivative:
//   n P_n = (2n - 1) x P_(n-1) - (n - 1) P_(n-2),   P_n' = n P_(n-1) + x P_(n-1)'
Value legendre_sum(int s, int mix, Quad x) {
  Value before{Quad(1), Quad(0)}, now{x, Quad(1)};
  for (int n = 2; n <= s; ++n) {
    const Value next{(Quad(2 * n - 1) * x * now.p - Quad(n - 1) * before.p) / Quad(n), Quad(n) * now.p + x * now.slope};
    before = now;
    now = next;
  }
  return {now.p + Quad(mix) * before.p, now.slope + Quad(mix) * before.slope};
}

// Every zero is real. Newton's method from the right of all zeros descends to the largest; dividing the polynomial by
// the zeros already found (Maehly) makes the next one the largest. A few plain Newton steps then remove that division's
// round-off. Radau's zero at -1 or 1 is set exactly, and Gauss's zeros pairwise opposite.
std::vector<Quad> zeros(int s, int mix) {
  std::vector<Quad> found;
  for (int k = 0; k < s; ++k) {
    Quad x = Quad(1.25);
    for (int n = 0;; ++n) {
      if (n == 400) throw std::logic_error("a zero of Legendre's polynomial was not found");
      const Value v = legendre_sum(s, mix, x);
      Quad pole = Quad(0);
      for (const Quad& zero : found) pole += Quad(1) / (x - zero);
      const Quad change = v.p / (v.slope - v.p * pole);
      x -= change;
      if (real::abs(change) < Quad(1e-20)) break;
    }
    for (int n = 0; n < 3; ++n) {
      const Value v = legendre_sum(s, mix, x);
      x -= v.p / v.slope;
    }
    found.push_back(x);
  }
  std::sort(found.begin(), found.end());
  if (mix < 0) found.back() = Quad(1);
  if (mix > 0) found.front() = Quad(-1);
  if (mix == 0)
    for (int k = 0; 2 * k < s; ++k) {
      const Quad half = (found[s - 1 - k] - found[k]) / Quad(2);
      found[s - 1 - k] = half;
      found[k] = -half;
    }
  return found;
}

// The integral of the Lagrange polynomial l_j of the nodes c from 0 to `end`, by Gauss's formula with points x in
// [-1, 1] (exact: degree s - 1 <= 2 s - 1) and weights w that sum to 2. The product form of l_j loses no digits.
Quad integral(const std::vector<Quad>& c, int j, Quad end, const std::vector<Quad>& x, const std::vector<Quad>& w) {
  const int s = static_cast<int>(c.size());
  Quad total = Quad(0);
  for (int k = 0; k < s; ++k) {
    const Quad at = end * (Quad(1) + x[k]) / Quad(2);
    Quad value = w[k];
    for (int m = 0; m < s; ++m)
      if (m != j) value *= (at - c[m]) / (c[j] - c[m]);
    total += value;
  }
  return total * end / Quad(2);
}

CollocationTableau make_collocation(int s, int mix) {
  const std::vector<Quad> x = zeros(s, 0);
  std::vector<Quad> w(s);  // w_k = 2 / ((1 - x_k^2) P_s'(x_k)^2)   (Abramowitz, Stegun, 25.4.29)
  for (int k = 0; k < s; ++k) {
    const Quad slope = legendre_sum(s, 0, x[k]).slope;
    w[k] = Quad(2) / ((Quad(1) - x[k]) * (Quad(1) + x[k]) * slope * slope);
  }
  CollocationTableau tableau{s, zeros(s, mix), {}, {}};
  for (Quad& c : tableau.c) c = (Quad(1) + c) / Quad(2);
  for (int i = 0; i < s; ++i)
    for (int j = 0; j < s; ++j) tableau.a.push_back(integral(tableau.c, j, tableau.c[i], x, w));
  for (int j = 0; j < s; ++j) tableau.b.push_back(integral(tableau.c, j, Quad(1), x, w));
  return tableau;
}

// Each table is made once a process, by the first run whose method needs it: every run makes its stepper anew, and
// Newton's method in quad takes longer than a short run.
CollocationTableau collocation(int s, int mix) {
  static std::mutex one_at_a_time;
  static std::map<std::pair<int, int>, CollocationTableau> made;
  const std::lock_guard<std::mutex> lock(one_at_a_time);
  auto place = made.find({s, mix});
  if (place == made.end()) place = made.emplace(std::pair{s, mix}, make_collocation(s, mix)).first;
  return place->second;
}

}  // namespace

CollocationTableau gauss_collocation(int stages) { return collocation(stages, 0); }
CollocationTableau radau_right_collocation(int stages) { return collocation(stages, -1); }
CollocationTableau radau_left_collocation(int stages) { return collocation(stages, 1); }

}  // namespace atwood
