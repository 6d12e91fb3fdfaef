// Runge-Kutta-Nystrom tables by their order conditions in quad; refusals of the methods; a held body.
#include <catch2/catch.hpp>
#include <cmath>

#include "integrators/nystrom_tables.hpp"
#include "scenes.hpp"

namespace atwood::testing {
namespace {

// An acceleration's expansion, tree by tree: with m factors of c (from x + c h v) and branches t_1 ... t_n at the root,
//   phi_i(t) = c_i^m prod_k sum_j a_ij phi_j(t_k), of order r(t) = 1 + m + sum_k (1 + r(t_k)).
// Along the exact solution it is th^(r - 1) / g, each branch integrated twice:
//   g(t) = prod_k g(t_k) r(t_k) (r(t_k) + 1).
// So
//   sum b'_i phi_i = 1 / (g r) for r <= p, and sum b_i phi_i = 1 / (g r (r + 1)) for r <= p - 1
// (Hairer, Norsett, Wanner I, section II.14, with the trees of x'' = a(t, x) only).
struct NystromTree {
  int order;
  double g;
  int c_factors;
  std::vector<std::size_t> branches;
};

void hang(std::vector<NystromTree>& trees, std::vector<NystromTree>& found, int order, int left, std::size_t last,
          std::vector<std::size_t>& chosen) {
  double g = 1;
  for (const std::size_t k : chosen) g *= trees[k].g * trees[k].order * (trees[k].order + 1);
  found.push_back({order, g, left, chosen});
  for (std::size_t i = 0; i < last && trees[i].order + 1 <= left; ++i) {
    chosen.push_back(i);
    hang(trees, found, order, left - trees[i].order - 1, i + 1, chosen);
    chosen.pop_back();
  }
}

std::vector<NystromTree> nystrom_trees(int most) {
  std::vector<NystromTree> trees;
  for (int order = 1; order <= most; ++order) {
    std::vector<NystromTree> found;
    std::vector<std::size_t> chosen;
    hang(trees, found, order, order - 1, trees.size(), chosen);
    trees.insert(trees.end(), found.begin(), found.end());
  }
  return trees;
}

struct Table {
  std::vector<TableauRow> a;
  TableauRow b, b_velocity, c;
};

Table read(const NystromTableau& t) {
  Table table{{}, read_row(t.b, t.stages), read_row(t.b_velocity, t.stages), read_row(t.c, t.stages)};
  for (int i = 0; i < t.stages; ++i) table.a.push_back(read_row(t.a[static_cast<std::size_t>(i)], t.stages));
  return table;
}

// Kicks and drifts as a Nystrom table: kick j moves what follows, so a_ij = b'_j (c_i - c_j) and b_j = b'_j (1 - c_j).
Table read(const SymplecticNystromTable& t) {
  const TableauRow kicks = read_row(t.kicks), drifts = read_row(t.drifts);
  REQUIRE(kicks.size() == drifts.size() + 1);
  Table table{{}, {}, kicks, {Quad(0)}};
  for (const Quad drift : drifts) table.c.push_back(table.c.back() + drift);
  for (std::size_t i = 0; i < kicks.size(); ++i) {
    TableauRow row(kicks.size(), Quad(0));
    for (std::size_t j = 0; j < i; ++j) row[j] = kicks[j] * (table.c[i] - table.c[j]);
    table.a.push_back(row);
    table.b.push_back(kicks[i] * (1 - table.c[i]));
  }
  return table;
}

double residual(const TableauRow& b, const TableauRow& phi, Quad wanted) {
  Quad sum = -wanted;
  for (std::size_t i = 0; i < b.size(); ++i) sum += b[i] * phi[i];
  return std::fabs(static_cast<double>(sum));
}

// The largest residuals over the trees whose conditions order p asks for and order p - 1 does not.
struct Missed {
  double position = 0, velocity = 0;
};
std::vector<Missed> missed_by_order(const Table& t, const TableauRow& b, const TableauRow& b_velocity, int most) {
  std::vector<Missed> missed(static_cast<std::size_t>(most) + 2);
  const std::vector<NystromTree> trees = nystrom_trees(most);
  std::vector<TableauRow> a_phi;
  for (const NystromTree& tree : trees) {
    TableauRow phi(t.c.size(), Quad(1)), sums;
    for (std::size_t i = 0; i < phi.size(); ++i) {
      for (int m = 0; m < tree.c_factors; ++m) phi[i] *= t.c[i];
      for (const std::size_t k : tree.branches) phi[i] *= a_phi[k][i];
    }
    for (std::size_t i = 0; i < phi.size(); ++i) {
      Quad sum = 0;
      for (std::size_t j = 0; j < i; ++j) sum += t.a[i][j] * phi[j];
      sums.push_back(sum);
    }
    a_phi.push_back(sums);
    const auto r = static_cast<std::size_t>(tree.order);
    const Quad g = Quad(tree.g) * Quad(tree.order);
    missed[r].velocity = std::fmax(missed[r].velocity, residual(b_velocity, phi, 1 / g));
    missed[r + 1].position = std::fmax(missed[r + 1].position, residual(b, phi, 1 / (g * Quad(tree.order + 1))));
  }
  return missed;
}

// Entries of dprkn12 reach 50 and cancel to 0.1: quad's 2e-34 grows to this.
constexpr double met = 1e-29, not_met = 1e-9;

void check_order(const Table& t, const TableauRow& b, const TableauRow& b_velocity, int order) {
  const auto missed = missed_by_order(t, b, b_velocity, order + 1);
  for (std::size_t p = 1; p <= static_cast<std::size_t>(order); ++p) {
    INFO("order " << p);
    CHECK(missed[p].velocity < met);
    CHECK(missed[p].position < met);
  }
  const Missed& next = missed[static_cast<std::size_t>(order) + 1];
  CHECK(std::fmax(next.velocity, next.position) > not_met);
}

TEST_CASE("x'' = a(t, x) has 1, 1, 2, 3, 6, 10, 20 trees of order 1, 2, ...") {
  const int counts[] = {1, 1, 2, 3, 6, 10, 20};
  int found[7] = {};
  for (const NystromTree& tree : nystrom_trees(7)) ++found[tree.order - 1];
  for (int k = 0; k < 7; ++k) CHECK(found[k] == counts[k]);
}

TEST_CASE("Nystrom tables meet the order conditions of their orders, and no more") {
  for (const NystromTableau* tableau : {&dormand_prince_nystrom6, &dormand_prince_nystrom12}) {
    INFO("order " << tableau->order);
    const Table t = read(*tableau);
    check_order(t, t.b, t.b_velocity, tableau->order);
    check_order(t, read_row(tableau->embedded, tableau->stages), read_row(tableau->embedded_velocity, tableau->stages),
                tableau->embedded_order);
    // Row sums: the stages lie on the parabola x + c h v + (c h)^2 a / 2.
    for (std::size_t i = 0; i < t.c.size(); ++i) {
      Quad sum = -t.c[i] * t.c[i] / 2;
      for (const Quad a : t.a[i]) sum += a;
      CHECK(std::fabs(static_cast<double>(sum)) < 1e-31);
    }
  }
  const Table six = read(dormand_prince_nystrom6);
  for (std::size_t j = 0; j < 6; ++j) CHECK(six.a[5][j] == six.b[j]);  // first same as last
}

TEST_CASE("Blanes and Moan's methods are symmetric and meet the order conditions of their orders, and no more") {
  for (const SymplecticNystromTable* table : {&blanes_moan_nystrom4, &blanes_moan_nystrom6}) {
    INFO("order " << table->order);
    const Table t = read(*table);
    check_order(t, t.b, t.b_velocity, table->order);
    const TableauRow kicks = read_row(table->kicks), drifts = read_row(table->drifts);
    for (std::size_t i = 0; i < kicks.size(); ++i) CHECK(kicks[i] == kicks[kicks.size() - 1 - i]);
    for (std::size_t i = 0; i < drifts.size(); ++i) CHECK(drifts[i] == drifts[drifts.size() - 1 - i]);
  }
}

const std::vector<std::string> schemes{"dprkn6", "dprkn12", "blanes-moan-rkn4", "blanes-moan-rkn6"};

TEST_CASE("Nystrom methods refuse by name scenes that are not x'' = a(t, x)") {
  Scene lorenz = empty_scene();
  lorenz.problem = "lorenz";
  lorenz.bodies.push_back(point("lorenz", 1, {1, 0, 0}, {0, 0, 0}));
  const std::pair<Scene, std::string> refused[] = {{quadratic_drag(), "a force depends on velocity"},
                                                   {e_cross_b(), "a force depends on velocity"},
                                                   {free_box(), "a body rotates"},
                                                   {lorenz, "system of equations without bodies"}};
  for (const std::string& scheme : schemes)
    for (const auto& [scene, why] : refused) {
      const Recorded r = try_run(scheme, scene, {1, 8, 1});
      CHECK(r.outcome.status == Status::unsupported);
      CHECK_THAT(r.outcome.reason, Catch::Contains("atwood/" + scheme) && Catch::Contains(why));
    }
}

// Two runs under forces of time: a wrong node shows only here.
TEST_CASE("Nystrom methods' executed order under a force of time, in quad") {
  struct Rung {
    const char* scheme;
    double claimed;
    std::int64_t steps;
  };
  const BodySample truth = run("verner9", driven_oscillator(), {3, 4000, 1}, "quad").samples.at(1).bodies[0];
  for (const auto& [scheme, claimed, steps] : {Rung{"dprkn6", 6, 200}, Rung{"dprkn12", 12, 48},
                                               Rung{"blanes-moan-rkn4", 4, 200}, Rung{"blanes-moan-rkn6", 6, 100}}) {
    INFO(scheme);
    Wide error[2];
    for (int k = 0; k < 2; ++k)
      error[k] =
          distance(run(scheme, driven_oscillator(), {3, steps << k, 1}, "quad").samples.at(1).bodies[0].p_m, truth.p_m);
    CHECK(error[1] > 1e-28);
    CHECK(std::log2(static_cast<double>(error[0] / error[1])) == Approx(claimed).margin(0.15));
  }
}

TEST_CASE("a held body stays in place until its release, also where it has a velocity") {
  Scene scene = driven_oscillator();
  scene.bodies[0].velocity_m_per_s = {1, 2, 3};
  scene.bodies[0].release_s = 0.5;
  for (const std::string& scheme : schemes) {
    INFO(scheme);
    const Recorded r = run(scheme, scene, {1, 20, 4});
    CHECK(distance(r.samples.at(2).bodies[0].p_m, r.samples.at(0).bodies[0].p_m) == 0);
    CHECK(distance(r.samples.at(4).bodies[0].p_m, run("rk4", scene, {1, 4000, 4}).samples.at(4).bodies[0].p_m) < 1e-5);
  }
}

}  // namespace
}  // namespace atwood::testing
