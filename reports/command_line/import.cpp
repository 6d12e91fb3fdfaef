// import: a scene from a robot's description, URDF by our own reader, MJCF through MuJoCo's own parser.
#include <unistd.h>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/urdf.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "validation/study/process.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

// The name of the first element: past declarations and comments.
std::string root_element(std::string_view text) {
  for (std::size_t at = text.find('<'); at != std::string_view::npos; at = text.find('<', at + 1)) {
    if (text.substr(at, 4) == "<!--") {
      at = text.find("-->", at);
      if (at == std::string_view::npos) break;
      continue;
    }
    if (at + 1 < text.size() && (text[at + 1] == '?' || text[at + 1] == '!')) continue;
    const std::size_t end = text.find_first_of(" \t\r\n/>", at);
    return std::string(text.substr(at + 1, end == std::string_view::npos ? end : end - at - 1));
  }
  return "";
}

// The program beside this one prints the scene; what it does not take it says on standard error.
std::string import_mjcf(const Place& place, const std::string& file) {
  const std::string program = place.worker_dir + "/atwood-mujoco-import";
  if (access(program.c_str(), X_OK) != 0)
    throw InputError(
        fmt::format("{}: MJCF is read by MuJoCo's own parser, which is not here; expected a URDF file, or "
                    "MuJoCo (`atwood doctor` says how to get it)",
                    file));
  try {
    return capture({program, file});
  } catch (const std::runtime_error&) {
    throw InputError(fmt::format("{}: MuJoCo's parser makes no scene of it", file));
  }
}

}  // namespace

int command_import(const Place& place, const Options& options) {
  if (options.outputs.size() > 1) throw InputError("-o: expected one file");
  const std::string text = read_input_file(options.input, "a robot's description (URDF or MJCF)", largest::kScenario);
  const std::string root = root_element(text);
  std::string toml;
  if (root == "mujoco") {
    toml = import_mjcf(place, options.input);
  } else if (root == "robot") {
    ImportedScene scene = import_urdf(text, options.input);
    for (const std::string& note : scene.notes) fmt::print(stderr, "not taken, or changed: {}\n", note);
    toml = std::move(scene.toml);
  } else {
    throw InputError(fmt::format("{}:1: found {}; expected <robot> (URDF) or <mujoco> (MJCF)", options.input,
                                 root.empty() ? "no element" : "<" + root.substr(0, 100) + ">"));
  }
  if (options.outputs.empty()) fmt::print("{}", toml);
  else write_file(options.outputs.front(), toml);
  return exit_pass;
}

}  // namespace atwood
