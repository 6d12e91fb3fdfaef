// Places of contacts in batches of lanes, colour by colour.
#pragma once

#include <vector>

#include "contact/stepping/contact_batches.hpp"

namespace atwood::stepping {

// Appends copies of `empty`, enough for the contacts of each colour, and an entry of `contacts.colours` for each colour
// in use. `colour[i]` is that of contact i, below `colours`; -1: it gets no place. next_slot[c] becomes the place of
// the first contact of colour c: batch slot / kLaneCount, lane slot % kLaneCount. `count`: working memory.
template <class Contacts, class Batch>
void append_batches(Contacts& contacts, const std::vector<int>& colour, int colours, SpherePartner partner,
                    const Batch& empty, std::vector<int>& count, std::vector<int>& next_slot) {
  count.assign(static_cast<std::size_t>(colours), 0);
  next_slot.assign(static_cast<std::size_t>(colours), 0);
  for (const int c : colour)
    if (c >= 0) ++count[c];
  auto& batches = contacts.batches;
  for (int c = 0; c < colours; ++c) {
    if (count[c] == 0) continue;
    const int first = static_cast<int>(batches.size());
    next_slot[c] = first * kLaneCount;
    batches.resize(batches.size() + static_cast<std::size_t>((count[c] + kLaneCount - 1) / kLaneCount), empty);
    contacts.colours.push_back({first, static_cast<int>(batches.size()), partner});
  }
}

}  // namespace atwood::stepping
