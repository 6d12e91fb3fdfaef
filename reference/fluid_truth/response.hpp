// The particles' equations as a truth reads them: "sph{kernel=wendland-c4,viscosity=central}".
#pragma once

#include <map>
#include <string>

namespace atwood::fluid_truth {

struct Response {
  std::string name;                             // "sph", "polynomial"; empty: none was given
  std::map<std::string, std::string> settings;  // as they were written
};

// A word, then optional settings in braces. Throws Refused (fluid_truth/solution.hpp) with what was expected.
Response parse_response(const std::string& text);

// The value of a setting, and `otherwise` where it was left out; a number that cannot be read is refused.
std::string word(const Response& response, const char* name, const std::string& otherwise);
double number(const Response& response, const char* name, double otherwise);
bool flag(const Response& response, const char* name, bool otherwise);

// The term of viscosity that the particles' equations tend to as their spacing vanishes, mu = rho0 nu:
//   morris              mu / rho lap u                           pairs along v_ij (Morris, Fox and Zhu 1997);
//                       +polynomial;
//                                                                without a response
//   monaghan_gingold    mu / rho (lap u + 2 grad div u)          pairs along x_ij (Monaghan and Gingold 1983)
// The last follows from the moments of a kernel in d dimensions: with F = W' / r <= 0 and s = x_j - x_i, to second
// order
//   (v_ij . x_ij) / r^2 F x_ij,e = -(F / r^2) s_e s_c (s_a d_a v_c + s_a s_b d_ab v_c / 2),
//   integral of -F s_a s_b s_c s_e / r^2 = (delta_ab delta_ce + delta_ac delta_be + delta_ae delta_bc) / (d + 2),
// because the integral of -F r^2 = -W' r over space is d, and the mean of n_a n_b n_c n_e over directions is the sum of
// deltas over d (d + 2). The sum of pairs is therefore (lap v + 2 grad div v) / (2 (d + 2)), and the factor 2 (d + 2)
// of the pair term (2 (d + 2) mu = (d + 2) (mu_i + mu_j)) leaves mu / rho (lap v + 2 grad div v) in every dimension.
enum class ViscousTerm { none, morris, monaghan_gingold };
ViscousTerm viscous_term_of(const std::string& response);

}  // namespace atwood::fluid_truth
