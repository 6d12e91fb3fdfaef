// The methods that a report's rows come from, each with every setting it ran with.
#pragma once

#include <string>
#include <vector>

#include "protocol/method.hpp"
#include "validation/row.hpp"

namespace atwood {

struct RanMethod {
  std::string id;
  const Engine* engine = nullptr;
  const MethodInfo* scheme = nullptr;    // as the engine lists it; null for a query ("fcl/contacts")
  const MethodInfo* response = nullptr;  // what followed the scheme; none: null
  Settings settings, response_settings;  // the defaults, with what the id says in their place
};

// In the order of the rows. A method that its engine refused on every scene did not run.
std::vector<RanMethod> ran_methods(const std::vector<Engine>& engines, const std::vector<Row>& rows);

// The engines, each with only those methods and responses that ran; engines of which none did are left out.
std::vector<Engine> engines_that_ran(const std::vector<Engine>& engines, const std::vector<RanMethod>& ran);

std::string setting_words(const SettingValue& value);  // as a method id spells it: "true", "0.2", "dantzig"
std::string settings_words(const Settings& settings);  // "erp = 0.2, sleeping = false"

}  // namespace atwood
