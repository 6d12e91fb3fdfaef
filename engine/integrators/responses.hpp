// What follows a scheme in an id ("rk4+event"): the responses that a room offers, and whose an id's settings are.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"

namespace atwood {

// `name` without the plus sign; null: the list has no such response.
const MethodInfo* find_response_in(const std::vector<MethodInfo>& responses, const std::string& name);
// An id's overrides that name settings of the response, merged over the defaults; an override that response and
// integrator both declare ("threads") applies to both. Fault (input): a value outside its range.
Result<Settings> settings_of_response(const MethodInfo& response, const MethodId& id);
// The same id with the overrides that are the integrator's. An unknown scheme keeps all of them.
MethodId without_settings_of(const MethodInfo& response, const MethodId& id);

}  // namespace atwood
