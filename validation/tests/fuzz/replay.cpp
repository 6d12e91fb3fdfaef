// Gives every file of the kept corpus to its target, without a fuzzer, in any build: replay FOLDER [TARGET [FILE...]].
// Each input may take two seconds of the processor and half a gigabyte of memory; one that takes more, or ends the
// process, is named on standard error.
#include <sys/resource.h>
#include <sys/time.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "validation/tests/fuzz/target.hpp"

namespace fs = std::filesystem;
using namespace atwood;

namespace {

constexpr rlim_t kMaxBytes = rlim_t{512} << 20;
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kLimitMemory = false;  // sanitizers reserve terabytes of addresses
constexpr int kMaxSeconds = 20;       // and are slow
#else
constexpr bool kLimitMemory = true;
constexpr int kMaxSeconds = 2;
#endif

// 0: no limit.
void limit_seconds(int seconds) {
  itimerval timer{};
  timer.it_value.tv_sec = seconds;
  setitimer(ITIMER_PROF, &timer, nullptr);
}

char g_now[4096] = "";

void name_input(int signal) {
  const char* const what = signal == SIGPROF ? "fuzz_corpus_test: took too long: " : "fuzz_corpus_test: ended by: ";
  for (const char* text : {what, static_cast<const char*>(g_now), "\n"}) {
    const auto written = write(STDERR_FILENO, text, std::strlen(text));
    if (written < 0) break;
  }
  std::signal(signal, SIG_DFL);
  raise(signal);
}

bool replay(const fuzz::Target& target, const fs::path& path) {
  std::ifstream in(path, std::ios::binary);
  std::ostringstream bytes;
  bytes << in.rdbuf();
  std::snprintf(g_now, sizeof g_now, "%s", path.c_str());
  limit_seconds(kMaxSeconds);
  try {
    target.read(bytes.str());
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s: threw %s\n", path.c_str(), error.what());
    return false;
  }
  limit_seconds(0);
  return true;
}

std::vector<fs::path> files_of(const fs::path& folder) {
  std::vector<fs::path> files;
  if (fs::is_directory(folder))
    for (const auto& entry : fs::directory_iterator(folder)) files.push_back(entry.path());
  std::sort(files.begin(), files.end());
  return files;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "usage: %s CORPUS [TARGET [FILE...]]\n", argv[0]);
    return 2;
  }
  for (const int signal : {SIGABRT, SIGSEGV, SIGFPE, SIGBUS, SIGILL, SIGPROF}) std::signal(signal, name_input);
  if (const rlimit most{kMaxBytes, kMaxBytes}; kLimitMemory) setrlimit(RLIMIT_AS, &most);
  bool good = true;
  for (const fuzz::Target& target : fuzz::all_targets()) {
    if (argc > 2 && std::strcmp(argv[2], target.name) != 0) continue;
    std::vector<fs::path> files(argv + std::min(argc, 3), argv + argc);
    if (files.empty()) files = files_of(fs::path(argv[1]) / target.name);
    for (const fs::path& file : files) good = replay(target, file) && good;
    std::printf("%-14s %4zu inputs\n", target.name, files.size());
    if (files.empty()) {
      std::fprintf(stderr, "%s: no corpus\n", target.name);
      good = false;
    }
  }
  return good ? 0 : 1;
}
