#include "dart/engine.hpp"

#include "dart/dart_world.hpp"
#include "rivals/rival.hpp"

namespace atwood {

Engine dart_engine() {
  rivals::Rival rival;
  rival.name = "dart";
  rival.version = dartsim::version();
  rival.scalar = "double";
  rival.source = "Lee et al. 2018, DART: Dynamic Animation and Robotics Toolkit; DART 6.12";
  rival.presets = {
      {"default",
       "DART's World with default settings, except the collision detector: the default, FCL on meshes, takes a "
       "plane for a thin upright box of 1000 m, so ODE's is used, in double. Semi-implicit Euler; contacts "
       "by Dantzig's method on a boxed complementarity problem; a friction pyramid along the world's x and "
       "y."},
      {"tuned",
       "DART with the settings that `atwood tune` found for the class of the scene (bounce, friction, stack, heap): the "
       "default's where none were better on scenes held out and worse nowhere in the class, and in free flight and for "
       "mechanisms.",
       {},
       {},
       false,
       true},
      {"stiff",
       "DART with the friction pyramid turned along the slip and the least softness of contacts that it "
       "admits (cfm 1e-9).",
       dartsim::stiff()}};
  rival.joints = true;
  rival.settings = dartsim::settings();
  rival.contradiction = dartsim::contradiction;
  rival.refusal = dartsim::refusal;
  rival.make = dartsim::make_world;
  rival.diagnostics = dartsim::diagnostics_since_last_call;
  return rivals::engine_of(rival);
}

}  // namespace atwood
