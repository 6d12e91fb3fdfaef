// The responses of fluids that may follow a scheme ("rk4+sph"), with their docs and settings.
#pragma once

#include <string>
#include <vector>

#include "fluid/sph.hpp"
#include "protocol/method.hpp"

namespace atwood::fluid {

const std::vector<MethodInfo>& responses();                // ids "+sph"
const MethodInfo* find_response(const std::string& name);  // "sph"; null: there is none

// What an id asks of its response. The input is to blame for a value outside its range.
struct SphRequest {
  SphOptions options;
  bool reversible = false;
};
Result<SphRequest> sph_request(const MethodId& id);

// The same id with the overrides that are the integrator's; "threads" is of both.
MethodId integrator_part(const MethodId& id);

}  // namespace atwood::fluid
