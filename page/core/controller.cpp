// The controller as WebAssembly: one of them in a module's memory, which JavaScript reads and writes in place.
#include <cstdlib>

#include "stillreach/control/insight.hpp"
#include "stillreach/control/rollout.hpp"
#include "stillreach/control/setup.hpp"

using namespace stillreach;

#define EXPORT(name) extern "C" __attribute__((export_name(#name)))

constexpr int kChunk = 128;  // most ticks of a run, each with up to two commands, and one more

namespace {

struct Page {
  ControllerState state{};
  Coupling coupling{};
  Answer answer{};
  Insight insight{};
  Plant plant{};
  Record record{};
  Workspace workspace{};
  double *q, *twists, *targets, *frames, *noise, *stage, *off, *asked, *rates;
  std::int8_t* stage_active;
  void* memory = nullptr;
  double* given = nullptr;  // a setup, as JavaScript writes it
};
Page page;

// Cuts a block of memory into arrays; without one it counts how much they need.
struct Cut {
  char* next;
  std::size_t used = 0;
  template <class Value>
  Value* take(int count) {
    used = (used + 15) & ~std::size_t{15};
    Value* const here = reinterpret_cast<Value*>(next + used);
    used += sizeof(Value) * to_size(count);
    return here;
  }
};

void cut(Cut& from, const SetupHead& h, int dead) {
  Settings& s = page.state.settings;
  const int n = h.n;
  const bool full = h.full;
  s.arm.n = n;
  s.arm.links = from.take<Link>(h.moved);
  page.coupling = {h.moved, from.take<int>(h.moved), from.take<double>(h.moved), from.take<double>(h.moved)};
  s.arm.coupling = h.coupled ? &page.coupling : nullptr;
  s.m = h.m;
  const auto part = [&from](int has, int count) { return has ? from.take<double>(count) : nullptr; };
  s.metric = {part(h.has_rows, h.m * h.m), part(h.has_units, n), part(h.has_columns, n), part(full, n * n)};
  each_array(page.state, n, [&from](auto*& to, int count) {
    to = from.take<std::remove_pointer_t<std::remove_reference_t<decltype(to)>>>(count);
  });
  page.answer.rates = from.take<double>(n);
  page.answer.residual = from.take<double>(6);
  page.answer.active = from.take<std::int8_t>(n);
  double* const doubles = from.take<double>(static_cast<int>(workspace_doubles(n, full)));
  int* const ints = from.take<int>(static_cast<int>(workspace_ints(n)));
  page.workspace = make_workspace(n, full, doubles, ints, from.take<std::int8_t>(static_cast<int>(workspace_bytes(n))));
  page.insight.relative = from.take<double>(n);
  page.insight.costs = from.take<int>(n);
  page.insight.cost = from.take<double>(6 * n);
  page.plant = {from.take<Fault>(n), 1.0, from.take<double>(n), dead, from.take<double>(dead * n), 0, 0.0, nullptr,
                from.take<double>(n)};
  constexpr int commands = 2 * kChunk + 1;
  page.q = from.take<double>(n);
  page.rates = from.take<double>(n);
  page.twists = from.take<double>(6 * commands);
  page.targets = from.take<double>(16 * commands);
  page.frames = from.take<double>(12 * commands);
  page.noise = from.take<double>(kChunk * n);
  page.stage = from.take<double>(4 * n);
  page.stage_active = from.take<std::int8_t>(n);
  page.asked = from.take<double>(6);
  page.off = from.take<double>(2 * kChunk);
  each_array(page.record, n, [&from](auto*& to, const char*, int count) {
    to = from.take<std::remove_pointer_t<std::remove_reference_t<decltype(to)>>>(kChunk * count);
  });
}

}  // namespace

EXPORT(room) double* room(int count) {
  std::free(page.given);
  return page.given = static_cast<double*>(std::malloc(sizeof(double) * to_size(count)));
}

// A controller at rest, of a setup in room(); its joints are whole. dead: ticks until a rate arrives at the drives.
// Returns its number of joints, or 0 where there is no memory.
EXPORT(load) int load(double follow, int dead, double resolution) {
  const double* next = page.given;
  int sizes[kSetupHead];
  for (int& size : sizes) size = static_cast<int>(*next++);
  const SetupHead head{sizes[0], sizes[1], sizes[2], sizes[3], sizes[4], sizes[5], sizes[6], sizes[7]};
  Cut count{nullptr};
  cut(count, head, dead);
  std::free(page.memory);
  page.memory = std::calloc(1, count.used);
  if (!page.memory) return 0;
  Cut from{static_cast<char*>(page.memory)};
  page.state = ControllerState{};
  cut(from, head, dead);
  each_setting(page.state.settings,
               [&next](auto& value) { value = static_cast<std::remove_reference_t<decltype(value)>>(*next++); });
  page.plant.follow = follow;
  page.plant.resolution = resolution;
  for (int i = 0; i < head.n; ++i) page.state.faults.of[i] = const_cast<Fault*>(page.plant.faults)[i] = Fault{};
  return head.n;
}

// Other settings for the same arm, from room(): what happened, and what is broken, stays.
EXPORT(change) void change() {
  const double* next = page.given + kSetupHead;
  each_setting(page.state.settings,
               [&next](auto& value) { value = static_cast<std::remove_reference_t<decltype(value)>>(*next++); });
  ControllerState& c = page.state;
  c.last.multiplier.known = 0;
  c.last.bounds_stand = 0;
  for (int i = 0; i < c.settings.arm.n; ++i) c.last.closing[i] = CLOSING_RATE | CLOSING_POSITION;
  bound_correction(c.settings, c.faults, c.now.scratch);
}

// What is wrong with a joint: in truth, or as far as the controller knows.
EXPORT(fail) void fail(int joint, int known, int health, double first, double second) {
  const Fault fault{static_cast<Health>(health), {first, second}};
  if (known)
    set_fault(page.state, joint, fault);
  else
    const_cast<Fault*>(page.plant.faults)[joint] = fault;
}

// Ticks from q on, at most kChunk, into the record. stages: 1, or 2 for Runge-Kutta.
EXPORT(run) void run(int ticks, int stages, int advance, int closed, int plant, int noisy) {
  const int commands = stages == 2 && advance ? 2 * ticks + 1 : ticks;
  for (int k = 0; k < commands && closed; ++k) read_pose(page.targets + 16 * k, page.frames + 12 * k);
  page.plant.noise = noisy ? page.noise : nullptr;
  rollout(page.state, page.q, page.twists, closed ? page.frames : nullptr, ticks, stages, advance,
          plant ? &page.plant : nullptr, page.workspace, page.answer, page.stage, page.stage_active, page.record);
}

// How far the poses of the last ticks are from their targets, which are `stages` apart: distances and angles.
EXPORT(distances) void distances(int ticks, int stages, int along_pose) {
  for (int t = 0; t < ticks; ++t)
    pose_distances(page.record.pose + 16 * t, page.targets + 16 * stages * t, 1, page.asked, along_pose,
                   page.off + 2 * t);
}

// What the arm can do, as of the last tick: by its true faults, known or not. They are the plant's.
EXPORT(look) void look() {
  look_into(page.state.settings, {const_cast<Fault*>(page.plant.faults)}, page.state.now, page.rates, page.workspace,
            page.insight);
}

// Addresses of what JavaScript reads and writes, in the order of page/src/core.js: at the end the arrays of the record.
EXPORT(address) const void* address(int which) {
  const Settings& s = page.state.settings;
  const Insight& i = page.insight;
  const void* all[] = {
      page.q,       page.twists,   page.targets,         page.noise, page.asked, page.off, page.rates,  s.rate_lower,
      s.rate_upper, s.null_vector, page.state.faults.of, i.relative, i.costs,    i.cost,   i.direction, i.sigma,
      i.axis,       &i.lost,       page.state.last.rates};
  int left = which - static_cast<int>(sizeof(all) / sizeof(*all));
  const void* found = left < 0 ? all[which] : nullptr;
  each_array(page.record, s.arm.n, [&left, &found](auto* array, const char*, int) {
    if (left-- == 0) found = array;
  });
  return found;
}
