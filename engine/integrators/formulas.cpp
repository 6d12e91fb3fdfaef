// Notation. y' = f(t, y): the equations of motion; y, y_new: the state before and after a step of length h. p, v:
// positions and velocities, p' = v, v' = a(t, p). exp, R, F: rotations in body axes, applied on the right of the
// quaternion q. Maps are written in the order in which they are applied, the first one on the left.
#include "integrators/formulas.hpp"

#include <map>
#include <stdexcept>
#include <vector>

namespace atwood {
namespace {

const std::string stages = "k_i = f(t + c_i h, y + h sum_{j<i} a_ij k_j), y_new = y + h sum_i b_i k_i";
const std::string table = ", with c, a and b of the source's table";
const std::string pair = stages + ", error h sum_i (b_i - b^_i) k_i" + table;
const std::string collocation =
    "k_i = f(t + c_i h, y + h sum_j a_ij k_j), y_new = y + h sum_i b_i k_i, a_ij = int_0^c_i l_j(s) ds, b_j = int_0^1 "
    "l_j(s) ds, l_j Lagrange's polynomials of the nodes c";
const std::string nystrom_pair =
    "k_i = a(t + c_i h, p + c_i h v + h^2 sum_{j<i} a_ij k_j), p_new = p + h v + h^2 sum_i b_i k_i, v_new = v + h sum_i "
    "b'_i k_i, errors h^2 sum_i (b_i - b^_i) k_i and h sum_i (b'_i - b^'_i) k_i";
const std::string maps = "; D(s): p += s v, K(s): v += s a(t, p)";
const std::string leapfrog = "; S(s) = D(s/2) K(s) D(s/2), D(s): p += s v, K(s): v += s a(t, p)";
const std::string kick_drift_kick =
    "v_half = v + h/2 a(t, p), p_new = p + h v_half, v_new = v_half + h/2 a(t + h, p_new)";
const std::string drift_kick_drift = "p_half = p + h/2 v, v_new = v + h a(t + h/2, p_half), p_new = p_half + h/2 v_new";
const std::string suzuki_g = "g = 1 / (4 - 4^(1/3))";
const std::string nine =
    "(w_4 h) {0}(w_3 h) {0}(w_2 h) {0}(w_1 h) {0}(w_0 h) {0}(w_1 h) {0}(w_2 h) {0}(w_3 h) {0}(w_4 h), w_0 = 1 - 2 (w_1 + "
    "w_2 + w_3 + w_4), w_4 = 0.392161444007314, w_3 = 0.332599136789359, w_2 = -0.706246172557639, w_1 = "
    "0.0822135962935508";
const std::string split_top =
    "; R_i(s): rotation of the body about its principal axis i by s L_i / I_i, and D(s) for its centre; K(s): v += s a, L "
    "+= s torque";
const std::string s6 =
    "a_1 = 0.0792036964311957, a_2 = 0.353172906049774, a_3 = -0.0420650803577195, a_4 = 1 - 2 (a_1 + a_2 + a_3), b_1 = "
    "0.209515106613362, b_2 = -0.143851773179818, b_3 = 1/2 - b_1 - b_2";
const std::string s10 =
    "a_1 = 0.0502627644003927, a_2 = 0.413514300428344, a_3 = 0.0450798897943981, a_4 = -0.188054853819569, a_5 = "
    "0.541960678450780, a_6 = 1 - 2 (a_1 + ... + a_5), b_1 = 0.148816447901042, b_2 = -0.132385865767784, b_3 = "
    "0.0673076046921845, b_4 = 0.432666402578174, b_5 = 1/2 - (b_1 + ... + b_4)";
const std::string exact_top =
    "; E(s): the exact flow of L' = L x I^-1 L, q' = q (0, I^-1 L) / 2 and p' = v, in which L_1, L_2, L_3 are multiples of "
    "cn, sn, dn; K(s): v += s a, L += s torque";
const std::string boris =
    "p_half = p + h/2 v, v_minus = v + h q E / 2 m, b = h q B / 2 m, v_plus = v_minus + 2 / (1 + |b|^2) (v_minus + v_minus x "
    "b) x b, v_new = v_plus + h q E / 2 m, p_new = p_half + h/2 v_new";
const std::string rattle =
    "M v_half = M v + h/2 (F(p) - G(p)^T lambda), p_new = p + h v_half, g(p_new) = 0, M v_new = M v_half + h/2 (F(p_new) - "
    "G(p_new)^T mu), G(p_new) v_new = 0, with the constraints g and G = dg/dp";
const std::string radau_nodes = ", c the zeros of P_7(2 c - 1) + P_8(2 c - 1), the first of which is 0";

// "S(w_4 h) S(w_3 h) ...": Kahan and Li's nine steps of the map that `letter` names.
std::string nine_of(const std::string& letter) {
  std::string text = letter + nine;
  for (std::size_t at = text.find("{0}"); at != std::string::npos; at = text.find("{0}")) text.replace(at, 3, letter);
  return text;
}
std::string five_of(const std::string& letter) {
  return letter + "(g h)^2 " + letter + "((1 - 4 g) h) " + letter + "(g h)^2, ";
}

const std::map<std::string, std::string>& explicit_formulas() {
  static const std::map<std::string, std::string> all{
      {"explicit-euler", "y_new = y + h f(t, y)"},
      {"midpoint", "k_1 = f(t, y), y_new = y + h f(t + h/2, y + h/2 k_1)"},
      {"heun", "k_1 = f(t, y), k_2 = f(t + h, y + h k_1), y_new = y + h (k_1 + k_2) / 2"},
      {"ralston2", "k_1 = f(t, y), k_2 = f(t + 2/3 h, y + 2/3 h k_1), y_new = y + h (k_1 + 3 k_2) / 4"},
      {"kutta3",
       "k_1 = f(t, y), k_2 = f(t + h/2, y + h/2 k_1), k_3 = f(t + h, y + h (2 k_2 - k_1)), y_new = y + h (k_1 + 4 k_2 + "
       "k_3) / 6"},
      {"rk4",
       "k_1 = f(t, y), k_2 = f(t + h/2, y + h/2 k_1), k_3 = f(t + h/2, y + h/2 k_2), k_4 = f(t + h, y + h k_3), y_new = y + "
       "h (k_1 + 2 k_2 + 2 k_3 + k_4) / 6"},
      {"rk38",
       "k_1 = f(t, y), k_2 = f(t + h/3, y + h/3 k_1), k_3 = f(t + 2/3 h, y + h (k_2 - k_1 / 3)), k_4 = f(t + h, y + h (k_1 - "
       "k_2 + k_3)), y_new = y + h (k_1 + 3 k_2 + 3 k_3 + k_4) / 8"},
      {"bogacki-shampine3",
       "k_1 = f(t, y), k_2 = f(t + h/2, y + h/2 k_1), k_3 = f(t + 3/4 h, y + 3/4 h k_2), y_new = y + h (2 k_1 + 3 k_2 + 4 "
       "k_3) / 9, k_4 = f(t + h, y_new), error h (-5 k_1 + 6 k_2 + 8 k_3 - 9 k_4) / 72"},
      {"rkf45", pair},
      {"cash-karp5", pair},
      {"dopri5", pair},
      {"tsit5", pair},
      {"verner6", pair},
      {"rkf78", pair + "; the error is h 41/840 (k_1 + k_11 - k_12 - k_13)"},
      {"verner8", pair},
      {"dop853", stages + table + "; error e_5^2 / sqrt(e_5^2 + e_3^2 / 100) of the estimates e_5 and e_3"},
      {"verner9", pair},
      {"dprkn6", nystrom_pair + table},
      {"dprkn12", nystrom_pair + table},
      {"blanes-moan-rkn4",
       "K(b_1 h) D(a_1 h) K(b_2 h) ... D(a_6 h) K(b_7 h), a_i = a_(7-i), b_i = b_(8-i) of the source's table" + maps},
      {"blanes-moan-rkn6",
       "D(a_1 h) K(b_1 h) D(a_2 h) ... K(b_14 h) D(a_15 h), a_i = a_(16-i), b_i = b_(15-i) of the source's table" +
           maps}};
  return all;
}

const std::map<std::string, std::string>& splitting_formulas() {
  static const std::map<std::string, std::string> all{
      {"symplectic-euler", "v_new = v + h a(t, p, v), p_new = p + h v_new"},
      {"velocity-verlet", kick_drift_kick},
      {"leapfrog", drift_kick_drift},
      {"leapfrog-kdk", kick_drift_kick},
      {"leapfrog-dkd", drift_kick_drift},
      {"forest-ruth",
       "D(theta h / 2) K(theta h) D((1 - theta) h / 2) K((1 - 2 theta) h) D((1 - theta) h / 2) K(theta h) D(theta h / 2), "
       "theta = 1 / (2 - 2^(1/3))" +
           maps},
      {"pefrl",
       "D(xi h) K((1 - 2 lambda) h / 2) D(chi h) K(lambda h) D((1 - 2 (chi + xi)) h) K(lambda h) D(chi h) K((1 - 2 lambda) h "
       "/ 2) D(xi h), xi = 0.178617895844809, lambda = -0.212341831062605, chi = -0.0662645826698185" +
           maps},
      {"mclachlan4",
       "C*(c_1 h) C(c_2 h) C*(c_3 h) ... C(c_10 h) with a map C of order 1 and its adjoint C*, c_i = c_(11-i), c_1 = (14 - r) "
       "/ 108, c_2 = (146 + 5 r) / 540, c_3 = -(23 + 20 r) / 270, c_4 = (10 r - 2) / 135, c_5 = 1/5, r = sqrt(19); C(s) = "
       "K(s) D(s), C*(s) = D(s) K(s)" +
           maps},
      {"suzuki4", five_of("S") + suzuki_g + leapfrog},
      {"suzuki6", five_of("T") + "g = 1 / (4 - 4^(1/5)), T(h) the step of suzuki4"},
      {"suzuki8", five_of("T") + "g = 1 / (4 - 4^(1/7)), T(h) the step of suzuki6"},
      {"yoshida4",
       "K(w h / 2) D(w h) K((1 - w) h / 2) D((1 - 2 w) h) K((1 - w) h / 2) D(w h) K(w h / 2), w = 1 / (2 - 2^(1/3))" +
           maps},
      {"yoshida6",
       "S(w_3 h) S(w_2 h) S(w_1 h) S(w_0 h) S(w_1 h) S(w_2 h) S(w_3 h), w_0 = 1 - 2 (w_1 + w_2 + w_3), w_3 = "
       "0.784513610477557, w_2 = 0.235573213359358, w_1 = -1.17767998417887" +
           leapfrog},
      {"yoshida8",
       "S(w_7 h) S(w_6 h) ... S(w_1 h) S(w_0 h) S(w_1 h) ... S(w_7 h), w_0 = 1 - 2 (w_1 + ... + w_7), w_7 = "
       "0.914844246229792, w_6 = 0.253693336566211, w_5 = -1.44485223686061, w_4 = -0.158240635368050, w_3 = "
       "1.93813913762253, w_2 = -1.96061023297531, w_1 = 0.102799849391796" +
           leapfrog},
      {"blanes-moan4",
       "D(a_1 h) K(b_1 h) D(a_2 h) K(b_2 h) D(a_3 h) K(b_3 h) D(a_4 h) K(b_3 h) D(a_3 h) K(b_2 h) D(a_2 h) K(b_1 h) D(a_1 "
       "h), " +
           s6 + maps},
      {"blanes-moan6",
       "K(a_1 h) D(b_1 h) K(a_2 h) ... K(a_5 h) D(b_5 h) K(a_6 h) D(b_5 h) K(a_5 h) ... D(b_1 h) K(a_1 h), " + s10 +
           maps},
      {"kahan-li8",
       "S(w_8 h) S(w_7 h) ... S(w_1 h) S(w_0 h) S(w_1 h) ... S(w_8 h), w_0 = 1 - 2 (w_1 + ... + w_8), w_8 = "
       "0.130202483088890, w_7 = 0.561162981775108, w_6 = -0.389474962644847, w_5 = 0.158841906555156, w_4 = "
       "-0.395903894133238, w_3 = 0.184539640978316, w_2 = 0.258374387686322, w_1 = 0.295011723609310" +
           leapfrog},
      {"boris", boris},
      {"boris4", five_of("B") + suzuki_g + "; B(h): " + boris},
      {"boris6", nine_of("B") + "; B(h): " + boris},
      {"rattle", rattle},
      {"rattle4", five_of("R") + suzuki_g + "; R(h): " + rattle},
      {"rattle6", nine_of("R") + "; R(h): " + rattle},
      {"baumgarte",
       "M v_new = M v + h F(p) + G(p)^T lambda, G(p) v_new = -(erp / h) g(p), p_new = p + h v_new, with the constraints g and G "
       "= dg/dp"}};
  return all;
}

const std::map<std::string, std::string>& rotation_formulas() {
  static const std::map<std::string, std::string> all{
      {"rkmk4",
       "q_2 = q exp(h/2 k_1), q_3 = q exp(h/2 k_2), q_4 = q exp(h k_3), q_new = q exp(h (k_1 + 2 k_2 + 2 k_3 + k_4) / 6), k_i "
       "= J_r(theta_i)^-1 w_i, theta_i the rotation vector of q^-1 q_i, w_i the body rate of stage i, J_r the right Jacobian "
       "of exp"},
      {"lie4",
       "q_2 = q exp(h/2 w_1), q_3 = q exp(h/2 w_2), q_4 = q_2 exp(h w_3 - h/2 w_1), q_new = q exp(h (3 w_1 + 2 w_2 + 2 w_3 - "
       "w_4) / 12) exp(h (-w_1 + 2 w_2 + 2 w_3 + 3 w_4) / 12), w_i the body rate of stage i"},
      {"free-top2", "K(h/2) R_1(h/2) R_2(h/2) R_3(h) R_2(h/2) R_1(h/2) K(h/2)" + split_top},
      {"free-top4",
       "K(a_1 h) T(b_1 h) K(a_2 h) T(b_2 h) K(a_3 h) T(b_3 h) K(a_4 h) T(b_3 h) ... K(a_1 h), T in parts of C(s) = R_1(s) R_2(s) "
       "R_3(s) and of C*(s) = R_3(s) R_2(s) R_1(s), " +
           s6 + split_top},
      {"free-top6",
       "K(a_1 h) T(b_1 h) K(a_2 h) ... T(b_5 h) K(a_6 h) T(b_5 h) ... K(a_1 h), T in parts of C(s) = R_1(s) R_2(s) R_3(s) and "
       "of C*(s) = R_3(s) R_2(s) R_1(s), " +
           s10 + split_top},
      {"moser-veselov",
       "K(h/2) T(h) K(h/2), T: h L^ = F J - J F^T, L_new = F^T L, q_new = q F, with L^ u = L x u and J = tr(I) 1 / 2 - I; K(s): "
       "v += s a, L += s torque"},
      {"implicit-midpoint-so3",
       "K(h/2) T(h) K(h/2), T: L_new = L + h L_m x w, L_m = (L + L_new) / 2, w = I^-1 L_m, q_new = q (1, h w / 2) / |(1, h w / "
       "2)|; K(s): v += s a, L += s torque"},
      {"jacobi2", "K(h/2) E(h) K(h/2)" + exact_top},
      {"jacobi4",
       "K(a_1 h) E(b_1 h) K(a_2 h) E(b_2 h) K(a_3 h) E(b_3 h) K(a_4 h) E(b_3 h) ... K(a_1 h), " + s6 + exact_top}};
  return all;
}

const std::map<std::string, std::string>& implicit_formulas() {
  static const std::map<std::string, std::string> all{
      {"implicit-euler", "y_new = y + h f(t + h, y_new)"},
      {"trapezoid", "y_new = y + h (f(t, y) + f(t + h, y_new)) / 2"},
      {"implicit-midpoint", "y_new = y + h f(t + h/2, (y + y_new) / 2)"},
      {"gauss2", "y_new = y + h f(t + h/2, (y + y_new) / 2)"},
      {"gauss4", collocation + ", c = 1/2 -+ sqrt(3) / 6"},
      {"gauss6", collocation + ", c = 1/2 - sqrt(15) / 10, 1/2, 1/2 + sqrt(15) / 10"},
      {"gauss8", collocation + ", c the zeros of P_4(2 c - 1)"},
      {"radau5", collocation + ", c = (4 - sqrt(6)) / 10, (4 + sqrt(6)) / 10, 1"},
      {"sdirk2",
       "k_1 = f(t + gamma h, y + gamma h k_1), k_2 = f(t + h, y + h ((1 - gamma) k_1 + gamma k_2)), y_new = y + h ((1 - gamma) "
       "k_1 + gamma k_2), gamma = 1 - 1 / sqrt(2)"},
      {"sdirk4",
       "k_i = f(t + c_i h, y + h sum_{j<=i} a_ij k_j), a_ii = 1/4, c = 1/4, 3/4, 11/20, 1/2, 1, y_new = y + h (25/24 k_1 - "
       "49/48 k_2 + 125/16 k_3 - 85/12 k_4 + 1/4 k_5), with a of the source's table"},
      {"generalised-alpha",
       "f(t + a_f h, y + a_f (y_new - y)) = r + a_m (r_new - r), v_new = v + h (r + g (r_new - r)), p_new = p + h v + h^2 (r / 2 "
       "+ b (r_new - r)), a_f = 1 / (1 + rho), a_m = (2 - rho) / (1 + rho), g = 1/2 + a_m - a_f, b = (1 + a_m - a_f)^2 / 4; of "
       "the first-order form a_m = (3 - rho) / (2 + 2 rho)"},
      {"average-vector-field", "v_new = v + h int_0^1 a(p + s (p_new - p)) ds, p_new = p + h (v + v_new) / 2"},
      {"discrete-gradient",
       "m (v_new - v) = -h sum (V(r_new) - V(r)) / (r_new^2 - r^2) (d + d_new), p_new = p + h (v + v_new) / 2, the sum over "
       "potentials V of distances r = |d|"},
      {"projected-rk4",
       "z = y + h (k_1 + 2 k_2 + 2 k_3 + k_4) / 6 of rk4, y_new = z + N^-1 (dg/dz)^T lambda, g(y_new) = g(y_0), "
       "with the invariants g and the weights N of m |dv|^2 + m |dp|^2 / tau^2, tau = |v| / |a|"},
      {"relaxation-rk4",
       "y(t + gamma h) = y + gamma h (k_1 + 2 k_2 + 2 k_3 + k_4) / 6 of rk4, gamma such that E(y(t + gamma h)) = E(y)"},
      {"radau15", collocation + radau_nodes},
      {"ias15",
       "a(t + s h) = a_0 + b_0 s + b_1 s^2 + ... + b_6 s^7 at the nodes s = c, v_new = v + h (a_0 + b_0 / 2 + b_1 / 3 + ... + b_6 "
       "/ 8), p_new = p + h v + h^2 (a_0 / 2 + b_0 / 6 + b_1 / 12 + ... + b_6 / 72)" +
           radau_nodes},
      {"gbs",
       "z_0 = y, z_1 = y + H f(t, y), z_(m+1) = z_(m-1) + 2 H f(t + m H, z_m), H = h / n, T_(j,1) = z_n for n = n_j = 2 j, "
       "T_(j,k+1) = T_(j,k) + (T_(j,k) - T_(j-1,k)) / ((n_j / n_(j-k))^2 - 1), y_new = T_(k,k)"},
      {"taylor",
       "y_new = sum_{k<=p} y_k h^k, y_(k+1) = f_k / (k + 1), by (u v)_k = sum_{j<=k} u_j v_(k-j) and (u^a)_k = sum_{j<k} (a (k - "
       "j) - j) u_(k-j) (u^a)_j / (k u_0)"}};
  return all;
}

// Differences of the rates: nabla f_n = f_n - f_(n-1), nabla^2 f_n = nabla f_n - nabla f_(n-1).
std::string adams(const char* const (&coefficients)[8], int order, const char* newest) {
  std::string text = std::string("y_(n+1) = y_n + h (") + newest;
  for (int j = 1; j < order; ++j) {
    const std::string c = coefficients[j];
    text += (c[0] == '-' ? " - " + c.substr(1) : " + " + c) + " nabla" + (j > 1 ? "^" + std::to_string(j) : "") + " " +
            newest;
  }
  return text + "), nabla f_n = f_n - f_(n-1)";
}

std::string multistep_formula(const std::string& scheme) {
  static const char* const bashforth[8] = {"1", "1/2", "5/12", "3/8", "251/720", "95/288", "19087/60480", "5257/17280"};
  static const char* const moulton[8] = {"1",       "-1/2",   "-1/12",      "-1/24",
                                         "-19/720", "-3/160", "-863/60480", "-275/24192"};
  const int order = scheme.empty() ? 0 : scheme.back() - '0';
  if (scheme.starts_with("adams-bashforth")) return adams(bashforth, order, "f_n");
  if (scheme.starts_with("adams-moulton")) return adams(moulton, order, "f_(n+1)");
  if (!scheme.starts_with("bdf")) return "";
  std::string text = "nabla y_(n+1)";
  for (int j = 2; j <= order; ++j) text += " + 1/" + std::to_string(j) + " nabla^" + std::to_string(j) + " y_(n+1)";
  return text + " = h f(t_(n+1), y_(n+1)), nabla y_n = y_n - y_(n-1)";
}

// The formula with each equation or map on a line of its own: it is broken at a comma or semicolon outside brackets
// where the text up to the next one defines something ("y_new = ...", "K(s): ...").
std::string one_equation_a_line(const std::string& formula) {
  std::vector<std::string> parts(1);
  std::string separators;
  int depth = 0;
  for (std::size_t i = 0; i < formula.size(); ++i) {
    const char c = formula[i];
    depth += (c == '(' || c == '{') - (c == ')' || c == '}');
    if (depth == 0 && (c == ',' || c == ';') && i + 1 < formula.size() && formula[i + 1] == ' ') {
      separators += c;
      parts.emplace_back();
      ++i;
    } else {
      parts.back() += c;
    }
  }
  const auto defines = [](const std::string& part) {
    return part.find(" = ") != std::string::npos || part.find(": ") != std::string::npos;
  };
  std::string text = parts.front();
  for (std::size_t k = 1; k < parts.size(); ++k)
    text += defines(parts[k]) ? "\n" + parts[k] : separators[k - 1] + (" " + parts[k]);
  return text;
}

}  // namespace

std::string formula_of(const std::string& scheme) {
  for (const auto* formulas : {&explicit_formulas(), &splitting_formulas(), &rotation_formulas(), &implicit_formulas()})
    if (const auto found = formulas->find(scheme); found != formulas->end()) return one_equation_a_line(found->second);
  const std::string of_steps = multistep_formula(scheme);
  if (of_steps.empty()) throw std::logic_error("atwood/" + scheme + " has no formula (integrators/formulas.cpp)");
  return one_equation_a_line(of_steps);
}

}  // namespace atwood
