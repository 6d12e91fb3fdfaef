#include "mujoco/mujoco.hpp"

#include <mujoco/mujoco.h>

#include "mujoco/mujoco_world.hpp"
#include "rivals/rival.hpp"

namespace atwood {

Engine mujoco_engine() {
  rivals::Rival rival;
  rival.name = "mujoco";
  rival.version = mj_versionString();
  rival.scalar = "double";
  rival.source =
      "Todorov, Erez and Tassa 2012, MuJoCo: A physics engine for model-based control; MuJoCo 2.2.2 documentation";
  rival.presets = {
      {"default",
       "MuJoCo with default options: semi-implicit Euler, soft contacts by a convex problem that Newton's method "
       "solves, a friction pyramid. No restitution: scenes with restitution are refused."},
      {"tuned",
       "MuJoCo with the settings that `atwood tune` found for the class of the scene (free flight, bounce, friction, stack, "
       "heap, mechanism): the default's where none were better on scenes held out and worse nowhere in the class.",
       {},
       {},
       false,
       true},
      {"stiff",
       "MuJoCo with its Runge-Kutta method of order 4, the elliptic cone, friction a hundred times stiffer than the "
       "normal (impratio), stiffer contacts and a tighter solver.",
       mujoco::stiff()},
      {"rk4",
       "MuJoCo with its Runge-Kutta method of order 4, all else as in default. The scene's forces, which the adapter "
       "evaluates, are those of each stage.",
       {{"integrator", std::string("RK4")}}},
      {"implicit",
       "MuJoCo with its integrator that is implicit in velocity, all else as in default.",
       {{"integrator", std::string("implicit")}}}};
  rival.joints = true;
  rival.settings = mujoco::settings();
  rival.refusal = mujoco::refusal;
  rival.make = mujoco::make_world;
  rival.diagnostics = mujoco::diagnostics_since_last_call;
  return rivals::engine_of(rival);
}

}  // namespace atwood
