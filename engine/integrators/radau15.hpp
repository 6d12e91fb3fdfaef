// Collocation at the eight Radau nodes that include the start of the step: order 15, solved by fixed-point sweeps
// (Everhart 1985; Rein and Spiegel, MNRAS 446 (2015) 1424). The rates of a step are predicted by extrapolating those of
// the step before. Positions are integrated twice from the accelerations, so velocities need no stages where no force
// depends on them.
#pragma once

#include "integrators/stepper.hpp"
#include "math/lanes.hpp"
#include "rigid/model.hpp"

namespace atwood {

inline constexpr int kRadauNodes = kLaneCount;  // one node per lane

// A row is eight lanes. With F_j the rate at node j, in units of the step:
//   Y_i = y + h sum_j a[j][i] F_j      x_i = x + c_i h v + h^2 sum_j a2[j][i] F_j     (a2 = a a, where x' = v, v' = F)
//   y_new = y + h sum_j b[j] F_j       x_new = x + h v + h^2 sum_j b2[j] F_j
//   F(tau) = sum_k tau^k sum_j power[j][k] F_j, so power[j][7] makes the divided difference over all nodes
//   a change D of the rate at node n changes F_j by D newton[n][j] (Newton's term of node n), 0 for j < n
template <class S> struct RadauTable {
  using Row = S[kRadauNodes];
  alignas(kLaneCount * sizeof(S)) Row c, a[kRadauNodes], a2[kRadauNodes], power[kRadauNodes], newton[kRadauNodes];
  Row row[kRadauNodes], row2[kRadauNodes];                // a and a2 transposed, one node per row
  alignas(kLaneCount * sizeof(S)) Row ends[kRadauNodes];  // ends[j]: b[j], b2[j], power[j][7]
};
template <class S> const RadauTable<S>& radau_table();

// How far the rates of a step were extrapolated: prod_k (tau - c_k) at its nodes, tau and c_k in units of the step
// before, of which it is `growth` times the length.
template <class S> struct RadauExtrapolation {
  S growth = S(1);
  alignas(kLaneCount * sizeof(S)) S product[kRadauNodes] = {S(1), S(1), S(1), S(1), S(1), S(1), S(1), S(1)};
};

// What chooses the next step: the tolerance, or a published criterion of IAS15 with its epsilon.
enum class StepCriterion { tolerance, rein_spiegel, prs23 };

struct RadauOptions {
  bool sequential = false;  // true: node by node, each with the newest rates; false: all nodes in one batch
  bool compensated = true;
  bool fused = true;  // a few gravitating point masses in one kernel (radau15_point_masses.hpp)
  StepCriterion criterion = StepCriterion::tolerance;
  double epsilon = 1e-9;  // of the published criteria
};

struct GravitatingBodies;

template <class S> class Radau15 final : public Stepper<S> {
 public:
  // `model`: of the system, which says what is a position; null: every component is integrated once.
  Radau15(System<S>& system, const RigidModel<S>* model, const RadauOptions& options);
  ~Radau15() override;

  bool step(S t_s, S h_s, const S* y, S* y_new) override;
  bool chooses_steps() const override { return true; }
  typename Stepper<S>::Advice advise(S rtol, S atol) override;
  void set_tolerance(S rtol, S atol) override;
  void dense(S theta, S* y_at) override;
  void set_vector_width(VectorWidth width) { width_ = width; }  // results have the same bits at each width

 private:
  // A completed step, from which the rates of the next one are extrapolated.
  struct Record {
    bool valid = false, in_plane = false;
    S t_s{}, h_s{}, contraction = S(1);
    std::vector<S> y, y_new, compensation,
        compensation_new;                 // compensation: remainders of the compensated sums
    LaneArray<S> rate, prediction_error;  // the rates at the nodes, and the error of their prediction
    RadauExtrapolation<S> extrapolation;
  };
  // Largest absolute values of the components of one kind
  struct Scale {
    S state{}, rate{};
  };

  void find_unknowns();
  void add_joints(const Tree<S>& tree);
  Record* find_start(S t_s, const S* y, S& offset);
  void predict(S h_s, Record* from, S offset);
  void set_base(S t_s, S h_s, const S* y);
  void measure_scales(const S* rate);
  void start_nodes(S t_s, const S* y, bool predicted);
  bool iterate(S h_s, bool predicted);
  S sweep_batch(S h_s, LaneArray<S>& before);
  S sweep_nodes(S h_s);
  void finish(S h_s, const S* y, S* y_new);
  S add(int i, S y, S increment);
  bool step_general(S t_s, S h_s, const S* y, S* y_new, Record* from, S offset);
  bool step_fused(S h_s, const S* y, S* y_new, Record* from, S offset);
  Record& next_record();
  void store_record(S t_s, S h_s, const S* y, const S* y_new);
  S roughness() const;
  S least_timescale() const;
  double published_factor() const;

  const RigidModel<S>* model_;  // null: a bare system
  const RadauOptions options_;
  const RadauTable<S>& table_;
  VectorWidth width_ = widest_vectors();
  int size_;
  std::vector<S> compensation_, compensation_new_;
  std::int64_t epoch_ = -1;
  // Components of the state: those integrated once (rate at the same place) and twice (positions; their rate is their
  // velocity's). `kinds_`: consecutive components that have rates to be evaluated and share a scale.
  // In rates_
  struct Kind {
    int first, last;
  };
  std::vector<int> once_, rates_;
  struct Twice {
    std::vector<int> components;
    int shift;  // from a component to its velocity
  };
  Twice twice_[2];  // positions of bodies, coordinates of joints
  std::vector<Kind> kinds_;
  std::vector<S> weight_;     // of rates_: h / scale, from a change of the rate to a relative change of the state
  std::vector<Scale> scale_;  // of kinds_
  RadauExtrapolation<S> extrapolation_;  // of the present step
  LaneArray<S> state_, base_, rate_, rate_before_, predicted_, ends_;
  std::vector<S> node_state_, node_rate_;
  S t_nodes_[kRadauNodes];
  std::unique_ptr<GravitatingBodies> bodies_;  // null: not fused
  Record record_[2];
  int last_ = 0;          // record of the last step
  int kept_ = -1;         // record of the last step that advise() accepted
  S rtol_{}, atol_{};     // 0: sweeps to round-off
  S contraction_ = S(1);  // of the last sweeps: ratio of successive changes
  S roughness_{};         // of the last fused step
  bool converged_ = false;
};

}  // namespace atwood
