// The responses of fluids that may follow a scheme ("rk4+sph"), with their docs and settings.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "fluid/polynomial.hpp"
#include "fluid/sph.hpp"
#include "protocol/method.hpp"

namespace atwood::fluid {

const std::vector<MethodInfo>& responses();                // ids "+sph", "+polynomial"
const MethodInfo* find_response(const std::string& name);  // "sph"; null: there is none

// The order that a scheme of the catalogue claims for the motion of a fluid, before the ceiling of the kernel, which is
// a claim of the response ("fluid{kernel=cubic}": 3). A fluid is a system of first order, stepped by what steps
// mechanisms in their coordinates, or, without friction, by kicks and drifts. None: the scheme steps no fluid.
std::optional<double> claimed_order(const MethodInfo& scheme);

// The settings of the id's response. An input fault where a value is out of range.
struct SphRequest {
  SphOptions options;
  bool reversible = false;
};
Result<SphRequest> sph_request(const MethodId& id);
Result<PolynomialOptions> polynomial_request(const MethodId& id);

// The same id with the overrides that are the integrator's; `threads`, which both declare, is kept.
MethodId integrator_part(const MethodId& id);

}  // namespace atwood::fluid
