// Landlock's three system calls: a process gives up rights on files, TCP and signals, for itself and all that it
// starts. Its numbers and structures are written here, because the headers of Debian 12 know fewer than the kernel may
// have. Source: linux/landlock.h, landlock(7).
#pragma once

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "validation/study/process.hpp"

namespace atwood::landlock {

inline constexpr long kCreateRuleset = 444, kAddRule = 445, kRestrictSelf = 446;
inline constexpr std::uint32_t kAskVersion = 1;
inline constexpr int kPathBeneath = 1;

inline constexpr std::uint64_t bit(int n) { return std::uint64_t{1} << n; }
inline constexpr std::uint64_t kWriteFile = bit(1), kTruncate = bit(14);
inline constexpr std::uint64_t kChangeFolders = bit(4) | bit(5) | bit(6) | bit(7) | bit(8) | bit(9) | bit(10) |
                                                bit(11) | bit(12);  // remove and make entries of each kind
inline constexpr std::uint64_t kRefer = bit(13);                    // move between folders
inline constexpr std::uint64_t kTcp = bit(0) | bit(1);              // bind, connect
inline constexpr std::uint64_t kScopes = bit(0) | bit(1);           // abstract Unix sockets, signals

struct Ruleset {
  std::uint64_t files = 0, network = 0, scoped = 0;
};
struct __attribute__((packed)) PathRule {
  std::uint64_t allowed;
  std::int32_t folder;
};

// The version of its interface; not positive, with errno: the kernel has none, or it is switched off.
inline int abi() { return static_cast<int>(syscall(kCreateRuleset, nullptr, std::size_t{0}, kAskVersion)); }

inline std::uint64_t changes_of(int abi) {
  return kWriteFile | kChangeFolders | (abi >= 2 ? kRefer : 0) | (abi >= 3 ? kTruncate : 0);
}

inline void allow(int ruleset, const std::string& path, std::uint64_t rights, bool required) {
  const int place = open(path.c_str(), O_PATH | O_CLOEXEC);
  const PathRule rule{rights, place};
  const bool added = place >= 0 && syscall(kAddRule, ruleset, kPathBeneath, &rule, 0U) == 0;
  const int error = errno;
  if (place >= 0) close(place);
  if (added || !required) return;
  close(ruleset);
  throw SystemFault("Landlock does not take " + path + ": " + std::strerror(error));
}

// A set of rules, as a descriptor: nothing is changed but in these folders, and in devices that keep nothing; no TCP
// where `without_tcp`; no signals to processes outside. Throws SystemFault.
inline int ruleset(int abi, const std::vector<std::string>& writable, bool without_tcp) {
  const Ruleset all{changes_of(abi), without_tcp && abi >= 4 ? kTcp : 0, abi >= 6 ? kScopes : 0};
  const int made = static_cast<int>(syscall(kCreateRuleset, &all, sizeof all, 0U));
  if (made < 0) throw SystemFault(std::string("no rules of Landlock: ") + std::strerror(errno));
  for (const std::string& folder : writable) allow(made, folder, all.files, true);
  for (const char* device : {"/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/dev/urandom"})
    allow(made, device, all.files & (kWriteFile | kTruncate), false);
  return made;
}

inline bool restrict_self(int ruleset) { return syscall(kRestrictSelf, ruleset, 0U) == 0; }

}  // namespace atwood::landlock
