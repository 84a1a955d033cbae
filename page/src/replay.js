// Runs as the page draws them: where one is at a time, and what the plots show of them all.

import { Simulation } from "./simulation.js";

const WHOLE = { health: 0, first: 0, second: 0 };

export class Replay {
  // tasks: of the runs, by their `task`.
  constructor(runs, tasks, module) {
    Object.assign(this, { runs, tasks, module, chosen: 0, time: 0, drawn: 0, of: null, lookers: [] });
  }

  get run() {
    return this.runs[this.chosen];
  }

  get task() {
    return this.tasks[this.run.task];
  }

  // [s]
  get end() {
    return this.run.end * this.task.period;
  }

  // Row and fraction to the next one, of a run at a time [s].
  rowAt(run, time) {
    const tick = time / this.tasks[run.task].period;
    let low = 0, high = run.tick.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (run.tick[middle] <= tick + 1e-6) low = middle;
      else high = middle - 1;
    }
    const next = Math.min(low + 1, run.tick.length - 1), span = run.tick[next] - run.tick[low];
    return [low, next, span ? Math.min((tick - run.tick[low]) / span, 1) : 0];
  }

  positions(run, time) {
    const n = this.task.arm.joints.length, [low, next, share] = this.rowAt(run, time);
    return Float64Array.from({ length: n }, (_, i) => run.q[low * n + i] * (1 - share) + run.q[next * n + i] * share);
  }

  // The moment as a snapshot has it; fresh: the paths are to be drawn from their beginning.
  moment() {
    const { run, task, time } = this, n = task.arm.joints.length;
    const [low, next, share] = this.rowAt(run, time);
    const rows = (array) => array.slice(low * n, low * n + n);
    const target = Float64Array.from([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    for (let r = 0; r < 3; ++r) target[4 * r + 3] = run.target[3 * low + r] * (1 - share) + run.target[3 * next + r] * share;
    const found = {
      tick: Math.round(time / task.period),
      time,
      q: this.positions(run, time),
      rates: rows(run.rates),
      moving: this.speeds(run, low),
      health: rows(run.health),
      known: rows(run.known),
      target,
      off: Array.from(run.off.slice(2 * low, 2 * low + 2)),
      status: run.status[low],
      replay: true,
    };
    found.truth = this.faultsAt(found);
    const other = this.runs.find((one) => one !== run);
    found.ghost = other && this.positions(other, time);
    Object.assign(found, this.insight(found));
    const fresh = this.of !== run || low < this.drawn - 1;
    if (fresh) this.drawn = 0;
    this.of = run;
    const trail = [];
    for (; this.drawn <= low; ++this.drawn)
      for (const path of [run.tool, run.target]) trail.push(...path.slice(3 * this.drawn, 3 * this.drawn + 3));
    found.trail = Float32Array.from(trail);
    return { found, fresh };
  }

  // Rates at a row of a run; the real ones, from positions, where the controller did not know what a joint did.
  speeds(run, row) {
    const n = this.task.arm.joints.length, { period } = this.task;
    const next = Math.min(row + 1, run.tick.length - 1), passed = (run.tick[next] - run.tick[row]) * period || Infinity;
    return Float64Array.from({ length: n }, (_, i) => {
      const at = row * n + i;
      return run.health[at] === run.known[at] ? run.rates[at] : (run.q[next * n + i] - run.q[at]) / passed;
    });
  }

  // What the arm can do there, from the core.
  insight({ tick, q, rates, truth }) {
    const at = this.run.task;
    this.lookers[at] ??= new Simulation(this.module, this.task);
    const looker = this.lookers[at];
    looker.goOn(tick, q, rates, truth);
    const { relative, costs, cost, lost, direction, never, sigma, axis } = looker.snapshot();
    return { relative, costs, cost, lost, direction, never, sigma, axis };
  }

  // The faults at a moment with their numbers, by joint.
  faultsAt({ tick, health }) {
    return Array.from(health, (state, joint) => {
      if (!state) return WHOLE;
      const spans = this.run.faults.filter((fault) => fault.joint === joint && fault.health === state && fault.begin <= tick && tick < fault.end);
      const last = spans.sort((a, b) => a.begin - b.begin).pop();
      return last ? { health: state, first: last.first, second: last.second } : { ...WHOLE, health: state };
    });
  }

  // [times, errors of each run [mm]] of all runs.
  errors() {
    const at = (run, k) => run.tick[k] * this.tasks[run.task].period;
    const times = [...new Set(this.runs.flatMap((run) => Array.from(run.tick, (_, k) => at(run, k))))].sort((a, b) => a - b);
    const lines = this.runs.map((run) => {
      let k = 0;
      const last = run.tick.length - 1;
      return times.map((time) => {
        while (k < last && at(run, k + 1) <= time) ++k;
        return time > at(run, last) ? null : 1000 * run.off[2 * k];
      });
    });
    return [times, ...lines];
  }

  // [times, shares of their limits [%] of each joint] of the run that is shown.
  shares() {
    const { run, task } = this;
    const share = (limit, rate) => (limit ? (100 * Math.abs(rate)) / limit : 0);
    const speeds = Array.from(run.tick, (_, k) => this.speeds(run, k));
    return [Array.from(run.tick, (t) => t * task.period), ...task.limits.map((limit, i) => speeds.map((row) => share(limit, row[i])))];
  }
}
