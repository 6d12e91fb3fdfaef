// mjd_transitionFD, MuJoCo's derivatives of its own discrete step by differences, against the exact derivatives of that
// step.
//
// Its semi-implicit Euler step without damping is v' = v + h a(q, v), q' = q + h v', so that with a_q and a_v
//   d(q', v') / d(q, v) = [I + h^2 a_q, h I + h^2 a_v; h a_q, I + h a_v].
#include <catch2/catch.hpp>

#include <mujoco/mujoco.h>
#include <unistd.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <vector>

#include "joints/derivatives.hpp"
#include "joints/tree.hpp"
#include "rigid/model.hpp"
#include "validation/tests/engine/mechanisms.hpp"

namespace atwood::testing {
namespace {

const char* const kChain = R"(<mujoco>
  <option timestep="0.01" integrator="Euler" gravity="0 -9.81 0"><flag contact="disable"/></option>
  <worldbody>
    <body><joint name="a" type="hinge" axis="0 0 1"/>
      <inertial pos="0 -0.5 0" mass="1" diaginertia="0.08333333333333333 0.01 0.08333333333333333"/>
      <body pos="0 -1 0"><joint name="b" type="hinge" axis="0 0 1"/>
        <inertial pos="0 -0.5 0" mass="1" diaginertia="0.08333333333333333 0.01 0.08333333333333333"/>
      </body>
    </body>
  </worldbody>
</mujoco>)";

// Row-major, 4 x 4, from the accelerations' derivatives at the same state.
std::vector<double> exact_transition(double h, const std::vector<double>& q, const std::vector<double>& v) {
  const Scene scene = hinge_chain(q, v);
  RigidModel<double> model(scene);
  std::vector<int> offsets;
  for (int i = 0; i < model.body_count(); ++i) offsets.push_back(model.offset(i));
  std::vector<double> y(model.state_size());
  model.initial_state(y.data());
  const AccelerationDerivatives a =
      acceleration_derivatives(scene, offsets, model.tree()->scalars_at(), y.data(), static_cast<int>(y.size()));
  std::vector<double> exact(16);
  for (int i = 0; i < 2; ++i)
    for (int k = 0; k < 2; ++k) {
      const double one = i == k ? 1 : 0, by_q = h * a.by_displacement[2 * i + k], by_v = h * a.by_rate[2 * i + k];
      exact[4 * i + k] = one + h * by_q;
      exact[4 * i + 2 + k] = h * (one + by_v);
      exact[4 * (i + 2) + k] = by_q;
      exact[4 * (i + 2) + 2 + k] = one + by_v;
    }
  return exact;
}

TEST_CASE("MuJoCo's derivatives of its step are as exact as its differences allow, at the best of their steps") {
  const auto path =
      std::filesystem::temp_directory_path() / ("mujoco-derivatives-" + std::to_string(getpid()) + ".xml");
  std::ofstream(path) << kChain;
  char fault[500] = "";
  mjModel* model = mj_loadXML(path.c_str(), nullptr, fault, sizeof fault);
  std::filesystem::remove(path);
  INFO(fault);
  REQUIRE(model != nullptr);
  mjData* data = mj_makeData(model);
  const std::vector<double> q{2, -1}, v{0.5, 1.5};
  const std::vector<double> exact = exact_transition(model->opt.timestep, q, v);
  const auto error = [&](double step, bool central) {
    mj_resetData(model, data);
    std::copy(q.begin(), q.end(), data->qpos);
    std::copy(v.begin(), v.end(), data->qvel);
    std::vector<mjtNum> A(16);
    mjd_transitionFD(model, data, step, central, A.data(), nullptr, nullptr, nullptr);
    double worst = 0;
    for (int i = 0; i < 16; ++i) worst = std::max(worst, std::abs(A[i] - exact[i]));
    return worst;
  };
  double least[2] = {1, 1};
  for (int k = 1; k <= 13; ++k)
    for (const bool central : {false, true}) {
      const double step = std::pow(10.0, -k), e = error(step, central);
      least[central] = std::min(least[central], e);
      UNSCOPED_INFO((central ? "central " : "forward ") << step << ": " << e);
    }
  const double forward_3 = error(1e-3, false), forward_4 = error(1e-4, false);
  CHECK(forward_3 / forward_4 == Approx(10).epsilon(0.05));  // order 1 in the difference's step
  const double central_2 = error(1e-2, true), central_3 = error(1e-3, true);
  CHECK(central_2 / central_3 == Approx(100).epsilon(0.05));  // order 2
  CHECK(least[0] < 1e-7);
  CHECK(least[0] > 1e-11);
  CHECK(least[1] < 1e-9);
  CHECK(least[1] > 1e-14);
  mj_deleteData(data);
  mj_deleteModel(model);
}

}  // namespace
}  // namespace atwood::testing
