// What a worker may do beside computing: a limit of memory, no network, no writing outside a scratch directory. Linux.
//
// Memory is the resident size of the worker with its descendants, which a thread watches. A limit of the address space
// (RLIMIT_AS) or of private mappings (RLIMIT_DATA) would end programs that reserve much and use little: WebAssembly,
// the address sanitizer.
//
// Writing is confined by Landlock and by a mount namespace in which all but the scratch directory is read-only, or by
// one of them where the kernel lacks the other: Landlock does not cover modes, times and attributes of files. The
// network is confined by a network namespace, or else by Landlock, which stops TCP alone. Which of them this program
// may use is found by trying each once. Where a worker cannot be confined as far as that, it is not started.
#pragma once

#include <sys/types.h>

#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

namespace atwood {

inline constexpr std::int64_t kDefaultMemoryBytes = std::int64_t{4} << 30;

// By which means workers can be confined here.
struct ConfinementMeans {
  // `privileged`: by this program's own rights; `user`: inside a user namespace, which needs none.
  enum class Namespaces { none, user, privileged };
  int landlock_abi = 0;  // 0: no Landlock
  Namespaces network = Namespaces::none, mount = Namespaces::none;
  std::string no_landlock, no_network, no_mount;  // why not, where there is none
};
inline constexpr int kLandlockOfTcp = 4;  // the first ABI that restricts TCP

const ConfinementMeans& kernel_means();  // tried at the first call
// The ways that workers are confined in, one line each: {"network", "none (a network namespace)"}.
struct ConfinementLine {
  std::string what, how;
  bool full = true;  // false: weaker than it is elsewhere
};
std::vector<ConfinementLine> describe(const ConfinementMeans& means, std::int64_t memory_bytes);
// "network: ...; writing: ...": what is not fully confined; empty: nothing.
std::string confinement_gaps(const ConfinementMeans& means);

struct Confinement {
  bool sandbox = true;                              // false: only the limit of memory holds
  std::int64_t memory_bytes = kDefaultMemoryBytes;  // 0: no limit
  std::vector<std::string> writable = {};           // folders, made where missing, that the worker may write in too
  std::optional<ConfinementMeans> means = {};       // unset: kernel_means()
};

// Removes the scratch directories in this folder whose owner was killed; it runs once by itself, where they are made.
void remove_stale_scratch(const std::string& beside);

// The confinement of one worker: made before the fork, applied by the child, removed after the worker's end.
class PreparedConfinement {
 public:
  explicit PreparedConfinement(const Confinement& asked);  // std::runtime_error
  PreparedConfinement(const PreparedConfinement&) = delete;
  PreparedConfinement& operator=(const PreparedConfinement&) = delete;
  ~PreparedConfinement();  // removes the scratch directory

  // Between fork and exec: async-signal-safe calls only. The step that failed, with errno; nullptr: none did.
  const char* apply() const;
  // HOME=..., TMPDIR=... of the worker, and the names that it does not inherit; both empty without a sandbox.
  const std::vector<std::string>& environment() const { return environment_; }
  bool keeps_variable(const char* entry) const;
  const std::string& scratch() const { return scratch_; }  // empty: none

 private:
  const char* enter_namespaces() const;
  const char* make_read_only() const;

  std::string scratch_, uid_map_, gid_map_;
  std::vector<std::string> writable_, environment_;
  std::int64_t memory_bytes_ = 0;
  int lock_ = -1, ruleset_ = -1, namespaces_ = 0;
};

// Watches the memory of a worker with its descendants and kills them all where they take more than the limit.
class MemoryWatch {
 public:
  MemoryWatch(pid_t worker, std::string mark, std::int64_t most_bytes);
  MemoryWatch(const MemoryWatch&) = delete;
  MemoryWatch& operator=(const MemoryWatch&) = delete;
  ~MemoryWatch() { end(); }
  bool exceeded() const { return exceeded_; }
  void end();  // before the worker is reaped

 private:
  void watch();

  pid_t worker_;
  std::string mark_;
  std::int64_t most_bytes_;
  std::atomic<bool> exceeded_{false};
  bool stop_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;
};

std::string memory_text(std::int64_t bytes);  // "4 GiB", "256 MiB"

}  // namespace atwood
