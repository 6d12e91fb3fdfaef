// What went wrong: errors as values.
#pragma once

#include <string>
#include <utility>
#include <variant>

namespace atwood {

struct Fault {
  std::string reason;  // a sentence that names what was found (a setting, a key of the scene) and what was expected
};

// A value, or why there is none.
template <class T> class Result {
 public:
  Result(T value) : held_(std::in_place_index<0>, std::move(value)) {}  // NOLINT: meant to convert
  Result(Fault fault) : held_(std::in_place_index<1>, std::move(fault)) {}

  explicit operator bool() const { return held_.index() == 0; }
  // Of a result that holds one; std::bad_variant_access otherwise.
  const T& operator*() const { return std::get<0>(held_); }
  T& operator*() { return std::get<0>(held_); }
  const T* operator->() const { return &std::get<0>(held_); }
  T* operator->() { return &std::get<0>(held_); }
  const Fault& fault() const { return std::get<1>(held_); }

 private:
  std::variant<T, Fault> held_;
};

}  // namespace atwood
