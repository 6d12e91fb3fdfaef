// Samples one after the other, the values of each kind in one list. A sample has no allocation of its own: a million
// samples of one body take 224 MB.
#pragma once

#include <cstddef>
#include <iterator>
#include <span>
#include <stdexcept>
#include <string>
#include <vector>

#include "protocol/ragged_array.hpp"
#include "protocol/sample.hpp"

namespace atwood {

// A sample where it is stored, in a series or by itself; valid as long as that does not change.
struct SampleView {
  Wide t_s = 0;
  std::span<const BodySample> bodies;
  std::span<const ContactSample> contacts;
  std::span<const ParticleSample> particles;
  std::span<const JointSample> joints;
  std::span<const RopeSample> ropes;

  SampleView(Wide t, std::span<const BodySample> of_bodies, std::span<const ContactSample> of_contacts,
             std::span<const ParticleSample> of_particles, std::span<const JointSample> of_joints,
             std::span<const RopeSample> of_ropes)
      : t_s(t), bodies(of_bodies), contacts(of_contacts), particles(of_particles), joints(of_joints), ropes(of_ropes) {}
  SampleView(const Sample& sample)
      : SampleView(sample.t_s, sample.bodies, sample.contacts, sample.particles, sample.joints, sample.ropes) {}
};

// The same to be changed; how many values of a kind a sample of a series has stays as it is.
struct SampleReference {
  Wide& t_s;
  std::span<BodySample> bodies;
  std::span<ContactSample> contacts;
  std::span<ParticleSample> particles;
  std::span<JointSample> joints;
  std::span<RopeSample> ropes;

  operator SampleView() const { return {t_s, bodies, contacts, particles, joints, ropes}; }
};

// Entry i of one of a sample's lists; throws std::out_of_range where it has fewer.
template <class T> T& checked(std::span<T> values, std::size_t i) {
  if (i >= values.size()) throw std::out_of_range("a sample of fewer values than expected");
  return values[i];
}

// A sample of its own.
inline Sample copy_of(const SampleView& view) {
  const auto list = [](const auto& values) { return std::vector(values.begin(), values.end()); };
  return {view.t_s, list(view.bodies), list(view.contacts), list(view.particles), list(view.joints), list(view.ropes)};
}

class SampleSeries {
 public:
  SampleSeries() = default;
  SampleSeries(const std::vector<Sample>& samples) {
    for (const Sample& sample : samples) push_back(sample);
  }

  bool empty() const { return t_s_.empty(); }
  std::size_t size() const { return t_s_.size(); }
  SampleView operator[](std::size_t k) const {
    return {t_s_[k], bodies_[k], contacts_[k], particles_[k], joints_[k], ropes_[k]};
  }
  SampleReference operator[](std::size_t k) {
    return {t_s_[k], bodies_[k], contacts_[k], particles_[k], joints_[k], ropes_[k]};
  }
  SampleView at(std::size_t k) const {
    if (k >= size()) throw std::out_of_range("a series of " + std::to_string(size()) + " samples");
    return (*this)[k];
  }
  SampleView front() const { return (*this)[0]; }
  SampleView back() const { return (*this)[size() - 1]; }
  SampleReference front() { return (*this)[0]; }
  SampleReference back() { return (*this)[size() - 1]; }

  // Room for so many samples with so many bodies each.
  void reserve(std::size_t samples, std::size_t bodies) {
    t_s_.reserve(samples);
    bodies_.reserve(samples, bodies);
  }
  void push_back(const SampleView& sample) {
    t_s_.push_back(sample.t_s);
    bodies_.push_back(sample.bodies);
    contacts_.push_back(sample.contacts);
    particles_.push_back(sample.particles);
    joints_.push_back(sample.joints);
    ropes_.push_back(sample.ropes);
  }
  // Keeps the first samples.
  void truncate(std::size_t samples) {
    t_s_.resize(samples);
    bodies_.truncate(samples);
    contacts_.truncate(samples);
    particles_.truncate(samples);
    joints_.truncate(samples);
    ropes_.truncate(samples);
  }
  void clear() { *this = {}; }  // and gives its memory back

  // Goes through the samples; an element is a view, made where it is asked for.
  template <class Series, class Element> struct Iterator {
    using iterator_category = std::random_access_iterator_tag;
    using value_type = Element;
    using difference_type = std::ptrdiff_t;
    using pointer = void;
    using reference = Element;

    Series* series = nullptr;
    std::ptrdiff_t at = 0;

    struct Arrow {
      Element element;
      const Element* operator->() const { return &element; }
    };
    Element operator*() const { return (*series)[static_cast<std::size_t>(at)]; }
    Arrow operator->() const { return {**this}; }
    Element operator[](std::ptrdiff_t n) const { return *(*this + n); }
    Iterator& operator++() { return ++at, *this; }
    Iterator& operator--() { return --at, *this; }
    Iterator operator++(int) { return {series, at++}; }
    Iterator& operator+=(std::ptrdiff_t n) { return at += n, *this; }
    Iterator operator+(std::ptrdiff_t n) const { return {series, at + n}; }
    Iterator operator-(std::ptrdiff_t n) const { return {series, at - n}; }
    std::ptrdiff_t operator-(const Iterator& other) const { return at - other.at; }
    bool operator==(const Iterator& other) const { return at == other.at; }
    auto operator<=>(const Iterator& other) const { return at <=> other.at; }
  };
  auto begin() const { return Iterator<const SampleSeries, SampleView>{this, 0}; }
  auto end() const { return begin() + static_cast<std::ptrdiff_t>(size()); }
  auto begin() { return Iterator<SampleSeries, SampleReference>{this, 0}; }
  auto end() { return begin() + static_cast<std::ptrdiff_t>(size()); }

 private:
  std::vector<Wide> t_s_;
  RaggedArray<BodySample> bodies_;
  RaggedArray<ContactSample> contacts_;
  RaggedArray<ParticleSample> particles_;
  RaggedArray<JointSample> joints_;
  RaggedArray<RopeSample> ropes_;
};

}  // namespace atwood
