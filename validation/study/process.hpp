// A worker's process: its three pipes, its time limit, its end. Linux.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <memory>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "scene/printable.hpp"
#include "validation/study/confinement.hpp"

namespace atwood {

using Clock = std::chrono::steady_clock;

// The signal that asked this program to stop; 0: none. Set by InterruptGuard; every wait checks it.
int interrupt_signal();
// While a guard exists, SIGINT and SIGTERM are recorded and do not end the program, and broken pipes and exceeded file
// sizes are errors of write(). At most one guard at a time. When it is destroyed, a signal that interrupt_signal() has
// returned is cleared; one that it has not returned stays recorded for the program's exit code.
class InterruptGuard {
 public:
  InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  ~InterruptGuard();

 private:
  struct Saved;
  Saved* saved_;
};

// While a guard exists, writing to a worker that has ended is an error instead of a signal that ends this program.
class BrokenPipeGuard {
 public:
  BrokenPipeGuard();
  BrokenPipeGuard(const BrokenPipeGuard&) = delete;
  BrokenPipeGuard& operator=(const BrokenPipeGuard&) = delete;
  ~BrokenPipeGuard();

 private:
  void (*before_)(int);
};

// The system refused this program what a worker needs: descriptors, processes, or to write to its pipe. The worker is
// not at fault, and other cells would fail alike.
struct SystemFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

enum class Wait { line, end_of_output, timeout, too_long, interrupted };

// A worker's process. Owned by one thread, which must outlive it: the kernel kills the process when that thread ends.
// The process has its own session and inherits only its three pipes. When it ends, its descendants are killed.
class Process {
 public:
  // Throws std::runtime_error with the system's message where the program cannot be started, or cannot be confined; and
  // SystemFault.
  // `pinned`: on one processor.
  Process(const std::vector<std::string>& command, bool pinned, const Confinement& confinement = {});
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();  // closes its input, waits shortly, then kills it and its descendants

  pid_t id() const { return pid_; }
  void send(std::string text);  // queued; written while waiting
  // `longest`: bytes of a line, its end not counted.
  Wait next_line(std::string& line, Clock::time_point deadline, std::size_t longest);
  bool half_a_line() const { return taken_ < received_.size(); }
  std::string unasked();  // the beginning of output that no request has asked for, without waiting; empty: none
  void kill();            // the process group, at once
  std::string ending();   // "exited with code 3", "killed by signal 11 (Segmentation fault)"; waits shortly
  bool succeeded();       // exited with code 0; waits shortly
  // By a SIGKILL, SIGTERM, SIGINT, SIGHUP or SIGQUIT from another process: out of memory, an administrator, a scheduler
  // that takes its processors back.
  bool killed_from_outside() const;
  bool took_too_much_memory() const { return memory_ && memory_->exceeded(); }
  const std::string& scratch() const { return confined_.scratch(); }  // its directory; empty: not confined
  void forget_errors() { errors_.clear(); }
  std::string error_text();  // the end of standard error: at most the last 64 KiB, without control characters

 private:
  bool take_line(std::string& line, std::size_t longest, Wait& result);
  void pump(int timeout_ms);
  void read_errors();
  bool ended(std::chrono::milliseconds patience);
  void bury();

  PreparedConfinement confined_;         // its scratch directory goes after the process
  std::unique_ptr<MemoryWatch> memory_;  // goes before the process is reaped
  pid_t pid_ = -1;
  std::string mark_;  // in its environment; identifies its descendants
  int in_ = -1, out_ = -1, err_ = -1;
  std::string pending_;   // to be written
  std::string received_;  // read; handed out up to taken_
  std::size_t taken_ = 0;
  std::size_t scanned_ = 0;  // no end of line between taken_ and here
  std::string errors_;
  struct Ending {
    bool by_signal = false;
    int code = 0;
  };                              // the signal's number, or the exit code
  std::optional<Ending> ending_;  // from then on it is a zombie until it is reaped
  bool buried_ = false;
  bool we_killed_ = false;
};

// The standard output of a program; throws std::runtime_error unless its exit code is 0.
std::string capture(const std::vector<std::string>& words);

}  // namespace atwood
