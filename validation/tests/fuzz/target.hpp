// A fuzz target gives bytes of any content to one of the library's readers. The reader may accept them or throw the
// error that it documents; anything else (another exception, a fault of memory, undefined behaviour, an endless loop)
// is an error of the reader. What was accepted is written and read again, where the library writes that format:
// `require` ends the process where the two differ.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace atwood::fuzz {

struct Target {
  const char* name;  // also of the folder of its corpus
  void (*read)(std::string_view bytes);
};
std::span<const Target> all_targets();

// Ends the process by abort(), with the words on standard error.
void require(bool holds, const char* what);

// A folder in memory for readers that take a path, made at the first call and removed at the end of the process.
const std::string& folder();
// Writes a file there; its path.
std::string file(const std::string& name, std::string_view bytes);

// What `read` returns; nothing where it throws Documented.
template <class Documented, class Read> auto read_or_refuse(Read read) -> std::optional<decltype(read())> {
  try {
    return read();
  } catch (const Documented&) {
    return std::nullopt;
  }
}

void read_toml_scene(std::string_view bytes);
void read_json_scene(std::string_view bytes);
void read_points_file(std::string_view bytes);
void read_obj_file(std::string_view bytes);
void read_values_file(std::string_view bytes);
void read_urdf(std::string_view bytes);
void read_mjcf(std::string_view bytes);
void read_trace_csv(std::string_view bytes);
void read_study_file(std::string_view bytes);
void read_gates_file(std::string_view bytes);
void read_baseline_file(std::string_view bytes);
void read_costs_file(std::string_view bytes);
void read_contact_case_file(std::string_view bytes);
void read_request_line(std::string_view bytes);
void read_hello_line(std::string_view bytes);
void read_answer_lines(std::string_view bytes);
void read_field_lines(std::string_view bytes);
void read_method_id(std::string_view bytes);
void read_recording_blob(std::string_view bytes);
void read_row_blob(std::string_view bytes);

}  // namespace atwood::fuzz
