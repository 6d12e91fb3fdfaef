// A worker that gets its numbers from a shared library: hello alone. LINKED_HELLO takes hello's place; with
// LINKED_CHILD it starts another process first; it kills itself after hello if it can remove the file LINKED_ENDS.
#include <signal.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>

extern "C" double linked_gain();

int main() {
  if (getenv("LINKED_CHILD") && fork() == 0) {
    sleep(5);
    _exit(0);
  }
  const char* hello = getenv("LINKED_HELLO");
  for (char line[4096]; std::fgets(line, sizeof line, stdin);) {
    std::printf("%s\n", hello ? hello
                        : linked_gain() > 0
                            ? R"({"engine":"linked","version":"1","methods":[{"id":"linked/a","doc":""}]})"
                            : "");
    std::fflush(stdout);
    if (const char* ends = getenv("LINKED_ENDS"); ends != nullptr && unlink(ends) == 0) kill(getpid(), SIGKILL);
  }
}
