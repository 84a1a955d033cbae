// Random problems of any kind, hostile ones among them, for a number of seconds (the first argument): memory is exactly
// as long as the kernels ask for, rates stay finite and inside their bounds, and a batch answers as its rows do alone.
#include <cstdlib>
#include <ctime>

#include "fuzz.hpp"

using namespace stillreach;

template <class Text>
void check_scalars(const Answer& a, const Text& d) {
  expect(!std::isnan(a.task_error), "the task error is a number", d);
  expect(!std::isnan(a.damping), "the damping is a number", d);
  expect(a.damping >= 0.0, "the damping is at least 0", d);
  expect(a.scale >= 0.0 && a.scale <= 1.0, "the scale is between 0 and 1", d);
}

static void solve_case() {
  const int m = 1 + below(6), n = 1 + below(below(12) ? 12 : 60);
  Numbers J = numbers(m * n, true), lower(n), upper(n), rates(n, kNan), residual(m, kNan);
  if (below(3) == 0)  // columns that nearly repeat
    for (int i = 1 + below(3), c = i; i < n; ++i)
      for (int r = 0; r < m; ++r) J[i * m + r] = J[(i % c) * m + r] * (below(2) ? 1.0 : 1.0 + 1e-15 * below(10));
  const Numbers twist = numbers(m, true), reference = numbers(n, true);
  const bool has_reference = below(3) == 0;
  any_bounds(n, below(4) != 0, lower.data(), upper.data());
  const Weights weights(m, n);
  const LawSettings law = any_law();
  Codes active(n);
  for (auto& code : active) code = below(5) ? 0 : static_cast<std::int8_t>(below(4) - 1);
  Multiplier start{};
  const Numbers any = numbers(6 + kParts, false);
  for (int r = 0; r < 6; ++r) start.u[r] = any[r];
  for (int g = 0; g < kParts; ++g) start.kappa[g] = std::fabs(any[6 + g]);
  start.known = below(2);
  SolveMemory memory(n, !weights.joints.empty());
  Answer a{rates.data(), residual.data(), active.data(), 0, 0, 0, 1, 0, below(2) ? &start : nullptr};
  kernel().solve(law,
                 {m, n, J.data(), twist.data(), lower.data(), upper.data(), has_reference ? reference.data() : nullptr,
                  weights.view()},
                 memory.view(), a);
  if (!finite(J) || !finite(twist) || (has_reference && !finite(reference)) ||
      !leave_room(lower.data(), upper.data(), n))
    return;
  const auto d = [&] {
    return "solve: " + shown(law) + shown("rates", rates.data(), n) + shown("lower", lower.data(), n) +
           shown("upper", upper.data(), n) + shown("J", J.data(), m * n) + shown("twist", twist.data(), m);
  };
  expect(finite(rates), "rates are finite", d);
  for (int i = 0; i < n; ++i) {
    expect(lower[i] != upper[i] || rates[i] == lower[i], "a joint with one rate has it", d);
    const double low = law.kind == LawKind::PSEUDOINVERSE ? lower[i] - 1e-9 * std::fabs(lower[i]) : lower[i];
    const double high = law.kind == LawKind::PSEUDOINVERSE ? upper[i] + 1e-9 * std::fabs(upper[i]) : upper[i];
    expect((a.status & OVER_LIMIT) || (rates[i] >= low && rates[i] <= high), "rates are inside the bounds", d);
    expect(law.kind == LawKind::PSEUDOINVERSE || !(a.status & OVER_LIMIT), "only the pseudoinverse goes over limits",
           d);
    expect(active[i] >= -1 && active[i] <= 2, "codes of active bounds", d);
  }
  check_scalars(a, d);
}

// A controller of any settings.
struct AnyController {
  AnyArm arm;
  Weights weights;
  ControllerMemory core;
  const Settings& s = core.state.settings;
  const int n = core.n();
  AnyController(int joints, int task_rows) : arm(joints), weights(task_rows, joints), core(told(task_rows)) {
    core.workspace = SolveMemory(n, !weights.joints.empty());
    for (int i = 0; i < n; ++i) core.answer.rates[i] = kNan;
    const Numbers vector = numbers(n, false);
    for (int i = 0; i < n; ++i) at(s.null_vector, i) = vector[i];
    any_limits();
  }
  static double& at(const double* setting, int i) { return ControllerMemory::writable(setting)[i]; }
  Settings told(int m) const {
    Settings t{};
    t.arm = arm.view;
    t.law = any_law();
    t.metric = weights.view();
    t.m = m;
    t.tool_axes = below(2);
    t.every_row = m == 6 && !t.tool_axes;
    for (int r = 0; r < m; ++r) t.rows[r] = r + 6 - m;
    t.period = below(3) ? 0.01 : decade(-320, 308);
    t.return_rate = below(3) ? 0.0 : decade(-308, 308);
    t.transition_rate = below(3) ? 2.0 : decade(-308, 308);
    t.track_gain = below(4) ? 2.0 : decade(-308, 308);
    t.track_linear = below(2) ? kInfinity : decade(-308, 10);
    t.track_angular = below(2) ? kInfinity : below(2);
    t.null_kind = static_cast<NullMotionKind>(below(8));
    t.null_failures = 1 + below(8);
    t.null_gain = below(3) ? 1.0 : decade(-308, 308);
    t.null_largest = below(2) ? kInfinity : decade(-308, 308);
    return t;
  }
  void any_limits() {
    const double speed = decade(below(3) ? 0 : -320, below(3) ? 0 : 308),
                 room = decade(below(3) ? 0 : -320, below(3) ? 0 : 308);
    const double quickness = decade(below(3) ? 0 : -320, below(3) ? 0 : 308);
    const int rates = below(4), positions = below(4), accelerations = below(3);
    for (int i = 0; i < n; ++i) {
      at(s.rate_lower, i) = rates ? -between(0, 1) * speed : -kInfinity;
      at(s.rate_upper, i) = rates ? between(0, 1) * speed : kInfinity;
      if (below(8) == 0) at(s.rate_lower, i) = at(s.rate_upper, i) = 0.0;
      at(s.position_lower, i) = positions ? -between(0, 1) * room : -kInfinity;
      at(s.position_upper, i) = positions ? between(0, 1) * room : kInfinity;
      if (positions == 2) at(s.position_lower, i) = s.position_upper[i];
      at(s.acceleration, i) = accelerations ? between(0, 1) * quickness : kInfinity;
      if (below(12) == 0) at(s.acceleration, i) = 0.0;
    }
    core.limits_changed();
  }
  std::string shown_with(const Numbers& q, const Numbers& before) const {
    const RateBounds& bounds = core.state.now.bounds;
    return "tick: " + shown(s.law) + shown("period", &s.period, 1) + shown("rates", core.answer.rates, n) +
           shown("lower", bounds.lower, n) + shown("upper", bounds.upper, n) + shown("q", q.data(), n) +
           shown("before", before.data(), n) + shown("acceleration", s.acceleration, n);
  }
};

static void check_tick(const AnyController& c, const Numbers& q, const Numbers& before, bool right_input) {
  const Answer& a = c.core.answer;
  const Settings& s = c.s;
  const RateBounds& bounds = c.core.state.now.bounds;
  const auto d = [&] { return c.shown_with(q, before); };
  expect(finite(a.rates, c.n), "rates are finite", d);
  expect(right_input || (a.status & INVALID_INPUT), "input that is not finite is told", d);
  for (int i = 0; i < c.n; ++i) {
    const double rate = a.rates[i], period = s.period;
    const Fault& fault = c.core.state.faults.of[i];
    const bool stands = fault.health == Health::LOCKED || fault.health == Health::FREE_SWINGING;
    if (stands) expect(rate == 0.0, "a joint that is not commanded stands still", d);
    if (fault.health == Health::RUNAWAY) expect(rate == fault.number[0], "a runaway joint has its rate", d);
    if (stands || fault.health == Health::RUNAWAY || s.law.kind == LawKind::PSEUDOINVERSE) continue;
    const double left = fault.health == Health::DERATED ? fault.number[0] : 1.0;
    if (fault.health == Health::ONE_WAY)
      expect(rate * fault.number[0] >= 0.0, "a one-way joint keeps its direction", d);
    if (fault.health == Health::CONFINED && std::isfinite(q[i])) {
      const double slack = 1e-9 * (std::fabs(q[i]) + std::fabs(period * rate)) + 1e-300, next = q[i] + period * rate;
      expect(!(q[i] >= fault.number[1]) || rate <= 0.0, "a confined joint moves no further out", d);
      expect(!(q[i] <= fault.number[0]) || rate >= 0.0, "a confined joint moves no further out", d);
      expect(!(q[i] < fault.number[1] && std::isfinite(next)) || next <= fault.number[1] + slack,
             "a confined joint stays inside", d);
      expect(!(q[i] > fault.number[0] && std::isfinite(next)) || next >= fault.number[0] - slack,
             "a confined joint stays inside", d);
    }
    expect(left == 0.0 ? rate == 0.0 : rate >= s.rate_lower[i] * left && rate <= s.rate_upper[i] * left,
           "the rate limit is kept", d);
    expect(rate >= bounds.lower[i] && rate <= bounds.upper[i], "rates are inside the bounds", d);
    const double step = s.acceleration[i] * period;
    if (left != 0.0 && std::isfinite(step) && !(a.status & LIMIT_GIVEN_UP))
      expect(std::fabs(rate - before[i]) <= step * (1 + 2e-9) + 4e-16 * std::fabs(before[i]) + 1e-323,
             "the acceleration limit is kept, or given up", d);
    if (!(q[i] >= s.position_lower[i] && q[i] <= s.position_upper[i])) continue;
    const double next = q[i] + period * rate, slack = 1e-9 * (std::fabs(q[i]) + std::fabs(period * rate)) + 1e-300;
    expect(!std::isfinite(next) || (next <= s.position_upper[i] + slack && next >= s.position_lower[i] - slack),
           "the position limit is kept", d);
  }
  check_scalars(a, d);
}

static void any_target(const ControllerState& s, double* target) {
  double T[16] = {};
  AnyArm::rotation(true, T);
  for (int c = 0; c < 3; ++c)
    for (int r = 0; r < 3; ++r) target[3 * c + r] = T[4 * r + c];
  if (below(4) == 0)  // half a turn from where the tool is
    for (int k = 0, keep = below(3); k < 9; ++k) target[k] = s.now.pose[k] * (k / 3 == keep ? 1.0 : -1.0);
  for (int r = 0; r < 3; ++r) target[9 + r] = number(any_style(false));
  if (below(12) == 0) target[below(12)] = number(any_style(true));
}

static Fault any_fault() {
  const auto health = static_cast<Health>(below(7));
  switch (health) {
    case Health::HEALTHY:
    case Health::LOCKED:
    case Health::FREE_SWINGING: return {health, {}};
    case Health::DERATED: return {health, {between(0, 1) * below(4) / 3, 0.0}};
    case Health::RUNAWAY: return {health, {number(any_style(false)), 0.0}};
    case Health::CONFINED: {
      const double a = number(any_style(false)), b = number(any_style(false));
      return {health, {std::fmin(a, b), std::fmax(a, b)}};
    }
    case Health::ONE_WAY: return {health, {below(2) ? 1.0 : -1.0, 0.0}};
  }
  return {};
}

static void tick_case() {
  AnyController c(1 + below(below(10) ? 11 : 40), below(2) ? 6 : 1 + below(6));
  const int n = c.n;
  const double* const rates = c.core.answer.rates;
  Numbers q = below(3) ? rng.vector(n, 3.0) : numbers(n, true);
  for (int t = 0; t < 12; ++t) {
    if (below(3) == 0) c.core.set_fault(below(n), any_fault());
    if (below(8) == 0) {
      const int i = below(n);
      q[i] = below(2) ? c.s.position_upper[i] : c.s.position_lower[i];
    }
    if (below(10) == 0) q = numbers(n, true);
    const Numbers twist = numbers(6, true), before(c.core.state.last.rates, c.core.state.last.rates + n);
    double target[12];
    const bool track = below(3) == 0;
    if (track) any_target(c.core.state, target);
    c.core.tick(q.data(), twist.data(), track ? target : nullptr);
    check_tick(c, q, before, finite(q) && finite(twist) && (!track || finite(target, 12)));
    for (int i = 0; i < n; ++i)
      if (std::isfinite(q[i] + c.s.period * rates[i])) q[i] += c.s.period * rates[i];
  }
}

// A batch's inputs and the memory that they lie in.
struct AnyBatch {
  int n, count, m;
  bool with_arm = below(2), own_twists = below(2), own_bounds = below(2);
  AnyArm arm;
  Weights weights;
  Batch b{};
  Numbers q, J, twist, lower, upper, reference, last, position_lower, position_upper, acceleration;
  AnyBatch()
      : n(1 + below(below(10) ? 12 : 50)),
        count(1 + below(20)),
        m(below(3) ? (below(2) ? 6 : 3) : 1 + below(6)),
        arm(n),
        weights(m, n) {
    b.m = m;
    b.law = any_law();
    b.metric = weights.view();
    b.arm = arm.view;
    b.tool_axes = with_arm && below(4) == 0;
    b.every_row = with_arm && m == 6 && !b.tool_axes;
    for (int r = 0, first = below(7 - m); r < m; ++r) b.rows[r] = first + r;
    q = below(2) ? rng.vector(count * n, 3.0) : numbers(count * n, true);
    J = numbers(count * m * n, true);
    (with_arm ? b.q : b.jacobians) = with_arm ? q.data() : J.data();
    const int length = with_arm ? 6 : m;
    twist = numbers((own_twists ? count : 1) * length, own_twists);
    b.twist = twist.data();
    b.twist_stride = own_twists ? length : 0;
    lower.resize((own_bounds ? count : 1) * n);
    upper.resize(lower.size());
    for (std::size_t k = 0; k < lower.size(); k += n) any_bounds(n, !own_bounds || below(3), &lower[k], &upper[k]);
    b.lower = lower.data();
    b.upper = upper.data();
    b.bounds_stride = own_bounds ? n : 0;
    if (below(4) == 0) {
      reference = numbers(count * n, true);
      b.reference = reference.data();
      b.reference_stride = n;
    }
    if (with_arm && below(2)) any_limits();
  }
  void any_limits() {
    last = numbers(count * n, true);
    for (int i = 0; i < n; ++i) {
      position_lower.push_back(below(2) ? -kInfinity : -between(0, 2));
      position_upper.push_back(below(2) ? kInfinity : between(0, 2));
      acceleration.push_back(below(2) ? kInfinity : below(4) ? between(0, 5) : 0.0);
    }
    b.last = last.data();
    b.position_lower = position_lower.data();
    b.position_upper = position_upper.data();
    b.acceleration = acceleration.data();
    b.period = below(3) ? 0.01 : decade(-300, 300);
  }
  void check_row(int k, const double* rates, std::int32_t status) const {
    const double *low = &lower[k * b.bounds_stride], *high = &upper[k * b.bounds_stride];
    const auto d = [&] {
      return "batch: " + shown(b.law) + shown("rates", rates, n) + shown("lower", low, n) + shown("upper", high, n);
    };
    expect(finite(rates, n), "rates are finite", d);
    if ((status & INVALID_INPUT) || b.law.kind == LawKind::PSEUDOINVERSE) return;
    for (int i = 0; i < n; ++i) expect(rates[i] >= low[i] && rates[i] <= high[i], "rates are inside the bounds", d);
  }
};

// Memory of a batch: doubles on a 64-byte boundary, and not one more than asked for.
struct RowsMemory {
  double* doubles;
  std::vector<int> ints;
  Codes bytes;
  RowsMemory(int n, bool full) : ints(kernel().batch_ints(n), 1 << 30), bytes(kernel().batch_bytes(n), 99) {
    const std::size_t count = kernel().batch_doubles(n, full);
    doubles = static_cast<double*>(std::aligned_alloc(64, (count * sizeof(double) + 63) / 64 * 64));
    for (std::size_t k = 0; k < count; ++k) doubles[k] = kNan;
  }
  ~RowsMemory() { std::free(doubles); }
  Memory view() { return {doubles, ints.data(), bytes.data()}; }
};

static void batch_case() {
  AnyBatch any;
  const int n = any.n, count = any.count;
  Batch b = any.b;
  Numbers rates(count * n, kNan), alone(count * n, kNan), residual(count * any.m), error(count), pose(16 * count),
      jacobian(count * any.m * n);
  std::vector<std::int32_t> status(count, -5), status_alone(count, -5), iterations(count);
  Codes active(count * n);
  b.rates = rates.data();
  b.status = status.data();
  if (below(2)) {
    b.residual = residual.data();
    b.task_error = error.data();
    b.active = active.data();
    b.iterations = iterations.data();
    b.jacobian = jacobian.data();
  }
  if (any.with_arm && below(2)) b.pose = pose.data();
  RowsMemory memory(n, !any.weights.joints.empty());
  const int cut = below(2) ? count : below(count);
  kernel().batch(b, 0, cut, memory.view());
  if (cut < count) kernel().batch(b, cut, count, memory.view());
  b.rates = alone.data();
  b.status = status_alone.data();
  for (int k = 0; k < count; ++k) {
    kernel().batch(b, k, k + 1, memory.view());
    any.check_row(k, &rates[k * n], status[k]);
    bool same = status[k] == status_alone[k];
    for (int i = 0; i < n; ++i) same &= rates[k * n + i] == alone[k * n + i];
    expect(same, "a row of a batch is answered as alone",
           [&] { return shown(b.law) + shown("rates", &rates[k * n], n) + shown("alone", &alone[k * n], n); });
    if (b.task_error) expect(!std::isnan(error[k]), "the task error is a number", [&] { return shown(b.law); });
  }
}

static void rollout_case() {
  AnyBatch any;
  if (!any.with_arm) return;
  const int n = any.n, count = any.count, steps = 1 + below(4);
  BatchRollout r{};
  r.batch = any.b;
  r.start = any.q.data();
  r.twist = any.twist.data();
  r.twist_row = any.own_twists ? 6 : 0;
  r.last = any.last.empty() ? nullptr : any.last.data();
  r.steps = steps, r.every = 1, r.period = any.b.acceleration ? any.b.period : 0.01, r.runge_kutta = below(2),
  r.stop = [](void*) { return false; };
  Numbers rates(count * steps * n, kNan), doubles(kernel().rollout_doubles(n), kNan);
  std::vector<std::int32_t> status(count * steps, -5);
  r.rates = rates.data();
  r.status = status.data();
  RowsMemory memory(n, !any.weights.joints.empty());
  kernel().rollout_rows(r, 0, count, memory.view(), doubles.data());
  for (int k = 0; k < count; ++k)
    for (int t = 0; t < steps; ++t) any.check_row(k, &rates[(k * steps + t) * n], status[k * steps + t]);
}

int main(int argc, char** argv) {
  const char* full = std::getenv("STILLREACH_FULL");
  const double seconds = full && *full ? 60.0 : argc > 1 ? std::atof(argv[1]) : 5.0;
  if (argc > 2) rng = Random(std::strtoull(argv[2], nullptr, 10));
  const std::clock_t end = std::clock() + static_cast<std::clock_t>(seconds * CLOCKS_PER_SEC);
  long cases = 0;
  while (std::clock() < end && failures() < 20) {
    solve_case();
    solve_case();
    tick_case();
    batch_case();
    rollout_case();
    cases += 5;
  }
  std::fprintf(stderr, "%s, %ld cases\n", kernel().instruction_set, cases);
  return finish("test_fuzz");
}
