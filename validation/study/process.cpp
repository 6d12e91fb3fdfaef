#include "validation/study/process.hpp"

#include <fcntl.h>
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
#include <stdexcept>
#include <thread>

#include "protocol/wire.hpp"

namespace atwood {
namespace {

constexpr std::size_t kLongestErrors = std::size_t{64} << 10;
constexpr int kSliceMs = 50;  // how long an interrupt may go unseen

std::atomic<int> g_signal{0};  // the only thing the signal handler touches
static_assert(std::atomic<int>::is_always_lock_free);

void remember(int signal) { g_signal = signal; }

void close_end(int& end) {
  if (end >= 0) close(end);
  end = -1;
}

struct Pipe {
  int read = -1, write = -1;
  Pipe() {
    int ends[2];
    if (pipe2(ends, O_CLOEXEC) != 0) throw std::runtime_error(std::string("no pipe: ") + std::strerror(errno));
    read = ends[0];
    write = ends[1];
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

// Between fork and exec only async-signal-safe calls.
[[noreturn]] void become(char* const* arguments, int in, int out, int err, int failure, pid_t parent, bool pinned) {
  setpgid(0, 0);  // a Ctrl-C at the terminal is ours to handle; killing the group takes its children along
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  if (getppid() != parent) _exit(127);
  for (const int signal : {SIGPIPE, SIGXFSZ, SIGINT, SIGTERM}) ::signal(signal, SIG_DFL);
  sigset_t none;
  sigemptyset(&none);
  sigprocmask(SIG_SETMASK, &none, nullptr);
  if (pinned) pin_to_last_processor();
  if (dup2(in, STDIN_FILENO) >= 0 && dup2(out, STDOUT_FILENO) >= 0 && dup2(err, STDERR_FILENO) >= 0) {
    execv(arguments[0], arguments);
  }
  const int error = errno;
  [[maybe_unused]] const auto written = write(failure, &error, sizeof error);
  _exit(127);
}

}  // namespace

int interrupt_signal() { return g_signal; }

struct InterruptGuard::Saved {
  struct sigaction interrupt, terminate, pipe, file_size;
};

InterruptGuard::InterruptGuard() : saved_(new Saved) {
  g_signal = 0;
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
  g_signal = 0;
}

BrokenPipeGuard::BrokenPipeGuard() : before_(::signal(SIGPIPE, SIG_IGN)) {}
BrokenPipeGuard::~BrokenPipeGuard() { ::signal(SIGPIPE, before_); }

Process::Process(const std::vector<std::string>& command, bool pinned) {
  Pipe in, out, err, failure;
  std::string program = command.at(0);
  if (program.find('/') == std::string::npos) program = "./" + program;
  std::vector<char*> arguments{program.data()};
  for (std::size_t i = 1; i < command.size(); ++i) arguments.push_back(const_cast<char*>(command[i].c_str()));
  arguments.push_back(nullptr);
  const pid_t parent = getpid();
  pid_ = fork();
  if (pid_ < 0) throw std::runtime_error(std::string("no process: ") + std::strerror(errno));
  if (pid_ == 0) become(arguments.data(), in.read, out.write, err.write, failure.write, parent, pinned);
  setpgid(pid_, pid_);
  close_end(failure.write);
  int error = 0;
  ssize_t size;
  do size = read(failure.read, &error, sizeof error);
  while (size < 0 && errno == EINTR);
  if (size == static_cast<ssize_t>(sizeof error)) {
    reap(std::chrono::seconds(1));
    throw std::runtime_error(program + " cannot be started: " + std::strerror(error));
  }
  std::swap(in_, in.write);
  std::swap(out_, out.read);
  std::swap(err_, err.read);
  for (const int end : {in_, out_, err_}) fcntl(end, F_SETFL, fcntl(end, F_GETFL) | O_NONBLOCK);
}

Process::~Process() {
  close_end(in_);
  if (!reap(std::chrono::milliseconds(we_killed_ ? 5000 : 300))) {
    kill();
    reap(std::chrono::seconds(5));
  }
  ::kill(-pid_, SIGKILL);  // what it may have left behind in its group
  close_end(out_);
  close_end(err_);
}

void Process::send(std::string text) { pending_ += text + "\n"; }

bool Process::take_line(std::string& line, Wait& result) {
  const std::size_t end = received_.find('\n', std::max(scanned_, taken_));
  if (end != std::string::npos && end - taken_ <= wire::kLongestLine) {
    line.assign(received_, taken_, end - taken_);
    taken_ = end + 1;
    return true;
  }
  received_.erase(0, taken_);  // once a block, not once a line
  taken_ = 0;
  scanned_ = received_.size();
  result = Wait::too_long;
  return received_.size() > wire::kLongestLine;
}

Wait Process::next_line(std::string& line, Clock::time_point deadline) {
  for (;;) {
    Wait result = Wait::line;
    if (take_line(line, result)) return result;
    if (out_ < 0) return Wait::end_of_output;
    if (interrupt_signal() != 0) return Wait::interrupted;
    const auto left = std::chrono::duration_cast<std::chrono::milliseconds>(deadline - Clock::now()).count();
    if (left <= 0) return Wait::timeout;
    pump(static_cast<int>(std::min<long long>(left, kSliceMs)));
  }
}

void Process::pump(int timeout_ms) {
  pollfd ends[3] = {{pending_.empty() ? -1 : in_, POLLOUT, 0}, {out_, POLLIN, 0}, {err_, POLLIN, 0}};
  if (poll(ends, 3, timeout_ms) <= 0) return;
  if (ends[0].revents != 0) {
    const ssize_t size = write(in_, pending_.data(), pending_.size());
    if (size > 0) pending_.erase(0, static_cast<std::size_t>(size));
    else if (size < 0 && errno != EAGAIN && errno != EINTR) pending_.clear();  // it died: its output will end
  }
  if (ends[1].revents != 0) {
    char block[65536];
    const ssize_t size = read(out_, block, sizeof block);
    if (size > 0) received_.append(block, static_cast<std::size_t>(size));
    else if (size == 0 || (errno != EAGAIN && errno != EINTR)) close_end(out_);
  }
  if (ends[2].revents != 0) read_errors();
}

void Process::read_errors() {
  char block[16384];
  for (int i = 0; err_ >= 0 && i < 64; ++i) {  // bounded: a flood of errors must not outlast the deadline
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
  if (status_) return;
  we_killed_ = true;
  ::kill(-pid_, SIGKILL);
  ::kill(pid_, SIGKILL);
}

bool Process::reap(std::chrono::milliseconds patience) {
  const auto deadline = Clock::now() + patience;
  while (!status_) {
    int status = 0;
    const pid_t who = waitpid(pid_, &status, WNOHANG);
    if (who == pid_) status_ = status;
    else if (who < 0 && errno != EINTR) status_ = 0;
    else if (Clock::now() >= deadline) return false;
    else std::this_thread::sleep_for(std::chrono::microseconds(500));
  }
  return true;
}

std::string Process::ending() {
  if (!reap(std::chrono::seconds(1))) return "closed its output";
  if (WIFSIGNALED(*status_)) {
    const int signal = WTERMSIG(*status_);
    return "killed by signal " + std::to_string(signal) + " (" + strsignal(signal) + ")";
  }
  return "exited with code " + std::to_string(WEXITSTATUS(*status_));
}

bool Process::killed_from_outside() const {
  return status_ && !we_killed_ && WIFSIGNALED(*status_) && WTERMSIG(*status_) == SIGKILL;
}

std::string Process::error_text() {
  read_errors();
  if (errors_.size() > kLongestErrors) errors_.erase(0, errors_.size() - kLongestErrors);
  return printable(errors_);
}

}  // namespace atwood
