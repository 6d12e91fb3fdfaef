// What decides a worker's results, as far as it can be seen from outside: its program, the files that its command
// names, the shared libraries that it has loaded, and what it says of itself in hello.
//
// The libraries are those that the running process has mapped as code after it answered hello (/proc/PID/maps): what
// the dynamic linker resolved, what LD_PRELOAD and LD_LIBRARY_PATH put in their place, and what was loaded with dlopen
// by then. What is loaded later is not seen; a worker names it in hello's `files`, or gives a `fingerprint`.
#pragma once

#include <sys/types.h>

#include <map>
#include <string>
#include <tuple>
#include <vector>

#include "protocol/method.hpp"

namespace atwood {

// Hashes of files, each read once as long as it does not change: engines share most libraries.
class FileHashes {
 public:
  std::string of(const std::string& path);  // empty: no regular file, or not readable

 private:
  using Stamp = std::tuple<dev_t, ino_t, off_t, time_t, long>;
  std::map<Stamp, std::string> known_;
};

struct WorkerIdentity {
  std::string hash;            // equal: the same program, libraries, files, fingerprint
  // Not empty: code beyond all that may decide its results (a script's imports, a launcher's child), and why. A worker
  // that gives a fingerprint answers for all of its code.
  std::string unknown_code;
  std::string error;           // not empty: hello lists a file that does not exist, or is no regular file
};

// `process`: the running worker, which has answered hello with `engine`. Files that hello lists by relative paths
// start at the folder of the program: the script's, where the command runs a script by its interpreter.
WorkerIdentity identify_worker(const std::vector<std::string>& command, const Engine& engine, pid_t process,
                               FileHashes& hashes);

}  // namespace atwood
