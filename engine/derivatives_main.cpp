// atwood-derivatives T_S [H_S]: reads a scene as JSON from standard input, and prints, of its start, the derivatives of
// the accelerations of its mechanisms, with the motors of the time T_S (`atwood derivatives` draws its table from it):
//   unknown,K,body|joint,INDEX,COMPONENT     what row and column K is of: a body or joint of the scene
//   derivative,by,I,K,VALUE,DIFFERENCE       by duals; in quad by central differences at 1e-10
//   ladder,by,duals|forward|central,STEP,ERROR   of the matrix in double, over its largest entry unless that is 0
//   transition,I,K,VALUE    with H_S: of one step of this length of semi-implicit Euler's method, in quad
// Exit codes: 0; 2 with one sentence on standard error where the scene is refused; 5: another failure.
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <iostream>
#include <string>
#include <utility>
#include <vector>

#include "joints/derivatives.hpp"
#include "joints/differences.hpp"
#include "joints/tree.hpp"
#include "protocol/sample.hpp"
#include "rigid/model.hpp"
#include "scene/files.hpp"

namespace {

using namespace atwood;

constexpr double kQuadStep = 1e-10;
constexpr int kStepExponents = 14;  // 1e-1 to 1e-14

struct Unknown {
  bool of_joint = false;
  int index = 0, component = 0, rate = 0;  // rate: its place in the tree's vectors
};

// Bodies that float, then joints, in the order of the scene; joints whose motion is prescribed have none.
std::vector<Unknown> unknowns_of(const Scene& scene, const Tree<double>& tree) {
  std::vector<Unknown> unknowns;
  const auto add = [&](bool of_joint, int index, const Link<double>& link) {
    for (int k = 0; k < link.rates && !link.driven; ++k) unknowns.push_back({of_joint, index, k, link.first_rate + k});
  };
  for (int i = 0; i < static_cast<int>(scene.bodies.size()); ++i)
    if (const int at = tree.link_of(i); at >= 0 && tree.links()[at].joint < 0) add(false, i, tree.links()[at]);
  for (int j = 0; j < tree.joint_count(); ++j)
    if (const int at = tree.link_of_joint(j); at >= 0) add(true, j, tree.links()[at]);
  return unknowns;
}

template <class A>
double largest_error(const std::vector<A>& a, const std::vector<Quad>& exact, const std::vector<Unknown>& unknowns,
                     int n) {
  Quad worst = 0, largest = 0;
  for (const Unknown& row : unknowns)
    for (const Unknown& column : unknowns) {
      const auto at = static_cast<std::size_t>(row.rate * n + column.rate);
      const Quad off = real::abs(Quad(a[at]) - exact[at]);
      if (!(off <= worst) && worst == worst) worst = off;  // also where it is not a number
      largest = real::max(largest, real::abs(exact[at]));
    }
  return static_cast<double>(largest > 0 ? worst / largest : worst);
}

void print_by(const char* by, Along along, const std::vector<double>& duals, const Scene& scene, const TreeState& at,
              const std::vector<Unknown>& unknowns, int n) {
  const auto exact = difference_derivatives<Quad>(scene, at, along, Quad(kQuadStep), DifferenceRule::central);
  for (std::size_t i = 0; i < unknowns.size(); ++i)
    for (std::size_t k = 0; k < unknowns.size(); ++k) {
      const auto entry = static_cast<std::size_t>(unknowns[i].rate * n + unknowns[k].rate);
      std::printf("derivative,%s,%zu,%zu,%s,%s\n", by, i, k, format_double(duals[entry]).c_str(),
                  format_number(exact[entry], 21).c_str());
    }
  if (along == Along::force) return;
  std::printf("ladder,%s,duals,,%s\n", by, format_double(largest_error(duals, exact, unknowns, n)).c_str());
  for (const auto& [rule, name] : {std::pair(DifferenceRule::forward, "forward"), {DifferenceRule::central, "central"}})
    for (int power = 1; power <= kStepExponents; ++power) {
      const double step = std::pow(10.0, -power);
      const auto matrix = difference_derivatives<double>(scene, at, along, step, rule);
      std::printf("ladder,%s,%s,%s,%s\n", by, name, format_double(step).c_str(),
                  format_double(largest_error(matrix, exact, unknowns, n)).c_str());
    }
}

void print_transition(const Scene& scene, const TreeState& at, double h_s, const std::vector<Unknown>& unknowns,
                      int n) {
  const std::vector<Quad> matrix = euler_step_derivatives(scene, at, h_s);
  const std::size_t m = unknowns.size();
  const auto place = [&](std::size_t i) { return (i < m ? 0 : n) + unknowns[i % m].rate; };
  for (std::size_t i = 0; i < 2 * m; ++i)
    for (std::size_t k = 0; k < 2 * m; ++k)
      std::printf("transition,%zu,%zu,%s\n", i, k,
                  format_number(matrix[static_cast<std::size_t>(place(i) * 2 * n + place(k))], 21).c_str());
}

int run(double t_s, double h_s) {
  std::string json;
  std::getline(std::cin, json);
  const Scene scene = scene_from_json(json);
  RigidModel<double> model(scene);
  const std::string why = !model.unsupported().empty() ? model.unsupported()
                          : model.tree() == nullptr    ? "the scene has no joints"
                          : model.constraints()        ? "the scene has loops, ropes or limits of joints"
                                                       : "";
  if (!why.empty()) {
    std::fprintf(stderr, "%s\n", why.c_str());
    return 2;
  }
  TreeState at{{}, model.tree()->scalars_at(), std::vector<double>(static_cast<std::size_t>(model.state_size())), t_s};
  for (int i = 0; i < model.body_count(); ++i) at.offsets.push_back(model.offset(i));
  model.initial_state(at.y.data());
  const AccelerationDerivatives duals =
      acceleration_derivatives(scene, at.offsets, at.first_free, at.y.data(), static_cast<int>(at.y.size()), t_s);
  const std::vector<Unknown> unknowns = unknowns_of(scene, *model.tree());
  for (std::size_t k = 0; k < unknowns.size(); ++k)
    std::printf("unknown,%zu,%s,%d,%d\n", k, unknowns[k].of_joint ? "joint" : "body", unknowns[k].index,
                unknowns[k].component);
  print_by("displacement", Along::displacement, duals.by_displacement, scene, at, unknowns, duals.rates);
  print_by("rate", Along::rate, duals.by_rate, scene, at, unknowns, duals.rates);
  print_by("force", Along::force, duals.by_force, scene, at, unknowns, duals.rates);
  if (h_s > 0) print_transition(scene, at, h_s, unknowns, duals.rates);
  return std::fflush(stdout) == 0 ? 0 : 5;
}

}  // namespace

int main(int count, char** words) {
  if (count != 2 && count != 3) {
    std::fputs("usage: atwood-derivatives T_S [H_S] < SCENE.json\n", stderr);
    return 2;
  }
  try {
    return run(std::stod(words[1]), count == 3 ? std::stod(words[2]) : 0);
  } catch (const InputError& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 5;
  }
}
