// atwood-mujoco-derivatives H_S STEP...: reads a scene as JSON from standard input, and prints MuJoCo's derivatives of
// its own step of H_S at the scene's start, by differences with each STEP, as CSV:
//   forward|central,STEP,I,K,VALUE
// Exit codes: 0; 2 with one sentence on standard error where there are none; 5: another failure.
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>

#include "mujoco/transition.hpp"
#include "protocol/sample.hpp"
#include "scene/files.hpp"

namespace {

int run(int count, char** words) {
  std::vector<double> steps;
  for (int i = 2; i < count; ++i) steps.push_back(std::stod(words[i]));
  std::string json;
  std::getline(std::cin, json);
  const auto found = atwood::mujoco::transitions(atwood::scene_from_json(json), std::stod(words[1]), steps);
  if (!found.refusal.empty()) {
    std::fprintf(stderr, "%s\n", found.refusal.c_str());
    return 2;
  }
  for (const auto& each : found.all) {
    std::size_t n = 0;
    while (n * n < each.matrix.size()) ++n;
    for (std::size_t i = 0; i < each.matrix.size(); ++i)
      std::printf("%s,%s,%zu,%zu,%s\n", each.centred ? "central" : "forward", atwood::format_double(each.step).c_str(),
                  i / n, i % n, atwood::format_double(each.matrix[i]).c_str());
  }
  return std::fflush(stdout) == 0 ? 0 : 5;
}

}  // namespace

int main(int count, char** words) {
  if (count < 3) {
    std::fputs("usage: atwood-mujoco-derivatives H_S STEP... < SCENE.json\n", stderr);
    return 2;
  }
  try {
    return run(count, words);
  } catch (const atwood::InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 5;
  }
}
