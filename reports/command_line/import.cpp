// import: a scene from a robot's description, URDF by our own reader, MJCF through MuJoCo's own parser.
#include <unistd.h>

#include <chrono>
#include <filesystem>

#include <fmt/format.h>

#include "reports/command_line/command_line.hpp"
#include "reports/command_line/mjcf_files.hpp"
#include "reports/command_line/urdf.hpp"
#include "scene/files.hpp"
#include "scene/input_file.hpp"
#include "scene/printable.hpp"
#include "validation/study/process.hpp"
#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

constexpr std::chrono::seconds kImportTime{20};
constexpr std::int64_t kImportMemoryBytes = std::int64_t{1} << 30;

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

// The notes that the scene's first comment holds.
std::vector<std::string> notes_of(std::string_view toml) {
  constexpr std::string_view note_prefix = "#   ";
  std::vector<std::string> notes;
  while (toml.starts_with("#")) {
    const std::size_t end = std::min(toml.find('\n'), toml.size());
    if (toml.starts_with(note_prefix))
      notes.push_back(printable(toml.substr(note_prefix.size(), end - note_prefix.size())));
    toml.remove_prefix(std::min(end + 1, toml.size()));
  }
  return notes;
}

// The program's message, in which the file has its full path, with the file as it was named.
std::string refusal_of(Process& process, const std::string& path, const std::string& file) {
  const std::string said = process.error_text();
  return said.starts_with(path + ": ") ? file + said.substr(path.size()) : file + ": " + said;
}

// Reads the scene that the program prints. Throws InputError where the model is to blame; empty: interrupted.
std::string output_of(Process& process, const std::string& path, const std::string& file) {
  const Clock::time_point deadline = Clock::now() + kImportTime;
  std::string toml, line;
  for (;;) {
    const Wait wait = process.next_line(line, deadline, largest::kScenario);
    if (wait == Wait::interrupted) return "";
    if (wait == Wait::timeout)
      throw InputError(fmt::format("{}: MuJoCo's parser did not end within {} s; expected a model that is read sooner",
                                   file, kImportTime.count()));
    if (wait == Wait::end_of_output) break;
    toml += line + "\n";
    if (wait == Wait::too_long || toml.size() > largest::kScenario)
      throw InputError(fmt::format("{}: its scene would take more than {} MiB; expected a smaller model", file,
                                   largest::kScenario / largest::kMebibyte));
  }
  if (process.succeeded()) return toml;
  if (process.took_too_much_memory())
    throw InputError(fmt::format("{}: MuJoCo's parser took more than {} of memory; expected a smaller model", file,
                                 memory_text(kImportMemoryBytes)));
  if (const std::string ending = process.ending(); ending != "exited with code 2")
    throw WorkerFailure(
        fmt::format("{}: MuJoCo's parser failed ({}); expected a model that it can read", file, ending));
  throw InputError(refusal_of(process, path, file));
}

// The program beside this one reads the model and prints the scene. It is confined as workers are: no network, no
// writing, and it ends with this program.
std::string import_mjcf(const Place& place, const std::string& text, const std::string& file) {
  const std::string program = place.worker_dir + "/atwood-mujoco-import";
  if (access(program.c_str(), X_OK) != 0)
    throw InputError(
        fmt::format("{}: MJCF is read by MuJoCo's own parser, which is not here; expected a URDF file, or "
                    "MuJoCo (`atwood doctor` says how to get it)",
                    file));
  require_files_in_folder(text, file);
  const std::string path = std::filesystem::absolute(file).string();
  Process process({program, path}, false, {.memory_bytes = kImportMemoryBytes});
  const std::string toml = output_of(process, path, file);
  for (const std::string& note : notes_of(toml)) fmt::print(stderr, "not taken, or changed: {}\n", note);
  return toml;
}

}  // namespace

int command_import(const Place& place, const Options& options) {
  if (options.outputs.size() > 1) throw InputError("-o: expected one file");
  if (!options.outputs.empty()) require_output(options.outputs.front());
  const std::string text = read_input_file(options.input, "a robot's description (URDF or MJCF)", largest::kRobot);
  const std::string root = root_element(text);
  std::string toml;
  if (root == "mujoco") {
    const InterruptGuard guard;
    toml = import_mjcf(place, text, options.input);
    if (interrupt_signal() != 0) return 128 + interrupt_signal();
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
