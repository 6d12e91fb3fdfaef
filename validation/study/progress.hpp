// How far a study is and how long it will take: at most two lines a second.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <mutex>
#include <string>

namespace atwood {

class Progress {
 public:
  Progress(std::size_t total, std::function<void(const std::string&)> print)
      : total_(total), print_(std::move(print)) {}

  void expect(std::size_t total);               // when more, or less, turns out to be needed
  void done(const std::string& what);           // one piece of work; `what` is the phase it belongs to

 private:
  std::mutex mutex_;
  std::size_t total_, done_ = 0;
  std::function<void(const std::string&)> print_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now(), printed_ = start_;
};

}  // namespace atwood
