// Rooted trees and the order conditions they stand for, from the theory alone.
//
// A method has order p when for each rooted tree t of at most p nodes sum b_i phi_i(t) = 1 / gamma(t) (Hairer, Norsett,
// Wanner I, theorem II.2.13). With t = [t_1 ... t_m], m branches at the root: phi_i(t) = prod_k sum_j a_ij phi_j(t_k),
// gamma(t) = (nodes of t) prod_k gamma(t_k).
#pragma once

#include <cmath>
#include <vector>

#include "integrators/tableaux.hpp"

namespace atwood::testing {

// branches: where in the list
struct Tree {
  int nodes;
  double gamma;
  std::vector<std::size_t> branches;
};

namespace detail {
// Adds the trees of `nodes` nodes that hang `chosen` and further ones, no later in the list than `last`, from a root.
inline void hang(std::vector<Tree>& trees, int nodes, int nodes_left, std::size_t last,
                 std::vector<std::size_t>& chosen) {
  if (nodes_left == 0) {
    double gamma = nodes;
    for (const std::size_t branch : chosen) gamma *= trees[branch].gamma;
    trees.push_back({nodes, gamma, chosen});
    return;
  }
  for (std::size_t i = 0; i <= last; ++i) {
    if (trees[i].nodes > nodes_left) return;  // the list is sorted by nodes
    chosen.push_back(i);
    hang(trees, nodes, nodes_left - trees[i].nodes, i, chosen);
    chosen.pop_back();
  }
}
}  // namespace detail

// 1, 1, 2, 4, 9, 20, 48, 115, 286, 719 of 1, 2, ... nodes.
inline std::vector<Tree> rooted_trees(int most_nodes) {
  std::vector<Tree> trees{{1, 1, {}}};
  for (int nodes = 2; nodes <= most_nodes; ++nodes) {
    std::vector<std::size_t> chosen;
    detail::hang(trees, nodes, nodes - 1, trees.size() - 1, chosen);
  }
  return trees;
}

// phi of each tree, by stages.
inline std::vector<TableauRow> elementary_weights(const std::vector<Tree>& trees, const std::vector<TableauRow>& a) {
  std::vector<TableauRow> phi, a_phi;
  for (const Tree& tree : trees) {
    TableauRow product(a.size(), Quad(1)), sums;
    for (const std::size_t branch : tree.branches)
      for (std::size_t i = 0; i < a.size(); ++i) product[i] *= a_phi[branch][i];
    for (std::size_t i = 0; i < a.size(); ++i) {
      Quad sum = 0;
      for (std::size_t j = 0; j < i; ++j) sum += a[i][j] * product[j];
      sums.push_back(sum);
    }
    phi.push_back(product);
    a_phi.push_back(sums);
  }
  return phi;
}

inline TableauRow sizes(const TableauRow& row) {
  TableauRow size;
  for (const Quad x : row) size.push_back(x < 0 ? -x : x);
  return size;
}

// The order conditions of a table, and what rounding to quad alone may miss them by: each product and sum is off by
// 2^-113 of itself at most, so a residual is off by some 2^-113 sum |b_i| phi_i(|a|), which cancellation among large
// entries can raise far above the residual's own size.
struct OrderConditions {
  std::vector<Tree> trees;
  std::vector<TableauRow> phi, phi_of_sizes;

  OrderConditions(int most_nodes, const std::vector<TableauRow>& a) : trees(rooted_trees(most_nodes)) {
    std::vector<TableauRow> a_sizes;
    for (const TableauRow& row : a) a_sizes.push_back(sizes(row));
    phi = elementary_weights(trees, a);
    phi_of_sizes = elementary_weights(trees, a_sizes);
  }

  // The largest residual, and the largest in units of round-off
  struct Worst {
    double missed = 0, roundings = 0;
  };

  // Over the trees of `nodes` nodes, sum b_i phi_i - th^nodes / gamma: th = 1 for a step, below 1 for an interpolant.
  Worst worst(const TableauRow& b, int nodes, Quad theta = 1) const {
    const TableauRow b_sizes = sizes(b);
    Worst worst;
    for (std::size_t k = 0; k < trees.size(); ++k) {
      if (trees[k].nodes != nodes) continue;
      Quad sum = -Quad(1) / Quad(trees[k].gamma), size = 0;
      for (int n = 0; n < nodes; ++n) sum *= theta;
      for (std::size_t i = 0; i < b.size(); ++i) {
        sum += b[i] * phi[k][i];
        size += b_sizes[i] * phi_of_sizes[k][i];
      }
      const double residual = std::fabs(static_cast<double>(sum));
      worst.missed = std::fmax(worst.missed, residual);
      worst.roundings = std::fmax(worst.roundings, residual / (0x1p-113 * static_cast<double>(size)));
    }
    return worst;
  }
};

}  // namespace atwood::testing
