// Files that a user names, read whole. A file is data of unknown origin: it may be a device, endless, enormous, or
// nested so deep that a recursive parser exhausts the stack. All that is refused here, by name, before any of it is
// parsed.
#pragma once

#include <cstddef>
#include <limits>
#include <string>
#include <string_view>

namespace atwood {

// The largest file of each kind that is read: with the counts of values below, no content takes its reader two seconds
// or a gigabyte; a baseline and a trace, which grow with what was measured, may take longer. A scenario of 30 000
// bodies written out takes 5 MiB, the costs of a million cells 30 MiB, a trace of a thousand instants of a thousand
// bodies 300 MiB.
namespace largest {
inline constexpr std::size_t kMebibyte = std::size_t{1} << 20;
inline constexpr std::size_t kScenario = 16 * kMebibyte;
inline constexpr std::size_t kRobot = 16 * kMebibyte;     // URDF, MJCF with what it includes
inline constexpr std::size_t kSettings = 16 * kMebibyte;  // studies, gates, goals, cases of contacts
inline constexpr std::size_t kFigures = 32 * kMebibyte;   // JSON: bench.json, costs
inline constexpr std::size_t kMesh = 64 * kMebibyte;      // OBJ
inline constexpr std::size_t kValues = 16 * kMebibyte;    // of a truth
inline constexpr std::size_t kPoints = 64 * kMebibyte;    // of a fluid
inline constexpr std::size_t kBaseline = 256 * kMebibyte;
inline constexpr std::size_t kTrace = 384 * kMebibyte;  // CSV that `check` judges
}  // namespace largest

// The bytes of a regular file, links followed. `expected` says what should stand there: "a study file (TOML)". Throws
// InputError when the file cannot be opened, is a directory, a pipe, a device or a socket, or is larger than
// `most_bytes`; nothing is read of such a file, and opening a pipe without a writer does not wait.
std::string read_input_file(const std::string& path, const std::string& expected, std::size_t most_bytes);

// Throw InputError with line and column where brackets or dotted keys nest deeper than any file of this project does,
// or where there are more keys or values than a parser takes in a second. Parsers of TOML, and what they build, are
// recursive: deep nesting ends them on the stack. They know strings and comments, and nothing else of the language:
// what they pass may still be no TOML or JSON.
struct JsonBounds {
  std::size_t values = 3'200'000;  // each key counts as three
  // Of one object, for parsers that look for each new member among those before it.
  std::size_t members = std::numeric_limits<std::size_t>::max();
};
void require_shallow_toml(std::string_view text, const std::string& name);
void require_shallow_json(std::string_view text, const std::string& name, const JsonBounds& most = {});

// The same for XML, whose parser is not recursive: more elements or attributes than a robot has.
void require_small_xml(std::string_view text, const std::string& name);

// Where the value of `key` in [table] of a TOML file stands ("": above all tables), for a message: "scene.toml:12:8".
// The file alone where the key is not there. Throws InputError as reading a scenario does.
std::string place_of_key(const std::string& path, std::string_view table, std::string_view key);

}  // namespace atwood
