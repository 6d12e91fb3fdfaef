// The forces of a scene that have a potential energy, and those that do no work: used by energy-preserving methods.
#pragma once

#include <string>
#include <vector>

#include "forces/force.hpp"

namespace atwood {

template <class S> class ConservativeForces {
 public:
  explicit ConservativeForces(const Scene& scene);

  // Why the motion does not conserve the scene's energy, naming the force ("" if it does).
  const std::string& refusal() const { return refusal_; }
  void refuse(const std::string& why) { refusal_ = why; }  // for forces that the scene does not name
  // Angular momentum about `centre` is conserved: every force points at it or along the line of two moving bodies.
  bool central() const { return central_; }
  const Vec3<S>& centre() const { return centre_; }

  S potential_energy(const Motion<S>& motion) const;  // J, of the bodies that move now and their surroundings

  // A discrete gradient: forces F_i (N, at the centre of mass; one per body, added to the array) with
  //   sum_i F_i . (p_i' - p_i) = -(U(p') - U(p)),   F(p, p) = -grad U(p),   F(p, p') = F(p', p)
  // Forces that do no work are taken at (p + p') / 2 with the velocities (v + v') / 2. For U = phi(r) a quotient that
  // needs no subtraction, F = -(phi(r') - phi(r)) / (r'^2 - r^2) (r + r'), r vectors: LaBudde, Greenspan, J. Comput.
  // Phys. 15 (1974) 134; Gonzalez, J. Nonlinear Sci. 6 (1996) 449, the equivariant one. It keeps angular momentum as
  // well. For polynomials of degree 3 the mean of -grad U over the segment, by Simpson's rule, which is exact there.
  void add_discrete_forces(const Motion<S>& from, const Motion<S>& to, Vec3<S>* force_W) const;

 private:
  struct Uniform {
    int body;
    Vec3<S> force_W;
  };
  // U = -strength / r
  struct Central {
    int body;
    Vec3<S> centre;
    S strength;
  };
  // U = -constant w w / sqrt(r^2 + s^2)
  struct Pairs {
    std::vector<int> bodies;
    std::vector<S> weight;
    S constant, softening2;
  };
  // a = -1: the anchor
  struct Elastic {
    int a, b;
    Vec3<S> anchor;
    S stiffness, rest_length;
  };
  struct HenonHeiles {
    int body;
    S lambda;
  };
  struct Magnetic {
    int body;
    Vec3<S> charge_times_field;
  };
  struct Frame {
    int body;
    S mass;
    Vec3<S> rate;
  };

  void read(const MutualGravity&, const Scene&);
  void read(const Attractor&, const Scene&);
  void read(const Spring&, const Scene&);
  void read(const Lorentz&, const Scene&);
  void read(const Coulomb&, const Scene&);
  void read(const RotatingFrame&, const Scene&);
  void read(const Potential&, const Scene&);
  void read(const PointForce&, const Scene&);
  void read(const LinearDrag&, const Scene&) { refusal_ = "drag takes energy away"; }
  void read(const QuadraticDrag&, const Scene&) { refusal_ = "drag takes energy away"; }
  void read(const Drive&, const Scene&) { refusal_ = "a drive does work"; }
  void read(const Thruster&, const Scene&) { refusal_ = "a thruster does work"; }
  void add_centre(const Vec3<S>& centre);

  std::string refusal_;
  bool central_ = true, has_centre_ = false;
  Vec3<S> centre_;
  std::vector<Uniform> uniform_;
  std::vector<Central> attractors_;
  std::vector<Pairs> pairs_;
  std::vector<Elastic> springs_;
  std::vector<HenonHeiles> henon_heiles_;
  std::vector<Magnetic> magnetic_;
  std::vector<Frame> frames_;
};

}  // namespace atwood
