// What the target does: the plan of a scenario or a recording, or a motion of the page's own about a pose.
// fill(core, tick, ticks, stages, period) writes twists and targets (4 x 4, row by row) and returns how many ticks it
// has commands for.

// Rows of a plan, 3 x 4 each, as a scenario or a recording made them; after its end the target stands still.
export class Plan {
  constructor(plan) {
    this.parts = plan.parts;
    this.closed = plan.closed;
    this.last = plan.parts[plan.parts.length - 1];
    this.stages = plan.stages;
  }

  partAt(tick) {
    return this.parts.find((part) => part.first <= tick && tick < part.end) ?? this.last;
  }

  fill(core, tick, ticks, stages) {
    const part = this.partAt(tick);
    const after = tick >= this.last.first;
    const count = after ? ticks : Math.min(ticks, part.end - tick);
    const rows = stages === 2 ? 2 * count + 1 : count;
    for (let k = 0; k < rows; ++k) {
      const row = after ? 0 : stages * (tick - part.first) + k;
      core.twists.set(part.twists.subarray(6 * row, 6 * row + 6), 6 * k);
      core.targets.set(part.poses.subarray(12 * row, 12 * row + 12), 16 * k);
      core.targets.set([0, 0, 0, 1], 16 * k + 12);
    }
    return count;
  }
}

// Offsets from the centre as a function of an angle that grows with time; each begins at 0 and with a velocity along
// the plane of the screen, x to the right.
const SHAPES = {
  hold: () => [0, 0],
  line: (s, a) => [s * Math.sin(a), 0],
  circle: (s, a) => [s * Math.sin(a), s * (1 - Math.cos(a))],
  eight: (s, a) => [s * Math.sin(a), 0.5 * s * Math.sin(2 * a)],
};
export const OWN = Object.keys(SHAPES);

// A shape in a plane through a pose: right and up are unit vectors in base axes.
export class Shape {
  constructor(kind, pose, right, up, size, seconds, firstTick) {
    Object.assign(this, { kind, pose: Float64Array.from(pose), right, up, size, seconds, firstTick, closed: true });
    this.stages = 1;
  }

  point(tick, period) {
    const time = (tick - this.firstTick) * period;
    const eased = time < 1 ? 0.5 * time * time : time - 0.5; // sets off within a second
    const [x, y] = SHAPES[this.kind](this.size, (2 * Math.PI * eased) / this.seconds);
    return [0, 1, 2].map((r) => this.pose[4 * r + 3] + x * this.right[r] + y * this.up[r]);
  }

  fill(core, tick, ticks, stages, period) {
    let here = this.point(tick, period);
    for (let k = 0; k < ticks; ++k) {
      const next = this.point(tick + k + 1, period);
      for (let r = 0; r < 3; ++r) {
        core.twists[6 * k + r] = (next[r] - here[r]) / period;
        core.twists[6 * k + 3 + r] = 0;
      }
      core.targets.set(this.pose, 16 * k);
      for (let r = 0; r < 3; ++r) core.targets[16 * k + 4 * r + 3] = here[r];
      here = next;
    }
    return ticks;
  }
}

// A target that follows the pointer, at most at a speed [m/s].
export class Drag {
  constructor(pose, speed) {
    Object.assign(this, { pose: Float64Array.from(pose), speed, closed: true, stages: 1 });
    this.goal = [3, 7, 11].map((k) => pose[k]);
  }

  fill(core, tick, ticks, stages, period) {
    for (let k = 0; k < ticks; ++k) {
      core.targets.set(this.pose, 16 * k);
      const way = this.goal.map((x, r) => x - this.pose[4 * r + 3]);
      const length = Math.hypot(...way);
      const share = length > 0 ? Math.min(1, (this.speed * period) / length, 8 * period) : 0;
      for (let r = 0; r < 3; ++r) {
        core.twists[6 * k + r] = (share * way[r]) / period;
        core.twists[6 * k + 3 + r] = 0;
        this.pose[4 * r + 3] += share * way[r];
      }
    }
    return ticks;
  }
}
