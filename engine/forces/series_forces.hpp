// The forces of a scene in the form that Taylor methods need: laws whose power series in time follow from those of the
// motion by recurrences.
#pragma once

#include <string>
#include <vector>

#include "math/vec3.hpp"
#include "scene/scene.hpp"

namespace atwood {

// Laws for accelerations (and for torques where stated); each holds at all times (forces that switch are refused).
// Indices are those of the scene's bodies.
template <class S> struct SeriesForces {
  explicit SeriesForces(const Scene& scene);

  static constexpr int kMaxSeriesBodies = 128;  // series of all pairs are kept

  std::string refusal;  // names a force without a recurrence; empty where all have one

  // a = constant + of_position p + of_velocity v (rows of matrices), torque = -angular_drag w: uniform fields, linear
  // drag, anchored springs, the rotating frame. One per body.
  struct Linear {
    Vec3<S> constant, of_position[3], of_velocity[3];
    S angular_drag{};
    bool none = true;  // only the constant is not zero
  };
  std::vector<Linear> linear;

  // r = p_b - p_a (a = -1: from the centre): a_a += on_a r / (r^2 + s^2)^(3/2), a_b += on_b r / (r^2 + s^2)^(3/2)
  struct InverseSquare {
    int a, b;
    Vec3<S> centre;
    S on_a, on_b, softening2;
  };
  std::vector<InverseSquare> inverse_square;

  // a spring of no rest length: a_a += on_a r, a_b += on_b r, r as above
  struct Link {
    int a, b;
    S on_a, on_b;
  };
  std::vector<Link> links;

  // a += amplitude cos(omega t + phase)
  struct Oscillating {
    int body;
    Vec3<S> amplitude;
    S angular_frequency, phase;
  };
  std::vector<Oscillating> oscillating;

  // a -= strength (2 x y, x^2 - y^2, 0): Henon and Heiles
  struct Quadratic {
    int body;
    S strength;
  };
  std::vector<Quadratic> quadratic;

 private:
  void read(const MutualGravity&, const Scene&);
  void read(const Attractor&, const Scene&);
  void read(const LinearDrag&, const Scene&);
  void read(const QuadraticDrag&, const Scene&) { refusal = "the size of a velocity (quadratic-drag)"; }
  void read(const Spring&, const Scene&);
  void read(const Drive&, const Scene&);
  void read(const Lorentz&, const Scene&);
  void read(const Coulomb&, const Scene&);
  void read(const Thruster&, const Scene&) { refusal = "a thrust in body axes (thruster)"; }
  void read(const PointForce&, const Scene&);
  void read(const RotatingFrame&, const Scene&);
  void read(const Potential&, const Scene&);
};

}  // namespace atwood
