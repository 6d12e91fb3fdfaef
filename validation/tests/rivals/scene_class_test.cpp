// The class of a scene, by which tuned presets are chosen.
#include <catch2/catch.hpp>

#include <algorithm>
#include <map>

#include "rivals/scene_class.hpp"
#include "rivals/tuned.hpp"
#include "validation/tests/catalogued.hpp"

using namespace atwood;
using namespace atwood::rivals;

namespace {

Scene catalogue_scene(const std::string& id) { return testing::catalogued(id).scene; }

}  // namespace

TEST_CASE("scenes of the catalogue have the class that their title names") {
  const std::map<std::string, SceneClass> expected{{"kepler-e0.6", SceneClass::free_flight},
                                                   {"free-box-complex", SceneClass::free_flight},
                                                   {"bounce-e0.8", SceneClass::bounce},
                                                   {"bounce-e0", SceneClass::bounce},
                                                   {"head-on", SceneClass::bounce},
                                                   {"cradle-touching-1", SceneClass::bounce},
                                                   {"oblique-rough", SceneClass::bounce},
                                                   {"oblique-phase", SceneClass::bounce},
                                                   {"rod-on-rough-floor", SceneClass::bounce},
                                                   {"roll", SceneClass::friction},
                                                   {"roll-cylinder", SceneClass::friction},
                                                   {"slide-30", SceneClass::friction},
                                                   {"stop-distance-45", SceneClass::friction},
                                                   {"mesh-floor-slide", SceneClass::friction},
                                                   {"slip-to-roll", SceneClass::friction},
                                                   {"stack-10", SceneClass::stack},
                                                   {"card-house", SceneClass::stack},
                                                   {"wall", SceneClass::stack},
                                                   {"settling-100", SceneClass::heap},
                                                   {"pile-216", SceneClass::heap},
                                                   {"elastic-216", SceneClass::heap},
                                                   {"bouncing-49", SceneClass::heap},
                                                   {"settling-boxes-100", SceneClass::heap},
                                                   {"pendulum-1", SceneClass::mechanism},
                                                   {"chain-20-hinges", SceneClass::mechanism}};
  for (const auto& [id, wanted] : expected) {
    CAPTURE(id, to_string(wanted));
    CHECK(to_string(scene_class(catalogue_scene(id))) == to_string(wanted));
  }
}

TEST_CASE("neither the order of the bodies nor the unit of length changes the class") {
  for (const char* id : {"roll", "stop-distance-45", "settling-100", "head-on"}) {
    Scene scene = catalogue_scene(id);
    const SceneClass wanted = scene_class(scene);
    std::reverse(scene.bodies.begin(), scene.bodies.end());
    CHECK(to_string(scene_class(scene)) == to_string(wanted));
  }
  Scene small = catalogue_scene("roll");
  for (Body& body : small.bodies) {
    for (double& x : body.position_m) x *= 1e-6;
    if (auto* sphere = std::get_if<Sphere>(&body.shape)) sphere->radius_m *= 1e-6;
    if (auto* plane = std::get_if<Plane>(&body.shape)) plane->offset_m *= 1e-6;
    if (auto* box = std::get_if<Box>(&body.shape))
      for (double& x : box->half_extents_m) x *= 1e-6;
  }
  CHECK(to_string(scene_class(small)) == "friction");
}

TEST_CASE("names read back, and an engine without a search has no changes") {
  for (const SceneClass each : all_scene_classes()) CHECK(scene_class_of(to_string(each)) == each);
  CHECK_FALSE(scene_class_of("heaps").has_value());
  CHECK(tuned_changes("havok", SceneClass::heap).empty());
  CHECK(tuned_words("havok", SceneClass::heap) == "the default");
}
