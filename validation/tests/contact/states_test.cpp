// The versions by which +event knows to which state a cached evaluation belongs.
#include <catch2/catch.hpp>

#include "contact/event/states.hpp"

using namespace atwood::event;

namespace {

StateBuffers<double> buffers() {
  StateBuffers<double> states;
  for (State<double>* state : {&states.y, &states.y_new, &states.y_probe, &states.y_before_impacts})
    state->values.resize(3);
  return states;
}

}  // namespace

TEST_CASE("Every write gives a state a version that no other state has had") {
  StateBuffers<double> states = buffers();
  states.overwrite(states.y)[0] = 1;
  const auto first = states.y.version;
  CHECK(first != 0);
  states.overwrite(states.y_new)[0] = 2;
  CHECK(states.y_new.version != first);
  states.overwrite(states.y)[0] = 3;
  CHECK(states.y.version != first);
  CHECK(states.y.version != states.y_new.version);
}

TEST_CASE("A version goes with the contents, by swap and by copy") {
  StateBuffers<double> states = buffers();
  states.overwrite(states.y)[0] = 1;
  states.overwrite(states.y_new)[0] = 2;
  const auto old_version = states.y.version, new_version = states.y_new.version;
  states.y_before_impacts = states.y;
  CHECK(states.y_before_impacts.version == old_version);
  states.y.swap(states.y_new);
  CHECK(states.y.data()[0] == 2);
  CHECK(states.y.version == new_version);
  CHECK(states.y_new.version == old_version);
  states.y = states.y_before_impacts;
  CHECK(states.y.data()[0] == 1);
  CHECK(states.y.version == old_version);
}

TEST_CASE("A method's stages have no version, also in the buffer of its result") {
  StateBuffers<double> states = buffers();
  states.overwrite(states.y)[0] = 1;
  states.overwrite(states.y_probe)[0] = 1;
  const std::vector<double> stage(3, 1.0);
  CHECK(states.version_of(stage.data()) == 0);
  CHECK(states.version_of(states.y.data()) == states.y.version);
  CHECK(states.version_of(states.y_probe.data()) == 0);
  states.overwrite(states.y_new)[0] = 2;
  CHECK(states.version_of(states.y_new.data()) == 0);
}
