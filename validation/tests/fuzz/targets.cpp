#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <filesystem>

#include "validation/tests/fuzz/target.hpp"

namespace atwood::fuzz {
namespace {

namespace fs = std::filesystem;

struct Folder {
  std::string path;
  Folder() {
    const fs::path memory = "/dev/shm";  // a campaign writes a file for each run
    const fs::path parent = access(memory.c_str(), W_OK) == 0 ? memory : fs::temp_directory_path();
    path = (parent / ("atwood-fuzz-" + std::to_string(getpid()))).string();
    fs::create_directory(path);
  }
  ~Folder() {
    std::error_code ignored;
    fs::remove_all(path, ignored);
  }
};

}  // namespace

std::span<const Target> all_targets() {
  static constexpr std::array<Target, 20> targets = {{
      {"scene-toml", read_toml_scene}, {"scene-json", read_json_scene},
      {"points", read_points_file},    {"obj", read_obj_file},
      {"values", read_values_file},    {"urdf", read_urdf},
      {"trace", read_trace_csv},       {"study", read_study_file},
      {"gates", read_gates_file},      {"baseline", read_baseline_file},
      {"costs", read_costs_file},      {"contact-cases", read_contact_case_file},
      {"request", read_request_line},  {"hello", read_hello_line},
      {"answer", read_answer_lines},   {"field", read_field_lines},
      {"method-id", read_method_id},   {"recording", read_recording_blob},
      {"rows", read_row_blob},         {"mjcf", read_mjcf},
  }};
  return targets;
}

void require(bool holds, const char* what) {
  if (holds) return;
  std::fprintf(stderr, "fuzz target: not so: %s\n", what);
  std::abort();
}

const std::string& folder() {
  static const Folder made;
  return made.path;
}

std::string file(const std::string& name, std::string_view bytes) {
  const std::string path = folder() + "/" + name;
  std::FILE* const out = std::fopen(path.c_str(), "wb");
  require(out != nullptr, "a file can be opened for writing");
  const bool written = std::fwrite(bytes.data(), 1, bytes.size(), out) == bytes.size();
  require(std::fclose(out) == 0 && written, "a file can be written");
  return path;
}

}  // namespace atwood::fuzz
