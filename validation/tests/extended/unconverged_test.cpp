// Searches for touches and for zero wind that cannot converge end the motion by name.
#include <catch2/catch.hpp>

#include "dynamics/state.hpp"
#include "extended/path.hpp"
#include "scenes.hpp"

using namespace atwood;

namespace {

// A body whose component `jumping` of the state is `first` before t = 0.3 and `then` after it; all else stays.
class JumpingStepper : public extended::Stepper<Wide> {
 public:
  JumpingStepper(int jumping, Wide first, Wide then) : jumping_(jumping), first_(first), then_(then) {}
  Wide step(Wide t, Wide* y, Wide limit) override {
    last_ = {t, limit, {y, y + 6}, {}, {y, y + 6}, {}, {}, {}};
    y[jumping_] = value_at(t + limit);
    last_.ym[jumping_] = value_at(t + limit / 2);
    last_.y1.assign(y, y + 6);
    for (auto* rates : {&last_.f0, &last_.fm, &last_.f1}) rates->assign(6, Wide(0));
    ++steps;
    return limit;
  }
  extended::DenseStep<Wide> dense() override { return last_; }
  void raise_scale(const Wide*) override {}

 private:
  Wide value_at(Wide t) const { return t < Wide(0.3) ? first_ : then_; }
  extended::DenseStep<Wide> last_;
  int jumping_;
  Wide first_, then_;
};

extended::Path<Wide> path_of(const Scene& scene, const std::vector<Wide>& initial, int jumping, Wide then) {
  return extended::integrate_path<Wide>(scene, 1, 1, initial,
                                        [&](const extended::Rate<Wide>&, const extended::Rate<double>&) {
                                          return std::make_unique<JumpingStepper>(jumping, initial[jumping], then);
                                        });
}

}  // namespace

TEST_CASE("a touch that the search does not find within the gap's round-off ends the motion by name") {
  Scene scene = scenes::empty_scene();
  scene.bodies = {scenes::point("floor", 1, {0, 0, 0}, {0, 0, 0}), scenes::point("ball", 1, {0, 0, 1}, {0, 0, -1})};
  scene.bodies[0].shape = Plane{{0, 0, 1}, 0};
  scene.bodies[0].fixed = true;
  scene.bodies[1].shape = Sphere{0.25};
  const dynamics::Slot slot = dynamics::layout(scene).slots[1];
  std::vector<Wide> initial(6);
  initial[slot.position + 2] = 1;
  initial[slot.velocity + 2] = -1;
  const extended::Path<Wide> path = path_of(scene, initial, slot.position + 2, Wide(0.1));  // below the floor at once
  CHECK_THAT(path.failure, Catch::Contains("`ball`") && Catch::Contains("`floor`") &&
                               Catch::Contains("touch did not converge in the step from t = 0.29999"));
  CHECK(path.valid_until_failure);
  CHECK(path.end < Wide(0.3));  // halved until a step holds nothing but the jump
  CHECK(path.end > Wide(0.2999));
  CHECK(path.events.empty());
}

TEST_CASE("a zero of the relative wind that the search does not find ends the motion by name") {
  Scene scene = scenes::empty_scene();
  scene.bodies = {scenes::point("ball", 1, {0, 0, 0}, {0, 0, 1})};
  scene.forces.push_back(QuadraticDrag{{0}, 1, 0.5, 0.1});
  const dynamics::Slot slot = dynamics::layout(scene).slots[0];
  std::vector<Wide> initial(6);
  initial[slot.velocity + 2] = 1;
  const extended::Path<Wide> path = path_of(scene, initial, slot.velocity + 2, Wide(-1));
  CHECK_THAT(path.failure, Catch::Contains("relative wind") && Catch::Contains("not located in the step from t = 0 s"));
  CHECK(path.valid_until_failure);
  CHECK(path.end == 0);
}
