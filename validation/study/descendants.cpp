#include "validation/study/descendants.hpp"

#include <dirent.h>
#include <fcntl.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <set>
#include <thread>
#include <vector>

extern "C" {  // missing in the header of glibc 2.36
#include <sys/pidfd.h>
}

namespace atwood {
namespace {

constexpr std::size_t kLongestFile = std::size_t{4} << 20;
constexpr int kRounds = 200;  // a process that forks as fast as it is killed is no longer pursued after this many

struct LiveWorkers {
  std::mutex mutex;
  std::set<pid_t> pids;
  bool adopting = false;
  bool inherited = false;  // the program had children before it started a worker: `setsid server & exec atwood`
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

// Whether the process is an orphan of a worker that this program has adopted. Processes that this program starts itself
// stay in its session, which an orphan in another session cannot rejoin.
bool adopted(const Stat& stat) {
  return stat.parent == getpid() && stat.session != getsid(0) && !live().pids.contains(stat.pid);
}

// Goes through all processes once; true where it killed one, which may have started others meanwhile.
bool sweep(pid_t worker, const std::string& mark, bool last) {
  bool found = false;
  for (const pid_t pid : all_processes()) {
    if (pid == getpid() || pid == worker || live().pids.contains(pid)) continue;
    const Stat stat = stat_of(pid);
    if (stat.pid < 0) continue;
    const bool orphan = adopted(stat);
    if (orphan && stat.zombie && !live().inherited) {
      waitpid(pid, nullptr, WNOHANG);
      continue;
    }
    const bool in_session = stat.session == worker && worker > 0;
    // As process 1 of a container, or with children inherited across exec, this program adopts orphans of others too.
    const bool unclaimed = orphan && last && getpid() != 1 && !live().inherited;
    if (stat.zombie || !(in_session || unclaimed || (orphan && carries(pid, mark)))) continue;
    found = true;
    kill_if_still(stat);
  }
  return found;
}

using Processes = std::vector<Stat>;

std::shared_ptr<const Processes> processes_now() {
  auto all = std::make_shared<Processes>();
  for (const pid_t pid : all_processes())
    if (const Stat stat = stat_of(pid); stat.pid >= 0 && !stat.zombie && pid != getpid()) all->push_back(stat);
  return all;
}

// The processes as they were at most kSharedLook ago: one look serves the watches of all workers.
std::shared_ptr<const Processes> recent_processes() {
  using Clock = std::chrono::steady_clock;
  constexpr std::chrono::milliseconds kSharedLook{100};
  static std::mutex mutex;
  static std::shared_ptr<const Processes> seen;
  static Clock::time_point seen_at;
  const std::lock_guard<std::mutex> held(mutex);
  if (!seen || Clock::now() - seen_at > kSharedLook) {
    seen = processes_now();
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

}  // namespace

std::string next_worker_mark() {
  static std::atomic<std::int64_t> number{0};
  return "ATWOOD_WORKER=" + std::to_string(getpid()) + "." + std::to_string(++number);
}

std::unique_lock<std::mutex> lock_workers() { return std::unique_lock(live().mutex); }
void enter_worker(pid_t pid) { live().pids.insert(pid); }

void adopt_orphans() {
  const auto held = lock_workers();
  if (live().adopting) return;
  for (const pid_t pid : all_processes()) live().inherited = live().inherited || stat_of(pid).parent == getpid();
  live().adopting = prctl(PR_SET_CHILD_SUBREAPER, 1) == 0;
}

void kill_descendants(pid_t worker, const std::string& mark) {
  const auto held = lock_workers();
  live().pids.erase(worker);
  const bool last = live().pids.empty();
  for (int round = 0; round < kRounds && sweep(worker, mark, last); ++round)
    std::this_thread::sleep_for(std::chrono::microseconds(500));
}

std::int64_t resident_bytes(pid_t process) { return stat_of(process).resident_pages * sysconf(_SC_PAGESIZE); }

std::int64_t family_bytes(pid_t worker, const std::string& mark, std::int64_t most) {
  const std::vector<Stat> members = family(worker, mark, *recent_processes());
  std::int64_t sum = 0, own_sum = 0;
  for (const Stat& stat : members) sum += stat.resident_pages * sysconf(_SC_PAGESIZE);
  if (sum <= most) return sum;
  for (const Stat& stat : members) {
    const std::int64_t own = own_bytes(stat.pid);
    own_sum += own >= 0 ? own : stat.resident_pages * sysconf(_SC_PAGESIZE);
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
