// The bodies of a scene as contacts see them: poses, inverse inertias, and the scales of their round-off.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/event/pose.hpp"
#include "contact/impulse.hpp"
#include "rigid/model.hpp"

namespace atwood::event {

// World axes.
template <class S> struct InverseInertia {
  S inverse_mass_per_kg{};
  Vec3<S> I_row[3];  // [1/(kg m^2)], about the centre of mass
};

// Vectors hold one entry a body.
template <class S> struct Bodies {
  explicit Bodies(RigidModel<S>& of_model) : model(of_model) {}

  RigidModel<S>& model;
  std::vector<Pose<S>> poses;  // of the states whose poses were computed last; fixed bodies' never change
  std::vector<InverseInertia<S>> inverse_inertia;  // at the poses, of bodies in contact; else of isotropic bodies only
  // Version of the state that the poses and inertias of all bodies in contact belong to; 0: of different states.
  std::uint64_t poses_version = 0;
  std::vector<unsigned char> moves;      // neither fixed nor held at present
  std::uint64_t moves_version = 0;       // of the contents of `moves`
  std::vector<unsigned char> isotropic;  // all principal moments of inertia are equal
  std::vector<S> bounding_radius;        // [m] about the centre of mass; of a plane 0
  std::vector<S> largest_inverse_mass;   // [1/kg] upper bound of the inverse effective mass at any of its points
  S length_scale{};                      // [m] largest coordinate or size so far: round-off of gaps is relative to it
  S speed_scale{};                       // [m/s] largest speed of any body's points so far

  // Bounds below which a gap, an approach or a slip is round-off.
  S gap_round_off() const { return S(64) * real::epsilon<S>() * length_scale; }
  S approach_round_off() const { return S(256) * real::epsilon<S>() * speed_scale; }
  S slip_round_off() const { return S(4096) * real::epsilon<S>() * speed_scale; }
};

// Sets `pose` to that of `body` in the state y; a fixed body's stays as it is.
template <class S> void update_pose(const Bodies<S>& bodies, int body, const S* y, Pose<S>& pose);
template <class S> Pose<S> pose_of(const Bodies<S>& bodies, int body, const S* y);
// Mass, inertia, velocity and lever arm of a body for an impact at x_W, from bodies.poses; zeros for a fixed one.
template <class S> ImpactBody<S> impact_body(const Bodies<S>& bodies, int body, const Vec3<S>& x_W);
// Sets a body's velocity in its pose and in the state y.
template <class S> void store_velocity(Bodies<S>& bodies, int body, const Vec3<S>& v_W, const Vec3<S>& w_W, S* y);
// Once a run: inverse masses, inverse inertias of isotropic bodies, bounds of inverse effective masses.
template <class S> void initialize_inverse_inertia(Bodies<S>& bodies);
// Raises speed_scale to the largest |v| + r |w| in the state y.
template <class S> void update_speed_scale(Bodies<S>& bodies, const S* y);

}  // namespace atwood::event
