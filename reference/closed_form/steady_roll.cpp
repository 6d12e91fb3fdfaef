// A coin (a cylinder, thick or thin) that rolls in a circle on its rim without slip, its lean and its rates steady:
// E. J. Routh, Advanced Rigid Dynamics (1905), art. 241 ff.; Euler's disc, whose centre stands still: H. K. Moffatt,
// Nature 404 (2000) 833. With z up, the axis a leaning from z by theta towards x, y = z x x, and d the unit vector in
// the disc that points down, d = cos x - sin z, the touch is at rho = R d - l a from the centre, and
//   w = W z + s a,   v = rho x w = -(W rho_x + s R) y = W c y        (c: the centre from the middle of its circle)
// About the centre, with friction -m W^2 c x and pressure m g z at the touch, L' = W z x L is
//   W sin (I_a (s + W cos) - I_t W cos) = m H W^2 c - m g rho_x,   H = R sin + l cos
// Doubles meet this to round-off, and the motion that they give nods about the steady one. In the frame d, y, a, which
// turns at f = theta' y - W sin d + W cos a, and where rho rests,
//   (I - m [rho]^2) w' = -f x I w + m rho x (f x (rho x w)) + m g rho x z
// (d x y = a). Nodding changes the lean by e, theta'' = A e + B (w_d, w_a), and (w_d, w_a)' = C theta': a steady roll
// is taken only where A + B C < 0, and what the doubles leave open, over that frequency and over the run, is in the
// bars.
#include <array>

#include "closed_form/floor.hpp"

namespace atwood::closed_form {

namespace {

// Of the radius and of the rates: doubles may miss a steady roll by so much; what misses it by more is another motion.
constexpr double kRoundOffShare = 0x1p-44;

template <class S> struct Roll {
  S m{}, g{}, R{}, l{}, I_a{}, I_t{};
  S lean{}, precession{}, spin{};  // theta, W, s
  Vec<S> up{}, from_middle{};      // of the circle to the centre, at the start
  S open_rad_per_s{};              // what the doubles leave open, as a rate
  S nod_rad_per_s{}, gain{};       // of nodding; what a lean of 1 makes of the rates, over it
};

// w' along d, y, a; w_y is theta'.
template <class S> Vec<S> change_of_rates(const Roll<S>& roll, S lean, const Vec<S>& w) {
  const S sine_ = sin(lean), cosine_ = cos(lean), W = -w[0] / sine_, m = roll.m;
  const Vec<S> f{w[0], w[1], W * cosine_}, rho{roll.R, 0, -roll.l}, z{-sine_, 0, cosine_};
  const Vec<S> momentum{roll.I_t * w[0], roll.I_t * w[1], roll.I_a * w[2]};
  const Vec<S> carried = cross(f, cross(rho, w)) + roll.g * z;
  const Vec<S> right = m * cross(rho, carried) - cross(f, momentum);
  // I - m [rho]^2 = I + m (rho^2 - rho rho^T): y apart, d and a together
  const S dd = roll.I_t + m * rho[2] * rho[2], aa = roll.I_a + m * rho[0] * rho[0], da = -m * rho[0] * rho[2];
  const S determinant = dd * aa - da * da;
  return {(aa * right[0] - da * right[2]) / determinant, right[1] / (roll.I_t + m * dot(rho, rho)),
          (dd * right[2] - da * right[0]) / determinant};
}

// A + B C by central differences; its root and the gain of the rates.
template <class S> std::string find_nodding(Roll<S>& roll, const Vec<S>& w) {
  const S rate = norm(w), width = S(0x1p-20), step = width * rate;
  const auto at = [&](S lean, S d, S y, S a) {
    return change_of_rates(roll, roll.lean + lean, Vec<S>{w[0] + d, y, w[2] + a});
  };
  // Rates of w_d and w_a are odd in theta' and proportional to it.
  const Vec<S> turned = at(0, 0, step, 0);
  const S C_d = turned[0] / step, C_a = turned[2] / step;
  const S lean_step = S(0x1p-20);
  const S A = (at(lean_step, 0, 0, 0)[1] - at(-lean_step, 0, 0, 0)[1]) / (2 * lean_step);
  const S B_d = (at(0, step, 0, 0)[1] - at(0, -step, 0, 0)[1]) / (2 * step);
  const S B_a = (at(0, 0, 0, step)[1] - at(0, 0, 0, -step)[1]) / (2 * step);
  const S square = -(A + B_d * C_d + B_a * C_a);
  if (!(square > S(1e-6) * (rate * rate + roll.g / roll.R))) return "the steady roll is not stable";
  roll.nod_rad_per_s = sqrt(square);
  // A lean off by e shifts W and s by their share of C e, and W = -w_d / sin itself.
  const S sine_ = sin(roll.lean);
  roll.gain = (magnitude(C_d) + magnitude(roll.precession)) / sine_ + magnitude(C_a) + rate;
  return "";
}

template <class S> std::string find_roll(const Scene& scene, int at, const Floor<S>& floor, Roll<S>& roll) {
  const Body& body = scene.bodies[at];
  const std::string name = "`" + body.name + "`";
  const auto* cylinder = std::get_if<Cylinder>(&body.shape);
  const Real33& I = body.inertia_kg_m2;
  if (cylinder == nullptr) return name + " is not a cylinder";
  if (!(I[0] > 0) || I[0] != I[4] || I[1] != 0 || I[2] != 0 || I[5] != 0)
    return name + " is not balanced about its axis";
  if (!is_zero(floor.g_t)) return "the floor is not orthogonal to gravity";
  roll.m = body.mass_kg;
  roll.g = floor.g_n;
  roll.R = cylinder->radius_m;
  roll.l = cylinder->half_length_m;
  roll.I_a = I[8];
  roll.I_t = I[0];
  const Pose<S> start = initial_pose<S>(body);
  const Vec<S> z = roll.up = floor.n, w = rotate(start.q_WB, start.w_WB_B);
  Vec<S> a = rotate(start.q_WB, Vec<S>{0, 0, 1});
  const S side = dot(z, a) < 0 ? -1 : 1;  // the upper end's way
  a = side * a;
  const S cosine_ = dot(z, a), sine_ = norm(cross(z, a));
  if (!(sine_ > S(0x1p-10)) || !(cosine_ > S(0x1p-30))) return name + " does not lean";
  const Vec<S> d = (-1 / sine_) * (z - cosine_ * a), y = cross(a, d);
  const Vec<S> rates{dot(w, d), dot(w, y), dot(w, a)}, rho = roll.R * d - roll.l * a;
  roll.lean = atan2(sine_, cosine_);
  roll.precession = -rates[0] / sine_;
  const S spin = rates[2] - roll.precession * cosine_, rate = norm(rates);
  roll.spin = side * spin;
  if (!(magnitude(roll.precession) > S(0x1p-30) * rate)) return name + " does not go round";
  roll.from_middle = (-1 / roll.precession) * cross(z, start.v_WB);
  const S scale = rate + sqrt(roll.g / roll.R);
  const S gap = dot(z, start.p_WB + rho) - floor.offset, slip = norm(start.v_WB + cross(w, rho));
  const std::string why = find_nodding(roll, rates);
  if (!why.empty()) return name + ": " + why;
  const S nods = change_of_rates(roll, roll.lean, rates)[1] / roll.nod_rad_per_s;
  const S misses = slip / roll.R + magnitude(rates[1]) + magnitude(nods) + roll.nod_rad_per_s * magnitude(gap) / roll.R;
  if (!(misses <= S(kRoundOffShare) * scale))
    return name + " does not roll steadily: off by " + format_double(static_cast<double>(misses / scale)) +
           " of its rates";
  roll.open_rad_per_s = misses;
  const S friction = roll.precession * roll.precession * norm(roll.from_middle) / roll.g;
  const PairLaw law = pair_law(scene, at, floor.body);
  if (!(friction < S(law.friction) * (1 - S(1e-6))))
    return name + " slips: friction is " + format_double(law.friction) + ", it takes " +
           format_double(static_cast<double>(friction));
  return "";
}

template <class S> Motion<S> solve_steady_roll(const Scenario& scenario, const std::vector<S>& t_s) {
  const Scene& scene = scenario.scene;
  Motion<S> motion;
  const Floor<S> floor = find_floor<S>(scene);
  motion.refusal = floor.refusal;
  int coin = -1;
  for (std::size_t i = 0; i < scene.bodies.size() && motion.refusal.empty(); ++i) {
    if (scene.bodies[i].fixed) continue;
    if (coin >= 0) motion.refusal = "two bodies move";
    coin = static_cast<int>(i);
  }
  if (motion.refusal.empty() && coin < 0) motion.refusal = "nothing moves";
  if (motion.refusal.empty() && !(floor.boundary.empty() && floor.unevenness == 0))
    motion.refusal = "the floor is not a plane";
  Roll<S> roll;
  if (motion.refusal.empty()) motion.refusal = find_roll(scene, coin, floor, roll);
  if (!motion.refusal.empty()) return motion;
  const Pose<S> start = initial_pose<S>(scene.bodies[coin]);
  const Vec<S> middle = start.p_WB - roll.from_middle;
  for (const S& t : t_s) {
    auto& poses = motion.poses.emplace_back();
    for (const Body& body : scene.bodies) poses.push_back(initial_pose<S>(body));
    const Quat<S> round = turn(roll.up, roll.precession * t), about = turn(Vec<S>{0, 0, 1}, roll.spin * t);
    Pose<S>& now = poses[coin];
    now.q_WB = round * start.q_WB * about;
    now.p_WB = middle + rotate(round, roll.from_middle);
    now.v_WB = rotate(round, start.v_WB);
    now.w_WB_B = rotate(conjugate(about), start.w_WB_B);
  }
  // Twice nodding's amplitude, and the rates that go with it, over the run.
  const S lean = 4 * (roll.open_rad_per_s / roll.nod_rad_per_s + S(floor.neglected) / roll.g);
  const S rate = 4 * roll.gain * lean + roll.open_rad_per_s;
  const S turned = lean + rate * S(scenario.t_end_s), size = roll.R + roll.l + norm(roll.from_middle);
  motion.input_round_off = {size * turned, turned, size * (rate + magnitude(roll.precession) * turned),
                            rate + norm(start.w_WB_B) * turned};
  return motion;
}

}  // namespace

Solution steady_roll() {
  return {"steady-roll",
          "a coin that rolls in a circle on its rim, its lean and its rates steady; Euler's disc: "
          "Routh, Advanced Rigid Dynamics (1905), art. 241 ff.",
          feature::uniform_gravity | feature::spin | feature::kSimpleContact, solve_steady_roll<Narrow>,
          solve_steady_roll<Wide>};
}

}  // namespace atwood::closed_form
