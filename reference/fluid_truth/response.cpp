#include "fluid_truth/response.hpp"

#include <charconv>

#include "fluid_truth/solution.hpp"

namespace atwood::fluid_truth {

Response parse_response(const std::string& text) {
  Response made;
  const std::size_t brace = text.find('{');
  made.name = text.substr(0, brace);
  if (brace == std::string::npos) return made;
  require(text.back() == '}', "the response `" + text + "` has no closing brace");
  std::size_t at = brace + 1;
  const std::size_t end = text.size() - 1;
  while (at < end) {
    const std::size_t comma = std::min(text.find(',', at), end), equals = text.find('=', at);
    require(equals != std::string::npos && equals < comma, "the response `" + text + "` has a setting without a value");
    made.settings[text.substr(at, equals - at)] = text.substr(equals + 1, comma - equals - 1);
    at = comma + 1;
  }
  return made;
}

std::string word(const Response& response, const char* name, const std::string& otherwise) {
  const auto found = response.settings.find(name);
  return found == response.settings.end() ? otherwise : found->second;
}

double number(const Response& response, const char* name, double otherwise) {
  const auto found = response.settings.find(name);
  if (found == response.settings.end()) return otherwise;
  double value = 0;
  const char *begin = found->second.data(), *end = begin + found->second.size();
  const auto [at, error] = std::from_chars(begin, end, value);
  require(error == std::errc() && at == end,
          "the setting " + std::string(name) + "=" + found->second + " is not a number");
  return value;
}

bool flag(const Response& response, const char* name, bool otherwise) {
  const std::string value = word(response, name, otherwise ? "true" : "false");
  require(value == "true" || value == "false", "the setting " + std::string(name) + " is neither true nor false");
  return value == "true";
}

ViscousTerm viscous_term_of(const std::string& text) {
  const Response response = parse_response(text);
  if (response.name.empty() || response.name == "polynomial") return ViscousTerm::morris;
  require(response.name == "sph", "expected the response sph or polynomial; found `" + response.name + "`");
  const std::string viscosity = word(response, "viscosity", "morris");
  if (viscosity == "none") return ViscousTerm::none;
  if (viscosity == "morris") return ViscousTerm::morris;
  require(viscosity == "central", "expected viscosity=morris, central or none; found `" + viscosity + "`");
  return ViscousTerm::monaghan_gingold;
}

}  // namespace atwood::fluid_truth
