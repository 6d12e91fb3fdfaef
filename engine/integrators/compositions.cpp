#include "integrators/compositions.hpp"

#include <initializer_list>
#include <stdexcept>

#include "protocol/sample.hpp"

// clang-format off: the rows of tables stand as they are printed in their sources

namespace atwood {
namespace {

using Fractions = std::vector<Quad>;

// Coefficients published with 15 to 25 digits were refined to quad precision by Newton's method on their order
// conditions (with the least change where the conditions leave a parameter free).
Fractions digits(std::initializer_list<const char*> texts) {
  Fractions values;
  for (const char* text : texts) values.push_back(parse_wide(text));
  return values;
}

// ---- c1, c2, ... alternately of chi and chi*. `kick_first`: chi is first.
std::vector<Substep> chain(const Fractions& c, bool kick_first) {
  std::vector<Substep> all{{kick_first, kick_first ? c[0] : Quad(0), kick_first ? Quad(0) : c[0]}};
  bool kick = !kick_first, direct = kick_first;
  for (std::size_t i = 0; i < c.size(); ++i, kick = !kick, direct = !direct) {
    const Quad next = i + 1 < c.size() ? c[i + 1] : Quad(0);
    all.push_back({kick, direct ? c[i] : next, direct ? next : c[i]});
  }
  return all;
}

// Alternating fractions of kicks and drifts, as the papers print them.
std::vector<Substep> splitting(const Fractions& whole, bool kick_first) {
  Fractions c{whole[0]};
  for (std::size_t i = 1; i + 1 < whole.size(); ++i) c.push_back(whole[i] - c.back());
  return chain(c, kick_first);
}

// A symmetric list from its first half, without the middle entries: they follow because each kind of fraction sums to
// 1.
Fractions palindrome(const Fractions& half, std::size_t size) {
  Fractions all(size);
  for (std::size_t i = 0; i < size; ++i) all[i] = half[i < size - 1 - i ? i : size - 1 - i];
  return all;
}

// ---- compositions of the leapfrog drift g/2, kick g, drift g/2, symmetric and of order 2
std::vector<Substep> leapfrogs(const Fractions& steps) {
  Fractions c;
  for (const Quad g : steps) c.insert(c.end(), {g / 2, g / 2});
  return chain(c, false);
}

// From the outer fractions; the middle one makes the sum 1.
std::vector<Substep> symmetric_leapfrogs(Fractions outer) {
  Quad middle = 1;
  for (const Quad g : outer) middle -= 2 * g;
  outer.push_back(middle);
  return leapfrogs(palindrome(outer, 2 * outer.size() - 1));
}

// x^(1/n), by Newton from 1; x in [1, 5].
Quad root(Quad x, int n) {
  Quad r = 1, change = 1;
  for (int k = 0; k < 60; ++k) {
    Quad power = 1;
    for (int i = 1; i < n; ++i) power *= r;
    change = (x / power - r) / n;
    r += change;
  }
  if (!(real::abs(change) <= 4 * real::epsilon<Quad>() * r)) throw std::logic_error("Newton's method found no root");
  return r;
}

// Each step of an even order p as n steps, the middle one backwards, which makes p + 2: g, ..., 1 - (n - 1) g, ..., g
// with (n - 1) g^(p + 1) + (1 - (n - 1) g)^(p + 1) = 0.
Fractions raised(const Fractions& steps, int p, int n) {
  const Quad g = 1 / (n - 1 - root(n - 1, p + 1));
  Fractions all;
  for (int k = 0; k < n; ++k)
    for (const Quad s : steps) all.push_back((2 * k + 1 == n ? 1 - (n - 1) * g : g) * s);
  return all;
}
Fractions suzuki(int order) { return order == 2 ? Fractions{1} : raised(suzuki(order - 2), order - 2, 5); }

std::vector<Substep> symplectic_euler() { return {{true, 1, 0}, {false, 1, 0}}; }

// Both kicks use the midpoint rule where forces depend on velocity, so that the step is symmetric.
std::vector<Substep> kick_drift_kick() {
  const Quad half = Quad(1) / 2, quarter = half / 2;
  return {{true, quarter, quarter}, {false, half, half}, {true, quarter, quarter}};
}
std::vector<Substep> drift_kick_drift() { return leapfrogs({1}); }

// Forest and Ruth, Physica D 43 (1990) 105: drifts first.
std::vector<Substep> forest_ruth() {
  const Quad theta = 1 / (2 - root(2, 3));
  return splitting({theta / 2, theta, (1 - theta) / 2, 1 - 2 * theta, (1 - theta) / 2, theta, theta / 2}, false);
}
// Yoshida's triple jump with the other leapfrog: kicks first.
std::vector<Substep> yoshida4() {
  const Quad w = 1 / (2 - root(2, 3));
  return splitting({w / 2, w, (1 - w) / 2, 1 - 2 * w, (1 - w) / 2, w, w / 2}, true);
}

std::vector<Substep> pefrl() {
  const Fractions p = digits({"0.178617895844809067059903767081192936784",      // xi
                              "-0.212341831062605403831890458068840392784",     // lambda
                              "-0.0662645826698184962780156217646028425379"});  // chi
  const Quad xi = p[0], lambda = p[1], chi = p[2], outer = (1 - 2 * lambda) / 2, middle = 1 - 2 * (chi + xi);
  return splitting({xi, outer, chi, lambda, middle, lambda, chi, outer, xi}, false);
}

// alpha and beta in closed form: order 4 for any chi.
std::vector<Substep> mclachlan4() {
  const Quad s = real::sqrt(Quad(19));
  const Fractions half{(14 - s) / 108, (146 + 5 * s) / 540, (-23 - 20 * s) / 270, (-2 + 10 * s) / 135, Quad(1) / 5};
  return chain(palindrome(half, 10), false);
}

// a1 b1 a2 ...; the middle fractions follow because each kind sums to 1. `kick_first`: a are kicks.
std::vector<Substep> blanes_moan(Fractions a, Fractions b, bool kick_first) {
  Quad a_middle = 1, b_middle = Quad(1) / 2;
  for (const Quad x : a) a_middle -= 2 * x;
  for (const Quad x : b) b_middle -= x;
  a.push_back(a_middle);
  b.push_back(b_middle);
  Fractions whole;
  for (std::size_t i = 0; i < a.size(); ++i) {
    whole.push_back(a[i]);
    if (i < b.size()) whole.push_back(b[i]);
  }
  return splitting(palindrome(whole, 2 * whole.size() - 1), kick_first);
}

// The a of the table are kicks if kicks come first, else drifts: the order conditions are the same. S6 has smaller
// errors with drifts first for points, and with kicks first (and one drift less) for the splitting of the free top.
std::vector<Substep> blanes_moan_s6(bool kick_first) {
  return blanes_moan(
      digits({"0.0792036964311956694336634958882688733080", "0.353172906049773988481061311573121056530",
              "-0.0420650803577195353681102983025170387204"}),
      digits({"0.209515106613362021274072640029501016902", "-0.143851773179818008275115057856527725648"}), kick_first);
}
std::vector<Substep> blanes_moan4() { return blanes_moan_s6(false); }
std::vector<Substep> blanes_moan4_kicks_first() { return blanes_moan_s6(true); }
std::vector<Substep> blanes_moan6() {
  return blanes_moan(
      digits({"0.0502627644003926860212216544020741094060", "0.413514300428343815063063720133884438975",
              "0.0450798897943980629688970521245134711617", "-0.188054853819568914799128488918870542488",
              "0.541960678450780134831414740933072496348"}),
      digits({"0.148816447901043231920901005535577588877", "-0.132385865767783647448845426598939921574",
              "0.0673076046921844581502578965926010468994", "0.432666402578173597527667970883545298058"}),
      true);
}

std::vector<Substep> yoshida6() {
  return symmetric_leapfrogs(
      digits({"0.784513610477557263819497633866349875777", "0.235573213359358133684793182978534601686",
              "-1.17767998417887100694641568096431573464"}));
}
std::vector<Substep> yoshida8() {
  return symmetric_leapfrogs(
      digits({"0.914844246229791566748793489847509604518", "0.253693336566211354146146020689942076098",
              "-1.44485223686060515769473065753739035496", "-0.158240635368050175204066776759754247755",
              "1.93813913762252598657918648744364176096", "-1.96061023297531080760763337639966364079",
              "0.102799849391796440698115131601225862911"}));
}

std::vector<Substep> kahan_li6() {
  return symmetric_leapfrogs(
      digits({"0.392161444007314139279250557422671403805", "0.332599136789359438599748637500049646882",
              "-0.706246172557639359809964819549256459396", "0.0822135962935508002314904481020563311033"}));
}
std::vector<Substep> kahan_li8() {
  return symmetric_leapfrogs(
      digits({"0.130202483088890080878817632096700522357", "0.561162981775108384561964407700150567266",
              "-0.389474962644847286408078598235248388836", "0.158841906555155600896210745707152481412",
              "-0.395903894133237577336231539347938936027", "0.184539640978315707091832541533375462819",
              "0.258374387686322047293979109994939471813", "0.295011723609310298870966240218228112977"}));
}
std::vector<Substep> suzuki4() { return leapfrogs(suzuki(4)); }
std::vector<Substep> suzuki6() { return leapfrogs(suzuki(6)); }
std::vector<Substep> suzuki8() { return leapfrogs(suzuki(8)); }

}  // namespace

const std::vector<Composition>& compositions() {
  static const std::vector<Composition> all{{"symplectic-euler", 1, symplectic_euler},
                                            {"leapfrog-kdk", 2, kick_drift_kick},
                                            {"leapfrog-dkd", 2, drift_kick_drift},
                                            {"forest-ruth", 4, forest_ruth},
                                            {"pefrl", 4, pefrl},
                                            {"mclachlan4", 4, mclachlan4},
                                            {"suzuki4", 4, suzuki4},
                                            {"suzuki6", 6, suzuki6},
                                            {"suzuki8", 8, suzuki8},
                                            {"yoshida4", 4, yoshida4},
                                            {"yoshida6", 6, yoshida6},
                                            {"yoshida8", 8, yoshida8},
                                            {"blanes-moan4", 4, blanes_moan4},
                                            {"blanes-moan4-kicks-first", 4, blanes_moan4_kicks_first},
                                            {"blanes-moan6", 6, blanes_moan6},
                                            {"kahan-li6", 6, kahan_li6},
                                            {"kahan-li8", 8, kahan_li8}};
  return all;
}

const Composition* find_composition(const std::string& id) {
  for (const Composition& composition : compositions())
    if (composition.id == id) return &composition;
  return nullptr;
}

}  // namespace atwood
