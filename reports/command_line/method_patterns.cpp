// Expands the names of methods on the command line to ids.
#include <algorithm>
#include <set>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"
#include "validation/gates/gates.hpp"

namespace atwood {
namespace {

// "odeint/dopri5" for "odeint/runge_kutta_dopri5": the last word of ids of that engine, where no id is just that.
std::vector<std::string> by_last_word(const std::string& base, const std::vector<Worker>& workers) {
  std::vector<std::string> ids;
  const std::size_t slash = base.find('/');
  if (slash == std::string::npos) return ids;
  const std::string engine = base.substr(0, slash + 1), word = base.substr(slash + 1);
  for (const auto& worker : workers) {
    if (worker.status != Status::ok) continue;
    for (const auto& info : worker.engine.methods) {
      const bool ends = info.id.size() > word.size() && info.id.rfind(engine, 0) == 0 && info.id.ends_with(word);
      if (ends && std::string("/_-").find(info.id[info.id.size() - word.size() - 1]) != std::string::npos)
        ids.push_back(info.id);
    }
  }
  return ids;
}

}  // namespace

std::vector<std::string> with_tolerances(const std::vector<std::string>& methods, const std::vector<Worker>& workers,
                                         std::vector<std::string>& notes) {
  std::vector<std::string> chosen;
  std::set<std::string> seen;
  const auto add = [&](const std::string& method) {
    if (seen.insert(method).second) chosen.push_back(method);
  };
  const auto add_all = [&](const std::string& base, const std::string& rest) {
    bool offered = false;
    for (const auto& worker : workers) {
      if (worker.status != Status::ok) continue;
      for (const auto& info : worker.engine.methods) {
        if (!glob_match(base, info.id)) continue;
        offered = true;
        const bool has_tolerance = !rest.empty() && rest.front() == ':';
        add(info.id + rest);
        for (int digits = 4; info.adaptive && !has_tolerance && digits <= 13; ++digits)
          add(fmt::format("{}:1e-{}{}", info.id, digits, rest));
      }
    }
    return offered;
  };
  for (const auto& text : methods) {
    const std::size_t cut = std::min(text.find_first_of(":+@{"), text.size());
    const std::string base = text.substr(0, cut), rest = text.substr(cut);
    if (add_all(base, rest)) continue;
    const std::vector<std::string> ids = by_last_word(base, workers);
    for (const auto& id : ids) add_all(id, rest);
    if (ids.empty()) add(text);
    else notes.push_back(fmt::format("{}: taken as {}.", text, fmt::join(ids, ", ")));
  }
  return chosen;
}

}  // namespace atwood
