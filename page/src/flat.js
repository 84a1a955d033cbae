// The same without WebGL: lines and circles on a canvas, turned by dragging.

import { stations } from "./kinematics.js";
import { thickness } from "./scene.js";

export class Flat {
  constructor(canvas, arm, q) {
    Object.assign(this, { canvas, arm, pen: canvas.getContext("2d"), turns: true, trail: [], zoom: 1 });
    const { points } = stations(arm, q);
    this.size = Math.max(thickness(points) / 0.016, 0.2);
    this.middle = [0, 1, 2].map((r) => (Math.min(...points.map((p) => p[r])) + Math.max(...points.map((p) => p[r]))) / 2);
    this.view();
    canvas.addEventListener("pointermove", (event) => {
      if (!this.turns || !(event.buttons & 1)) return;
      this.azimuth -= 0.01 * event.movementX;
      this.elevation = Math.max(-1.5, Math.min(1.5, this.elevation + 0.01 * event.movementY));
    });
    canvas.addEventListener("wheel", (event) => {
      this.zoom *= Math.exp(-0.001 * event.deltaY);
      event.preventDefault();
    });
  }

  view() {
    Object.assign(this, { azimuth: -0.82, elevation: 0.38, zoom: 1 });
  }

  theme(colours) {
    this.colours = colours;
  }

  resize(width, height, ratio) {
    this.canvas.width = width * ratio;
    this.canvas.height = height * ratio;
    this.ratio = ratio;
  }

  plane() {
    const a = this.azimuth, e = this.elevation;
    return [
      [-Math.sin(a), Math.cos(a), 0],
      [-Math.sin(e) * Math.cos(a), -Math.sin(e) * Math.sin(a), Math.cos(e)],
    ];
  }

  scale() {
    return (0.75 * this.zoom * Math.min(this.canvas.clientWidth, this.canvas.clientHeight)) / this.size;
  }

  project(point) {
    const along = this.plane().map((axis) => axis.reduce((sum, x, r) => sum + x * (point[r] - this.middle[r]), 0));
    const { clientWidth, clientHeight } = this.canvas;
    return [clientWidth / 2 + this.scale() * along[0], clientHeight / 2 - this.scale() * along[1], true];
  }

  line(points, colour, width) {
    const { pen } = this;
    pen.beginPath();
    for (const point of points) pen.lineTo(...this.project(point).slice(0, 2));
    pen.strokeStyle = colour;
    pen.lineWidth = width;
    pen.lineJoin = pen.lineCap = "round";
    pen.stroke();
  }

  dot(point, radius, colour, corners) {
    const { pen } = this, [x, y] = this.project(point);
    pen.beginPath();
    if (corners) for (let k = 0; k < corners; ++k) pen.lineTo(x + radius * Math.sin((2 * Math.PI * k) / corners), y - radius * Math.cos((2 * Math.PI * k) / corners));
    else pen.arc(x, y, radius, 0, 2 * Math.PI);
    pen.fillStyle = colour;
    pen.fill();
  }

  draw(found, shown) {
    const { pen, colours, canvas } = this;
    pen.setTransform(this.ratio, 0, 0, this.ratio, 0, 0);
    pen.fillStyle = colours.paper;
    pen.fillRect(0, 0, canvas.clientWidth, canvas.clientHeight);
    const span = 1.5 * this.size;
    for (let k = -6; k <= 6; ++k)
      for (const ends of [[[(k * span) / 6, -span, 0], [(k * span) / 6, span, 0]], [[-span, (k * span) / 6, 0], [span, (k * span) / 6, 0]]])
        this.line(ends, colours.grid, 1);
    for (let k = 0; k + 5 < (found.trail?.length ?? 0); k += 6) this.trail.push(Array.from(found.trail.subarray(k, k + 6)));
    if (this.trail.length > 3000) this.trail.splice(0, 1500);
    if (shown.trail) {
      this.line(this.trail.map((p) => p.slice(3)), colours.target, 1.5);
      this.line(this.trail.map((p) => p.slice(0, 3)), colours.actual, 1.5);
    }
    const width = Math.max(3, 0.03 * this.size * this.scale());
    if (shown.ghost && found.ghost) this.line(stations(this.arm, found.ghost).points, colours.ghost, 0.7 * width);
    const { points, axes } = stations(this.arm, found.q);
    const reach = 2.2 * thickness(points);
    this.points = points;
    this.drums = axes.map((axis, k) => [-1, 1].map((sign) => points[k + 1].map((x, r) => x + sign * reach * axis[r])));
    this.line(points, colours.link, width);
    this.arm.chain.forEach((link, k) => {
      const state = found.health[link.joint], colour = state ? colours.health[state] : colours.joint;
      this.line(this.drums[k], colour, 1.2 * width);
      if (state) this.dot(points[k + 1], 1.1 * width, colour, 5);
    });
    const { target } = found;
    this.dot([target[3], target[7], target[11]], 0.6 * width, colours.target, 0);
  }

  clear() {
    this.trail = [];
  }

  station(link) {
    return this.points[link + 1];
  }

  handles(joint) {
    return this.arm.chain.flatMap((link, k) => (link.joint === joint ? [...this.drums[k], this.points[k + 1]] : []));
  }

  // The joint whose drum is nearest to a pixel, or -1.
  pick(x, y) {
    let best = 14, found = -1;
    this.arm.chain.forEach((link, k) => {
      const [a, b] = this.drums[k].map((end) => this.project(end));
      const u = [b[0] - a[0], b[1] - a[1]], length = u[0] * u[0] + u[1] * u[1];
      const share = length ? Math.max(0, Math.min(1, ((x - a[0]) * u[0] + (y - a[1]) * u[1]) / length)) : 0;
      const away = Math.hypot(a[0] + share * u[0] - x, a[1] + share * u[1] - y);
      if (away < best) [best, found] = [away, link.joint];
    });
    return found;
  }

  under(x, y, through) {
    const [u, v] = this.project(through), [right, up] = this.plane();
    return through.map((value, r) => value + ((x - u) * right[r] - (y - v) * up[r]) / this.scale());
  }

  orbit(on) {
    this.turns = on;
  }
}
