// A file is there whole or not at all: write a temporary beside it, fsync, rename.
#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <filesystem>
#include <stdexcept>
#include <system_error>

#include "reports/report.hpp"

namespace atwood {
namespace {

// A file size limit (ulimit -f) raises SIGXFSZ, which kills; ignored, write() answers EFBIG and we can say so.
class IgnoreSizeSignal {
 public:
  IgnoreSizeSignal() {
    struct sigaction ignore{};
    ignore.sa_handler = SIG_IGN;
    sigaction(SIGXFSZ, &ignore, &before_);
  }
  ~IgnoreSizeSignal() { sigaction(SIGXFSZ, &before_, nullptr); }
  IgnoreSizeSignal(const IgnoreSizeSignal&) = delete;
  IgnoreSizeSignal& operator=(const IgnoreSizeSignal&) = delete;

 private:
  struct sigaction before_{};
};

[[noreturn]] void fail(const std::string& path, int error) {
  throw std::runtime_error("cannot write " + path + ": " + std::generic_category().message(error));
}

// 0, or the errno of the first failure. Closes the descriptor in each case.
int write_and_close(int descriptor, const std::string& content, bool sync) {
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
  if (::close(descriptor) != 0 && error == 0) error = errno;
  return error;
}

mode_t usual_mode() {
  const mode_t mask = ::umask(0);
  ::umask(mask);
  return 0666 & ~mask;
}

}  // namespace

void write_file(const std::string& path, const std::string& content) {
  const IgnoreSizeSignal guard;
  struct stat info{};
  const bool exists = ::stat(path.c_str(), &info) == 0;
  if (exists && S_ISDIR(info.st_mode)) fail(path, EISDIR);
  if (exists && !S_ISREG(info.st_mode)) {  // a pipe or /dev/stdout: nothing to rename over
    const int descriptor = ::open(path.c_str(), O_WRONLY | O_CLOEXEC);
    if (descriptor < 0) fail(path, errno);
    if (const int error = write_and_close(descriptor, content, false)) fail(path, error);
    return;
  }
  // A link stays a link: its target is what is replaced.
  const std::string target = exists ? std::filesystem::canonical(path).string() : path;
  std::string temporary = target + ".XXXXXX";
  const int descriptor = ::mkostemp(temporary.data(), O_CLOEXEC);
  if (descriptor < 0) fail(path, errno);
  ::fchmod(descriptor, exists ? info.st_mode & 07777 : usual_mode());
  int error = write_and_close(descriptor, content, true);
  if (error == 0 && ::rename(temporary.c_str(), target.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    fail(path, error);
  }
  // The rename itself lasts once the folder is on disk; where that cannot be asked for, the file is still whole.
  const std::filesystem::path folder = std::filesystem::path(target).parent_path();
  const int folder_descriptor = ::open(folder.empty() ? "." : folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (folder_descriptor >= 0) {
    ::fsync(folder_descriptor);
    ::close(folder_descriptor);
  }
}

}  // namespace atwood
