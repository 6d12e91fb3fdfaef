#include "reports/command_line/trace_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "scene/csv.hpp"
#include "scene/files.hpp"
#include "scene/printable.hpp"

namespace atwood {
namespace {

constexpr std::size_t kMaxStates = 2'000'000;  // bodies times instants; a state takes 208 bytes

struct Columns {
  std::map<std::string, std::size_t> at;
  bool has(const char* name) const { return at.contains(name); }
};

template <std::size_t n>
void read_group(const std::array<const char*, n>& names, const Columns& columns, const std::vector<std::string>& fields,
                const std::string& where, std::array<Wide, n>& out) {
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t column = columns.at.at(names[i]);
    try {
      out[i] = parse_wide(fields.at(column));
    } catch (const std::exception&) {
      throw InputError(fmt::format("{}:{}: {}: found `{}`; expected a number", where, column + 1, names[i],
                                   column < fields.size() ? fields[column] : "nothing"));
    }
  }
}

constexpr std::array<const char*, 3> kPNames{"px_m", "py_m", "pz_m"};
constexpr std::array<const char*, 4> kQNames{"qw", "qx", "qy", "qz"};
constexpr std::array<const char*, 3> kVNames{"vx_m_per_s", "vy_m_per_s", "vz_m_per_s"};
constexpr std::array<const char*, 3> kWNames{"wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};

Columns read_header(const std::vector<std::string>& names, const std::string& path) {
  Columns columns;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (!columns.at.emplace(names[i], i).second)
      throw InputError(fmt::format("{}:1:{}: column `{}` appears twice", path, i + 1, names[i]));
  }
  auto require = [&](const char* name) {
    if (!columns.has(name))
      throw InputError(fmt::format("{}:1:1: found no column `{}`; expected the columns of `atwood trace`", path, name));
  };
  require("t_s");
  require("body");
  for (const char* name : kPNames) require(name);
  for (const char* name : kVNames) require(name);
  auto all_or_none = [&](const auto& group) {  // half an orientation is a mistake, not an omission
    if (std::any_of(group.begin(), group.end(), [&](const char* name) { return columns.has(name); })) {
      for (const char* name : group) require(name);
    }
  };
  all_or_none(kQNames);
  all_or_none(kWNames);
  return columns;
}

// Rows may come in any order within one instant; instants must rise and be the same for every body.
Recording read_rows(CsvReader& file, const Columns& columns, const std::string& path, const Scene& scene) {
  std::map<std::string, std::size_t> index;
  for (std::size_t i = 0; i < scene.bodies.size(); ++i) index[scene.bodies[i].name] = i;

  Recording run;
  std::vector<bool> seen;
  auto complete = [&](int number) {
    for (std::size_t i = 0; i < seen.size(); ++i) {
      if (!seen[i] && !scene.bodies[i].fixed) {
        throw InputError(fmt::format("{}:{}: no row for body `{}` at the instant that ends before this line", path,
                                     number, scene.bodies[i].name));
      }
    }
  };
  std::vector<std::string> fields;
  while (file.next(fields)) {
    const int number = file.line();
    const std::string where = fmt::format("{}:{}", path, number);
    if (fields.size() != columns.at.size()) {
      throw InputError(
          fmt::format("{}: found {} fields; expected {}, as in the header", where, fields.size(), columns.at.size()));
    }
    std::array<Wide, 1> t{};
    read_group<1>({"t_s"}, columns, fields, where, t);
    const std::size_t t_column = columns.at.at("t_s");
    if (!std::isfinite(static_cast<double>(t[0])))
      throw InputError(fmt::format("{}:{}: t_s: found `{}`; expected a finite time within the range of a double", where,
                                   t_column + 1, fields[t_column]));
    const std::string name = unguarded_cell(fields.at(columns.at.at("body")));
    if (!index.contains(name))
      throw InputError(fmt::format("{}: found body `{}`, which the scene does not have", where, name));
    if (run.values.empty() || t[0] != run.values.back().t_s) {
      if ((run.values.size() + 1) * scene.bodies.size() > kMaxStates)
        throw InputError(
            fmt::format("{}: found more than {} states of bodies; expected fewer instants", where, kMaxStates));
      if (!run.values.empty()) {
        complete(number);
        if (!(t[0] > run.values.back().t_s))
          throw InputError(
              fmt::format("{}:{}: t_s: found `{}`; expected increasing times", where, t_column + 1, fields[t_column]));
      }
      run.values.push_back(Sample{t[0], std::vector<BodySample>(scene.bodies.size())});
      for (std::size_t i = 0; i < scene.bodies.size(); ++i) {  // fixed bodies need no rows
        for (std::size_t k = 0; k < 3; ++k) run.values.back().bodies[i].p_m[k] = scene.bodies[i].position_m[k];
        for (std::size_t k = 0; k < 4; ++k) run.values.back().bodies[i].q_wxyz[k] = scene.bodies[i].orientation_wxyz[k];
      }
      seen.assign(scene.bodies.size(), false);
    }
    BodySample& body = run.values.back().bodies[index[name]];
    if (seen[index[name]]) throw InputError(fmt::format("{}: body `{}` appears twice at this instant", where, name));
    seen[index[name]] = true;
    read_group(kPNames, columns, fields, where, body.p_m);
    read_group(kVNames, columns, fields, where, body.v_m_per_s);
    if (columns.has("qw")) read_group(kQNames, columns, fields, where, body.q_wxyz);
    if (columns.has("wx_rad_per_s")) read_group(kWNames, columns, fields, where, body.w_rad_per_s);
  }
  if (run.values.size() < 2)
    throw InputError(fmt::format("{}: found {} instants; expected at least two", path, run.values.size()));
  complete(file.line() + 1);
  return run;
}

// The truth is solved at equal intervals: the trace must be sampled so, from 0 on.
void require_even(const Recording& run, const std::string& path) {
  const double t_end = static_cast<double>(run.values.back().t_s);
  const auto samples = static_cast<double>(run.values.size() - 1);
  for (std::size_t k = 0; k < run.values.size(); ++k) {
    const double expected = t_end * static_cast<double>(k) / samples;
    if (std::abs(static_cast<double>(run.values[k].t_s) - expected) > 1e-12 * t_end) {
      throw InputError(fmt::format("{}: found instant {} at t = {} s; expected {} s (equal intervals from 0)", path, k,
                                   format_double(static_cast<double>(run.values[k].t_s)), format_double(expected)));
    }
  }
}

}  // namespace

Trace read_trace(std::string text, const std::string& path, const Scene& scene) {
  CsvReader file(std::move(text), path);
  Trace trace;
  if (!file.next(trace.columns))
    throw InputError(fmt::format("{}:1:1: found an empty file; expected a header line", path));
  trace.run = read_rows(file, read_header(trace.columns, path), path, scene);
  require_even(trace.run, path);
  return trace;
}

}  // namespace atwood
