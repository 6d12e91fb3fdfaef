// The tables of kicks and drifts before any physics: order conditions in quad, symmetry, sums.
#include "integrators/compositions.hpp"

#include <catch2/catch.hpp>
#include <cmath>

namespace atwood {
namespace {

// A series in two letters that do not commute: the coefficient of each word, by length, the word's letters as bits.
// A splitting is of order p where the product of its exponentials is exp(A + B) on every word of up to p letters.
using Series = std::vector<std::vector<Quad>>;

Series one(int longest) {
  Series s;
  for (int n = 0; n <= longest; ++n) s.emplace_back(std::size_t(1) << n);
  s[0][0] = 1;
  return s;
}

Series times_exponential(const Series& s, int letter, Quad c, std::size_t letters = 2) {
  Series product = s;
  for (std::size_t n = 0; n < s.size(); ++n)
    for (std::size_t word = 0; word < s[n].size(); ++word) {
      Quad coefficient = s[n][word];
      std::size_t longer = word;
      for (std::size_t k = 1; n + k < s.size(); ++k) {
        coefficient *= c / Quad(k);
        longer = letters * longer + letter;
        product[n + k][longer] += coefficient;
      }
    }
  return product;
}

double misfit(const Series& s, int length) {
  Quad wanted = 1;
  for (int n = 1; n <= length; ++n) wanted /= n;
  double worst = 0;
  for (const Quad coefficient : s[length])
    worst = std::max(worst, std::fabs(static_cast<double>(coefficient - wanted)));
  return worst;
}

TEST_CASE("every composition meets the order conditions of its order, and no more") {
  for (const Composition& composition : compositions()) {
    INFO(composition.id);
    Series s = one(composition.order + 1);
    for (const Substep& substep : composition.substeps())
      s = times_exponential(s, substep.kick, substep.direct + substep.adjoint);
    for (int n = 1; n <= composition.order; ++n) CHECK(misfit(s, n) < 1e-30);
    CHECK(misfit(s, composition.order + 1) > 1e-9);
  }
}

// The parts, not their sums: chi and chi* of fractions c1, c2, ... alternately, for a chi of three flows, A then B then
// C. Its leapfrogs are symmetric of order 2, and every list is of its order for three flows that do not commute either.
TEST_CASE("the parts of each substep keep the order for a map of order 1 and its adjoint") {
  for (const Composition& composition : compositions()) {
    if (composition.order > 6) continue;  // 3^8 words
    INFO(composition.id);
    // Words in three letters, as above: a direct drift is the flows 1, 2 in turn, its adjoint 2, 1; a kick is the flow
    // 0.
    const int longest = composition.order + 1;
    std::vector<std::vector<Quad>> s;
    for (std::size_t n = 0, size = 1; n <= static_cast<std::size_t>(longest); ++n, size *= 3) s.emplace_back(size);
    s[0][0] = 1;
    const auto flow = [&](int letter, Quad c) { s = times_exponential(s, letter, c, 3); };
    for (const Substep& substep : composition.substeps()) {
      if (substep.kick) {
        flow(0, substep.direct + substep.adjoint);
      } else {
        flow(1, substep.direct);
        flow(2, substep.direct + substep.adjoint);
        flow(1, substep.adjoint);
      }
    }
    for (int n = 1; n <= composition.order; ++n) {
      Quad wanted = 1;
      for (int k = 1; k <= n; ++k) wanted /= k;
      double worst = 0;
      for (const Quad coefficient : s[n]) worst = std::max(worst, std::fabs(static_cast<double>(coefficient - wanted)));
      CHECK(worst < 1e-30);
    }
  }
}

TEST_CASE("compositions of even order are symmetric: backwards, the parts change places") {
  for (const Composition& composition : compositions()) {
    if (composition.order == 1) continue;
    INFO(composition.id);
    const std::vector<Substep> substeps = composition.substeps();
    for (std::size_t i = 0; i < substeps.size(); ++i) {
      const Substep &a = substeps[i], &b = substeps[substeps.size() - 1 - i];
      CHECK(a.kick == b.kick);
      CHECK(std::fabs(static_cast<double>(a.direct - b.adjoint)) < 1e-32);
    }
  }
}

TEST_CASE("each composition has the published number of kicks per step") {
  const auto kicks = [](const char* id) {
    int count = 0;
    for (const Substep& substep : find_composition(id)->substeps()) count += substep.kick;
    return count;
  };
  CHECK(kicks("forest-ruth") == 3);
  CHECK(kicks("yoshida4") == 4);
  CHECK(kicks("pefrl") == 4);
  CHECK(kicks("mclachlan4") == 5);
  CHECK(kicks("suzuki4") == 5);
  CHECK(kicks("blanes-moan4") == 6);
  CHECK(kicks("yoshida6") == 7);
  CHECK(kicks("kahan-li6") == 9);
  CHECK(kicks("blanes-moan6") == 11);
  CHECK(kicks("blanes-moan4-kicks-first") == 7);
  CHECK(kicks("yoshida8") == 15);
  CHECK(kicks("kahan-li8") == 17);
  CHECK(kicks("suzuki6") == 25);
  CHECK(kicks("suzuki8") == 125);
  CHECK(find_composition("rk4") == nullptr);
}

}  // namespace
}  // namespace atwood
