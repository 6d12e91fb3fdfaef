// What workers cannot do: take memory, reach the network, write outside their scratch directory; by each means that
// this kernel offers.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>
#include <catch2/catch.hpp>

#include <chrono>
#include <cstddef>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <thread>

#include "asked.hpp"

using namespace atwood;
namespace fs = std::filesystem;
using Namespaces = ConfinementMeans::Namespaces;

namespace {

struct Hostile {
  BrokenPipeGuard guard;
  WorkerClient client;
  explicit Hostile(Confinement confinement = {})
      : client({workers + "/hostile.py"}, false, false, std::move(confinement)) {}
  Outcome operator()(const std::string& what, double limit_s = 30) {
    return client
        .run("hostile/" + what, scene_to_json(scenario.scene), sampled_bodies(scenario.scene),
             {scenario.t_end_s, 16, 8}, 0, limit_s)
        .outcome;
  }
};

double seconds_since(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

// Catch2 2 has no way to skip a case.
bool offered(bool there, const std::string& what) {
  if (!there) std::cerr << "skipped: " << what << " (this kernel, or its settings, do not offer it)\n";
  return there;
}

ConfinementMeans only_landlock(int abi) {
  ConfinementMeans means;
  means.landlock_abi = abi;
  return means;
}

ConfinementMeans only_namespaces() {
  ConfinementMeans means = kernel_means();
  means.landlock_abi = 0;
  return means;
}

std::string first_line(const std::string& path) {
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  return line;
}

// What a worker with these means achieves in a folder that is not its own; nothing there has changed.
std::string writes(const ConfinementMeans& means) {
  const Folder folder;
  fs::create_directory(folder / "target");
  std::ofstream(folder / "target/kept") << "ours\n";
  setenv("HOSTILE_TARGET", (folder / "target").c_str(), 1);
  const Outcome outcome = Hostile({.means = means})("writes_outside");
  unsetenv("HOSTILE_TARGET");
  CHECK(outcome.status == Status::unsupported);
  CHECK(first_line(folder / "target/kept") == "ours");
  CHECK(std::distance(fs::directory_iterator(folder / "target"), fs::directory_iterator()) == 1);
  return outcome.reason;
}

// A server of TCP, of UDP and of an abstract Unix socket.
struct Server {
  int tcp = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  int udp = socket(AF_INET, SOCK_DGRAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  int local = socket(AF_UNIX, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  Server() {
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    REQUIRE(bind(tcp, reinterpret_cast<sockaddr*>(&address), size) == 0);
    REQUIRE(listen(tcp, 4) == 0);
    REQUIRE(getsockname(tcp, reinterpret_cast<sockaddr*>(&address), &size) == 0);
    REQUIRE(bind(udp, reinterpret_cast<sockaddr*>(&address), size) == 0);
    const std::string port = std::to_string(ntohs(address.sin_port)), name = "atwood-test-" + port;
    sockaddr_un unix_address{};
    unix_address.sun_family = AF_UNIX;
    name.copy(unix_address.sun_path + 1, name.size());
    const auto length = static_cast<socklen_t>(offsetof(sockaddr_un, sun_path) + 1 + name.size());
    REQUIRE(bind(local, reinterpret_cast<sockaddr*>(&unix_address), length) == 0);
    REQUIRE(listen(local, 4) == 0);
    setenv("HOSTILE_PORT", port.c_str(), 1);
  }
  ~Server() {
    unsetenv("HOSTILE_PORT");
    for (const int each : {tcp, udp, local}) close(each);
  }
  Server(const Server&) = delete;
  Server& operator=(const Server&) = delete;
  bool reached() const {
    char byte;
    return accept4(tcp, nullptr, nullptr, 0) >= 0 || recv(udp, &byte, 1, 0) >= 0 ||
           accept4(local, nullptr, nullptr, 0) >= 0;
  }
};

}  // namespace

TEST_CASE("Landlock: a worker changes nothing outside its scratch directory") {
  const int abi = kernel_means().landlock_abi;
  if (!offered(abi > 0, "Landlock")) return;
  for (int version = 1; version <= abi; ++version) {  // a newer kernel is asked for no more than an older one knows
    CAPTURE(version);
    CHECK(writes(only_landlock(version)) ==
          "new:EACCES over:EACCES append:EACCES remove:EACCES folder:EACCES link:EACCES move:EACCES scratch:done "
          "null:done");
  }
}

TEST_CASE("a mount namespace: a worker changes nothing outside its scratch directory") {
  if (!offered(kernel_means().mount != Namespaces::none, "mount namespaces")) return;
  const std::string all =
      "new:EROFS over:EROFS append:EROFS remove:EROFS folder:EROFS link:EROFS move:EXDEV scratch:done null:done";
  CHECK(writes(only_namespaces()) == all);
#ifndef __SANITIZE_THREAD__  // its own thread runs in forked children too: they get no namespace of users
  ConfinementMeans as_user = only_namespaces();
  as_user.mount = as_user.network = Namespaces::user;
  CHECK(writes(as_user) == all);
#endif
}

TEST_CASE("Landlock with a mount namespace: not even modes, times and attributes of other files change") {
  if (!offered(kernel_means().mount != Namespaces::none, "mount namespaces")) return;
  const Folder folder;
  std::ofstream(folder / "kept") << "ours\n";
  setenv("HOSTILE_TARGET", folder.path.c_str(), 1);
  CHECK(Hostile()("changes_attributes").reason == "mode:EROFS folder:EROFS times:EROFS attribute:EROFS scratch:done");
  CHECK_THAT(Hostile({.sandbox = false})("changes_attributes").reason,
             Catch::StartsWith("mode:done folder:done times:done"));
  unsetenv("HOSTILE_TARGET");
  fs::permissions(folder.path, fs::perms::owner_all);
}

TEST_CASE("a network namespace: a worker reaches no server of this machine") {
  if (!offered(kernel_means().network != Namespaces::none, "network namespaces")) return;
  const Server server;
  CHECK(Hostile()("connects").reason == "tcp:ENETUNREACH udp:ENETUNREACH abstract:ECONNREFUSED");
  CHECK_FALSE(server.reached());
  CHECK(Hostile({.sandbox = false})("connects").reason == "tcp:done udp:done abstract:done");
  CHECK(server.reached());
}

TEST_CASE("Landlock: a worker opens no TCP connection, and signals no process of ours") {
  const int abi = kernel_means().landlock_abi;
  if (!offered(abi >= kLandlockOfTcp, "Landlock for TCP")) return;
  const Server server;
  CHECK_THAT(Hostile({.means = only_landlock(kLandlockOfTcp)})("connects").reason, Catch::StartsWith("tcp:EACCES "));
  if (!offered(abi >= 6, "Landlock for signals")) return;
  CHECK_THAT(Hostile({.means = only_landlock(6)})("connects").reason, Catch::EndsWith("abstract:EPERM"));
  CHECK(Hostile()("signals_parent").reason == "EPERM");
  CHECK(Hostile({.sandbox = false})("signals_parent").reason == "done");
}

TEST_CASE("HOME, TMPDIR and the working directory are a scratch directory that goes with the worker") {
  const Outcome outcome = Hostile()("reads_home");
  CHECK_THAT(outcome.reason, Catch::Contains("/atwood-worker-") && Catch::EndsWith(" same"));  // and empty
  const std::string scratch = outcome.reason.substr(0, outcome.reason.find(' '));
  CHECK(scratch.size() > 10);
  CHECK_FALSE(fs::exists(scratch));
  const std::string home = std::getenv("HOME") ? std::getenv("HOME") : "";
  if (!home.empty() && fs::is_directory(home))
    CHECK_THAT(Hostile({.sandbox = false})("reads_home").reason, Catch::StartsWith(home + " different"));
}

TEST_CASE("a scratch directory whose owner was killed is removed later") {
  const Folder folder;
  const std::string left = folder / "atwood-worker-left", young = folder / "atwood-worker-young";
  for (const std::string& each : {left, young}) fs::create_directories(each + "/inside");
  fs::last_write_time(left, fs::file_time_type::clock::now() - std::chrono::hours(1));
  remove_stale_scratch(folder.path);
  CHECK_FALSE(fs::exists(left));
  CHECK(fs::exists(young));
}

TEST_CASE("a worker that cannot be confined as far as was promised is not started") {
  const pid_t child = fork();
  if (child == 0) {
    if (geteuid() == 0 && setresuid(65534, 65534, 65534) != 0) _exit(3);
    ConfinementMeans promised;
    promised.mount = Namespaces::privileged;
    try {
      const Process process({"/bin/true"}, false, {.means = promised});
      _exit(1);
    } catch (const std::runtime_error& error) {
      _exit(error.what() == std::string("/bin/true cannot be confined (namespaces): Operation not permitted") ? 0 : 2);
    }
  }
  int status = 0;
  waitpid(child, &status, 0);
  CHECK(WIFEXITED(status));
  CHECK(WEXITSTATUS(status) == 0);
}

TEST_CASE("what the kernel lacks is said") {
  ConfinementMeans means;
  means.no_landlock = "the kernel has none", means.no_network = means.no_mount = "Operation not permitted";
  CHECK(confinement_gaps(means) ==
        "network: NOT confined (no network namespace: Operation not permitted; Landlock restricts TCP from ABI 4 on); "
        "writing: NOT confined (no Landlock: the kernel has none; no mount namespace: Operation not permitted)");
  means.landlock_abi = 4;
  CHECK(confinement_gaps(means) ==
        "network: no TCP, but other protocols (Landlock, ABI 4; no network namespace: Operation not permitted); "
        "writing: only in the scratch directory: Landlock, ABI 4; modes, times and attributes of files can be changed "
        "everywhere (no mount namespace: Operation not permitted)");
  means.network = means.mount = Namespaces::user;
  CHECK(confinement_gaps(means).empty());
  const auto lines = describe(means, std::int64_t{3} << 29);
  REQUIRE(lines.size() == 3);
  CHECK(lines[0].how == "at most 1.5 GiB resident, with descendants");
  CHECK(lines[1].how == "none: a network namespace in a user namespace");
  CHECK(lines[2].how == "only in the scratch directory: Landlock, ABI 4, and a mount namespace in a user namespace");
}

TEST_CASE("a worker that takes memory is ended at the limit, with descendants that each take less") {
  for (const bool sandbox : {true, false}) {
    Hostile ask({.sandbox = sandbox, .memory_bytes = std::int64_t{256} << 20});
    for (const std::string how : {"takes_memory", "takes_memory_in_children"}) {
      CAPTURE(how);
      const auto start = Clock::now();
      const Outcome outcome = ask(how, 60);
      CHECK(outcome.status == Status::crashed);
      CHECK(outcome.reason == "took more than 256 MiB of memory");
      CHECK(ask.client.killed_from_outside());  // the next run, perhaps with another limit, tries it again
      CHECK(seconds_since(start) < 30);
    }
    CHECK(ask("well").status == Status::ok);
  }
}

TEST_CASE("a worker that takes memory after its answer is ended too; shared memory counts once") {
  Hostile ask({.memory_bytes = std::int64_t{256} << 20});
  CHECK(ask("takes_memory_later").status == Status::ok);
  const pid_t worker = ask.client.process_id();
  const auto start = Clock::now();
  while (runs(worker) && seconds_since(start) < 30) std::this_thread::sleep_for(std::chrono::milliseconds(20));
  CHECK_FALSE(runs(worker));
  CHECK(ask("well").reason == "took more than 256 MiB of memory");
  CHECK(ask("shares_memory").status == Status::ok);
}

TEST_CASE("files in memory that a worker holds open count to its memory, once") {
  Hostile ask({.memory_bytes = std::int64_t{256} << 20});
  CHECK(ask("holds_memory_files", 60).reason == "took more than 256 MiB of memory");
  CHECK(ask("maps_a_memory_file").status == Status::ok);
}

TEST_CASE("an orphan that names no running worker is killed while workers run; one that names its worker is not") {
  Hostile ask, other;
  CHECK(other("well").status == Status::ok);
  CHECK(ask("leaves_a_named_daemon").reason == "runs");
  CHECK(ask("leaves_a_daemon").reason == "ended");
  CHECK(runs(other.client.process_id()));
}

TEST_CASE("a slow drip and ignored signals end at the time limit") {
  Hostile ask;
  CHECK(ask("well").status == Status::ok);
  for (const std::string how : {"drips", "ignores_signals"}) {
    CAPTURE(how);
    CHECK(ask("well").status == Status::ok);  // started again
    const pid_t worker = ask.client.process_id();
    const auto start = Clock::now();
    const Outcome outcome = ask(how, 0.5);
    CHECK(outcome.status == Status::timeout);
    CHECK(outcome.reason == "no answer within 0.5 s");
    CHECK(seconds_since(start) < 10);
    CHECK_FALSE(runs(worker));
  }
}
