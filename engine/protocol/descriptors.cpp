#include "protocol/descriptors.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>

namespace atwood {

void open_standard_descriptors() {
  for (int descriptor = STDIN_FILENO; descriptor <= STDERR_FILENO; ++descriptor) {
    if (fcntl(descriptor, F_GETFD) >= 0 || errno != EBADF) continue;
    // open() returns the lowest free descriptor: all below it are open.
    const int opened = open("/dev/null", descriptor == STDERR_FILENO ? O_WRONLY : O_RDONLY);
    if (opened >= 0 && opened != descriptor) close(opened);
  }
}

namespace {

ssize_t write_what_goes(void*, const char* text, std::size_t size) {
  for (std::size_t done = 0; done < size;) {
    const ssize_t written = write(STDERR_FILENO, text + done, size - done);
    if (written > 0) done += static_cast<std::size_t>(written);
    else if (written == 0 || errno != EINTR) break;
  }
  return static_cast<ssize_t>(size);
}

}  // namespace

void forgive_standard_error() {
  FILE* tolerant = fopencookie(nullptr, "w", {nullptr, write_what_goes, nullptr, nullptr});
  if (!tolerant) return;
  std::setvbuf(tolerant, nullptr, _IONBF, 0);
  std::fflush(stderr);
  stderr = tolerant;  // in glibc it is a variable
}

}  // namespace atwood
