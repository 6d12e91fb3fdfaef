// The head of a table of published values: what it must hold to be a truth. Its numbers are read where they are used.
#include <algorithm>

#include "scene/csv.hpp"
#include "scene/declarations.hpp"
#include "scene/input_file.hpp"

namespace atwood {
namespace {

const std::vector<std::string> kPosition = {"px_m", "py_m", "pz_m"}, kOrientation = {"qw", "qx", "qy", "qz"},
                               kVelocity = {"vx_m_per_s", "vy_m_per_s", "vz_m_per_s"},
                               kSpin = {"wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};

}  // namespace

void check_values_file(Reading& r, const Value& file, const Scenario& scenario) {
  const std::string& path = scenario.truth.file;
  CsvReader table(read_input_file(path, "a table of values (CSV)", largest::kValues), path);
  const auto refuse = [&](int line, const std::string& what) {
    throw InputError(path + ":" + std::to_string(line) + ":1: " + what + " (`file` in [truth] of " + r.name + ":" +
                     std::to_string(file.location.line) + ")");
  };
  std::vector<std::string> names, first_row;
  if (!table.next(names)) refuse(1, "found no header; expected the columns t_s, body, px_m, px_m_bar, ...");
  const int header = table.line();
  const auto has = [&](const std::string& name) { return std::find(names.begin(), names.end(), name) != names.end(); };
  const auto require = [&](const std::string& name, const std::string& why) {
    if (!has(name)) refuse(header, "found no column `" + name + "`; expected it" + why + did_you_mean(name, names));
  };
  const auto require_any = [&](const std::vector<std::string>& group) {
    if (std::none_of(group.begin(), group.end(), has))
      refuse(header, "found none of the columns " + listed(group) +
                         "; expected those that change, each with its bar: what a table leaves out counts as "
                         "known and constant");
  };
  for (const char* name : {"t_s", "body"}) require(name, " in a table of values");
  require_any(kPosition);
  require_any(kVelocity);
  if (std::any_of(scenario.scene.bodies.begin(), scenario.scene.bodies.end(), [](const Body& b) { return rotates(b); }))
    for (const auto* group : {&kOrientation, &kSpin})
      for (const std::string& name : *group) require(name, ", as a body of the scene rotates");
  for (const auto* group : {&kPosition, &kOrientation, &kVelocity, &kSpin})
    for (const std::string& name : *group)
      if (has(name)) require(name + "_bar", ": the half-width of `" + name + "`");
  for (std::size_t i = 0; i < names.size(); ++i)
    if (std::count(names.begin(), names.end(), names[i]) > 1)
      refuse(header, "found the column `" + names[i] + "` twice; expected each once");
  if (!table.next(first_row)) refuse(header, "found no row under the header; expected one a body and instant");
}

}  // namespace atwood
