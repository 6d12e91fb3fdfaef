// What a worker is known by: its program, its libraries, the files that it names, and whether that is all of its code.
#include <catch2/catch.hpp>

#include <fstream>

#include "validation/tests/study/free_flight.hpp"

using namespace atwood;
namespace fs = std::filesystem;

namespace {

const std::string fakes = ATWOOD_FAKE_WORKERS;

// The worker that is linked to a shared library, with copies of both in a folder, where the linker finds the copy.
struct Linked {
  Folder folder;
  std::string engine = folder / "engine", library = folder / "liblinked_gain.so";
  Linked() {
    fs::copy_file(ATWOOD_LINKED_ENGINE, engine);
    fs::copy_file(ATWOOD_LINKED_GAIN, library);
    setenv("LD_LIBRARY_PATH", folder.path.c_str(), 1);
  }
  ~Linked() {
    for (const char* name : {"LD_LIBRARY_PATH", "LINKED_HELLO", "LINKED_CHILD", "LINKED_ENDS"}) unsetenv(name);
  }
  Worker worker(const std::vector<std::string>& words = {}) const {
    std::vector<std::string> command{engine};
    command.insert(command.end(), words.begin(), words.end());
    return find_workers_by_argv({command}).front();
  }
  static void hello(const std::string& more) {
    setenv("LINKED_HELLO",
           (R"({"engine":"linked","version":"1","methods":[{"id":"linked/a","doc":""}],)" + more + "}").c_str(), 1);
  }
  std::string file(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name) << text;
    return folder / name;
  }
};

}  // namespace

TEST_CASE("a worker is known by its program and by the shared libraries that it has loaded") {
  const Linked linked;
  const Worker before = linked.worker();
  REQUIRE(before.status == Status::ok);
  CHECK(before.unknown_code.empty());
  CHECK(linked.worker().build_id == before.build_id);
  std::ofstream(linked.library, std::ios::app) << "another build";  // what follows the sections is not loaded
  const std::string of_library = linked.worker().build_id;
  CHECK(of_library != before.build_id);
  std::ofstream(linked.engine, std::ios::app) << "another build";
  CHECK(linked.worker().build_id != of_library);
}

TEST_CASE("where a worker and its files lie is no part of what it is") {
  const auto build_id = [] {
    const Linked linked;
    linked.file("table.bin", std::string("\0\1", 2));
    Linked::hello(R"("fingerprint":"7","files":["table.bin"])");
    return linked.worker({"--fast", "--table=" + linked.folder.path + "/table.bin"}).build_id;
  };
  CHECK(build_id() == build_id());
}

TEST_CASE("the words of a worker's command count, and the bytes of the files that they name") {
  const Linked linked;
  CHECK(linked.worker({"--fast"}).build_id != linked.worker().build_id);
  CHECK(linked.worker({"--fast"}).unknown_code.empty());
  const std::string table = linked.file("table.bin", std::string("\0\1", 2));
  for (const std::string& word : {table, "--table=" + table}) {
    linked.file("table.bin", std::string("\0\1", 2));
    const Worker before = linked.worker({word});
    CHECK(before.unknown_code.empty());
    linked.file("table.bin", std::string("\0\2", 2));
    CHECK(linked.worker({word}).build_id != before.build_id);
  }
  CHECK(linked.worker({"--table=" + table}).build_id != linked.worker({"--mask=" + table}).build_id);
  CHECK_THAT(linked.worker({linked.file("model.lua", "print(1)\n")}).unknown_code, Catch::Contains("text file"));
  CHECK_THAT(linked.worker({linked.folder.path}).unknown_code, Catch::Contains("not a regular file"));
  CHECK_THAT(linked.worker({linked.engine}).unknown_code, Catch::Contains("names the program"));
}

TEST_CASE("a worker's own fingerprint and files count; a file that is not there is an error by name") {
  const Linked linked;
  Linked::hello(R"("fingerprint":"7")");
  const Worker seven = linked.worker();
  REQUIRE(seven.status == Status::ok);
  CHECK(seven.engine.fingerprint == "7");
  Linked::hello(R"("fingerprint":"8")");
  CHECK(linked.worker().build_id != seven.build_id);
  Linked::hello(R"("files":["plugin.so"])");
  const Worker missing = linked.worker();
  CHECK(missing.status == Status::crashed);
  CHECK_THAT(missing.reason, Catch::Contains("`plugin.so`, which does not exist (" + linked.folder.path));
  linked.file("plugin.so", "one");
  const Worker before = linked.worker();
  REQUIRE(before.status == Status::ok);
  linked.file("plugin.so", "two");
  CHECK(linked.worker().build_id != before.build_id);
  Linked::hello(R"("files":["."])");
  CHECK_THAT(linked.worker().reason, Catch::Contains("`.`, which is not a regular file"));
  Linked::hello(R"("files":[7])");
  CHECK(linked.worker().status == Status::crashed);
}

TEST_CASE("a worker that is killed right after hello is started again and known by its libraries") {
  const Linked linked;
  Linked::hello(R"("fingerprint":"7")");
  Confinement writes;  // removes the file
  writes.writable = {linked.folder.path};
  const auto build_id = [&] { return find_workers_by_argv({{linked.engine}}, {writes}).front().build_id; };
  const std::string calm = build_id();
  setenv("LINKED_ENDS", linked.file("ends", "").c_str(), 1);
  for (int killed = 0; killed < 20; ++killed) {
    linked.file("ends", "");
    CHECK(build_id() == calm);
    REQUIRE_FALSE(fs::exists(linked.folder / "ends"));
  }
}

TEST_CASE("code that cannot be seen from outside is said to be unknown, unless a fingerprint answers for it") {
  const Linked linked;
  setenv("LINKED_CHILD", "1", 1);
  CHECK(linked.worker().unknown_code == "it has started another process");
  Linked::hello(R"("fingerprint":"7")");
  CHECK(linked.worker().unknown_code.empty());
  unsetenv("LINKED_CHILD");
  unsetenv("LINKED_HELLO");

  const Worker script = find_workers({fakes + "/sound.py"}).front();
  REQUIRE(script.status == Status::ok);
  CHECK_THAT(script.unknown_code, Catch::StartsWith("it is run by python3"));
  const Worker argument = find_workers_by_argv({{"/usr/bin/python3", fakes + "/sound.py"}}).front();
  REQUIRE(argument.status == Status::ok);
  CHECK(argument.unknown_code == "python3 runs code of other files");
  const std::string wrapper = linked.file("wrapper", "#!/bin/sh\nexec " + linked.engine + "\n");
  fs::permissions(wrapper, fs::perms::owner_all);
  CHECK(find_workers({wrapper}).front().unknown_code == "it is run by engine");
}

TEST_CASE("relative files of a script that is named after its interpreter start at the script's folder") {
  const Folder folder;
  std::ofstream(folder / "data.bin") << "1";
  std::ofstream(folder / "engine.py") << R"(import sys
for line in sys.stdin:
    print('{"engine":"e","version":"1","methods":[{"id":"e/a","doc":""}],"fingerprint":"1","files":["data.bin"]}', flush=True)
)";
  const auto worker = [&] { return find_workers_by_argv({{"/usr/bin/python3", "-B", folder / "engine.py"}}).front(); };
  const Worker before = worker();
  REQUIRE(before.status == Status::ok);
  CHECK(before.unknown_code.empty());
  std::ofstream(folder / "data.bin") << "2";
  CHECK(worker().build_id != before.build_id);
}
