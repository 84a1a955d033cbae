// The viewer: what the reader sees and does. The controller runs in a worker; runs are replayed here.

import { Flat } from "./flat.js";
import { make } from "./layout.js";
import * as panels from "./panels.js";
import { Plot } from "./plots.js";
import { Replay } from "./replay.js";
import { Solid } from "./scene.js";
import { angleOf, flags, lengthOf, missing, number, status, valueOf } from "./words.js";

const AFTER = 1; // [s] that a task goes on after its end before it is paused
const HELD = 4000; // [ms] for which a message stays
const EVERY = 6; // frames between two plots
const TOLD = 100; // [ms] between two texts
const STATE_SIGN = ["●", "■", "◐", "▲", "◇", "▶", "○", "✚"]; // by health, one to spare: shape as well as colour
const SPEEDS = "half axes of the ellipsoid of the tool's speeds, for joint rates of norm 1 in units of their limits";
const WHOLE = { health: 0, first: 0, second: 0 };

const THEMES = {
  light: { paper: "#f7f9fb", ink: "#1d2430", soft: "#5b6675", grid: "#d5dbe2", link: "#c9d1da", ghost: "#7f93ab", joint: "#66788c", target: "#2f74c0", actual: "#c8501e", bad: "#b3261e" },
  dark: { paper: "#12161c", ink: "#e6eaf0", soft: "#9aa6b5", grid: "#2a323d", link: "#aab5c2", ghost: "#8fa6c2", joint: "#71839a", target: "#5aa0ea", actual: "#f0863c", bad: "#ff7b6e" },
};
const HEALTH_COLOURS = ["#66788c", "#d0342c", "#e09a2a", "#b455b8", "#b58a4a", "#d9689c", "#6f62c4", "#7d7d3a"];
const LINE_COLOURS = ["#2f74c0", "#c8501e", "#2f8d4f", "#9a4f9f", "#a3891f", "#4aa3a8", "#d0342c", "#7a6bc0"];

export class Viewer {
  constructor(box, data, module) {
    const shown = { ghost: true, ellipsoid: false, trail: true, lost: true, names: true };
    Object.assign(this, { box, data, module, shown, task: data.tasks[0], frames: 0, kind: 0, delay: 0, playing: false, pace: 1, heldUntil: 0 });
    this.n = this.task.arm.joints.length;
    this.mode = data.runs.length ? "replay" : "live";
    this.replay = data.runs.length ? new Replay(data.runs, data.tasks, module) : null;
    this.worker = new Worker(URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" })));
    this.worker.onmessage = ({ data: found }) => this.arrive(found);
    this.worker.onerror = (event) => this.hold(`The controller stopped: ${event.message}`);
    this.waiting = false;
    this.build();
    this.begin();
    this.animate = this.animate.bind(this);
    if (this.replay) this.chooseRun(0);
    else {
      this.run(true);
      if (!this.task.parts.length) this.setMotion("circle");
    }
    requestAnimationFrame(this.animate);
  }

  send(what, more = {}) {
    this.worker.postMessage({ do: what, ...more });
  }

  begin() {
    this.send("begin", { module: this.module, task: this.task });
  }

  // ---------------------------------------------------------------- the page

  build() {
    const { task } = this;
    this.canvas = make("canvas", { tabIndex: 0, ariaLabel: `${task.arm.name}: the arm. Choose a joint to break it.`, className: "scene" });
    this.tags = make("div", { className: "tags", ariaHidden: "true" });
    this.sentence = make("p", { className: "status", role: "status", ariaLive: "polite" });
    this.heading = make("h1", {}, task.title);
    this.rows = task.arm.joints.map((joint, i) => panels.jointRow(this, joint, i));
    this.facts = make("dl", { className: "facts" });
    this.looks = panels.looks(this);
    const stage = make("div", { className: "stage" }, this.canvas, this.tags, this.looks);
    this.plotBoxes = [make("div", { className: "plot" }), make("div", { className: "plot" })];
    const left = make("div", { className: "left" }, stage, panels.transport(this), make("div", { className: "plots" }, ...this.plotBoxes));
    this.settingsBox = make("div", {}, panels.motion(this), panels.control(this));
    const now = make("section", { className: "now" }, make("h2", {}, "Now"), this.facts);
    const right = make("aside", { className: "panel" }, panels.breaking(this), this.settingsBox, now, panels.notes(this));
    this.box.append(make("header", {}, this.heading, this.sentence), make("main", {}, left, right));
    this.startScene();
    this.follow();
    const hears = document.body.classList.contains("app") ? window : this.box; // a page around it keeps its own keys
    hears.addEventListener("keydown", (event) => this.key(event));
    this.freeKeys();
    new ResizeObserver(() => this.resize()).observe(stage);
    new ResizeObserver(() => this.plots?.forEach((plot) => plot.size())).observe(this.plotBoxes[0]);
    this.resize();
    this.makePlots();
  }

  startScene() {
    try {
      if (new URLSearchParams(location.search).has("flat")) throw new Error("asked for");
      this.scene = new Solid(this.canvas, this.task.arm, Array.from(this.task.start));
    } catch {
      const fresh = this.canvas.cloneNode();
      this.canvas.replaceWith(fresh);
      this.canvas = fresh;
      this.scene = new Flat(fresh, this.task.arm, Array.from(this.task.start));
      this.notesBox.append(make("p", {}, "WebGL is missing here; the arm is drawn flat."));
    }
    this.canvas.addEventListener("pointerdown", (event) => this.press(event));
    this.canvas.addEventListener("pointermove", (event) => this.drag(event));
    this.canvas.addEventListener("pointerup", (event) => this.release(event));
    this.canvas.addEventListener("pointercancel", (event) => this.release(event));
  }

  // What was used by a pointer does not keep the keyboard, so that the space bar goes on pausing.
  freeKeys() {
    let byPointer = false;
    const free = () => byPointer && document.activeElement?.matches("#viewer button, #viewer input, #viewer select") && document.activeElement.blur();
    this.box.addEventListener("pointerdown", () => (byPointer = true), true);
    window.addEventListener("keydown", () => (byPointer = false), true);
    for (const what of ["click", "change"]) this.box.addEventListener(what, (event) => event.target.matches("select") && what === "click" ? undefined : free());
  }

  // Light or dark, as the reader's system has it.
  follow() {
    const dark = matchMedia("(prefers-color-scheme: dark)");
    const take = () => {
      this.colours = { ...THEMES[dark.matches ? "dark" : "light"], health: HEALTH_COLOURS };
      this.scene.theme(this.colours);
      this.plots?.forEach((plot) => plot.draw(this.colours));
    };
    dark.addEventListener("change", take);
    take();
  }

  makePlots() {
    const { colours, data, task } = this, replay = this.mode === "replay";
    const runs = data.runs.map((run, k) => [short(run.label), LINE_COLOURS[k % LINE_COLOURS.length], k ? [6, 3] : undefined]);
    const joints = task.arm.joints.map((joint, i) => [short(joint.name, 12), LINE_COLOURS[i % LINE_COLOURS.length]]);
    this.rows.forEach((row, i) => (row.rate.style.background = joints[i][1]));
    this.plots?.forEach((plot) => plot.plot.destroy());
    this.plots = [
      new Plot(this.plotBoxes[0], "tool from its target", "mm", replay ? runs : [["distance", LINE_COLOURS[0]]], colours, 0.1),
      new Plot(this.plotBoxes[1], "rates, as a share of their limits", "%", joints, colours, 100),
    ];
    if (!replay) return;
    this.plots[0].whole(this.replay.errors());
    this.plots[1].whole(this.replay.shares());
  }

  say(text) {
    if (performance.now() > this.heldUntil && this.sentence.textContent !== text) this.sentence.textContent = text;
  }

  // A message that stays for a while.
  hold(text) {
    this.heldUntil = 0;
    this.say(text);
    this.heldUntil = performance.now() + HELD;
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (!clientWidth || !clientHeight) return;
    this.scene.resize(clientWidth, clientHeight, devicePixelRatio || 1);
    if (this.latest?.signs) this.scene.draw({ ...this.latest, trail: new Float32Array(0) }, this.shown); // it was cleared
  }

  // ---------------------------------------------------------------- what the reader does

  run(on) {
    this.playing = on;
    this.playButton.textContent = on ? "❚❚" : "▶";
    this.playButton.title = this.playButton.ariaLabel = on ? "pause (space)" : "play (space)";
    this.send("run", { value: on && this.mode === "live" });
    if (on && this.mode === "replay" && this.replay.time >= this.replay.end) this.seek(0, true);
  }

  setPace(pace) {
    this.pace = pace;
    this.send("speed", { value: pace });
  }

  step(ticks) {
    this.run(false);
    if (this.mode === "live") this.send("step", { ticks });
    else this.seek(this.replay.time + ticks * this.task.period);
  }

  reset() {
    this.goal = undefined;
    if (this.mode === "replay") return this.seek(0, this.playing);
    this.scene.clear();
    this.send("restart");
    this.plots.forEach((plot) => plot.clear());
    this.select(this.task.parts.length ? "plan" : "circle");
    if (!this.task.parts.length) this.shape();
  }

  // A click on a joint: it fails as chosen, or is whole again.
  hit(i) {
    const broken = this.latest?.truth[i].health || this.latest?.known[i];
    this.fail(i, broken ? null : this.kind);
  }

  fail(i, kind) {
    if (this.mode === "replay") this.goOn();
    let fault = WHOLE;
    if (kind !== null) {
      const { health, numbers, moves } = this.task.kinds[kind];
      if (!numbers[i]) return this.hold(`${this.task.arm.joints[i].name} has no rate limit, of which a runaway would take a share.`);
      const shift = moves * this.latest.q[i];
      fault = { health, first: numbers[i][0] + shift, second: moves ? numbers[i][1] + shift : numbers[i][1] };
    }
    const ticks = this.delay === Infinity ? Infinity : Math.round(this.delay / this.task.period);
    this.send("fail", { joint: i, fault, ticks });
  }

  random() {
    const whole = Array.from({ length: this.n }, (_, i) => i).filter((i) => !this.latest?.truth[i].health);
    if (whole.length) this.fail(whole[Math.floor(Math.random() * whole.length)], this.kind);
  }

  // Every joint is whole, and the controller knows it at once.
  heal() {
    if (this.mode === "replay") this.goOn();
    for (let i = 0; i < this.n; ++i)
      if (this.latest?.truth[i].health || this.latest?.known[i]) this.send("fail", { joint: i, fault: WHOLE, ticks: 0 });
  }

  select(kind) {
    this.motionKind = kind;
    this.motionSelect.value = kind;
    this.shapeRows.forEach((row) => (row.hidden = !panels.SIZED.includes(kind)));
  }

  setMotion(kind) {
    if (this.mode === "replay") this.goOn();
    const same = kind === this.motionKind;
    this.goal = undefined;
    this.select(kind);
    if (!same) this.scene.clear();
    if (kind === "plan") this.plots.forEach((plot) => plot.clear());
    this.shape();
    if (!this.playing) this.run(true);
  }

  // The motion that is chosen, in the plane of the screen.
  shape() {
    const kind = this.motionKind, [right, up] = this.scene.plane(), { reach } = this.task.arm;
    const size = kind === "drag" ? 0.6 * reach : Number(this.sizeInput.value) * reach;
    this.send("motion", { kind, right, up, size, seconds: Number(this.timeInput.value) });
  }

  settings(changed) {
    if (this.mode === "replay") this.goOn();
    Object.assign(this, changed);
    this.send("change", { setup: panels.setup(this.task, this.law, this.nullMotion, this.share) });
  }

  key(event) {
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const within = event.target.closest?.("input, select, summary, button");
    const key = event.key.toLowerCase();
    if (key === "escape") return document.activeElement?.blur();
    if (within?.matches("select") || (key === " " && within)) return;
    if (within?.matches("input") && !/^[a-z]$/.test(key)) return;
    const digit = key.length === 1 ? "1234567890".indexOf(key) : -1;
    const way = { arrowleft: [0, -1], arrowright: [0, 1], arrowdown: [1, -1], arrowup: [1, 1], pageup: [2, 1], pagedown: [2, -1] }[key];
    const actions = { " ": () => this.run(!this.playing), s: () => this.step(1), r: () => this.reset(), x: () => this.random(), h: () => this.heal() };
    if (actions[key]) actions[key]();
    else if (digit >= 0 && digit < this.n) this.hit(digit);
    else if (way && this.motionKind === "drag" && this.latest) this.nudge(...way);
    else return;
    event.preventDefault();
  }

  // Moves the target along the screen's right, its up, or away from the reader.
  nudge(along, sign) {
    const [right, up] = this.scene.plane();
    const axis = [right, up, cross(right, up)][along];
    const from = this.goal ?? pointOf(this.latest.target);
    this.moveGoal(from.map((x, r) => x + 0.02 * this.task.arm.reach * sign * axis[r]));
  }

  moveGoal(point) {
    this.goal = point;
    this.send("goal", { point });
    if (!this.playing) this.run(true);
  }

  press(event) {
    const found = this.scene.pick(event.offsetX, event.offsetY);
    this.pressed = { x: event.offsetX, y: event.offsetY, found };
    if (found !== "goal" || event.button !== 0) return;
    this.scene.orbit(false);
    this.canvas.setPointerCapture(event.pointerId);
    this.dragging = true;
  }

  drag(event) {
    if (!this.dragging) {
      if (!event.buttons) this.canvas.style.cursor = this.scene.pick(event.offsetX, event.offsetY) === -1 ? "grab" : "pointer";
      return;
    }
    if (this.motionKind !== "drag") this.setMotion("drag");
    const point = this.scene.under(event.offsetX, event.offsetY, pointOf(this.latest.target));
    if (point) this.moveGoal(point);
  }

  release(event) {
    this.scene.orbit(true);
    const { pressed } = this;
    const still = pressed && Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) < 5;
    if (!this.dragging && still && event.type === "pointerup" && pressed.found >= 0) this.hit(pressed.found);
    if (this.dragging) this.goal = undefined;
    this.dragging = false;
    this.pressed = null;
  }

  // ---------------------------------------------------------------- replay

  chooseRun(k) {
    const { replay } = this;
    replay.chosen = k;
    const { run } = replay;
    if (this.task !== replay.task) {
      this.task = replay.task;
      this.heading.textContent = this.task.title;
      this.settingsBox.replaceChildren(panels.motion(this), panels.control(this));
      this.begin();
    }
    this.slider.max = replay.end;
    const marks = run.faults.map((fault) => {
      const mark = make("i", { title: `${this.task.arm.joints[fault.joint].name} ${this.task.words.health[fault.health]}` });
      mark.style.left = `${(100 * fault.begin) / Math.max(run.end, 1)}%`;
      return mark;
    });
    this.marks.replaceChildren(...marks);
    this.backToReplay();
  }

  backToReplay() {
    this.mode = "replay";
    this.run(false);
    this.replay.of = null;
    this.makePlots();
    this.seek(Math.min(this.replay.time, this.replay.end));
  }

  // To a time [s] of the replay.
  seek(time, playing = false) {
    if (this.mode !== "replay") this.backToReplay();
    if (this.playing !== playing) this.run(playing);
    this.replay.time = Math.min(time, this.replay.end);
    this.slider.value = this.replay.time;
  }

  // The controller takes over from the moment that is shown.
  goOn() {
    const { found } = this.replay.moment();
    this.mode = "live";
    this.latest = found;
    this.goal = undefined;
    this.select(this.task.parts.length ? "plan" : "hold");
    this.send("goOn", { tick: found.tick, q: found.q, rates: found.rates, faults: found.truth });
    this.scene.clear();
    this.makePlots();
    this.run(true);
  }

  // A case of a rehearsal: from a second before its onset. told(worst): the largest distance and angle from there on.
  play({ changes, known, delayed, onset }, told) {
    this.mode = "live";
    this.select("plan");
    this.scene.clear();
    this.plots.forEach((plot) => plot.clear());
    this.case = { id: (this.case?.id ?? 0) + 1, told };
    this.send("play", { changes, known, delayed, onset, id: this.case.id, to: Math.max(0, onset - Math.round(1 / this.task.period)) });
    this.run(true);
  }

  // Reports the errors of the case that is played, at its end.
  followCase(found) {
    const played = this.case;
    if (!played?.told || !found.ended || found.case?.id !== played.id) return;
    played.told(found.case.worst);
    played.told = null;
  }

  // ---------------------------------------------------------------- frames

  arrive(found) {
    this.waiting = false;
    if (this.mode !== "live") return;
    this.latest = found;
    this.followCase(found);
    this.show(found);
    const over = found.ended && found.time > (this.task.steps + 1) * this.task.period + AFTER;
    if (over && !this.over) this.run(false);
    this.over = over;
    this.plots[0].add(found.time, [1000 * found.worst[0]]);
    this.plots[1].add(found.time, Array.from(found.moving, (rate, i) => 100 * this.shareOf(rate, i)));
    if (this.frames % EVERY === 0) this.plots.forEach((plot) => plot.show());
  }

  animate(now) {
    requestAnimationFrame(this.animate);
    if (this.mode === "replay") this.showReplay(Math.min((now - (this.then ?? now)) / 1000, 0.1));
    else if (!this.waiting) {
      this.waiting = true;
      this.send("frame");
    }
    this.then = now;
  }

  showReplay(passed) {
    const { replay } = this;
    if (this.playing) {
      this.seek(replay.time + passed * this.pace, true);
      if (replay.time >= replay.end) this.run(false);
    }
    const { found, fresh } = replay.moment();
    if (fresh) this.scene.clear();
    this.latest = found;
    this.show(found);
    if (this.frames % EVERY === 0) this.plots.forEach((plot) => plot.at(replay.time));
  }

  // A rate as a share of its limit; 0 without a limit.
  shareOf(rate, i) {
    const limit = this.task.limits[i] * (this.mode === "live" ? this.share : 1);
    return limit ? Math.abs(rate) / limit : 0;
  }

  show(found) {
    const { task } = this;
    found.signs = missing(found, task);
    this.scene.draw(found, this.shown);
    ++this.frames;
    this.label(found);
    this.clock.textContent = `${found.time.toFixed(task.period < 0.01 ? 3 : 2)} s, ${lengthOf(found.off[0])} off`;
    this.rows.forEach((row, i) => {
      const state = found.health[i], known = found.known[i];
      row.button.classList.toggle("broken", state !== 0 || known !== 0);
      row.button.setAttribute("aria-pressed", String(state !== 0));
      row.sign.textContent = STATE_SIGN[state];
      row.sign.style.color = this.colours.health[state];
      const doubt = known === state ? "" : state ? ", unknown" : `works, taken for ${task.words.health[known]}`;
      const words = (state ? task.words.health[state] : "") + doubt;
      if (row.state.textContent !== words) row.state.textContent = words;
      row.value.textContent = valueOf(found.q[i], task.arm.joints[i].unit);
      row.rate.style.width = `${Math.min(100, 100 * this.shareOf(found.moving[i], i))}%`;
      row.worth.style.width = `${100 * (1 - found.relative[i])}%`;
    });
    const now = performance.now(), jumped = !this.playing && found.tick !== this.toldOf;
    if (now - (this.told ?? 0) < TOLD && !jumped) return;
    Object.assign(this, { told: now, toldOf: found.tick });
    this.describe(found);
  }

  // The sentence and the numbers.
  describe(found) {
    const { task } = this, replay = this.mode === "replay";
    if (this.replay) {
      this.goOnButton.hidden = !replay;
      this.backButton.hidden = replay;
      this.slider.parentElement.hidden = !replay;
    }
    this.ghostBox.hidden = replay && !found.ghost;
    this.ghostName.textContent = replay ? "other run" : "healthy arm";
    this.say(replay ? `Replay of ${this.replay.run.label}. ${status(found, task)}` : status(found, task));
    const entries = [
      ["tool from its target", `${lengthOf(found.off[0])}, ${angleOf(found.off[1])}`],
      ["limits", flags(found.status, task)],
      ["axes of its speeds", found.sigma.reduce((text, axis) => `${text}${text && ", "}${lengthOf(axis * (replay ? 1 : this.share))}/s`, ""), SPEEDS],
    ];
    if (!replay) entries.push(["damping", number(found.damping), "of the law"], ["done of the command", `${number(100 * found.scale)} %`, "keep-direction slows the whole command"]);
    this.facts.replaceChildren(...entries.flatMap(([name, text, title = ""]) => [make("dt", { title }, name), make("dd", {}, text)]));
  }

  // Names beside the joints, broken ones first, where there is room.
  label(found) {
    const { chain, joints } = this.task.arm;
    if (this.tags.childElementCount !== chain.length) this.tags.replaceChildren(...chain.map(() => make("span")));
    this.tags.hidden = !this.shown.names;
    if (!this.shown.names) return;
    const { clientWidth, clientHeight } = this.canvas, taken = [], top = this.looks.offsetTop + this.looks.offsetHeight + 10;
    const order = chain.map((_, k) => k).sort((a, b) => (found.health[chain[b].joint] !== 0) - (found.health[chain[a].joint] !== 0));
    for (const k of order) {
      const { joint } = chain[k], state = found.health[joint], tag = this.tags.children[k];
      const text = joints[joint].name + (state ? `: ${this.task.words.health[state]}` : "");
      if (tag.textContent !== text) tag.textContent = text;
      tag.className = state ? "broken" : "";
      const [x, y, seen] = this.scene.project(this.scene.station(k)), width = 7 * text.length + 14;
      const fits = ([u, v]) => seen && u > 0 && v > top && u + width < clientWidth && v < clientHeight - 8 && !taken.some(([a, b, wide]) => u < a + wide && a < u + width && Math.abs(b - v) < 17);
      const at = [x, x - width].flatMap((u) => [y, y + 17, y - 17, y + 34].map((v) => [u, v])).find(fits);
      tag.hidden = at === undefined;
      if (tag.hidden) continue;
      taken.push([...at, width]);
      const side = at[0] < x ? `calc(${Math.round(x - 12)}px - 100%)` : `${Math.round(x + 12)}px`;
      tag.style.transform = `translate(${side}, ${Math.round(at[1] - 9)}px)`;
    }
  }

  // A point on the screen [px] at which a click meets a joint, for tests; null where it is hidden.
  pixel(i) {
    const box = this.canvas.getBoundingClientRect();
    for (const point of this.scene.handles(i)) {
      const [x, y] = this.scene.project(point);
      if (this.scene.pick(x, y) === i) return [box.left + x, box.top + y];
    }
    return null;
  }
}

function short(label, most = 24) {
  return label.length > most ? `${label.slice(0, most - 1)}…` : label;
}

function pointOf(pose) {
  return [pose[3], pose[7], pose[11]];
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}
