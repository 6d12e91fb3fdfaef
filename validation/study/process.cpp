#include "validation/study/process.hpp"

#include <fcntl.h>
#include <linux/close_range.h>
#include <poll.h>
#include <sched.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <new>
#include <stdexcept>
#include <thread>

#include "validation/study/descendants.hpp"

namespace atwood {
namespace {

constexpr std::size_t kLongestErrors = std::size_t{64} << 10;
constexpr std::size_t kLongBlock = std::size_t{1} << 20;
constexpr int kSliceMs = 50;  // longest time until an interrupt is noticed

std::atomic<int> g_signal{0};     // the only thing the signal handler touches
std::atomic<bool> g_seen{false};  // interrupt_signal() has returned it
static_assert(std::atomic<int>::is_always_lock_free);

void forget_what_was_seen() {
  if (g_seen.exchange(false)) g_signal = 0;
}

void remember(int signal) { g_signal = signal; }

void close_end(int& end) {
  if (end >= 0) close(end);
  end = -1;
}

// A duplicate of the descriptor that is above 2: the child replaces descriptors 0 to 2.
int above_standard(int end) {
  if (end > STDERR_FILENO) return end;
  const int moved = fcntl(end, F_DUPFD_CLOEXEC, STDERR_FILENO + 1);
  if (moved < 0) return end;
  close(end);
  return moved;
}

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw SystemFault(std::string("no pipe to a worker: ") + std::strerror(errno));
    read = above_standard(ends[0]);
    write = above_standard(ends[1]);
  }
  ~Pipe() {
    close_end(read);
    close_end(write);
  }
  Pipe(const Pipe&) = delete;
  Pipe& operator=(const Pipe&) = delete;
};

void pin_to_last_processor() {
  cpu_set_t allowed, one;
  CPU_ZERO(&one);
  if (sched_getaffinity(0, sizeof allowed, &allowed) != 0) return;
  for (int cpu = CPU_SETSIZE - 1; cpu >= 0; --cpu) {
    if (!CPU_ISSET(cpu, &allowed)) continue;
    CPU_SET(cpu, &one);
    sched_setaffinity(0, sizeof one, &one);
    return;
  }
}

// Sets close-on-exec on all other descriptors, so that the worker does not inherit them.
void close_others_on_exec() {
  if (close_range(STDERR_FILENO + 1, ~0U, CLOSE_RANGE_CLOEXEC) == 0) return;
  for (int descriptor = STDERR_FILENO + 1; descriptor < 4096; ++descriptor) fcntl(descriptor, F_SETFD, FD_CLOEXEC);
}

// The environment with one more entry and those of the confinement, for execve.
std::vector<char*> environment_with(std::string& entry, const PreparedConfinement& confined) {
  std::vector<char*> all;
  const std::string name = entry.substr(0, entry.find('=') + 1);
  for (char** each = environ; each && *each; ++each)
    if (std::strncmp(*each, name.c_str(), name.size()) != 0 && confined.keeps_variable(*each)) all.push_back(*each);
  for (const std::string& more : confined.environment()) all.push_back(const_cast<char*>(more.c_str()));
  all.push_back(entry.data());
  all.push_back(nullptr);
  return all;
}

// Why a child did not become the worker.
struct Failure {
  int error = 0;
  const char* step = nullptr;  // of the confinement; of this program's text, which the child shares
};

// Between fork and exec only async-signal-safe calls.
[[noreturn]] void become(char* const* arguments, char* const* environment, int in, int out, int err, int failure,
                         pid_t parent, bool pinned, const PreparedConfinement& confined) {
  setsid();  // Ctrl-C at the terminal goes to this program alone; descendants are found by the session
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (pinned) pin_to_last_processor();
  Failure why{0, confined.apply()};
  prctl(PR_SET_PDEATHSIG, SIGKILL);  // after the confinement: a change of rights clears it
  if (getppid() != parent) _exit(127);
  if (why.step == nullptr && dup2(in, STDIN_FILENO) >= 0 && dup2(out, STDOUT_FILENO) >= 0 &&
      dup2(err, STDERR_FILENO) >= 0) {
    close_others_on_exec();
    execve(arguments[0], arguments, environment);
  }
  why.error = errno;
  [[maybe_unused]] const auto written = ::write(failure, &why, sizeof why);
  _exit(127);
}

}  // namespace

int interrupt_signal() {
  const int signal = g_signal;
  if (signal != 0) g_seen = true;
  return signal;
}

struct InterruptGuard::Saved {
  struct sigaction interrupt, terminate, pipe, file_size;
};

InterruptGuard::InterruptGuard() : saved_(new Saved) {
  forget_what_was_seen();
  struct sigaction action {};
  action.sa_handler = remember;
  sigaction(SIGINT, &action, &saved_->interrupt);
  sigaction(SIGTERM, &action, &saved_->terminate);
  action.sa_handler = SIG_IGN;
  sigaction(SIGPIPE, &action, &saved_->pipe);
  sigaction(SIGXFSZ, &action, &saved_->file_size);
}

InterruptGuard::~InterruptGuard() {
  sigaction(SIGINT, &saved_->interrupt, nullptr);
  sigaction(SIGTERM, &saved_->terminate, nullptr);
  sigaction(SIGPIPE, &saved_->pipe, nullptr);
  sigaction(SIGXFSZ, &saved_->file_size, nullptr);
  delete saved_;
  forget_what_was_seen();
}

BrokenPipeGuard::BrokenPipeGuard() : before_(::signal(SIGPIPE, SIG_IGN)) {}
BrokenPipeGuard::~BrokenPipeGuard() { ::signal(SIGPIPE, before_); }

Process::Process(const std::vector<std::string>& command, bool pinned, const Confinement& confinement)
    : confined_(confinement) {
  Pipe in, out, err, failure;
  std::string program = std::filesystem::absolute(command.at(0)).string();  // the worker has another working directory
  std::vector<char*> arguments{program.data()};
  for (std::size_t i = 1; i < command.size(); ++i) arguments.push_back(const_cast<char*>(command[i].c_str()));
  arguments.push_back(nullptr);
  mark_ = next_worker_mark();
  const std::vector<char*> environment = environment_with(mark_, confined_);
  const pid_t parent = getpid();
  adopt_orphans();
  {
    const auto held = lock_workers();
    pid_ = fork();
    if (pid_ < 0) throw SystemFault(std::string("no process for a worker: ") + std::strerror(errno));
    if (pid_ == 0)
      become(arguments.data(), environment.data(), in.read, out.write, err.write, failure.write, parent, pinned,
             confined_);
    enter_worker(pid_, mark_);
  }
  close_end(failure.write);
  Failure why;
  ssize_t size;
  do size = read(failure.read, &why, sizeof why);
  while (size < 0 && errno == EINTR);
  const int unread = size < 0 ? errno : 0;
  if (size == static_cast<ssize_t>(sizeof why)) {
    ended(std::chrono::seconds(5));
    bury();
    throw std::runtime_error(command.at(0) + " cannot be " +
                             (why.step ? "confined (" + std::string(why.step) + "): " : "started: ") +
                             std::strerror(why.error));
  }
  if (unread != 0) {
    kill();
    bury();
    throw SystemFault(std::string("reading how a worker began: ") + std::strerror(unread));
  }
  memory_ = std::make_unique<MemoryWatch>(pid_, mark_, confinement.memory_bytes);
  std::swap(in_, in.write);
  std::swap(out_, out.read);
  std::swap(err_, err.read);
  for (const int end : {in_, out_, err_}) fcntl(end, F_SETFL, fcntl(end, F_GETFL) | O_NONBLOCK);
}

Process::~Process() {
  close_end(in_);
  if (!ended(std::chrono::milliseconds(we_killed_ ? 5000 : 300))) {
    kill();
    ended(std::chrono::seconds(5));
  }
  bury();
  close_end(out_);
  close_end(err_);
}

void Process::send(std::string text) { pending_ += text + "\n"; }

bool Process::take_line(std::string& line, std::size_t longest, Wait& result) {
  const std::size_t end = received_.find('\n', std::max(scanned_, taken_));
  if (end != std::string::npos && end - taken_ <= longest) {
    if (end - taken_ < kLongBlock) {
      line.assign(received_, taken_, end - taken_);
      taken_ = end + 1;
      return true;
    }
    std::string rest(received_, end + 1);  // a long line is moved, not copied
    received_.resize(end);
    received_.erase(0, taken_);
    line = std::move(received_);
    received_ = std::move(rest);
    taken_ = scanned_ = 0;
    return true;
  }
  received_.erase(0, taken_);  // once a block, not once a line
  taken_ = 0;
  scanned_ = received_.size();
  result = Wait::too_long;
  return received_.size() > longest;
}

Wait Process::next_line(std::string& line, Clock::time_point deadline, std::size_t longest) {
  for (;;) {
    Wait result = Wait::line;
    if (take_line(line, longest, result)) return result;
    if (out_ < 0) return Wait::end_of_output;
    if (interrupt_signal() != 0) return Wait::interrupted;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return Wait::timeout;
    pump(static_cast<int>(std::min<long long>(left, kSliceMs)));
  }
}

std::string Process::unasked() {
  if (out_ >= 0) pump(0);
  return received_.substr(taken_, 120);
}

void Process::pump(int timeout_ms) {
  pollfd ends[3] = {{pending_.empty() ? -1 : in_, POLLOUT, 0}, {out_, POLLIN, 0}, {err_, POLLIN, 0}};
  if (poll(ends, 3, timeout_ms) <= 0) return;
  if (ends[0].revents != 0) {
    const ssize_t size = ::write(in_, pending_.data(), pending_.size());
    if (size > 0) pending_.erase(0, static_cast<std::size_t>(size));
    else if (size < 0 && errno == EPIPE) pending_.clear();  // the process has ended
    else if (size < 0 && errno != EAGAIN && errno != EINTR)
      throw SystemFault(std::string("writing to a worker: ") + std::strerror(errno));
  }
  if (ends[1].revents != 0) {
    char block[65536];
    const ssize_t size = read(out_, block, sizeof block);
    if (size > 0) received_.append(block, static_cast<std::size_t>(size));
    else if (size == 0) close_end(out_);
    else if (errno != EAGAIN && errno != EINTR)
      throw SystemFault(std::string("reading from a worker: ") + std::strerror(errno));
  }
  if (ends[2].revents != 0) read_errors();
}

void Process::read_errors() {
  char block[16384];
  for (int i = 0; err_ >= 0 && i < 64; ++i) {  // bounded, so that reading many errors does not pass the deadline
    const ssize_t size = read(err_, block, sizeof block);
    if (size > 0) {
      errors_.append(block, static_cast<std::size_t>(size));
      if (errors_.size() > 2 * kLongestErrors) errors_.erase(0, errors_.size() - kLongestErrors);
      continue;
    }
    if (size < 0 && errno == EINTR) continue;
    if (size < 0 && errno == EAGAIN) return;
    close_end(err_);
  }
}

void Process::kill() {
  if (buried_ || ended(std::chrono::milliseconds(0))) return;
  we_killed_ = true;
  ::kill(-pid_, SIGKILL);
  ::kill(pid_, SIGKILL);
}

// Waits at most `patience` for the end of the process; whether it has ended. It remains a zombie, so that no other
// process gets its number.
bool Process::ended(std::chrono::milliseconds patience) {
  const auto deadline = Clock::now() + patience;
  while (!ending_) {
    siginfo_t info{};
    if (waitid(P_PID, static_cast<id_t>(pid_), &info, WEXITED | WNOHANG | WNOWAIT) != 0) {
      if (errno != EINTR) ending_ = Ending{};  // another part of the program has waited for it
    } else if (info.si_pid == pid_) {
      ending_ = Ending{info.si_code != CLD_EXITED, info.si_status};
    } else if (Clock::now() >= deadline) {
      return false;
    } else {
      std::this_thread::sleep_for(std::chrono::microseconds(500));
    }
  }
  return true;
}

// Ends the descendants while the process is a zombie, then reaps it. Its number is not used for signals afterwards.
void Process::bury() {
  if (buried_) return;
  buried_ = true;
  if (memory_) memory_->end();
  try {
    kill_descendants(pid_, mark_);
  } catch (const std::bad_alloc&) {  // a destructor may not throw it
    ::kill(-pid_, SIGKILL);          // its session's first group, which needs no memory
  }
  while (waitpid(pid_, nullptr, ending_ ? 0 : WNOHANG) < 0 && errno == EINTR) {}
}

std::string Process::ending() {
  if (!ended(std::chrono::seconds(5))) return "closed its output";
  if (!ending_->by_signal) return "exited with code " + std::to_string(ending_->code);
  return "killed by signal " + std::to_string(ending_->code) + " (" + strsignal(ending_->code) + ")";
}

bool Process::succeeded() { return ended(std::chrono::seconds(5)) && !ending_->by_signal && ending_->code == 0; }

bool Process::killed_from_outside() const {
  if (!ending_ || we_killed_ || !ending_->by_signal) return false;
  constexpr int sent_signals[] = {SIGKILL, SIGTERM, SIGINT, SIGHUP, SIGQUIT};  // a fault of the program raises others
  return std::find(std::begin(sent_signals), std::end(sent_signals), ending_->code) != std::end(sent_signals);
}

std::string Process::error_text() {
  read_errors();
  if (errors_.size() > kLongestErrors) errors_.erase(0, errors_.size() - kLongestErrors);
  return printable(errors_);
}

std::string capture(const std::vector<std::string>& words) {
  int ends[2];
  if (pipe(ends) != 0) throw std::runtime_error("pipe failed");
  const pid_t child = fork();
  if (child == 0) {
    dup2(ends[1], STDOUT_FILENO);
    close(ends[0]);
    close(ends[1]);
    std::vector<char*> arguments;
    for (const auto& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
    arguments.push_back(nullptr);
    execv(arguments[0], arguments.data());
    _exit(127);
  }
  close(ends[1]);
  if (child < 0) throw std::runtime_error("fork failed");
  std::string text;
  char buffer[65536];
  for (ssize_t n; (n = read(ends[0], buffer, sizeof buffer)) > 0;) text.append(buffer, static_cast<std::size_t>(n));
  close(ends[0]);
  int status = 0;
  waitpid(child, &status, 0);
  if (!WIFEXITED(status) || WEXITSTATUS(status) != 0) throw std::runtime_error(words[0] + " failed");
  return text;
}

}  // namespace atwood
