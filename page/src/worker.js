// The worker: runs the closed loop at its own period, and tells the page what happened whenever that asks for a frame.

import { Drag, Plan, Shape } from "./motions.js";
import { Simulation } from "./simulation.js";

const SLICE = 8; // [ms] at most computed at a time, so that messages are heard
const REST = 2; // [ms] between slices
const BEHIND = 0.1; // [s] that the loop catches up at most, after the computer was busy elsewhere

let simulation = null;
let running = false;
let speed = 1;
let owed = 0; // ticks to be made
let before = 0;
let until = Infinity; // tick at which the loop pauses
let slices = 0;

function loop() {
  const now = performance.now();
  if (running) {
    const { period } = simulation.task;
    const share = Math.min((now - before) / 1000, BEHIND) * speed;
    owed = Math.min(owed + share / period, (BEHIND * speed) / period + 1);
    while (owed >= 1 && performance.now() - now < SLICE && simulation.tick < until) {
      const ticks = Math.min(Math.floor(owed), 256, until - simulation.tick);
      simulation.advance(ticks);
      owed -= ticks;
      ++slices;
    }
    if (simulation.tick >= until) running = false;
  } else owed = 0;
  before = now;
  setTimeout(loop, REST);
}

const commands = {
  begin({ module, task, run }) {
    simulation = new Simulation(module, task);
    running = run;
    before = performance.now();
    loop();
  },
  run({ value }) {
    running = value;
    until = Infinity;
  },
  step({ ticks }) {
    running = false;
    simulation.advance(ticks);
  },
  speed({ value }) {
    speed = value;
  },
  restart() {
    simulation.restart();
    until = Infinity;
  },
  fail({ joint, fault, ticks }) {
    simulation.fail(joint, fault, ticks);
  },
  change({ setup }) {
    simulation.change(setup);
  },
  goOn({ tick, q, rates, faults }) {
    simulation.goOn(tick, q, rates, faults);
  },
  // From the beginning with these faults instead of the scenario's own, up to a tick at once.
  play({ changes, known, to, delayed, onset, id }) {
    simulation.restart();
    simulation.case = { id, onset, worst: [0, 0] };
    simulation.changes = changes.slice();
    simulation.known = known.slice();
    simulation.delayed = delayed;
    simulation.advance(to);
    simulation.trail = [];
    until = Infinity;
  },
  // The plan, or a motion of the page's own about the tool's pose.
  motion({ kind, right, up, size, seconds }) {
    const { task } = simulation;
    const pose = Float64Array.from(simulation.snapshot().pose);
    simulation.planned = kind === "plan";
    simulation.motion =
      kind === "plan" ? new Plan(task) : kind === "drag" ? new Drag(pose, size) : new Shape(kind, pose, right, up, size, seconds, simulation.tick);
    if (kind === "plan") simulation.restart();
    simulation.changed();
  },
  goal({ point }) {
    if (simulation.motion instanceof Drag) simulation.motion.goal = point;
  },
  frame() {
    const found = { ...simulation.snapshot(), running, speed, slices };
    postMessage(found);
  },
};

onmessage = ({ data }) => commands[data.do](data);
