// A file is there whole or not at all.
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <catch2/catch.hpp>
#include <csignal>
#include <filesystem>
#include <fstream>

#include "validation/study/write_file.hpp"

namespace {

namespace fs = std::filesystem;

struct Folder {
  fs::path path;
  Folder() {
    std::string name = (fs::temp_directory_path() / "atwood-write-XXXXXX").string();
    REQUIRE(::mkdtemp(name.data()) != nullptr);
    path = name;
  }
  ~Folder() { fs::remove_all(path); }
  std::string operator/(const char* name) const { return (path / name).string(); }
  std::size_t entries() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(path), fs::directory_iterator()));
  }
};

std::string content(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

}  // namespace

TEST_CASE("a new file and a replaced one hold exactly what was given") {
  const Folder folder;
  const std::string path = folder / "report.html";
  atwood::write_file(path, std::string("a\0b\n", 4));
  CHECK(content(path) == std::string("a\0b\n", 4));
  ::chmod(path.c_str(), 0640);
  atwood::write_file(path, "second");
  CHECK(content(path) == "second");
  struct stat info {};
  REQUIRE(::stat(path.c_str(), &info) == 0);
  CHECK((info.st_mode & 07777) == 0640);
  CHECK(folder.entries() == 1);
}

TEST_CASE("a link stays a link") {
  const Folder folder;
  atwood::write_file(folder / "real", "old");
  fs::create_symlink("real", folder / "link");
  atwood::write_file(folder / "link", "new");
  CHECK(fs::is_symlink(folder / "link"));
  CHECK(content(folder / "real") == "new");
}

TEST_CASE("a file that grows past the limit leaves the old one and no other") {
  const Folder folder;
  const std::string path = folder / "report.html";
  atwood::write_file(path, "old");
  rlimit before{};
  REQUIRE(::getrlimit(RLIMIT_FSIZE, &before) == 0);
  rlimit small = before;
  small.rlim_cur = 4096;
  REQUIRE(::setrlimit(RLIMIT_FSIZE, &small) == 0);
  std::string words;
  try {
    atwood::write_file(path, std::string(100000, 'x'));
  } catch (const std::runtime_error& error) {
    words = error.what();
  }
  ::setrlimit(RLIMIT_FSIZE, &before);
  CHECK(words == "cannot write " + path + ": File too large");
  CHECK(content(path) == "old");
  CHECK(folder.entries() == 1);
}

TEST_CASE("errors carry the system's words") {
  const Folder folder;
  CHECK_THROWS_WITH(atwood::write_file(folder / "no/such/report.html", "x"),
                    Catch::EndsWith("No such file or directory"));
  CHECK_THROWS_WITH(atwood::write_file(folder.path.string(), "x"), Catch::EndsWith("Is a directory"));
  if (fs::exists("/dev/full")) {
    CHECK_THROWS_WITH(atwood::write_file("/dev/full", "x"), "cannot write /dev/full: No space left on device");
  }
}

TEST_CASE("a program killed while it writes leaves the old file and no other") {
  const Folder folder;
  const std::string path = folder / "report.html";
  atwood::write_file(path, "old");
  const std::string large(std::size_t{64} << 20, 'x');
  for (int attempt = 0; attempt < 6; ++attempt) {
    const pid_t child = ::fork();
    REQUIRE(child >= 0);
    if (child == 0) {
      for (const int end : {SIGTERM, SIGINT}) std::signal(end, SIG_DFL);  // Catch has its own
      for (;;) atwood::write_file(path, large);
    }
    ::usleep(static_cast<useconds_t>(3000 + 7000 * attempt));
    ::kill(child, attempt % 2 == 0 ? SIGTERM : SIGINT);
    int status = 0;
    REQUIRE(::waitpid(child, &status, 0) == child);
    CHECK(WIFSIGNALED(status));
    CHECK(folder.entries() == 1);
    const std::size_t size = fs::file_size(path);
    CHECK((size == 3 || size == large.size()));
  }
}
