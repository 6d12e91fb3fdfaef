// Writes a file completely or not at all: writes a file without a name, calls fsync, gives it a name beside the target
// and renames it. A program that is killed while it writes leaves no file behind. Where the file system has no files
// without a name, a temporary file beside the target is used and removed on failure.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <string>
#include <system_error>

#include "validation/study/write_file.hpp"

namespace atwood {
namespace {

// A file size limit (ulimit -f) raises SIGXFSZ, which ends the program; where it is ignored, write() fails with EFBIG.
class IgnoreSizeSignal {
 public:
  IgnoreSizeSignal() {
    struct sigaction ignore {};
    ignore.sa_handler = SIG_IGN;
    sigaction(SIGXFSZ, &ignore, &before_);
  }
  ~IgnoreSizeSignal() { sigaction(SIGXFSZ, &before_, nullptr); }
  IgnoreSizeSignal(const IgnoreSizeSignal&) = delete;
  IgnoreSizeSignal& operator=(const IgnoreSizeSignal&) = delete;

 private:
  struct sigaction before_ {};
};

[[noreturn]] void fail(const std::string& path, int error) {
  throw std::runtime_error("cannot write " + path + ": " + std::generic_category().message(error));
}

// 0, or the errno of the first failure.
int write_all(int descriptor, const std::string& content, bool sync) {
  int error = 0;
  std::size_t done = 0;
  while (error == 0 && done < content.size()) {
    const ssize_t count = ::write(descriptor, content.data() + done, content.size() - done);
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
    } else if (errno != EINTR) {
      error = errno;
    }
  }
  if (error == 0 && sync && ::fsync(descriptor) != 0) error = errno;
  return error;
}

int close_after(int descriptor, int error) {
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

// Blocks signals between the first name and the rename.
class HoldSignals {
 public:
  HoldSignals() {
    sigset_t ends{};
    sigemptyset(&ends);
    for (const int signal : {SIGINT, SIGTERM, SIGHUP, SIGQUIT}) sigaddset(&ends, signal);
    pthread_sigmask(SIG_BLOCK, &ends, &before_);
  }
  ~HoldSignals() { pthread_sigmask(SIG_SETMASK, &before_, nullptr); }
  HoldSignals(const HoldSignals&) = delete;
  HoldSignals& operator=(const HoldSignals&) = delete;

 private:
  sigset_t before_{};
};

// Opens a new file beside `target`; it has no name if `temporary` stays empty.
int open_beside(const std::string& target, bool may_be_nameless, std::string& temporary) {
  const std::filesystem::path folder = std::filesystem::path(target).parent_path();
  if (may_be_nameless) {
    const int nameless = ::open(folder.empty() ? "." : folder.c_str(), O_TMPFILE | O_WRONLY | O_CLOEXEC, 0600);
    if (nameless >= 0) return nameless;
  }
  temporary = target + ".XXXXXX";
  return ::mkostemp(temporary.data(), O_CLOEXEC);
}

// Gives a file without a name a name beside `target`, by its descriptor, before that is closed.
int give_name(int descriptor, const std::string& target, std::string& temporary) {
  const std::string self = "/proc/self/fd/" + std::to_string(descriptor);
  for (int attempt = 0; attempt < 100; ++attempt) {
    temporary = target + "." + std::to_string(::getpid()) + "-" + std::to_string(attempt);
    if (::linkat(AT_FDCWD, self.c_str(), AT_FDCWD, temporary.c_str(), AT_SYMLINK_FOLLOW) == 0) return 0;
    if (errno != EEXIST) break;
  }
  temporary.clear();
  return errno;
}

mode_t usual_mode() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

constexpr int kNoName = -1;  // the file was written but cannot get a name: no /proc, or a file system without links

// 0, or the errno of the first failure; the old file is then unchanged, and no other file is left.
int replace(const std::string& target, const std::string& content, mode_t mode, bool may_be_nameless) {
  std::string temporary;
  const int descriptor = open_beside(target, may_be_nameless, temporary);
  if (descriptor < 0) return errno;
  ::fchmod(descriptor, mode);
  int error = write_all(descriptor, content, true);
  const HoldSignals held;
  if (error == 0 && temporary.empty() && give_name(descriptor, target, temporary) != 0) {
    ::close(descriptor);
    return kNoName;
  }
  error = close_after(descriptor, error);
  if (error == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
  if (error != 0 && !temporary.empty()) ::unlink(temporary.c_str());
  return error;
}

}  // namespace

void write_file(const std::string& path, const std::string& content) {
  const IgnoreSizeSignal guard;
  struct stat info {};
  const bool exists = ::stat(path.c_str(), &info) == 0;
  if (exists && S_ISDIR(info.st_mode)) fail(path, EISDIR);
  if (exists && !S_ISREG(info.st_mode)) {  // a pipe or /dev/stdout cannot be replaced by a rename
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) fail(path, errno);
    if (const int error = close_after(descriptor, write_all(descriptor, content, false))) fail(path, error);
    return;
  }
  // A symbolic link is kept; its target is replaced.
  const std::string target = exists ? std::filesystem::canonical(path).string() : path;
  const mode_t mode = exists ? info.st_mode & 07777 : usual_mode();
  int error = replace(target, content, mode, true);
  if (error == kNoName) error = replace(target, content, mode, false);
  if (error != 0) fail(path, error);
  // The rename is durable once the folder is synchronised; where that is impossible, the file is still complete.
  const std::filesystem::path folder = std::filesystem::path(target).parent_path();
  const int folder_descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_descriptor >= 0) {
    ::fsync(folder_descriptor);
    ::close(folder_descriptor);
  }
}

}  // namespace atwood
