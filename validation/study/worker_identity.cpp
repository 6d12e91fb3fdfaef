#include "validation/study/worker_identity.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <fstream>
#include <set>

#include "validation/study/content_hash.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

// Programs that run code which their command does not name: interpreters, and launchers of another program.
constexpr std::array kInterpreters = {
    "python", "pypy",   "perl",   "ruby",    "node",   "nodejs", "deno",    "bun",     "java",  "julia",
    "lua",    "luajit", "R",      "Rscript", "octave", "php",    "tclsh",   "wish",    "guile", "racket",
    "sbcl",   "bash",   "dash",   "sh",      "zsh",    "ksh",    "fish",    "busybox", "mono",  "dotnet",
    "wine",   "qemu",   "docker", "podman",  "ssh",    "mpirun", "mpiexec", "prterun", "srun",  "valgrind",
    "gdb",    "ghc",    "runghc", "erl",     "elixir", "swipl",  "matlab",  "sage"};
// Libraries that make a program an interpreter.
constexpr std::array kEmbedded = {"libpython", "libjvm",  "libjulia",     "libruby",    "libperl",
                                  "libR.so",   "libnode", "libmono",      "libcoreclr", "liblua",
                                  "libguile",  "libtcl",  "liboctinterp", "libphp",     "libv8"};

struct Mapped {
  std::set<std::string> files;  // code that is mapped from files
  std::string program;          // /proc/PID/exe
  bool known = false;           // false: the process has ended, or its files do not exist any more
};

Mapped mapped_files(pid_t process) {
  Mapped mapped;
  const std::string folder = "/proc/" + std::to_string(process);
  std::error_code error;
  mapped.program = fs::read_symlink(folder + "/exe", error).string();
  std::ifstream maps(folder + "/maps");
  for (std::string line; std::getline(maps, line);) {  // begin-end rwxp offset device inode path
    const std::size_t space = line.find(' '), slash = line.find('/');
    if (space == std::string::npos || slash == std::string::npos || line.size() < space + 5) continue;
    if (line[space + 3] != 'x') continue;
    const std::string path = line.substr(slash);
    if (path.rfind("/memfd:", 0) == 0 || path.rfind("/SYSV", 0) == 0) continue;  // made by the program itself
    mapped.files.insert(path);
  }
  // A process that ends meanwhile leaves a part of its list, or none.
  mapped.known = !fs::read_symlink(folder + "/exe", error).empty() && !mapped.files.empty();
  return mapped;
}

bool same_file(const std::string& a, const std::string& b) {
  struct stat one {
  }, two{};
  return stat(a.c_str(), &one) == 0 && stat(b.c_str(), &two) == 0 && one.st_dev == two.st_dev &&
         one.st_ino == two.st_ino;
}

bool is_regular(const std::string& path) {
  std::error_code error;
  return fs::is_regular_file(path, error);
}

bool is_text(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::string head(8192, ' ');
  file.read(head.data(), static_cast<std::streamsize>(head.size()));
  head.resize(static_cast<std::size_t>(std::max<std::streamsize>(0, file.gcount())));
  return head.find('\0') == std::string::npos;
}

bool is_executable(const std::string& path) {
  struct stat info {};
  return stat(path.c_str(), &info) == 0 && (info.st_mode & S_IXUSR) != 0;
}

// "python3.11" -> "python", "qemu-x86_64" -> "qemu".
std::string leading_letters(const std::string& name) {
  const auto end = std::find_if(name.begin(), name.end(), [](unsigned char c) { return !std::isalpha(c); });
  return {name.begin(), end};
}

bool is_interpreter(const std::string& program) {
  const std::string name = leading_letters(fs::path(program).filename().string());
  return std::find(kInterpreters.begin(), kInterpreters.end(), name) != kInterpreters.end();
}

// The path in a word of a command: the word, or its part after "=".
std::string named_path(const std::string& word) {
  std::error_code error;
  if (word.empty() || fs::exists(word, error)) return word;
  const std::size_t equals = word.find('=');
  return equals == std::string::npos ? "" : word.substr(equals + 1);
}

std::string child_of(pid_t process) {
  std::error_code error;
  for (const auto& task : fs::directory_iterator("/proc/" + std::to_string(process) + "/task", error)) {
    std::ifstream file(task.path() / "children");
    std::string child;
    if (file >> child) return child;
  }
  return "";
}

std::string program_of(const std::vector<std::string>& command) {
  const std::string& first = command.at(0);
  return first.find('/') == std::string::npos ? "./" + first : first;
}

// Why not all code that can decide the results is hashed; empty where all is.
std::string why_unknown(const std::vector<std::string>& command, const Mapped& mapped, pid_t process) {
  const std::string program = program_of(command);
  if (!mapped.known) return "its process had ended after hello";
  if (!same_file(program, mapped.program)) return "it is run by " + fs::path(mapped.program).filename().string();
  if (is_interpreter(mapped.program) || is_interpreter(program))
    return fs::path(program).filename().string() + " runs code of other files";
  for (std::size_t i = 1; i < command.size(); ++i) {
    const std::string path = named_path(command[i]);
    std::error_code error;
    if (path.empty() || !fs::exists(path, error)) continue;
    if (!is_regular(path)) return "its command names " + path + ", which is not a regular file";
    if (is_executable(path)) return "its command names the program " + path;
    if (is_text(path)) return "its command names the text file " + path;
  }
  for (const std::string& file : mapped.files) {
    const std::string name = fs::path(file).filename().string();
    for (const char* embedded : kEmbedded)
      if (name.rfind(embedded, 0) == 0) return "it has an interpreter in it (" + name + ")";
  }
  return child_of(process).empty() ? "" : "it has started another process";
}

// The folder of relative paths in the answer to `hello`.
fs::path folder_of_program(const std::vector<std::string>& command) {
  std::string program = program_of(command);
  if (is_interpreter(program)) {
    for (std::size_t i = 1; i < command.size(); ++i) {
      if (!is_regular(command[i])) continue;
      program = command[i];
      break;
    }
  }
  return fs::absolute(program).parent_path();
}

}  // namespace

std::string FileHashes::of(const std::string& path) {
  struct stat info {};
  if (stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return "";
  if (info.st_size > kLargestHashedFile) return "";
  const Stamp stamp{info.st_dev, info.st_ino, info.st_size, info.st_mtim.tv_sec, info.st_mtim.tv_nsec};
  const auto [place, fresh] = known_.emplace(stamp, "");
  if (fresh) place->second = file_hash(path);
  return place->second;
}

WorkerIdentity identify_worker(const std::vector<std::string>& command, const Engine& engine, pid_t process,
                               FileHashes& hashes) {
  WorkerIdentity identity;
  const Mapped mapped = mapped_files(process);
  std::string all = content_hash({"worker 2", hashes.of(program_of(command)), engine.fingerprint});
  const auto add = [&](const std::string& what, const std::string& hash) { all = content_hash({all, what, hash}); };
  identity.process_ended = !mapped.known;
  identity.code.assign(mapped.files.begin(), mapped.files.end());
  if (engine.fingerprint.empty()) identity.unknown_code = why_unknown(command, mapped, process);

  for (std::size_t i = 1; i < command.size(); ++i) {
    const std::string path = named_path(command[i]);
    const std::string hash = path.empty() ? "" : hashes.of(path);
    // The hash contains a file's content and name, not its folder.
    const std::string option = command[i].substr(0, command[i].size() - path.size());
    add(hash.empty() ? command[i] : option + fs::path(path).filename().string(), hash);
  }

  const auto refuse_large = [&](const std::string& who, const std::string& path) {
    struct stat info {};
    if (!identity.error.empty() || stat(path.c_str(), &info) != 0 || !S_ISREG(info.st_mode)) return;
    if (info.st_size > kLargestHashedFile)
      identity.error = who + " `" + path + "`, which has " + std::to_string(info.st_size) + " bytes; at most " +
                       std::to_string(kLargestHashedFile) + " (4 GiB) are hashed";
  };
  refuse_large("its program is", program_of(command));
  for (std::size_t i = 1; i < command.size(); ++i) refuse_large("its command names", named_path(command[i]));
  for (const std::string& listed : engine.files)
    refuse_large("hello lists", (folder_of_program(command) / listed).string());

  std::set<std::pair<std::string, std::string>> libraries;  // by name: the order of addresses changes from run to run
  for (const std::string& file : mapped.files) {
    const std::string hash = hashes.of(file);
    if (hash.empty() && engine.fingerprint.empty() && identity.unknown_code.empty())
      identity.unknown_code = "it runs code of " + file + ", which cannot be read";
    libraries.emplace(same_file(file, program_of(command)) ? "" : fs::path(file).filename().string(), hash);
  }
  for (const auto& [name, hash] : libraries) add(name, hash);

  for (const std::string& listed : engine.files) {
    if (!identity.error.empty()) break;
    const std::string path = (folder_of_program(command) / listed).string();
    const std::string hash = hashes.of(path);
    std::error_code error;
    if (!fs::exists(path, error))
      identity.error = "hello lists the file `" + listed + "`, which does not exist (" + path + ")";
    else if (hash.empty())
      identity.error = "hello lists `" + listed + "`, which is not a regular file that can be read (" + path + ")";
    if (!identity.error.empty()) break;
    add("listed " + listed, hash);
  }
  identity.hash = all;
  return identity;
}

std::string code_loaded_since(const std::vector<std::string>& command, const Engine& engine,
                              const std::vector<std::string>& code, pid_t process) {
  for (const std::string& file : mapped_files(process).files) {
    if (std::binary_search(code.begin(), code.end(), file)) continue;
    const bool listed = std::any_of(engine.files.begin(), engine.files.end(), [&](const std::string& name) {
      return same_file(file, (folder_of_program(command) / name).string());
    });
    if (!listed) return file;
  }
  return "";
}

}  // namespace atwood
