// The state vectors of a run, each with a version number that says which contents a cached evaluation belongs to.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

namespace atwood::event {

// A state vector. Equal versions mean equal contents, in whichever buffer; 0 is the version of no state.
template <class S> struct State {
  std::vector<S> values;
  std::uint64_t version = 0;

  const S* data() const { return values.data(); }
  void swap(State& other) {
    values.swap(other.values);
    std::swap(version, other.version);
  }
};

template <class S> struct StateBuffers {
  State<S> y;                 // at the present time
  State<S> y_new;             // at the end of the trial step
  State<S> y_probe;           // within the trial step, during event location
  State<S> y_before_impacts;  // before the impacts of an instant
  std::vector<S> dydt;        // rates of an evaluation that is not part of a step
  std::uint64_t last_version = 0;

  // For writing: the contents get a new version.
  S* overwrite(State<S>& state) {
    state.version = ++last_version;
    return state.values.data();
  }
  // Of a state that a method passes by address: 0 unless it is y, which no step writes to. Methods may keep stages in
  // the buffer of their result, so that one is not known before the step has ended.
  std::uint64_t version_of(const S* state) const { return state == y.data() ? y.version : 0; }
};

}  // namespace atwood::event
