#include "validation/study/descendants.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <limits.h>
#include <linux/magic.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/stat.h>
#include <sys/statfs.h>
#include <sys/sysmacros.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <sstream>
#include <thread>
#include <vector>

extern "C" {  // missing in the header of glibc 2.36
#include <sys/pidfd.h>
}

namespace atwood {
namespace {

constexpr std::size_t kLongestFile = std::size_t{4} << 20;
constexpr std::chrono::milliseconds kExec{
    5};                       // while a process begins to run another program, its environment is empty
constexpr int kRounds = 200;  // a process that forks as fast as it is killed is no longer pursued after this many

struct LiveWorkers {
  std::mutex mutex;
  std::map<pid_t, std::string> marks;  // of running workers
  bool adopting = false;
  // Children that the program had before it started a worker (`server & exec atwood`), and the sessions of then.
  std::set<pid_t> inherited, old_sessions;
};
LiveWorkers& live() {
  static LiveWorkers workers;
  return workers;
}

// A file of /proc/PID; empty where the process has ended, which can happen at any time. Not by a stream: its buffer
// throws on ESRCH.
std::string read_of_process(pid_t pid, const char* name) {
  const int file = open(("/proc/" + std::to_string(pid) + "/" + name).c_str(), O_RDONLY | O_CLOEXEC);
  if (file < 0) return "";
  std::string text;
  char block[4096];
  ssize_t size = 0;
  while (text.size() < kLongestFile && ((size = read(file, block, sizeof block)) > 0 || (size < 0 && errno == EINTR)))
    if (size > 0) text.append(block, static_cast<std::size_t>(size));
  close(file);
  return text;
}

struct Stat {
  pid_t pid = -1, parent = -1, session = -1;
  bool zombie = false;
  long long resident_pages = 0;
};

// proc(5): pid (name) state parent group session, seventeen more, resident pages; the name may hold anything.
Stat stat_of(pid_t pid) {
  const std::string text = read_of_process(pid, "stat");
  const std::size_t name_end = text.rfind(')');
  Stat stat;
  char state = 0;
  int parent = 0, group = 0, session = 0;
  long long pages = 0;
  if (name_end == std::string::npos) return stat;
  const char* const form = " %c %d %d %d %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %*s %lld";
  if (std::sscanf(text.c_str() + name_end + 1, form, &state, &parent, &group, &session, &pages) != 5) return stat;
  return {pid, parent, session, state == 'Z' || state == 'X', pages};
}

std::vector<pid_t> all_processes() {
  std::vector<pid_t> pids;
  DIR* folder = opendir("/proc");
  if (!folder) return pids;
  while (const dirent* entry = readdir(folder)) {
    if (entry->d_name[0] >= '1' && entry->d_name[0] <= '9')
      pids.push_back(static_cast<pid_t>(std::atoi(entry->d_name)));
  }
  closedir(folder);
  return pids;
}

bool carries(pid_t pid, const std::string& mark) {
  const std::string environment = read_of_process(pid, "environ");
  for (std::size_t at = 0; (at = environment.find(mark, at)) != std::string::npos; ++at) {
    const std::size_t end = at + mark.size();
    if ((at == 0 || environment[at - 1] == '\0') && (end == environment.size() || environment[end] == '\0'))
      return true;
  }
  return false;
}

// Uses a process descriptor, because the number may belong to another process by now.
void kill_if_still(const Stat& seen) {
  const int handle = pidfd_open(seen.pid, 0);
  if (handle < 0) return;
  const Stat now = stat_of(seen.pid);
  if (now.session == seen.session && now.parent == seen.parent) pidfd_send_signal(handle, SIGKILL, nullptr, 0);
  close(handle);
}

// Whether the process is an orphan that this program has adopted. Processes that this program starts itself stay in its
// session, which an orphan in another session cannot rejoin.
bool adopted(const Stat& stat) {
  return stat.parent == getpid() && stat.session != getsid(0) && !live().marks.contains(stat.pid) &&
         !live().inherited.contains(stat.pid);
}

bool has_no_new_privileges(pid_t pid) {
  return read_of_process(pid, "status").find("\nNoNewPrivs:\t1") != std::string::npos;
}

// Whether an orphan may be that of another program: as process 1 of a container, or with children inherited across
// exec, this program adopts those too. What a confined worker has started can gain no privileges, ever.
bool may_be_of_others(const Stat& orphan) {
  if (live().old_sessions.contains(orphan.session)) return true;
  if (getpid() != 1 && live().inherited.empty()) return false;
  return !has_no_new_privileges(orphan.pid) || has_no_new_privileges(getpid());
}

// Whether it is in a running worker's session or has its mark.
bool belongs_to_a_worker(const Stat& stat) {
  if (live().marks.contains(stat.session)) return true;
  return std::any_of(live().marks.begin(), live().marks.end(),
                     [&](const auto& worker) { return carries(stat.pid, worker.second); });
}

// Those orphans that cannot be attributed to a running worker: which limit their memory is to keep is unknown.
std::vector<Stat> strays_among(std::vector<Stat> orphans) {
  const auto leave_strays = [&] {
    std::erase_if(orphans, [](const Stat& one) { return may_be_of_others(one) || belongs_to_a_worker(one); });
  };
  leave_strays();
  if (orphans.empty()) return orphans;
  std::this_thread::sleep_for(kExec);
  leave_strays();
  return orphans;
}

// Goes through all processes once; true where it killed one, which may have started others meanwhile.
bool sweep(pid_t worker, const std::string& mark) {
  std::vector<Stat> doomed, orphans;
  for (const pid_t pid : all_processes()) {
    if (pid == getpid() || pid == worker || live().marks.contains(pid)) continue;
    const Stat stat = stat_of(pid);
    if (stat.pid < 0) continue;
    const bool orphan = adopted(stat);
    if (orphan && stat.zombie && !live().old_sessions.contains(stat.session)) waitpid(pid, nullptr, WNOHANG);
    if (stat.zombie) continue;
    if ((stat.session == worker && worker > 0) || (orphan && carries(pid, mark))) doomed.push_back(stat);
    else if (orphan) orphans.push_back(stat);
  }
  for (const Stat& stat : doomed) kill_if_still(stat);
  orphans = strays_among(std::move(orphans));
  for (const Stat& stat : orphans) kill_if_still(stat);
  return !doomed.empty() || !orphans.empty();
}

using Processes = std::vector<Stat>;

void kill_strays(const Processes& all) {
  const auto held = lock_workers();
  std::vector<Stat> orphans;
  for (const Stat& stat : all)
    if (adopted(stat)) orphans.push_back(stat);
  for (const Stat& stat : strays_among(std::move(orphans))) kill_if_still(stat);
}

std::shared_ptr<const Processes> processes_now() {
  auto all = std::make_shared<Processes>();
  for (const pid_t pid : all_processes())
    if (const Stat stat = stat_of(pid); stat.pid >= 0 && !stat.zombie && pid != getpid()) all->push_back(stat);
  return all;
}

// The processes as they were at most shared_look ago: one look serves the watches of all workers.
std::shared_ptr<const Processes> recent_processes() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds shared_look{100};
  static std::mutex mutex;
  static std::shared_ptr<const Processes> seen;
  static Clock::time_point seen_at;
  const std::lock_guard<std::mutex> held(mutex);
  if (!seen || Clock::now() - seen_at > shared_look) {
    seen = processes_now();
    kill_strays(*seen);
    seen_at = Clock::now();
  }
  return seen;
}

// The worker, the processes of its session, all that descend from one of these, and adopted orphans with its mark.
std::vector<Stat> family(pid_t worker, const std::string& mark, const Processes& all) {
  std::vector<Stat> others, found;
  std::set<pid_t> members;
  const auto take = [&](const Stat& stat) { found.push_back(stat), members.insert(stat.pid); };
  for (const Stat& stat : all) {
    const bool orphan = stat.parent == getpid() && stat.session != getsid(0) && stat.pid != worker;
    if (stat.pid == worker || stat.session == worker || (orphan && carries(stat.pid, mark))) take(stat);
    else others.push_back(stat);
  }
  for (std::size_t before = 0; before != found.size();) {
    before = found.size();
    std::erase_if(others, [&](const Stat& stat) {
      if (!members.contains(stat.parent)) return false;
      take(stat);
      return true;
    });
  }
  return found;
}

// Memory that only this process has, and its share of what it has with others; without mapped files where the kernel
// tells them apart. -1: unknown.
std::int64_t own_bytes(pid_t pid) {
  const std::string text = read_of_process(pid, "smaps_rollup");
  const auto value = [&](const char* name) -> std::int64_t {
    const std::size_t at = text.find(name);
    return at == std::string::npos ? -1 : 1024 * std::atoll(text.c_str() + at + std::strlen(name));
  };
  const std::int64_t anonymous = value("\nPss_Anon:"), shared = value("\nPss_Shmem:");
  return anonymous >= 0 && shared >= 0 ? anonymous + shared : value("\nPss:");
}

using Files = std::set<std::pair<dev_t, ino_t>>;

// Whether the file is memory and has no name: it goes when nothing holds it open, and until then is in the size of no
// process but as far as it is mapped.
bool is_nameless_memory(const std::string& link, const std::string& path) {
  if (link.starts_with("/memfd:")) return true;
  struct statfs about {};
  return link.ends_with(" (deleted)") && statfs(path.c_str(), &about) == 0 &&
         (about.f_type == TMPFS_MAGIC || about.f_type == RAMFS_MAGIC);
}

// Bytes of the nameless files in memory that the process holds open and that are not `counted` yet.
std::int64_t held_bytes(pid_t pid, Files& counted) {
  const std::string folder = "/proc/" + std::to_string(pid) + "/fd";
  const std::unique_ptr<DIR, int (*)(DIR*)> entries(opendir(folder.c_str()), closedir);
  std::int64_t bytes = 0;
  while (const dirent* entry = entries ? readdir(entries.get()) : nullptr) {
    const std::string path = folder + "/" + entry->d_name;
    char target[PATH_MAX];
    const ssize_t length = readlink(path.c_str(), target, sizeof target);
    struct stat info {};
    if (length <= 0 || !is_nameless_memory(std::string(target, static_cast<std::size_t>(length)), path)) continue;
    if (stat(path.c_str(), &info) == 0 && info.st_nlink == 0 && counted.emplace(info.st_dev, info.st_ino).second)
      bytes += std::int64_t{512} * info.st_blocks;
  }
  return bytes;
}

// The process's share of the pages that it has mapped of these files.
std::int64_t mapped_bytes(pid_t pid, const Files& files) {
  std::int64_t bytes = 0, share = 0;
  bool counts = false;
  std::istringstream lines(read_of_process(pid, "smaps"));
  for (std::string line; std::getline(lines, line);) {
    unsigned major = 0, minor = 0;
    unsigned long long file = 0;
    if (std::sscanf(line.c_str(), "%*x-%*x %*s %*x %x:%x %llu", &major, &minor, &file) == 3)
      counts = files.contains({makedev(major, minor), file});
    else if (counts && line.starts_with("Pss:")) share = 1024 * std::atoll(line.c_str() + 4), bytes += share;
    else if (counts && line.starts_with("Anonymous:"))  // copies of its own
      bytes -= std::min<std::int64_t>(share, 1024 * std::atoll(line.c_str() + 10));
  }
  return bytes;
}

}  // namespace

std::string next_worker_mark() {
  static std::atomic<std::int64_t> number{0};
  return "ATWOOD_WORKER=" + std::to_string(getpid()) + "." + std::to_string(++number);
}

std::unique_lock<std::mutex> lock_workers() { return std::unique_lock(live().mutex); }
void enter_worker(pid_t pid, const std::string& mark) { live().marks[pid] = mark; }

void adopt_orphans() {
  const auto held = lock_workers();
  if (live().adopting) return;
  for (const pid_t pid : all_processes()) {
    const Stat stat = stat_of(pid);
    if (stat.parent == getpid()) live().inherited.insert(pid);
    if (stat.pid >= 0) live().old_sessions.insert(stat.session);
  }
  live().adopting = prctl(PR_SET_CHILD_SUBREAPER, 1) == 0;
}

void kill_descendants(pid_t worker, const std::string& mark) {
  const auto held = lock_workers();
  live().marks.erase(worker);
  for (int round = 0; round < kRounds && sweep(worker, mark); ++round)
    std::this_thread::sleep_for(std::chrono::microseconds(500));
}

std::int64_t resident_bytes(pid_t process) { return stat_of(process).resident_pages * sysconf(_SC_PAGESIZE); }

std::int64_t family_bytes(pid_t worker, const std::string& mark, std::int64_t most) {
  const std::vector<Stat> members = family(worker, mark, *recent_processes());
  Files files;
  std::int64_t held = 0;
  for (const Stat& stat : members) held += held_bytes(stat.pid, files);
  std::int64_t sum = held, own_sum = held;
  for (const Stat& stat : members) sum += stat.resident_pages * sysconf(_SC_PAGESIZE);
  if (sum <= most) return sum;
  for (const Stat& stat : members) {
    const std::int64_t own = own_bytes(stat.pid);
    own_sum += own >= 0 ? own : stat.resident_pages * sysconf(_SC_PAGESIZE);
    if (held > 0) own_sum -= mapped_bytes(stat.pid, files);
  }
  return own_sum;
}

void kill_family(pid_t worker, const std::string& mark) {
  for (int round = 0; round < kRounds; ++round) {
    const std::vector<Stat> members = family(worker, mark, *processes_now());
    if (members.empty()) return;
    for (const Stat& stat : members) kill_if_still(stat);
    std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
}

}  // namespace atwood
