// What the target does: the plan of a scenario or a recording, or a motion of the page's own about a pose.
// fill(core, tick, ticks, stages, period) writes twists and targets (4 x 4, row by row) and returns the number of ticks
// that they are for. save() returns the state of a motion, which restore() takes back.

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

  save() {}

  restore() {}
}

// Offsets from the start as functions of an angle, x to the right and y up.
const SHAPES = {
  hold: () => [0, 0],
  line: (s, a) => [s * Math.sin(a), 0],
  circle: (s, a) => [s * Math.sin(a), s * (1 - Math.cos(a))],
  eight: (s, a) => [s * Math.sin(a), 0.5 * s * Math.sin(2 * a)],
};
export const OWN = Object.keys(SHAPES);

// Writes a target and the velocity of its point.
function write(core, k, pose, point, velocity) {
  core.targets.set(pose, 16 * k);
  for (let r = 0; r < 3; ++r) {
    core.targets[16 * k + 4 * r + 3] = point[r];
    core.twists[6 * k + r] = velocity[r];
    core.twists[6 * k + 3 + r] = 0;
  }
}

// A shape in a plane through a pose: right and up are unit vectors in base axes. Speed and size change within a second.
export class Shape {
  constructor(kind, pose, right, up, size, seconds) {
    Object.assign(this, { kind, right, up, size, seconds, closed: true, stages: 1, angle: 0, pace: 0, grown: size });
    this.pose = Float64Array.from(pose);
  }

  save() {
    return [this.angle, this.pace, this.grown];
  }

  restore([angle, pace, grown]) {
    Object.assign(this, { angle, pace, grown });
  }

  point() {
    const [x, y] = SHAPES[this.kind](this.grown, this.angle);
    return [0, 1, 2].map((r) => this.pose[4 * r + 3] + x * this.right[r] + y * this.up[r]);
  }

  fill(core, tick, ticks, stages, period) {
    for (let k = 0; k < ticks; ++k) {
      const here = this.point();
      this.pace += Math.min(1, 3 * period) * ((2 * Math.PI) / this.seconds - this.pace);
      this.grown += Math.min(1, 3 * period) * (this.size - this.grown);
      this.angle += this.pace * period;
      const next = this.point();
      write(core, k, this.pose, here, next.map((x, r) => (x - here[r]) / period));
    }
    return ticks;
  }
}

// A target that follows the pointer, at most at a speed [m/s].
export class Drag {
  constructor(pose, speed) {
    Object.assign(this, { pose: Float64Array.from(pose), speed, closed: true, stages: 1 });
    this.at = [3, 7, 11].map((k) => pose[k]);
    this.goal = this.at;
  }

  save() {
    return this.at;
  }

  restore(at) {
    this.at = at;
  }

  fill(core, tick, ticks, stages, period) {
    for (let k = 0; k < ticks; ++k) {
      const way = this.goal.map((x, r) => x - this.at[r]);
      const length = Math.hypot(...way);
      const share = length > 0 ? Math.min(1, (this.speed * period) / length, 8 * period) : 0;
      write(core, k, this.pose, this.at, way.map((x) => (share * x) / period));
      this.at = this.at.map((x, r) => x + share * way[r]);
    }
    return ticks;
  }
}
