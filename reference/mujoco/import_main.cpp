// atwood-mujoco-import FILE: the scene of an MJCF file as TOML on standard output; what is not taken, on standard
// error. Exit codes: 0; 2 with one sentence on standard error where the file is refused.
#include <cstdio>

#include "mujoco/import.hpp"

int main(int count, char** words) {
  if (count != 2) {
    std::fputs("usage: atwood-mujoco-import FILE.xml\n", stderr);
    return 2;
  }
  const auto scene = atwood::mujoco::import_model(words[1]);
  if (!scene) {
    std::fprintf(stderr, "%s\n", scene.fault().reason.c_str());
    return 2;
  }
  for (const auto& note : scene->notes) std::fprintf(stderr, "not taken, or changed: %s\n", note.c_str());
  return std::fputs(scene->toml.c_str(), stdout) < 0 || std::fflush(stdout) != 0 ? 5 : 0;
}
