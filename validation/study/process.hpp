// A worker's process: its three pipes, its time limit, its end. Linux.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <optional>
#include <string>
#include <vector>

#include "scene/printable.hpp"

namespace atwood {

using Clock = std::chrono::steady_clock;

// The signal that asked this program to stop, 0 if none; every wait looks at it. Set by InterruptGuard.
int interrupt_signal();
// While it lives SIGINT and SIGTERM are remembered instead of killing, and broken pipes and exceeded file sizes come
// back as errors. One at a time. A signal that nobody has asked for when it ends is still there afterwards, so that the
// program's end can see it; one that was seen is forgotten.
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

// While it lives a worker that died gives an error on writing to it instead of killing this program.
class BrokenPipeGuard {
 public:
  BrokenPipeGuard();
  BrokenPipeGuard(const BrokenPipeGuard&) = delete;
  BrokenPipeGuard& operator=(const BrokenPipeGuard&) = delete;
  ~BrokenPipeGuard();

 private:
  void (*before_)(int);
};

enum class Wait { line, end_of_output, timeout, too_long, interrupted };

// Owned by one thread, which must outlive it: the kernel kills the process when that thread ends. It leads a session of
// its own, inherits no descriptor but its three pipes, and takes its descendants along when it ends.
class Process {
 public:
  // Throws std::runtime_error with the system's words when the program cannot be started. `pinned`: on one processor.
  Process(const std::vector<std::string>& command, bool pinned);
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;
  ~Process();  // closes its input, waits a moment, then kills it and all that it has started

  pid_t id() const { return pid_; }
  void send(std::string text);  // queued; written while waiting
  // `longest`: bytes of a line, its end not counted.
  Wait next_line(std::string& line, Clock::time_point deadline, std::size_t longest);
  bool half_a_line() const { return taken_ < received_.size(); }
  std::string unasked();             // the first bytes of what has come and was not taken, without waiting; empty: none
  void kill();                       // the process group, at once
  std::string ending();              // "exited with code 3", "killed by signal 11 (Segmentation fault)"; waits shortly
  bool killed_from_outside() const;  // by a SIGKILL that is not ours: out of memory, an administrator
  void forget_errors() { errors_.clear(); }
  std::string error_text();  // what is left of standard error: at most the last 64 KiB, without control characters

 private:
  bool take_line(std::string& line, std::size_t longest, Wait& result);
  void pump(int timeout_ms);
  void read_errors();
  bool ended(std::chrono::milliseconds patience);
  void bury();

  pid_t pid_ = -1;
  std::string mark_;  // its environment's, by which descendants are known
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
  std::optional<Ending> ending_;  // it is a zombie from then on, until it is buried
  bool buried_ = false;
  bool we_killed_ = false;
};

// What a program prints on standard output; std::runtime_error unless it ends with 0.
std::string capture(const std::vector<std::string>& words);

}  // namespace atwood
