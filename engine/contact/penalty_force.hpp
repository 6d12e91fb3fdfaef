// The forces of compliant contacts.
//
// At each contact point with the overlap d and the rate d':
//   linear   F = k d + c d'                       never below 0, unless the pair may pull
//   Hertz    F = 4/3 E sqrt(R) d^(3/2) (1 + a d')  never below 0
// along the normal, and across it a spring of stiffness k_t and a damper between the points of both bodies that met:
//   F_t = -(k_t x + c_t u)                        while it lies within the friction cone
// else the friction of the cone's surface; x then is the stretch at which the spring alone would give that friction.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "collision/broad_phase.hpp"
#include "collision/contacts.hpp"
#include "forces/stateful_force.hpp"

namespace atwood {

struct PenaltyOptions {
  double overlap = 1e-3;            // of the smaller body's bounding radius, at an impact at
  double impact_speed_m_per_s = 0;  // 0: the scene's own, see scene_speed
  double damping_ratio = 0;         // 0: from the pair's restitution
  double tangential_ratio = 2.0 / 7;
};

// Upper bound on the approach speed of two bodies: twice the largest speed at the start and that of a fall through the
// scene's height.
double scene_speed(const Scene& scene);

// The damping ratio z of a linear contact that never pulls, whose restitution is e (at least kMinRestitution). It
// ends where the force does (Schwager, Poeschel 2007, eq. 20 and 24):
//   e = exp(-2 z acos(z) / sqrt(1 - z^2)) for z < 1,  exp(-2 z acosh(z) / sqrt(z^2 - 1)) for z > 1
double damping_ratio_of(double restitution);
inline constexpr double kMinRestitution = 1e-3;

// The contact law of one pair.
template <class S> struct ContactSpring {
  ContactLaw law = ContactLaw::linear;
  S stiffness{}, damping{};  // linear: k, c; Hertz: 4/3 E sqrt(R), a
  bool pull = false;
  S friction{}, tangential_ratio{};
};

template <class S> class PenaltyForce final : public StatefulForce<S> {
 public:
  PenaltyForce(const Scene& scene, const PenaltyOptions& options);

  const std::string& refusal() const { return refusal_; }  // why a pair cannot be simulated; empty: all can
  // The stiffest contact that the scene can have: angular frequency and damping ratio.
  struct Stiffest {
    double angular_frequency_rad_per_s = 0, damping_ratio = 0;
  };
  Stiffest stiffest() const;
  // Iterations of the narrow phase since reset(), in every evaluation of the loads.
  const SolverTallies& solvers() const { return solvers_; }

  void add_loads(const Motion<S>& motion, Load<S>* loads) const override;
  bool velocity_dependent() const override { return true; }
  void reset(const Motion<S>& motion) override;
  S longest_step(const Motion<S>& motion, const std::vector<Vec3<S>>& acceleration_W, S step_s) override;
  S missed_contact(const Motion<S>& motion, S step_s) override;
  bool accept_step(const Motion<S>& motion) override;
  void report(const Motion<S>& motion, Sample& sample, const Observer& observer) override;

 private:
  struct Key {  // the pair, and which features meet
    int a, b, part_a, part_b;
    std::uint32_t id;
    auto operator<=>(const Key&) const = default;
  };
  struct Point {  // of contact, now
    Key key;
    Vec3<S> x_W, normal_W, u_W;  // u: slip of b on a
    S overlap, closing, force_N;
    Vec3<S> friction_W;  // on b
    Vec3<S> stretch_W;   // of the tangential spring
    bool slides;         // on the cone
  };
  struct Memory {  // of a point, since the last accepted step
    Key key;
    Vec3<S> stretch_W, on_a_B, on_b_B;  // the spring's stretch; the material points that met
  };
  struct ImpactRecord {  // of a point, since its first touch
    Key key;
    S begin_s, vn_before, impulse_n, impulse_t, last_s, last_n, last_t;
    Vec3<S> x_W, normal_W;
  };

  ContactSpring<S> spring_of(int a, int b) const;
  void find_points(const Motion<S>& motion) const;
  void add_contact_points(const Motion<S>& motion, int a, int b) const;
  void apply_friction(Point& point, const ContactSpring<S>& spring) const;
  bool moving(const Motion<S>& motion, int body) const { return motion.slots[body].moves(); }
  Vec3<S> velocity_at(const Motion<S>& motion, int body, const Vec3<S>& x_W) const;
  S least_gap(int a, int b, const std::vector<Transform<S>>& places, S margin);
  void update_impacts(const Motion<S>& motion);
  void report_impact(const Motion<S>& motion, const ImpactRecord& record);

  const Scene& scene_;
  PenaltyOptions options_;
  std::string refusal_;
  S speed_{};
  std::vector<Geometry<S>> shapes_;
  std::vector<int> bounded_, planes_;            // bodies with shapes
  std::vector<S> inverse_mass_, damping_ratio_;  // a body; a pair law
  std::vector<Memory> memory_, next_memory_;     // sorted by key
  std::vector<ImpactRecord> impacts_, next_impacts_;
  std::vector<Event> events_;
  // The motion at the start of an adaptive step, and the pairs that may touch in it.
  struct BodyMotion {
    Vec3<S> p_W, v_W, w_B;
    Quat<S> q_WB;
    bool moves;
  };
  S near_s_{};  // 1 / (16 w) of the stiffest contact, once it is known
  std::vector<BodyMotion> start_;
  std::vector<BodyPair> may_touch_;
  std::vector<Transform<S>> between_;
  // Working memory of one evaluation.
  std::unique_ptr<BroadPhase<double>> broad_;  // in double whatever S is: boxes grown by what narrowing can lose
  mutable std::vector<BroadItem<double>> items_;
  mutable std::vector<BodyPair> near_;
  mutable std::vector<Transform<S>> places_;
  mutable std::vector<Manifold<S>> manifolds_;
  mutable std::vector<Point> points_;
  mutable SolverTallies solvers_;
};

}  // namespace atwood
