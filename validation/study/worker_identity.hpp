// Identifies the code that decides a worker's results, as far as it is visible from outside: its program, the files
// that its command names, the shared libraries that it has loaded, and its answer to `hello`.
//
// The libraries are those that the running process has mapped as code after it answered hello (/proc/PID/maps): what
// the dynamic linker resolved, what LD_PRELOAD and LD_LIBRARY_PATH put in their place, and what was loaded with dlopen
// by then. Code that is loaded later is in no hash unless the worker names it in `files` or covers it by a
// `fingerprint` in its answer: code_loaded_since() finds it, and every run measures the cells of such a process again.
#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "protocol/method.hpp"

namespace atwood {

// Larger files are not hashed: that would take minutes, and with a sparse file much longer.
inline constexpr off_t kLargestHashedFile = off_t{4} << 30;

// Hashes of files, each read once as long as it does not change: engines share most libraries.
class FileHashes {
 public:
  std::string of(const std::string& path);  // empty: no regular file, not readable, or too large

 private:
  using Stamp = std::tuple<dev_t, ino_t, off_t, time_t, long>;
  std::map<Stamp, std::string> known_;
};

struct WorkerIdentity {
  std::string hash;  // equal: the same program, libraries, files, fingerprint
  // Not empty: why code outside the hash may decide the results (a script's imports, the child of a launcher). A
  // fingerprint covers all code of a worker.
  std::string unknown_code;
  std::string error;  // not empty: hello lists a file that does not exist or is not a regular file, or one is too large
  std::vector<std::string> code;  // files that the process has mapped as code, sorted
  bool process_ended = false;     // before its libraries were read: the hash is without them
};

// `process`: the running worker, which has answered hello with `engine`. Files that hello lists by relative paths
// start at the folder of the program: the script's, where the command runs a script by its interpreter.
WorkerIdentity identify_worker(const std::vector<std::string>& command, const Engine& engine, pid_t process,
                               FileHashes& hashes);

// A file that the process has mapped as code since it answered `hello`: neither in `code` (Worker::code) nor among the
// `files` of its answer; empty: none.
std::string code_loaded_since(const std::vector<std::string>& command, const Engine& engine,
                              const std::vector<std::string>& code, pid_t process);

}  // namespace atwood
