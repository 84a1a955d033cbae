// The closed loop, tick by tick: commands from a motion, faults at their ticks, the controller and the plant in the core.

import { CHUNK, Core } from "./core.js";
import { Plan, Shape } from "./motions.js";

const NO_FAULT = { health: 0, first: 0, second: 0 };
const TRAIL_SECONDS = 0.02;

export class Simulation {
  // module: WebAssembly.Module. task: what Python wrote of a scenario (plan.py).
  constructor(module, task) {
    this.task = task;
    this.core = new Core(module);
    this.ghost = new Core(module);
    this.setup = Float64Array.from(task.setup);
    this.restart();
  }

  // From the beginning: of the plan where there is one, else at the start, holding it.
  restart() {
    const { task, core, ghost } = this;
    for (const one of [core, ghost]) {
      one.load(this.setup, task.plant);
      one.q.set(task.start);
      one.asked.set(task.asked);
      one.fullRates.set(task.fullRates);
    }
    this.tick = 0;
    this.place = 0; // in the plan [ticks]: behind `tick` where the motion waits for the arm
    this.changes = task.changes.slice();
    this.known = task.known.slice();
    this.truth = Array.from({ length: core.n }, () => NO_FAULT);
    this.trail = [];
    this.worst = [0, 0];
    this.case = null;
    this.delayed = task.hasPlant;
    this.motion = task.parts.length ? new Plan(task) : this.still(Float64Array.from(task.startPose));
    this.planned = task.parts.length > 0;
    this.changed();
  }

  // What there is to see is that of a tick which has not been made yet.
  changed() {
    this.moved = false;
    this.seen = null;
  }

  still(pose) {
    return new Shape("hold", pose, [0, 1, 0], [0, 0, 1], 0, 1);
  }

  // Goes on from another state: joints at q that moved at these rates, these faults, true and known.
  goOn(tick, q, rates, faults) {
    this.restart();
    this.tick = this.place = tick;
    for (const one of [this.core, this.ghost]) {
      one.q.set(q);
      one.last.set(rates);
    }
    this.changes = this.changes.filter((change) => change.tick > tick);
    this.known = this.known.filter((change) => change.tick > tick);
    faults.forEach((fault, joint) => {
      if (fault.health) this.set(joint, fault);
    });
  }

  set(joint, fault, known = true) {
    this.truth[joint] = fault;
    this.core.exports.fail(joint, 0, fault.health, fault.first, fault.second);
    if (known) this.core.exports.fail(joint, 1, fault.health, fault.first, fault.second);
  }

  // A joint fails now, or is whole again; the controller knows after so many ticks (Infinity: never).
  fail(joint, fault, ticks) {
    this.known = this.known.filter((change) => change.joint !== joint || !change.own); // those of the plan stay
    this.set(joint, fault, ticks === 0);
    this.changed();
    if (ticks === 0) return;
    this.delayed = true;
    if (ticks === Infinity) return;
    this.known.push({ tick: this.tick + ticks, joint, own: true, ...fault });
    this.known.sort((a, b) => a.tick - b.tick);
  }

  // Other settings from the next tick on.
  change(setup) {
    this.setup = Float64Array.from(setup);
    this.core.change(this.setup);
    this.ghost.change(this.setup);
    this.changed();
  }

  takeChanges() {
    while (this.known.length && this.known[0].tick <= this.tick) {
      const { joint, health, first, second } = this.known.shift();
      this.core.exports.fail(joint, 1, health, first, second);
    }
    while (this.changes.length && this.changes[0].tick <= this.tick) {
      const { joint, health, first, second } = this.changes.shift();
      this.truth[joint] = { health, first, second };
      this.core.exports.fail(joint, 0, health, first, second);
    }
  }

  // So many ticks. onChunk(core, ticks): sees every chunk's record.
  advance(ticks, onChunk) {
    const { core, ghost, task } = this;
    for (let left = ticks; left > 0; ) {
      this.takeChanges();
      let count = Math.min(left, CHUNK);
      for (const list of [this.changes, this.known])
        if (list.length) count = Math.min(count, list[0].tick - this.tick);
      const stages = this.planned ? task.stages : 1, waits = this.planned && task.waits;
      count = this.motion.fill(core, waits ? Math.round(this.place) : this.tick, waits ? 1 : count, stages, task.period);
      const noisy = this.planned && task.noise !== null && task.noise.length >= (this.tick + count) * core.n;
      if (noisy) core.noise.set(task.noise.subarray(this.tick * core.n, (this.tick + count) * core.n));
      ghost.twists.set(core.twists);
      ghost.targets.set(core.targets);
      const closed = this.motion.closed ? 1 : 0;
      core.exports.run(count, stages, 1, closed, this.delayed ? 1 : 0, noisy ? 1 : 0);
      ghost.exports.run(count, stages, 1, closed, 0, 0);
      core.exports.distances(count, stages, task.alongTool ? 1 : 0);
      this.row = count - 1;
      this.remember(count);
      if (onChunk) onChunk(core, count);
      this.tick += count;
      this.place += waits ? core["record.scale"][0] : count;
      left -= count;
      this.moved = true;
    }
  }

  remember(count) {
    const { core, task } = this;
    const every = Math.max(1, Math.round(TRAIL_SECONDS / task.period));
    for (let t = 0; t < count; ++t) {
      this.worst[0] = Math.max(this.worst[0], core.off[2 * t]);
      this.worst[1] = Math.max(this.worst[1], core.off[2 * t + 1]);
      const { case: played } = this, tick = this.tick + t;
      if (played && tick >= played.onset && tick <= task.steps)
        for (const k of [0, 1]) played.worst[k] = Math.max(played.worst[k], core.off[2 * t + k]);
      if ((this.tick + t) % every) continue;
      const at = 16 * t;
      if (this.trail.length > 6000) this.trail.splice(0, 3000);
      for (const from of [core["record.pose"], core.targets])
        this.trail.push(from[at + 3], from[at + 7], from[at + 11]);
    }
  }

  // What the last tick was like, and the positions after it; takes the trail and the worst errors since the last time.
  // Where something was changed since the last tick, it is what the next one will be like.
  snapshot() {
    if (this.moved) return this.take();
    if (this.seen) return { ...this.seen, trail: new Float32Array(0) };
    const { core, task } = this;
    const memory = new Uint8Array(core.exports.memory.buffer), before = memory.slice(), motion = this.motion.save();
    this.motion.fill(core, Math.round(this.place), 1, 1, task.period);
    core.exports.run(1, 1, 0, this.motion.closed ? 1 : 0, this.delayed ? 1 : 0, 0);
    core.exports.distances(1, 1, task.alongTool ? 1 : 0);
    this.row = 0;
    this.seen = this.take();
    memory.set(before);
    this.motion.restore(motion);
    return this.seen;
  }

  // Directions that the tool would not have here even with every joint whole: 6 numbers each.
  neverHad() {
    const { core, truth } = this, broken = truth.flatMap((fault, joint) => (fault.health ? [joint] : []));
    for (const joint of broken) core.exports.fail(joint, 0, 0, 0, 0);
    core.look();
    for (const joint of broken) core.exports.fail(joint, 0, truth[joint].health, truth[joint].first, truth[joint].second);
    return core.direction.slice(0, 6 * core.lost[0]);
  }

  // How fast the joints really move: as commanded, but where the controller does not know what a joint does.
  speeds(rates, health, known, before) {
    return rates.map((rate, i) => (health[i] === known[i] ? rate : (this.core.q[i] - before[i]) / this.task.period));
  }

  take() {
    const { core, ghost, task, row } = this;
    const { n } = core;
    const never = this.neverHad();
    core.look();
    const last = (name, size) => core[`record.${name}`].slice(row * size, row * size + size);
    const found = {
      tick: this.tick,
      time: this.tick * task.period,
      planned: this.planned,
      ended: this.planned && this.tick > task.steps,
      q: core.q.slice(),
      measured: last("measured", n),
      rates: last("rates", n),
      moving: this.speeds(last("rates", n), last("health", n), last("known", n), last("q", n)),
      lower: last("lower", n),
      upper: last("upper", n),
      health: last("health", n),
      known: last("known", n),
      active: last("active", n),
      pose: last("pose", 16),
      command: last("command", 6),
      residual: last("residual", 6),
      target: core.targets.slice(16 * row, 16 * row + 16),
      damping: core["record.damping"][row],
      scale: core["record.scale"][row],
      status: core["record.status"][row],
      taskError: core["record.task_error"][row],
      off: [core.off[2 * row], core.off[2 * row + 1]],
      worst: this.worst,
      case: this.case && { ...this.case, worst: this.case.worst.slice() },
      trail: Float32Array.from(this.trail),
      relative: core.relative.slice(),
      costs: core.costs.slice(),
      cost: core.cost.slice(),
      lost: core.lost[0],
      direction: core.direction.slice(0, 6 * core.lost[0]),
      never,
      sigma: core.sigma.slice(),
      axis: core.axis.slice(),
      ghost: ghost.q.slice(),
      memory: core.memory + ghost.memory,
      truth: this.truth.map((fault) => ({ ...fault })),
    };
    this.trail = [];
    this.worst = [core.off[2 * row], core.off[2 * row + 1]];
    return found;
  }
}
