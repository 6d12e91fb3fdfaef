#include "validation/study/confinement.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <sched.h>
#include <sys/file.h>
#include <sys/mount.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <ctime>
#include <filesystem>
#include <memory>
#include <new>
#include <stdexcept>

#include "validation/study/landlock.hpp"
#include "validation/study/process.hpp"

namespace atwood {
namespace fs = std::filesystem;
namespace {

constexpr const char* kScratchPrefix = "atwood-worker-";
constexpr std::time_t kStaleAfterS = 60;
constexpr int kKeptCapability = 1;  // CAP_DAC_OVERRIDE: a worker of root still reads what root may read
constexpr int kMaxCapabilities = 64;
// Not inherited: they would lead programs past HOME and TMPDIR.
constexpr std::array kDroppedVariables = {"HOME=",
                                          "TMPDIR=",
                                          "TMP=",
                                          "TEMP=",
                                          "PWD=",
                                          "OLDPWD=",
                                          "XDG_CACHE_HOME=",
                                          "XDG_CONFIG_HOME=",
                                          "XDG_DATA_HOME=",
                                          "XDG_STATE_HOME=",
                                          "XDG_RUNTIME_DIR="};

// ---- the scratch directory ----------------------------------------------------------------------------------------
// Its owner holds a lock on it; one whose owner was killed is found by that.
void remove_folder(const std::string& path) {
  std::error_code error;
  fs::remove_all(path, error);
  if (!error) return;
  // A worker may have taken the rights of its folders away.
  for (fs::recursive_directory_iterator each(path, error), end; !error && each != end; each.increment(error))
    if (each->is_directory(error) && !each->is_symlink(error))
      fs::permissions(each->path(), fs::perms::owner_all, error);
  fs::remove_all(path, error);
}

std::string make_scratch() {
  std::error_code error;
  fs::path beside = fs::canonical(fs::temp_directory_path(error), error);
  if (error) beside = "/tmp";
  static const bool cleared = (remove_stale_scratch(beside.string()), true);
  static_cast<void>(cleared);
  std::string path = (beside / kScratchPrefix).string() + "XXXXXX";
  if (mkdtemp(path.data()) == nullptr)
    throw SystemFault("no scratch directory in " + beside.string() + ": " + std::strerror(errno));
  return path;
}

// ---- namespaces ---------------------------------------------------------------------------------------------------
bool write_file(const char* path, const std::string& text) {
  const int file = open(path, O_WRONLY | O_CLOEXEC);
  if (file < 0) return false;
  const bool written = write(file, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const int error = errno;
  close(file);
  errno = error;
  return written;
}

// linux/mount.h of Debian 12 and sys/mount.h of other releases define these twice or not at all.
struct MountAttributes {
  std::uint64_t set = 0, clear = 0, propagation = 0, user_namespace = 0;
};
constexpr std::uint64_t kReadOnly = 1;
constexpr unsigned kRecursive = 0x8000;
constexpr long kMountSetattr = 442;

bool set_mount(const char* path, unsigned flags, const MountAttributes& attributes) {
  return syscall(kMountSetattr, AT_FDCWD, path, flags, &attributes, sizeof attributes) == 0;
}

// A program of root gets the rights of its bounding set at exec. Those that could undo the confinement are taken from
// it; without the right to do so there are none to take.
void drop_capabilities() {
  prctl(PR_CAP_AMBIENT, PR_CAP_AMBIENT_CLEAR_ALL, 0, 0, 0);
  struct {
    std::uint32_t version;
    int pid;
  } header{0x20080522, 0};
  struct {
    std::uint32_t effective, permitted, inheritable;
  } sets[2] = {};
  if (syscall(SYS_capget, &header, sets) == 0) {
    sets[0].inheritable = sets[1].inheritable = 0;
    syscall(SYS_capset, &header, sets);
  }
  for (int capability = 0; capability < kMaxCapabilities; ++capability)
    if (capability != kKeptCapability) prctl(PR_CAPBSET_DROP, capability, 0, 0, 0);
}

void limit(int resource, std::int64_t most) {
  rlimit both{};
  if (getrlimit(static_cast<__rlimit_resource>(resource), &both) != 0) return;
  both.rlim_cur = both.rlim_max = std::min(both.rlim_max, static_cast<rlim_t>(most));
  setrlimit(static_cast<__rlimit_resource>(resource), &both);
}

// ---- what the kernel offers ---------------------------------------------------------------------------------------
// Applies it in a child; why it failed, empty where it did not.
std::string failure_of(const ConfinementMeans& means) {
  try {
    const PreparedConfinement tried({.sandbox = true, .memory_bytes = 0, .writable = {}, .means = means});
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) return std::strerror(errno);
    const pid_t child = fork();
    if (child == 0) {
      const char* step = tried.apply();
      const std::string_view text = step ? strerrordesc_np(errno) : "";
      const auto written = write(ends[1], text.data(), text.size());
      _exit(step != nullptr || written < 0 ? 1 : 0);
    }
    close(ends[1]);
    char text[128];
    const ssize_t size = child < 0 ? 0 : read(ends[0], text, sizeof text);
    close(ends[0]);
    int status = 0;
    if (child < 0 || waitpid(child, &status, 0) != child) return "it could not be tried";
    if (WIFEXITED(status) && WEXITSTATUS(status) == 0) return "";
    return size > 0 ? std::string(text, static_cast<std::size_t>(size)) : "it failed";
  } catch (const std::runtime_error& error) {
    return error.what();
  }
}

struct TriedNamespaces {
  ConfinementMeans::Namespaces kind = ConfinementMeans::Namespaces::none;  // the first that works
  std::string failure;                                                     // of the last tried; empty: it works
};

TriedNamespaces first_that_works(ConfinementMeans::Namespaces ConfinementMeans::*member) {
  using enum ConfinementMeans::Namespaces;
  TriedNamespaces tried;
  for (const auto kind : {privileged, user}) {
    if (kind == privileged && geteuid() != 0) continue;
    ConfinementMeans only;
    only.*member = kind;
    tried.failure = failure_of(only);
    if (tried.failure.empty()) {
      tried.kind = kind;
      break;
    }
  }
  return tried;
}

ConfinementMeans find_means() {
  ConfinementMeans means;
  const int abi = landlock::abi();
  if (abi <= 0) {
    means.no_landlock = errno == EOPNOTSUPP ? "it is switched off" : "the kernel has none";
  } else {
    ConfinementMeans only;
    only.landlock_abi = abi;
    means.no_landlock = failure_of(only);
    if (means.no_landlock.empty()) means.landlock_abi = abi;
  }
  const TriedNamespaces network = first_that_works(&ConfinementMeans::network),
                        mount = first_that_works(&ConfinementMeans::mount);
  means.network = network.kind, means.no_network = network.failure;
  means.mount = mount.kind, means.no_mount = mount.failure;
  return means;
}

// Not by directory_iterator: GCC 12's ends the program where memory is exhausted while it advances.
std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(opendir(folder.c_str()), closedir);
  while (const dirent* entry = entries ? readdir(entries.get()) : nullptr) names.emplace_back(entry->d_name);
  return names;
}

}  // namespace

void remove_stale_scratch(const std::string& beside) {
  for (const std::string& name : names_in(beside)) {
    if (name.rfind(kScratchPrefix, 0) != 0) continue;
    const std::string path = (fs::path(beside) / name).string();
    struct stat info {};
    if (lstat(path.c_str(), &info) != 0 || !S_ISDIR(info.st_mode) || info.st_uid != geteuid()) continue;
    if (info.st_mtime + kStaleAfterS > std::time(nullptr)) continue;
    const int folder = open(path.c_str(), O_RDONLY | O_DIRECTORY | O_NOFOLLOW | O_CLOEXEC);
    if (folder < 0) continue;
    if (flock(folder, LOCK_EX | LOCK_NB) == 0) remove_folder(path);
    close(folder);
  }
}

const ConfinementMeans& kernel_means() {
  static const ConfinementMeans means = find_means();
  return means;
}

std::string memory_text(std::int64_t bytes) {
  const auto text = [](double value) {
    char buffer[32];
    std::snprintf(buffer, sizeof buffer, "%.4g", value);
    return std::string(buffer);
  };
  const auto mebibytes = static_cast<double>(bytes) / (1 << 20);
  return mebibytes < 1024 ? text(mebibytes) + " MiB" : text(mebibytes / 1024) + " GiB";
}

std::vector<ConfinementLine> describe(const ConfinementMeans& means, std::int64_t memory_bytes) {
  using enum ConfinementMeans::Namespaces;
  const auto in_user = [](ConfinementMeans::Namespaces kind) { return kind == user ? " in a user namespace" : ""; };
  const std::string landlock = "Landlock, ABI " + std::to_string(means.landlock_abi);
  std::vector<ConfinementLine> lines;
  lines.push_back({"memory", memory_bytes > 0 ? "at most " + memory_text(memory_bytes) + " resident, with descendants"
                                              : "not limited"});
  const std::string no_namespace = "no network namespace: " + means.no_network;
  if (means.network != none)
    lines.push_back({"network", std::string("none: a network namespace") + in_user(means.network)});
  else if (means.landlock_abi >= kLandlockOfTcp)
    lines.push_back({"network", "no TCP, but other protocols (" + landlock + "; " + no_namespace + ")", false});
  else
    lines.push_back({"network",
                     "NOT confined (" + no_namespace + "; Landlock restricts TCP from ABI " +
                         std::to_string(kLandlockOfTcp) + " on)",
                     false});
  const std::string scratch = "only in the scratch directory: ";
  if (means.landlock_abi > 0 && means.mount != none)
    lines.push_back({"writing", scratch + landlock + ", and a mount namespace" + in_user(means.mount)});
  else if (means.landlock_abi > 0)
    lines.push_back({"writing",
                     scratch + landlock +
                         "; modes, times and attributes of files can be changed everywhere (no mount " +
                         "namespace: " + means.no_mount + ")",
                     false});
  else if (means.mount != none)
    lines.push_back({"writing", scratch + "a mount namespace" + in_user(means.mount) +
                                    " (no Landlock: " + means.no_landlock + ")"});
  else
    lines.push_back(
        {"writing", "NOT confined (no Landlock: " + means.no_landlock + "; no mount namespace: " + means.no_mount + ")",
         false});
  return lines;
}

std::string confinement_gaps(const ConfinementMeans& means) {
  std::string text;
  for (const ConfinementLine& line : describe(means, 0))
    if (!line.full) text += (text.empty() ? "" : "; ") + line.what + ": " + line.how;
  return text;
}

// ---- one worker ---------------------------------------------------------------------------------------------------
PreparedConfinement::PreparedConfinement(const Confinement& asked) {
  if (!asked.sandbox) return;
  const ConfinementMeans& means = asked.means ? *asked.means : kernel_means();
  using enum ConfinementMeans::Namespaces;
  const bool by_mounts = means.mount != none;
  const bool network = means.network != none;
  namespaces_ = (network ? CLONE_NEWNET : 0) | (by_mounts ? CLONE_NEWNS : 0);
  if ((network && means.network == user) || (by_mounts && means.mount == user)) namespaces_ |= CLONE_NEWUSER;
  uid_map_ = std::to_string(geteuid()) + " " + std::to_string(geteuid()) + " 1\n";
  gid_map_ = std::to_string(getegid()) + " " + std::to_string(getegid()) + " 1\n";
  memory_bytes_ = asked.memory_bytes;
  scratch_ = make_scratch();
  lock_ = open(scratch_.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (lock_ >= 0) flock(lock_, LOCK_SH);
  writable_ = {scratch_};
  for (const std::string& folder : asked.writable) {
    std::error_code error;
    fs::create_directories(folder, error);  // where it cannot be made, the worker says what it cannot write
    if (fs::is_directory(folder, error)) writable_.push_back(fs::canonical(folder, error).string());
  }
  for (const char* name : {"HOME=", "TMPDIR=", "TMP=", "TEMP=", "PWD="}) environment_.push_back(name + scratch_);
  if (means.landlock_abi == 0) return;
  try {
    ruleset_ = landlock::ruleset(means.landlock_abi, writable_, !network);
  } catch (...) {
    remove_folder(scratch_);
    if (lock_ >= 0) close(lock_);
    throw;
  }
}

PreparedConfinement::~PreparedConfinement() {
  if (ruleset_ >= 0) close(ruleset_);
  try {
    if (!scratch_.empty()) remove_folder(scratch_);
  } catch (const std::bad_alloc&) {}  // a later run removes it
  if (lock_ >= 0) close(lock_);
}

bool PreparedConfinement::keeps_variable(const char* entry) const {
  return scratch_.empty() || std::none_of(kDroppedVariables.begin(), kDroppedVariables.end(), [&](const char* name) {
           return std::strncmp(entry, name, std::strlen(name)) == 0;
         });
}

const char* PreparedConfinement::enter_namespaces() const {
  if (namespaces_ == 0) return nullptr;
  if (unshare(namespaces_) != 0) return "namespaces";
  if ((namespaces_ & CLONE_NEWUSER) == 0) return nullptr;
  if (!write_file("/proc/self/setgroups", "deny") && errno != ENOENT) return "the groups of a user namespace";
  if (!write_file("/proc/self/uid_map", uid_map_)) return "the user of a user namespace";
  if (!write_file("/proc/self/gid_map", gid_map_)) return "the group of a user namespace";
  return nullptr;
}

const char* PreparedConfinement::make_read_only() const {
  if ((namespaces_ & CLONE_NEWNS) == 0) return nullptr;
  if (mount("", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0) return "private mounts";
  for (const std::string& folder : writable_)
    if (mount(folder.c_str(), folder.c_str(), nullptr, MS_BIND, nullptr) != 0)
      return "a mount of the scratch directory";
  if (!set_mount("/", kRecursive, {.set = kReadOnly})) return "read-only mounts";
  for (const std::string& folder : writable_)
    if (!set_mount(folder.c_str(), 0, {.clear = kReadOnly})) return "a writable scratch directory";
  return nullptr;
}

const char* PreparedConfinement::apply() const {
  if (scratch_.empty()) return nullptr;
  limit(RLIMIT_CORE, 0);
  if (memory_bytes_ > 0) limit(RLIMIT_FSIZE, memory_bytes_);  // of one file in the scratch directory
  if (const char* step = enter_namespaces()) return step;
  if (const char* step = make_read_only()) return step;
  if (chdir(scratch_.c_str()) != 0) return "the scratch directory";
  drop_capabilities();
  if (prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0) != 0) return "no new privileges";
  if (ruleset_ >= 0 && !landlock::restrict_self(ruleset_)) return "Landlock";
  return nullptr;
}

}  // namespace atwood
