// Chunks of a plan that processes take from a shared directory, dearest first, where costs are too uneven to deal them
// out beforehand. A chunk is a file that is renamed: todo/ -> taken/ -> done/. A rename is atomic and has one winner,
// also on NFS. A taken chunk whose file was not touched for `expiry_s` belongs to a process that died, and is taken
// again; both may then have run it, which a merge notices only if their results differ.
//
// Times are those of the file server (a file is touched and its time read), so that clocks of hosts need not agree.
#pragma once

#include <condition_variable>
#include <cstddef>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

namespace atwood {

class Lease {
 public:
  // Makes the directory of this plan under `folder` with `chunks` files, unless another process has made it.
  // `owner`: unique among the processes (host and process id). std::runtime_error where it cannot be written, or has
  // the chunks of another plan.
  Lease(const std::string& folder, const std::string& plan, std::size_t chunks, const std::string& owner,
        double expiry_s);
  ~Lease();  // gives back a chunk that is not done
  Lease(const Lease&) = delete;
  Lease& operator=(const Lease&) = delete;

  // The next chunk; waits while others hold the last ones. Empty: all are done, or a signal came. A thread touches the
  // chunk's file until it is done.
  std::optional<std::size_t> take();
  void done();  // with the chunk that was taken last

 private:
  bool take_todo();
  bool take_expired(bool& others);
  void touch();
  std::string place_, owner_, mine_;
  double expiry_s_;
  std::mutex mutex_;
  std::condition_variable changed_;
  bool stop_ = false;
  std::thread toucher_;
};

}  // namespace atwood
