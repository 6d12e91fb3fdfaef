// Compounds of oriented boxes (b) against any shape (a), compounds included: bounding spheres first, then box by box.
// Every pair of parts has its own manifold; the gap is the least of the parts' gaps.
#pragma once

#include "collision/pair_tests.hpp"

namespace atwood {

// Appends the manifolds, `part_b` the index of the box.
template <class S>
void compound_contacts(const Posed<S>& a, const Posed<S>& b, S margin, std::vector<Manifold<S>>& out);
// The separation of the nearest box, or of that of deepest overlap.
template <class S> Separation<S> compound_separation(const Posed<S>& a, const Posed<S>& b);

}  // namespace atwood
