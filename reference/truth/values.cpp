#include <cmath>
#include <map>
#include <stdexcept>

#include "dynamics/state.hpp"
#include "protocol/refusal.hpp"
#include "scene/csv.hpp"
#include "scene/input_file.hpp"
#include "truth/truth.hpp"

namespace atwood {

namespace {

const char* const columns[] = {"px_m",         "py_m",         "pz_m",        "qw",         "qx",
                               "qy",           "qz",           "vx_m_per_s",  "vy_m_per_s", "vz_m_per_s",
                               "wx_rad_per_s", "wy_rad_per_s", "wz_rad_per_s"};
constexpr int kColumnCount = 13;

Wide& component(BodySample& body, int column) {
  if (column < 3) return body.p_m[column];
  if (column < 7) return body.q_wxyz[column - 3];
  return column < 10 ? body.v_m_per_s[column - 7] : body.w_rad_per_s[column - 10];
}

struct Table {
  std::string source;
  std::map<std::string, std::size_t> at;  // column name -> index
  std::vector<std::vector<std::string>> rows;
};

Table read_table(const std::string& path) {
  CsvReader file(read_input_file(path, "a table of values (CSV)", largest::kValues), path);
  Table made;
  std::vector<std::string> cells;
  if (file.next(cells))
    for (std::size_t k = 0; k < cells.size(); ++k) made.at[cells[k]] = k;
  while (file.next(cells)) {
    if (cells.size() != made.at.size())
      throw std::runtime_error("`" + path + "`: a row of " + std::to_string(cells.size()) + " cells under " +
                               std::to_string(made.at.size()) + " columns");
    made.rows.push_back(std::move(cells));
  }
  const std::string mark = "# source: ";
  for (const std::string& comment : file.comments())
    if (made.source.empty() && comment.starts_with(mark)) made.source = comment.substr(mark.size());
  if (!made.at.contains("t_s") || !made.at.contains("body"))
    throw std::runtime_error("`" + path + "` has no columns t_s and body");
  for (const char* column : columns)
    if (made.at.contains(column) && !made.at.contains(std::string(column) + "_bar"))
      throw std::runtime_error("`" + path + "` has " + column + " and no " + column + "_bar");
  return made;
}

const std::vector<std::string>* find_row(const Table& table, double t_s, double slack_s, const std::string& body) {
  for (const auto& row : table.rows)
    if (row[table.at.at("body")] == body &&
        std::fabs(static_cast<double>(parse_wide(row[table.at.at("t_s")])) - t_s) <= slack_s)
      return &row;
  return nullptr;
}

void fill(Truth& truth, const Scenario& scenario, const Table& table, std::int64_t samples) {
  const Scene& scene = scenario.scene;
  const std::vector<Wide> initial = dynamics::pack<Wide>(scene);
  const std::vector<Wide> zero(initial.size(), Wide(0));
  for (std::int64_t k = 0; k <= samples; ++k) {
    const Wide t = Wide(scenario.t_end_s) * Wide(k) / Wide(samples);
    Sample value = dynamics::unpack<Wide>(scene, t, initial.data());
    Sample bar = dynamics::unpack_bars<Wide>(scene, t, zero.data());
    for (std::size_t i = 0; i < scene.bodies.size() && k > 0; ++i) {
      const Body& body = scene.bodies[i];
      if (body.fixed) continue;
      const auto* row = find_row(table, static_cast<double>(t), 1e-12 * scenario.t_end_s, body.name);
      if (row == nullptr)
        throw std::runtime_error("`" + scenario.truth.file + "` has no row of `" + body.name +
                                 "` at t = " + format_double(static_cast<double>(t)) + " s");
      for (int column = 0; column < kColumnCount; ++column) {
        const auto at = table.at.find(columns[column]);
        if (at == table.at.end()) continue;
        component(value.bodies[i], column) = parse_wide((*row)[at->second]);
        component(bar.bodies[i], column) = parse_wide((*row)[table.at.at(std::string(columns[column]) + "_bar")]);
      }
    }
    truth.values.push_back(std::move(value));
    truth.bars.push_back(std::move(bar));
  }
}

}  // namespace

Truth values_truth(const Scenario& scenario, std::int64_t samples) {
  Truth truth;
  try {
    const Table table = read_table(scenario.truth.file);
    truth.source = "values: " + (table.source.empty() ? scenario.truth.file : table.source);
    if (samples < 1) throw std::runtime_error("no samples to give");
    fill(truth, scenario, table, samples);
  } catch (const std::exception& error) {
    truth = Truth{};
    truth.source = "values: " + scenario.truth.file;
    truth.outcome = refused(error.what());
  }
  return truth;
}

}  // namespace atwood
