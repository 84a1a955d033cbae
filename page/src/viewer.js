// The viewer: what the reader sees and does. The controller runs in a worker; runs are replayed here.

import { choice, make, slider, tick } from "./layout.js";
import { OWN } from "./motions.js";
import { Plot } from "./plots.js";
import { Flat } from "./flat.js";
import { Solid } from "./scene.js";
import { angleOf, flags, lengthOf, number, status, valueOf } from "./words.js";

const NULL_TAIL = 3; // kind, gain, largest rate, before n numbers of it, n bytes and 5 n limits: see setup.hpp
const SPEEDS = [0.1, 0.25, 0.5, 1, 2, 5, 10];
const MOTION_WORDS = { plan: "the task's motion", hold: "hold still", line: "line", circle: "circle", eight: "figure eight", drag: "follow the pointer" };
const AFTER = 1; // [s] that a task goes on after its end before it is paused
const STATE_SIGN = ["●", "■", "◐", "▲", "◇", "▶"]; // by health: shape as well as colour

const THEMES = {
  light: { paper: "#f7f9fb", ink: "#1d2430", soft: "#5b6675", grid: "#d5dbe2", link: "#c9d1da", ghost: "#7f93ab", joint: "#66788c", target: "#2f74c0", actual: "#c8501e", bad: "#b3261e" },
  dark: { paper: "#12161c", ink: "#e6eaf0", soft: "#9aa6b5", grid: "#2a323d", link: "#aab5c2", ghost: "#8fa6c2", joint: "#71839a", target: "#5aa0ea", actual: "#f0863c", bad: "#ff7b6e" },
};
const HEALTH_COLOURS = ["#66788c", "#d0342c", "#e09a2a", "#b455b8", "#b58a4a", "#d9689c"];
const LINE_COLOURS = ["#2f74c0", "#c8501e", "#2f8d4f", "#9a4f9f", "#a3891f", "#4aa3a8", "#d0342c", "#7a6bc0"];

export class Viewer {
  constructor(box, data, module) {
    Object.assign(this, { box, data, task: data.task, frames: 0, shown: { ghost: true, ellipsoid: false, trail: true, lost: true, names: true } });
    this.n = this.task.arm.joints.length;
    this.kind = 0;
    this.delay = 0;
    this.share = 1;
    this.law = 0;
    this.nullMotion = 0;
    this.playing = false;
    this.pace = 1;
    this.mode = data.runs.length ? "replay" : "live";
    this.place = 0; // [s] of a replay
    this.build();
    this.worker = new Worker(URL.createObjectURL(new Blob([WORKER], { type: "text/javascript" })));
    this.worker.onmessage = ({ data: found }) => this.arrive(found);
    this.worker.onerror = (event) => this.say(`The controller stopped: ${event.message}`);
    this.send("begin", { module, task: this.task, run: false });
    this.waiting = false;
    this.animate = this.animate.bind(this);
    if (this.mode === "live") {
      this.run(true);
      if (!this.task.parts.length) this.setMotion("circle");
    }
    requestAnimationFrame(this.animate);
  }

  send(what, more = {}) {
    this.worker.postMessage({ do: what, ...more });
  }

  // ---------------------------------------------------------------- the page

  build() {
    const { task } = this;
    this.canvas = make("canvas", { tabIndex: 0, ariaLabel: `${task.arm.name}: the arm. Choose a joint to break it.`, className: "scene" });
    this.tags = make("div", { className: "tags", ariaHidden: "true" });
    this.sentence = make("p", { className: "status", role: "status", ariaLive: "polite" });
    this.rows = task.arm.joints.map((joint, i) => this.jointRow(joint, i));
    this.facts = make("dl", { className: "facts" });
    const stage = make("div", { className: "stage" }, this.canvas, this.tags, this.looks());
    this.plotBoxes = [make("div", { className: "plot" }), make("div", { className: "plot" })];
    const left = make("div", { className: "left" }, stage, this.transport(), make("div", { className: "plots" }, ...this.plotBoxes));
    const right = make("aside", { className: "panel" }, this.breaking(), this.motionPanel(), this.controlPanel(), make("section", {}, make("h2", {}, "Now"), this.facts), this.notes());
    this.box.append(make("header", {}, make("h1", {}, task.title), this.sentence), make("main", {}, left, right));
    this.startScene();
    this.follow();
    const hears = document.body.classList.contains("app") ? window : this.box; // a page around it keeps its own keys
    hears.addEventListener("keydown", (event) => this.key(event));
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
      this.notesBox.append(make("p", {}, "This browser has no WebGL here; the arm is drawn flat."));
      this.notesBox.parentElement.hidden = false;
    }
    this.canvas.addEventListener("pointerdown", (event) => this.press(event));
    this.canvas.addEventListener("pointermove", (event) => this.drag(event));
    this.canvas.addEventListener("pointerup", (event) => this.release(event));
    this.canvas.addEventListener("pointercancel", (event) => this.release(event));
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

  looks() {
    const { shown } = this;
    const box = (name, label) => tick(label, shown[name], (on) => (shown[name] = on));
    return make("div", { className: "looks" }, box("names", "names"), box("ghost", "healthy arm"), box("trail", "paths"), box("lost", "lost directions"), box("ellipsoid", "speeds"), make("button", { type: "button", onclick: () => this.scene.view() }, "view"));
  }

  jointRow(joint, i) {
    const name = make("span", { className: "name" }, joint.name);
    const state = make("span", { className: "state" });
    const rate = make("i"), worth = make("i");
    const value = make("span", { className: "value" });
    const button = make("button", { type: "button", className: "joint", onclick: () => this.hit(i) }, make("span", { className: "sign" }), name, state, value,
      make("span", { className: "bar", title: "rate, as a share of its limit" }, rate), make("span", { className: "bar worth", title: "how much this joint matters now: manipulability lost without it" }, worth));
    return { button, state, rate, worth, value, sign: button.firstChild };
  }

  breaking() {
    const { task } = this;
    const kinds = task.kinds.map((kind, k) => [k, `${kind.word}: ${kind.meaning}`]);
    const [kindRow] = choice("a click makes it", kinds, (value) => (this.kind = Number(value)), { className: "kind" });
    const steps = [0, 0.01, 0.02, 0.04, 0.1, 0.2, 0.5, 1, Infinity];
    const [delayRow] = slider("known after", { min: 0, max: steps.length - 1, step: 1, value: 0, shown: (k) => (steps[k] === Infinity ? "never" : lengthOfTime(steps[k])) }, (k) => (this.delay = steps[k]));
    const random = make("button", { type: "button", className: "random", onclick: () => this.random() }, "a random joint");
    const heal = make("button", { type: "button", className: "heal", onclick: () => this.heal() }, "restore all");
    const legend = make("p", { className: "soft" }, "Upper bar: rate, as a share of its limit. Lower bar: how much the joint matters now.");
    return make("section", { className: "joints" }, make("h2", {}, "Break a joint"), kindRow, delayRow, make("div", { className: "list" }, ...this.rows.map((row) => row.button)), make("div", { className: "buttons" }, random, heal), legend);
  }

  motionPanel() {
    const kinds = [...(this.task.parts.length ? ["plan"] : []), ...OWN, "drag"];
    const [row, select] = choice("the target", kinds.map((kind) => [kind, MOTION_WORDS[kind]]), (kind) => this.setMotion(kind), { className: "motion" });
    this.motionSelect = select;
    const { reach } = this.task.arm;
    const [sizeRow, size] = slider("size", { min: 0.01, max: 0.4, step: 0.01, value: 0.1, shown: (x) => lengthOf(x * reach) }, () => this.setMotion(this.motionKind));
    const [timeRow, time] = slider("a round takes", { min: 1, max: 30, step: 0.5, value: 8, shown: (x) => `${x} s` }, () => this.setMotion(this.motionKind));
    this.sizeInput = size;
    this.timeInput = time;
    this.shapeRows = [sizeRow, timeRow];
    this.motionKind = kinds[0];
    this.shapeRows.forEach((one) => (one.hidden = !["line", "circle", "eight"].includes(kinds[0])));
    return make("section", {}, make("h2", {}, "Motion"), row, sizeRow, timeRow);
  }

  controlPanel() {
    const { task } = this;
    const [lawRow] = choice("law", task.laws.map((law, k) => [k, law.label]), (k) => this.settings({ law: Number(k) }), { className: "law" });
    const [nullRow] = choice("spare freedom", task.nullMotions.map((motion, k) => [k, motion.label]), (k) => this.settings({ nullMotion: Number(k) }), { className: "null" });
    const [limitRow] = slider("rate limits", { min: 0.05, max: 1, step: 0.05, value: 1, shown: (x) => `${Math.round(100 * x)} %` }, (share) => this.settings({ share }));
    limitRow.classList.add("limits");
    return make("section", {}, make("h2", {}, "Controller"), lawRow, nullRow, limitRow);
  }

  notes() {
    this.notesBox = make("div", { className: "soft" }, ...this.data.notes.map((note) => make("p", {}, note)));
    const keys = make("details", { className: "soft" }, make("summary", {}, "Keys"), make("p", {}, "Space: pause. S: one tick. R: from the beginning. 1 to 9, 0: break or restore a joint. X: a random one. H: restore all. In “follow the pointer”: arrow keys and page up and down move the target."));
    const about = make("p", { className: "soft" }, `stillreach ${this.data.version}: the controller of the C++ core, compiled to WebAssembly, every ${number(1000 * this.task.period)} ms.`);
    return make("section", {}, this.notesBox, keys, about);
  }

  transport() {
    const button = (text, label, action, name) => make("button", { type: "button", ariaLabel: label, title: label, className: name, onclick: action }, text);
    this.playButton = button("▶", "play (space)", () => this.run(!this.playing), "play");
    const [speedRow] = slider("speed", { min: 0, max: SPEEDS.length - 1, step: 1, value: 3, shown: (k) => `× ${SPEEDS[k]}` }, (k) => {
      this.pace = SPEEDS[k];
      this.send("speed", { value: this.pace });
    });
    this.clock = make("span", { className: "clock" });
    this.slider = make("input", { type: "range", className: "time", min: 0, max: 1, step: "any", value: 0, ariaLabel: "time of the replay" });
    this.slider.addEventListener("input", () => {
      this.mode = "replay";
      this.run(false);
      this.place = Number(this.slider.value);
      this.replayPlots();
    });
    this.marks = make("div", { className: "marks" });
    const { runs } = this.data;
    const [runRow] = choice("run", runs.map((run, k) => [k, run.label]), (k) => this.chooseRun(Number(k)), { className: "run" });
    this.goOnButton = make("button", { type: "button", className: "go-on", onclick: () => this.goOn() }, "continue live from here");
    this.backButton = make("button", { type: "button", className: "back", onclick: () => this.backToReplay() }, "back to the replay");
    this.replayBar = make("div", { className: "replay" }, make("div", { className: "track" }, this.slider, this.marks), runs.length > 1 ? runRow : null, this.goOnButton, this.backButton);
    this.replayBar.hidden = !runs.length;
    this.chosen = 0;
    if (runs.length) this.chooseRun(0);
    return make("div", { className: "transport" }, this.playButton, button("▸|", "one tick (S)", () => this.step(1), "step"), button("↺", "from the beginning (R)", () => this.reset(), "reset"), speedRow, this.clock, this.replayBar);
  }

  makePlots() {
    const { colours } = this;
    const runs = this.data.runs.map((run, k) => [run.label, LINE_COLOURS[k % LINE_COLOURS.length], k ? [6, 3] : undefined]);
    const error = this.mode === "replay" ? runs : [["distance", LINE_COLOURS[0]]];
    this.plots?.forEach((plot) => plot.plot.destroy());
    this.plots = [
      new Plot(this.plotBoxes[0], "tool from its target", "mm", error, colours, 0.1),
      new Plot(this.plotBoxes[1], "rates, as a share of their limits", "%", this.task.arm.joints.map((joint, i) => [joint.name, LINE_COLOURS[i % LINE_COLOURS.length]]), colours, 100),
    ];
    if (this.mode === "replay") this.replayPlots(true);
  }

  say(text) {
    if (this.sentence.textContent !== text) this.sentence.textContent = text;
  }

  resize() {
    const { clientWidth, clientHeight } = this.canvas.parentElement;
    if (clientWidth && clientHeight) this.scene.resize(clientWidth, clientHeight, devicePixelRatio || 1);
  }

  // ---------------------------------------------------------------- what the reader does

  run(on) {
    this.playing = on;
    this.playButton.textContent = on ? "❚❚" : "▶";
    this.playButton.title = this.playButton.ariaLabel = on ? "pause (space)" : "play (space)";
    this.send("run", { value: on && this.mode === "live" });
    if (on && this.mode === "replay" && this.place >= this.length()) this.place = 0;
  }

  step(ticks) {
    this.run(false);
    if (this.mode === "live") this.send("step", { ticks });
    else {
      this.place = Math.min(this.place + ticks * this.task.period, this.length());
      this.slider.value = this.place;
    }
  }

  reset() {
    this.scene.clear();
    if (this.mode === "replay") this.place = 0;
    else {
      this.send("restart");
      this.plots.forEach((plot) => plot.clear());
      this.select(this.task.parts.length ? "plan" : "hold");
      if (this.share !== 1 || this.law || this.nullMotion) this.settings({});
    }
  }

  // A click on a joint: it fails as chosen, or is whole again.
  hit(i) {
    const broken = (this.latest?.truth ?? [])[i]?.health ?? this.latest?.health[i];
    this.fail(i, broken ? null : this.kind);
  }

  fail(i, kind) {
    if (this.mode === "replay") this.goOn();
    let fault = { health: 0, first: 0, second: 0 };
    if (kind !== null) {
      const { health, numbers, moves } = this.task.kinds[kind];
      if (!numbers[i]) {
        this.say(`${this.task.arm.joints[i].name} has no rate limit to run away at a share of.`);
        return;
      }
      const shift = moves * this.latest.q[i];
      fault = { health, first: numbers[i][0] + shift, second: moves ? numbers[i][1] + shift : numbers[i][1] };
    }
    const ticks = this.delay === Infinity ? Infinity : Math.round(this.delay / this.task.period);
    this.send("fail", { joint: i, fault, ticks });
  }

  random() {
    const whole = Array.from({ length: this.n }, (_, i) => i).filter((i) => !this.latest?.truth?.[i].health && !this.latest?.health[i]);
    if (whole.length) this.fail(whole[Math.floor(Math.random() * whole.length)], this.kind);
  }

  heal() {
    for (let i = 0; i < this.n; ++i) if (this.latest?.truth?.[i].health) this.send("fail", { joint: i, fault: { health: 0, first: 0, second: 0 }, ticks: 0 });
  }

  select(kind) {
    this.motionKind = kind;
    this.motionSelect.value = kind;
    this.shapeRows.forEach((row) => (row.hidden = !["line", "circle", "eight"].includes(kind)));
  }

  setMotion(kind) {
    if (this.mode === "replay") this.goOn();
    this.select(kind);
    const [right, up] = this.scene.plane();
    const { reach } = this.task.arm;
    const size = kind === "drag" ? 0.6 * reach : Number(this.sizeInput.value) * reach;
    this.scene.clear();
    if (kind === "plan") this.plots.forEach((plot) => plot.clear());
    this.send("motion", { kind, right, up, size, seconds: Number(this.timeInput.value) });
  }

  // Law, null motion and limits as one setup.
  settings(changed) {
    Object.assign(this, changed);
    if (this.mode === "replay") this.goOn();
    const { n, task } = this;
    const setup = Float64Array.from(task.laws[this.law].setup);
    const from = task.nullMotions[this.nullMotion].setup;
    const rates = setup.length - 5 * n, motion = rates - n - n - NULL_TAIL;
    const own = from.length - 7 * n - NULL_TAIL;
    setup.set(from.subarray(own, own + NULL_TAIL + n), motion);
    for (let i = 0; i < 2 * n; ++i) setup[rates + i] *= this.share;
    this.send("change", { setup });
  }

  key(event) {
    const within = event.target.closest?.("input, select, summary, button");
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    const { key } = event;
    if (key === " " && within) return;
    if (within?.matches("select, input") && !/^[a-zA-Z]$/.test(key)) return;
    if (within?.matches("select")) return;
    const digit = "1234567890".indexOf(key);
    const moves = { ArrowLeft: [0, -1], ArrowRight: [0, 1], ArrowDown: [1, -1], ArrowUp: [1, 1], PageUp: [2, 1], PageDown: [2, -1] }[key];
    if (key === " ") this.run(!this.playing);
    else if (key === "s") this.step(1);
    else if (key === "r") this.reset();
    else if (key === "x") this.random();
    else if (key === "h") this.heal();
    else if (digit >= 0 && digit < this.n && key) this.hit(digit);
    else if (moves && this.motionKind === "drag" && this.latest) {
      const [right, up] = this.scene.plane();
      const along = moves[0] === 0 ? right : moves[0] === 1 ? up : cross(right, up);
      const goal = this.goal ?? [3, 7, 11].map((k) => this.latest.target[k]);
      this.moveGoal(goal.map((x, r) => x + 0.02 * this.task.arm.reach * moves[1] * along[r]));
    } else return;
    event.preventDefault();
  }

  moveGoal(point) {
    this.goal = point;
    this.send("goal", { point });
  }

  press(event) {
    const found = this.scene.pick(event.offsetX, event.offsetY);
    this.pressed = { x: event.offsetX, y: event.offsetY, found };
    if (found === "goal" && event.button === 0) {
      this.scene.orbit(false);
      this.canvas.setPointerCapture(event.pointerId);
      if (this.motionKind !== "drag") this.setMotion("drag");
      this.dragging = true;
    }
  }

  drag(event) {
    if (!this.dragging) {
      if (event.buttons) return;
      const found = this.scene.pick(event.offsetX, event.offsetY);
      this.canvas.style.cursor = found === -1 ? "grab" : "pointer";
      return;
    }
    const through = [3, 7, 11].map((k) => this.latest.target[k]);
    const point = this.scene.under(event.offsetX, event.offsetY, through);
    if (point) this.moveGoal(point);
  }

  release(event) {
    this.scene.orbit(true);
    const { pressed } = this;
    const still = pressed && Math.hypot(event.offsetX - pressed.x, event.offsetY - pressed.y) < 5;
    if (!this.dragging && still && event.type === "pointerup" && typeof pressed.found === "number" && pressed.found >= 0) this.hit(pressed.found);
    this.dragging = false;
    this.goal = undefined;
    this.pressed = null;
  }

  // ---------------------------------------------------------------- replay

  chooseRun(k) {
    this.chosen = k;
    const run = this.data.runs[k];
    this.mode = "replay";
    this.slider.max = run.end * this.task.period;
    this.marks.replaceChildren(
      ...run.faults.map((fault) => {
        const mark = make("i", { title: `${this.task.arm.joints[fault.joint].name} ${this.task.words.health[fault.health]}` });
        mark.style.left = `${(100 * fault.first_tick) / Math.max(run.end, 1)}%`;
        return mark;
      }),
    );
    if (this.plots) this.makePlots();
  }

  length() {
    return this.data.runs[this.chosen].end * this.task.period;
  }

  replayPlots(fresh) {
    if (!this.data.runs.length) return;
    if (fresh || this.plotted !== "replay") {
      this.plotted = "replay";
      const times = [...new Set(this.data.runs.flatMap((run) => Array.from(run.tick)))].sort((a, b) => a - b);
      const series = this.data.runs.map((run) => {
        let k = 0;
        return times.map((t) => {
          while (k < run.tick.length - 1 && run.tick[k + 1] <= t) ++k;
          return t > run.end ? null : 1000 * run.off[2 * k];
        });
      });
      this.plots[0].whole([times.map((t) => t * this.task.period), ...series]);
      const run = this.data.runs[this.chosen];
      const shares = this.task.limits.map((limit, i) => Array.from(run.tick, (_, k) => (limit ? (100 * Math.abs(run.rates[k * this.n + i])) / limit : 0)));
      this.plots[1].whole([Array.from(run.tick, (t) => t * this.task.period), ...shares]);
    }
    this.plots.forEach((plot) => plot.at(this.place));
  }

  // A moment of a run, as a snapshot is.
  moment() {
    const run = this.data.runs[this.chosen], { n } = this;
    const tickNow = Math.round(this.place / this.task.period);
    let low = 0, high = run.tick.length - 1;
    while (low < high) {
      const middle = (low + high + 1) >> 1;
      if (run.tick[middle] <= tickNow) low = middle;
      else high = middle - 1;
    }
    const next = Math.min(low + 1, run.tick.length - 1);
    const span = run.tick[next] - run.tick[low], share = span ? Math.min((tickNow - run.tick[low]) / span, 1) : 0;
    const mix = (array, size) => Float64Array.from({ length: size }, (_, i) => array[low * size + i] * (1 - share) + array[next * size + i] * share);
    const rows = (array) => array.slice(low * n, low * n + n);
    const target = Float64Array.from([1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1]);
    const at = mix(run.target, 3);
    for (let r = 0; r < 3; ++r) target[4 * r + 3] = at[r];
    const found = { tick: tickNow, time: this.place, q: mix(run.q, n), rates: rows(run.rates), health: rows(run.health), known: rows(run.known), target, off: Array.from(run.off.slice(2 * low, 2 * low + 2)), status: run.status[low], replay: true };
    const from = this.drawn ?? 0;
    const trail = [];
    if (low < from || this.trailOf !== run) {
      this.scene.clear();
      this.drawn = 0;
      this.trailOf = run;
    }
    for (let k = this.drawn ?? 0; k <= low; ++k) trail.push(...run.tool.slice(3 * k, 3 * k + 3), ...run.target.slice(3 * k, 3 * k + 3));
    this.drawn = low + 1;
    found.trail = Float32Array.from(trail);
    return found;
  }

  // The controller takes over from the moment that is shown.
  goOn() {
    const run = this.data.runs[this.chosen];
    const found = this.moment();
    const faults = Array.from({ length: this.n }, (_, i) => {
      if (!found.health[i]) return { health: 0, first: 0, second: 0 };
      const spans = run.faults.filter((fault) => fault.joint === i && fault.health === found.health[i] && fault.first_tick <= found.tick && found.tick < fault.end_tick);
      const last = spans.sort((a, b) => a.first_tick - b.first_tick).pop();
      return last ? { health: last.health, first: last.first, second: last.second } : { health: 1, first: 0, second: 0 };
    });
    this.mode = "live";
    this.trailOf = null;
    this.select(this.task.parts.length ? "plan" : "hold");
    this.send("goOn", { tick: found.tick, q: found.q, rates: found.rates, faults });
    this.scene.clear();
    this.plotted = "live";
    this.makePlots();
    this.run(true);
  }

  backToReplay() {
    this.mode = "replay";
    this.run(false);
    this.trailOf = null;
    this.makePlots();
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

  // Tells what came of the case that is played, at its end.
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
    const share = (i) => (this.task.limits[i] ? (100 * Math.abs(found.rates[i])) / (this.task.limits[i] * this.share) : 0);
    this.plots[0].add(found.time, [1000 * found.worst[0]]);
    this.plots[1].add(found.time, Array.from({ length: this.n }, (_, i) => share(i)));
    if (this.frames % 6 === 0) this.plots.forEach((plot) => plot.show());
  }

  animate(now) {
    requestAnimationFrame(this.animate);
    if (this.mode === "replay") {
      const passed = Math.min((now - (this.then ?? now)) / 1000, 0.1);
      if (this.playing) {
        this.place = Math.min(this.place + passed * this.pace, this.length());
        this.slider.value = this.place;
        if (this.place >= this.length()) this.run(false);
      }
      this.latest = this.moment();
      this.show(this.latest);
      if (this.frames % 6 === 0) this.replayPlots();
    } else if (!this.waiting) {
      this.waiting = true;
      this.send("frame");
    }
    this.then = now;
  }

  show(found) {
    this.scene.draw(found, this.shown);
    ++this.frames;
    this.label(found);
    this.replayState();
    const { task } = this;
    const period = task.period;
    this.clock.textContent = `${found.time.toFixed(period < 0.01 ? 3 : 2)} s`;
    this.rows.forEach((row, i) => {
      const state = found.health[i], known = found.known[i];
      row.button.classList.toggle("broken", state !== 0);
      row.button.setAttribute("aria-pressed", String(state !== 0));
      row.sign.textContent = STATE_SIGN[state];
      row.sign.style.color = this.colours.health[state];
      const words = state ? task.words.health[state] + (known === state ? "" : ", not known yet") : "";
      if (row.state.textContent !== words) row.state.textContent = words;
      row.value.textContent = valueOf(found.q[i], task.arm.joints[i].unit);
      const limit = task.limits[i] ? task.limits[i] * (found.replay ? 1 : this.share) : 0;
      row.rate.style.width = `${limit ? Math.min(100, (100 * Math.abs(found.rates[i])) / limit) : 0}%`;
      row.worth.style.width = found.relative ? `${100 * (1 - found.relative[i])}%` : "0";
    });
    if (this.frames % 6 !== 1) return;
    this.say(found.replay ? this.replayStatus(found) : status(found, task));
    const entries = [
      ["tool from its target", `${lengthOf(found.off[0])}, ${angleOf(found.off[1])}`],
      ["limits", flags(found.status, task)],
    ];
    if (!found.replay) {
      entries.push(["damping", number(found.damping)], ["of the command", `${number(100 * found.scale)} %`]);
      entries.push(["fastest direction", `${lengthOf(found.sigma[0])}/s`], ["slowest direction", `${lengthOf(found.sigma[2])}/s`]);
    }
    this.facts.replaceChildren(...entries.flatMap(([name, text]) => [make("dt", {}, name), make("dd", {}, text)]));
  }

  replayStatus(found) {
    const { task } = this;
    const failed = task.arm.joints.map((joint, i) => (found.health[i] ? `${joint.name} ${task.words.health[found.health[i]]}` : "")).filter(Boolean);
    return `Replay of ${this.data.runs[this.chosen].label}: ${failed.length ? failed.join(", ") : "all joints work"}; the tool is ${lengthOf(found.off[0])} from its target.`;
  }

  replayState() {
    if (!this.data.runs.length) return;
    this.goOnButton.hidden = this.mode !== "replay";
    this.backButton.hidden = this.mode === "replay";
  }

  label(found) {
    const { chain, joints } = this.task.arm;
    if (this.tags.childElementCount !== chain.length) this.tags.replaceChildren(...chain.map(() => make("span")));
    const tags = this.tags.children, taken = [];
    this.tags.hidden = !this.shown.names;
    if (!this.shown.names) return;
    const order = chain.map((_, k) => k).sort((a, b) => (found.health[chain[b].joint] !== 0) - (found.health[chain[a].joint] !== 0));
    for (const k of order) {
      const { joint } = chain[k];
      const [x, y, seen] = this.scene.project(this.scene.station(k));
      const state = found.health[joint];
      const text = joints[joint].name + (state ? `: ${this.task.words.health[state]}` : "");
      const tag = tags[k];
      if (tag.textContent !== text) tag.textContent = text;
      tag.className = state ? "broken" : "";
      const width = 7 * text.length + 14;
      const free = seen && x > 0 && y > 0 && x + width < this.canvas.clientWidth && y < this.canvas.clientHeight - 8 && !taken.some(([u, v, w]) => x < u + w && u < x + width && Math.abs(v - y) < 17);
      tag.hidden = !free;
      if (!free) continue;
      taken.push([x, y, width]);
      tag.style.transform = `translate(${Math.round(x + 12)}px, ${Math.round(y - 9)}px)`;
    }
  }

  // Where a joint is on the screen [px], for tests.
  pixel(i) {
    const k = this.task.arm.chain.findIndex((link) => link.joint === i);
    const [x, y] = this.scene.project(this.scene.station(k));
    const box = this.canvas.getBoundingClientRect();
    return [box.left + x, box.top + y];
  }
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function lengthOfTime(seconds) {
  return seconds < 1 ? `${number(1000 * seconds)} ms` : `${number(seconds)} s`;
}
