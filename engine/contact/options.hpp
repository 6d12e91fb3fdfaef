// The contact responses that may follow a scheme ("rk4+event"), each with its doc and its settings.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"

namespace atwood {

// ids "+impulse", "+event", "+penalty"; their settings hold every default.
const std::vector<MethodInfo>& contact_responses();
const MethodInfo* find_response(const std::string& name);  // "impulse"; null: there is none

// An id's overrides that name settings of its response, merged over the defaults; an override that response and
// integrator both declare ("threads") applies to both. Fault (input): a value outside its range.
Result<Settings> response_settings(const MethodId& id);
// The same id with the overrides that are the integrator's.
MethodId integrator_part(const MethodId& id);

}  // namespace atwood
