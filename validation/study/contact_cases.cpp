// Files of contacts whose answers are derived by hand.
#include <cmath>
#include <filesystem>
#include <sstream>

#include "scene/toml_parser.hpp"

#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/study/pose_sweep.hpp"

namespace atwood {
namespace {

namespace fs = std::filesystem;

constexpr const char* kHead =
    "id = \"case\"\ntitle = \"A case of a table\"\nclaim = \"The answer by hand\"\nsource = \"by hand\"\n"
    "[run]\nt_end_s = 1.0\nsteps = [1]\nsamples = 1\n[world]\ngravity_m_per_s2 = [0, 0, 0]\n[truth]\nkind = \"none\"\n";

ContactCase read_case(const toml::table& table, const std::string& path, int number) {
  const std::string where = path + ": case " + std::to_string(number);
  ContactCase read;
  const auto name = table["name"].value<std::string>();
  const auto gap = table["gap_m"].value<double>();
  const toml::array* bodies = table["body"].as_array();
  if (!name || !gap || !bodies || bodies->size() != 2)
    throw InputError(where + ": expected `name`, `gap_m` and two [[case.body]]");
  read.name = *name;
  read.answer.gap_m = *gap;
  read.answer.hit = *gap <= 0;
  if (const toml::array* normal = table["normal"].as_array()) {
    if (normal->size() != 3) throw InputError(where + ": `normal`: expected three numbers");
    for (std::size_t i = 0; i < 3; ++i) read.answer.normal[i] = normal->get(i)->value<double>().value_or(0);
    read.answer.margin_m = HUGE_VAL;  // a normal that the case gives is unique
  }
  std::ostringstream text;  // a scenario of the two bodies
  text << kHead << toml::table{{"body", *bodies}} << "\n";
  read.scene = read_scenario_text(text.str(), where, fs::path(path).parent_path().string()).scene;
  return read;
}

}  // namespace

std::vector<ContactCase> read_contact_cases(const std::string& path) {
  const std::string text = read_input_file(path, "a table of contacts (TOML)", largest::kSettings);
  require_shallow_toml(text, path);
  toml::table root;
  try {
    root = toml::parse(text, path);
  } catch (const toml::parse_error& error) {
    throw InputError(path + ":" + std::to_string(error.source().begin.line) + ": " + std::string(error.description()));
  }
  const toml::array* list = root["case"].as_array();
  if (!list || list->empty()) throw InputError(path + ": no [[case]]; expected at least one");
  std::vector<ContactCase> cases;
  for (const toml::node& each : *list) {
    if (!each.is_table())
      throw InputError(path + ":" + std::to_string(each.source().begin.line) + ": found a value; expected [[case]]");
    cases.push_back(read_case(*each.as_table(), path, static_cast<int>(cases.size()) + 1));
  }
  return cases;
}

}  // namespace atwood
