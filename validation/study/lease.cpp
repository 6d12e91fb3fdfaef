#include "validation/study/lease.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <vector>

#include "validation/study/process.hpp"

namespace atwood {
namespace fs = std::filesystem;

namespace {

[[noreturn]] void fail(const std::string& path, const std::string& what) {
  throw std::runtime_error("--lease: " + path + ": " + what);
}

std::string name_of(std::size_t chunk) {
  char text[24];
  std::snprintf(text, sizeof text, "%09zu", chunk);
  return text;
}

// Names of a folder's files, sorted; those that vanish meanwhile are not missed.
std::vector<std::string> names_in(const std::string& folder) {
  std::vector<std::string> names;
  std::error_code error;
  for (fs::directory_iterator entry(folder, error), end; !error && entry != end; entry.increment(error))
    names.push_back(entry->path().filename().string());
  if (error) fail(folder, error.message());
  std::sort(names.begin(), names.end());
  return names;
}

double seconds_of(const std::string& path) {
  struct stat about {};
  if (stat(path.c_str(), &about) != 0) return -1;
  return static_cast<double>(about.st_mtim.tv_sec) + 1e-9 * static_cast<double>(about.st_mtim.tv_nsec);
}

}  // namespace

Lease::Lease(const std::string& folder, const std::string& plan, std::size_t chunks, const std::string& owner,
             double expiry_s)
    : place_(folder + "/" + plan.substr(0, 16)), owner_(owner), expiry_s_(expiry_s) {
  std::error_code error;
  fs::create_directories(folder, error);
  if (error) fail(folder, error.message());
  const std::string made = place_ + ".making." + owner_;
  if (!fs::exists(place_)) {
    for (const char* part : {"/todo", "/taken", "/done", "/clock"}) fs::create_directories(made + part);
    for (std::size_t chunk = 0; chunk < chunks; ++chunk)
      if (!std::ofstream(made + "/todo/" + name_of(chunk))) fail(made, std::strerror(errno));
    // Fails where another process was quicker: that directory is not empty.
    if (rename(made.c_str(), place_.c_str()) != 0 && errno != ENOTEMPTY && errno != EEXIST)
      fail(place_, std::strerror(errno));
    fs::remove_all(made, error);
  }
  for (const std::string& other : names_in(folder))
    if (folder + "/" + other != place_ && other.find(".making.") == std::string::npos)
      fail(folder, "has the chunks of another study, build or file of costs (" + other + "); give another directory");
  toucher_ = std::thread([this] {
    std::unique_lock<std::mutex> held(mutex_);
    const auto pause = std::chrono::duration<double>(std::max(0.05, expiry_s_ / 10));
    while (!stop_) {
      if (!mine_.empty()) touch();
      changed_.wait_for(held, pause);
    }
  });
}

Lease::~Lease() {
  {
    const std::lock_guard<std::mutex> held(mutex_);
    stop_ = true;
    if (!mine_.empty())
      rename((place_ + "/taken/" + mine_).c_str(), (place_ + "/todo/" + mine_.substr(0, mine_.find('.'))).c_str());
  }
  changed_.notify_all();
  toucher_.join();
  unlink((place_ + "/clock/" + owner_).c_str());
}

void Lease::touch() { utimensat(AT_FDCWD, (place_ + "/taken/" + mine_).c_str(), nullptr, 0); }

bool Lease::take_todo() {
  for (const std::string& chunk : names_in(place_ + "/todo")) {
    const std::string mine = chunk + "." + owner_;
    utimensat(AT_FDCWD, (place_ + "/todo/" + chunk).c_str(), nullptr, 0);  // before it could look expired
    if (rename((place_ + "/todo/" + chunk).c_str(), (place_ + "/taken/" + mine).c_str()) == 0) {
      mine_ = mine;
      return true;
    }
    if (errno != ENOENT) fail(place_, std::strerror(errno));
  }
  return false;
}

bool Lease::take_expired(bool& others) {
  const std::string clock = place_ + "/clock/" + owner_;
  if (!std::ofstream(clock, std::ios::app) || utimensat(AT_FDCWD, clock.c_str(), nullptr, 0) != 0)
    fail(clock, std::strerror(errno));
  const double now_s = seconds_of(clock);
  for (const std::string& taken : names_in(place_ + "/taken")) {
    const double touched_s = seconds_of(place_ + "/taken/" + taken);
    if (touched_s < 0) continue;  // it is done meanwhile
    if (now_s - touched_s < expiry_s_) {
      others = true;
      continue;
    }
    const std::string mine = taken.substr(0, taken.find('.')) + "." + owner_;
    utimensat(AT_FDCWD, (place_ + "/taken/" + taken).c_str(), nullptr, 0);  // before it could look expired to a third
    if (mine == taken || rename((place_ + "/taken/" + taken).c_str(), (place_ + "/taken/" + mine).c_str()) == 0) {
      mine_ = mine;
      return true;
    }
    if (errno != ENOENT) fail(place_, std::strerror(errno));
  }
  return false;
}

std::optional<std::size_t> Lease::take() {
  for (;;) {
    if (interrupt_signal() != 0) return std::nullopt;
    {
      const std::lock_guard<std::mutex> held(mutex_);
      bool others = false;
      if (take_todo() || take_expired(others)) return std::stoull(mine_);
      if (!others && names_in(place_ + "/todo").empty() && names_in(place_ + "/taken").empty()) return std::nullopt;
    }
    std::this_thread::sleep_for(std::chrono::duration<double>(std::min(0.5, expiry_s_ / 10)));
  }
}

void Lease::done() {
  const std::lock_guard<std::mutex> held(mutex_);
  // Where it had expired and another process took it, that one ends it.
  const std::string taken = place_ + "/taken/" + mine_, ended = place_ + "/done/" + mine_.substr(0, mine_.find('.'));
  if (rename(taken.c_str(), ended.c_str()) != 0 && errno != ENOENT) fail(ended, std::strerror(errno));
  mine_.clear();
}

}  // namespace atwood
